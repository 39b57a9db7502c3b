//! The matrix of form factors: F_ij is the share of what leaves patch i that arrives at patch j.
//!
//! ```text
//! F_ij = 1/A_i Int_i Int_j V cos_i cos_j / (pi r^2)       A_i F_ij = A_j F_ji       Sum_j F_ij + lost_i = 1
//! ```
//! The bake's rays that count what they hit ([`crate::rays`]), both directions pooled and balanced ([`crate::balance`]),
//! and, what a bake leaves out, closed forms in the place of chance where they are known ([`known`]). Here it is for plain
//! triangles, each a patch of its own, beside the slow plain twin that has none of it.

mod facet;
pub mod known;
mod pairs;
mod plain;
pub mod polygon;
pub mod precision;
mod shaft;
mod solid_angle;

use engine::transport::Rows;
use engine::transport::bvh::{Bvh, Holes};
use glam::Vec3;

use crate::balance::balanced_rows;
use crate::cache::Cache;
use crate::directions::hash_of;
use crate::emitter::Emitters;
use crate::layout::RayScene;
use crate::rays::Tracer;
use crate::{BakeError, Watcher};

pub use plain::by_plain_rays;

/// A row and a column for each face, in their order; those of a face without area are empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FormFactors {
    pub rows: Rows,
    /// In the square of the callers' unit.
    pub areas: Vec<f64>,
    /// By face, the share of its rays that left or met the back of a face, as they were counted.
    pub lost: Vec<f64>,
}

/// Of all pairs of faces. Corners run counter-clockwise as seen from the front, in any unit. `rays` start on each
/// face; a power of two is best.
pub fn of_faces(faces: &[[Vec3; 3]], rays: u32, watcher: &dyn Watcher) -> Result<FormFactors, BakeError> {
    let scene = Faces::new(faces)?;
    let rays = rays.clamp(1, 1 << 20);
    let bvh = Bvh::new(&scene.rays.triangles, Vec::new());
    let tracer = Tracer { scene: &scene.rays, bvh: &bvh, holes: &Solid, watcher };
    let n = scene.numbers.len();
    let hits = tracer.patch_rows(rays, &Cache::none())?;
    let emitters = Emitters::choose(&scene.rays, &vec![false; n]);
    let known = known::known(&tracer, rays, 0.0, &emitters, |_| true)?;
    let towards = vec![Vec::new(); n];
    let areas = &scene.rays.patch_areas;
    let (rows, ..) = balanced_rows(&hits, rays, areas, &emitters, &towards, &known, watcher)?;
    let lost = (0..n).map(|i| f64::from(hits.lost[i] + hits.escaped[i]) / f64::from(rays));
    Ok(scene.spread(&rows, &lost.collect::<Vec<_>>()))
}

/// Faces let nothing through.
struct Solid;

impl Holes for Solid {
    fn passes(&self, _: u32, _: [f32; 2], _: f32) -> bool {
        false
    }
}

/// Faces that have an area, each a patch.
struct Faces {
    rays: RayScene,
    /// By patch, the face's number.
    numbers: Vec<usize>,
    faces: usize,
}

impl Faces {
    fn new(faces: &[[Vec3; 3]]) -> Result<Self, BakeError> {
        let mut rays = RayScene::default();
        let mut numbers = Vec::new();
        for (number, corners) in faces.iter().enumerate() {
            if !corners.iter().all(|corner| corner.is_finite()) {
                return Err(BakeError::Other(format!("face {} has a corner that is no number", number + 1)));
            }
            let [a, b, c] = corners.map(|corner| corner.as_dvec3());
            let area = (b - a).cross(c - a).length() * 0.5;
            let [a, b, c] = *corners;
            if (b - a).cross(c - a).length() > 0.0 {
                let patch = numbers.len();
                numbers.push(number);
                rays.triangles.push(*corners);
                rays.patches.push([patch as u32, engine::transport::NONE]);
                rays.patch_keys.push(hash_of([number as u64]));
                rays.patch_triangles.push(patch..patch + 1);
                rays.patch_back.push(false);
                rays.patch_areas.push(area);
            }
        }
        Ok(Self { rays, numbers, faces: faces.len() })
    }

    /// From patches back to faces.
    fn spread(&self, rows: &Rows, lost: &[f64]) -> FormFactors {
        let mut of_faces =
            FormFactors { areas: vec![0.0; self.faces], lost: vec![0.0; self.faces], ..Default::default() };
        for (patch, &number) in self.numbers.iter().enumerate() {
            while of_faces.rows.len() < number {
                of_faces.rows.push([]);
            }
            of_faces.rows.push(rows.row(patch).map(|(j, share)| (self.numbers[j as usize] as u32, share)));
            of_faces.areas[number] = self.rays.patch_areas[patch];
            of_faces.lost[number] = lost[patch];
        }
        while of_faces.rows.len() < self.faces {
            of_faces.rows.push([]);
        }
        of_faces
    }
}
