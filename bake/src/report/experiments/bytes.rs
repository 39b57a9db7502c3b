//! Bytes of the stored rows against what storing them costs: the same rows in other forms, each solved exactly.
//!
//! The truth is what the rows show as the bake balanced them, in f64 to the end; both the patches' and the receivers' rows
//! take the form, and count.

use engine::transport::Rows;
use engine::transport::solve::{Channel, Method, Stop, System, solve};
use glam::{DVec3, Vec3};

use super::lit::{Lit, weights};
use super::quantise::{Kept, kept};
use crate::query::Place;
use crate::report::Budget;
use crate::report::model::{Axis, Diagram, Error, Floor, Norm, Point, Series};
use crate::{BakeError, Watcher};

const WEIGHTS: [Kept; 3] = [Kept::U8, Kept::F16, Kept::F32];
const LARGEST: [Kept; 4] = [Kept::Largest(32), Kept::Largest(64), Kept::Largest(128), Kept::Largest(256)];
/// Bound to which rows that lost their symmetry are solved, and the products that may take.
const NEAR: f64 = 1e-8;
const MOST: f64 = 4000.0;

/// `direct`: from punctual lights, by patch; `truth`: what the shipped rows show.
pub fn diagram(
    lit: &Lit,
    direct: &[Vec3],
    places: &[Option<Place>],
    truth: &[f64],
    budget: &Budget,
    watcher: &dyn Watcher,
) -> Result<Diagram, BakeError> {
    watcher.stage("bytes", (WEIGHTS.len() + LARGEST.len()) as u64);
    let mut series = Vec::new();
    for (name, forms) in
        [("all entries, smaller weights", &WEIGHTS[..]), ("only the largest (do not)", &LARGEST)]
    {
        let mut points = Vec::new();
        for &how in forms {
            watcher.advance(1, 0);
            if watcher.cancelled() {
                return Err(BakeError::Cancelled);
            }
            if budget.is_spent() {
                continue;
            }
            points.push(point(lit, direct, places, truth, how));
        }
        series.push(Series { name: name.to_owned(), points });
    }
    series.retain(|series| !series.points.is_empty());
    Ok(Diagram {
        id: "bytes".to_owned(),
        title: "Bytes of the rows and what storing them costs".to_owned(),
        about: "What do fewer bytes cost? The shipped bake's rows in other forms, of patches and of receivers, solved \
                exactly, against the same rows as they are stored now. Rows keep their sums."
            .to_owned(),
        x: Axis { label: "rows".to_owned(), unit: "bytes".to_owned() },
        y: super::bake_time::irradiance(),
        norm: Norm::Rms,
        series,
        floors: vec![Floor { name: "rounding of f32".to_owned(), y: 0.5 * f64::from(f32::EPSILON) }],
    })
}

fn point(lit: &Lit, direct: &[Vec3], places: &[Option<Place>], truth: &[f64], how: Kept) -> Point {
    let [patches, receivers] = [&lit.transport.patch_from_patch, &lit.transport.receiver_from_patch];
    let [patch_rows, receiver_rows] = [kept(patches, how), kept(receivers, how)];
    let b = radiosity(lit, &patch_rows, direct);
    let irradiance = engine::transport::solve::gather(&receiver_rows, &lit.columns(&b));
    let x = (how.bytes(&patch_rows) + how.bytes(&receiver_rows)) as f64;
    Point {
        setting: how.name(),
        x,
        x_range: [x; 2],
        runs: 1,
        error: Error::of(&lit.blended(&irradiance, places), truth, &weights(truth)),
        preset: (how == Kept::F32).then(|| "shipped".to_owned()),
    }
}

/// The solution of rows that may have lost their symmetry: by conjugate gradients as far as those come, then by
/// Gauss-Seidel, which needs none.
pub fn radiosity(lit: &Lit, rows: &Rows, direct: &[Vec3]) -> Vec<DVec3> {
    let e = lit.e(rows, direct);
    let system = System { rows, patches: &lit.transport.patches, albedo: &lit.albedo };
    let mut b = lit.solve(rows, &e);
    for c in 0..3 {
        let channel = Channel::of(&system, c);
        let e: Vec<f64> = e.iter().map(|e| e[c]).collect();
        let start: Vec<f64> = b.iter().map(|b| b[c]).collect();
        let stop = Stop::at(NEAR, MOST);
        let solved = solve(Method::GaussSeidel, &channel, &e, Some(&start), &stop, &mut |_| {});
        b.iter_mut().zip(solved.b).for_each(|(b, solved)| b[c] = solved);
    }
    b
}
