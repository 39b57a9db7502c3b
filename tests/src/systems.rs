//! Systems to be solved: rows of real bakes, with an albedo put to them.

use std::sync::LazyLock;

use bake::{Settings, Silent, bake};
use engine::transport::solve::Channel;
use engine::transport::{Patch, Rows, Transport};
use glam::Vec3;

use crate::room::walls;
use crate::surfaces::{self, Faces, face};

/// Rows and patches of it alone.
#[derive(Clone)]
pub struct Geometry {
    pub rows: Rows,
    pub patches: Vec<Patch>,
}

impl Geometry {
    pub fn channel(&self, albedo: impl Fn(&Patch) -> f64) -> Channel<'_> {
        Channel::new(&self.rows, &self.patches, self.patches.iter().map(albedo))
    }
}

impl From<Transport> for Geometry {
    fn from(transport: Transport) -> Self {
        Self { rows: transport.patch_from_patch, patches: transport.patches }
    }
}

/// The inside of a box, baked; its walls -x +x -y +y -z +z are batches 0 to 5.
pub fn baked_box(low: Vec3, high: Vec3, length: f64) -> Transport {
    let names = ["-x", "+x", "-y", "+y", "-z", "+z"];
    let walls = walls(low, high);
    let surfaces: Vec<(&str, Faces)> = names.into_iter().zip(walls.iter().map(face)).collect();
    let project = surfaces::project(&surfaces);
    let settings = Settings { rays: Some(1024), patch_length: Some(length), ..Settings::default() };
    let baked = bake(project.path(), None, &settings, &Silent).expect("a bake");
    assert!(baked.transport.certificate.holds(), "{:?}", baked.transport.certificate.statements());
    baked.transport
}

/// A closed box of 4 x 2.5 x 2 m.
pub static BOX: LazyLock<Geometry> =
    LazyLock::new(|| baked_box(Vec3::new(-2.0, 0.0, -1.0), Vec3::new(2.0, 2.5, 1.0), 0.4).into());

/// The same in few patches.
pub static SMALL_BOX: LazyLock<Geometry> =
    LazyLock::new(|| baked_box(Vec3::new(-2.0, 0.0, -1.0), Vec3::new(2.0, 2.5, 1.0), 1.0).into());

/// A closed corridor, 20:1:1.
pub static CORRIDOR: LazyLock<Geometry> =
    LazyLock::new(|| baked_box(Vec3::ZERO, Vec3::new(20.0, 1.0, 1.0), 0.4).into());

/// The same box without its last wall: what it saw of it is lost to the sky behind.
pub fn open(geometry: &Geometry) -> Geometry {
    let last = geometry.patches.iter().map(|patch| patch.batch).max().unwrap_or(0);
    let kept = geometry.patches.iter().position(|patch| patch.batch == last).unwrap_or(0);
    assert!(geometry.patches[kept..].iter().all(|patch| patch.batch == last), "its patches come last");
    let mut rows = Rows::default();
    (0..kept).for_each(|i| rows.push(geometry.rows.row(i)));
    Geometry { rows, patches: geometry.patches[..kept].to_vec() }
}

/// Two that see nothing of each other, in one system.
pub fn apart(first: &Geometry, second: &Geometry) -> Geometry {
    let (mut rows, mut patches) = (first.rows.clone(), first.patches.clone());
    let n = patches.len() as u32;
    let after =
        |number: fn(&Patch) -> u32| first.patches.iter().map(|patch| number(patch) + 1).max().unwrap_or(0);
    let (components, aggregates) = (after(|patch| patch.component), after(|patch| patch.aggregate));
    for (i, patch) in second.patches.iter().enumerate() {
        rows.push(second.rows.row(i).map(|(j, weight)| (n + j, weight)));
        let (component, aggregate) = (patch.component + components, patch.aggregate + aggregates);
        patches.push(Patch { component, aggregate, ..*patch });
    }
    Geometry { rows, patches }
}
