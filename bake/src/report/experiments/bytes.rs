//! Bytes of the stored rows against what storing them costs: the same rows in other forms, each solved exactly.
//!
//! The truth is what the rows show as the bake balanced them, in f64 to the end; both the patches' and the receivers' rows
//! take the form, and count.

use engine::transport::solve::{Channel, Method, Stop, System, solve};
use engine::transport::{Rows, Transport, file};
use glam::{DVec3, Vec3};

use super::lit::{Lit, weights};
use super::quantise::{Kept, kept};
use crate::compress::{cut_rows, one_ray};
use crate::query::Place;
use crate::report::Budget;
use crate::report::model::{Axis, Diagram, Error, Floor, Norm, Point, Series};
use crate::{BakeError, Watcher};

const WEIGHTS: [Kept; 3] = [Kept::U8, Kept::F16, Kept::F32];
const LARGEST: [Kept; 4] = [Kept::Largest(64), Kept::Largest(256), Kept::Largest(1024), Kept::Largest(4096)];
/// Tolerances of cut rows, in what one ray carries: from coarse to fine.
const IN_RAYS: [f64; 6] = [8.0, 4.0, 2.0, 1.0, 0.5, 0.25];
/// Bound to which rows that lost their symmetry are solved, and the products that may take.
const NEAR: f64 = 1e-8;
const FEW: f64 = 100.0;
const MOST: f64 = 4000.0;

/// The shipped rows under the scene's light: `direct` from punctual lights, by patch; `exact`: solved.
pub struct Stored<'a> {
    pub lit: &'a Lit<'a>,
    pub direct: &'a [Vec3],
    pub exact: &'a [DVec3],
    pub places: &'a [Option<Place>],
    /// What the rows are off by already, where that is known: to store them better than they were counted is of no use.
    pub counted: Option<f64>,
}

pub fn diagram(stored: &Stored, budget: &Budget, watcher: &dyn Watcher) -> Result<Diagram, BakeError> {
    watcher.stage("bytes", (WEIGHTS.len() + LARGEST.len() + IN_RAYS.len()) as u64);
    let truth = stored.lit.shown(stored.exact, stored.places);
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
            points.push(point(stored, &truth, how));
        }
        series.push(Series::new(name, points));
    }
    series.push(Series::new("as they are stored", vec![shipped(stored.lit.transport)]));
    series.push(cuts(stored, &truth, budget, watcher)?);
    series.retain(|series| !series.points.is_empty());
    Ok(Diagram {
        id: "bytes".to_owned(),
        title: "Bytes of the rows and what storing them costs".to_owned(),
        about: "What do fewer bytes cost? The shipped bake's rows in other forms, of patches and of receivers, solved \
                exactly, against the same rows as they are stored now. Rows keep their sums."
            .to_owned(),
        x: Axis { label: "rows".to_owned(), unit: "MB".to_owned() },
        y: super::bake_time::irradiance(),
        norm: Norm::Rms,
        series,
        floors: vec![floor(stored.counted)],
    })
}

fn floor(counted: Option<f64>) -> Floor {
    match counted {
        Some(y) => Floor { name: "error of the form factors themselves".to_owned(), y },
        None => Floor { name: "rounding of f32".to_owned(), y: 0.5 * f64::from(f32::EPSILON) },
    }
}

/// Receivers' rows cut through a tree over the patches; the patches' own stay whole.
fn cuts(stored: &Stored, truth: &[f64], budget: &Budget, watcher: &dyn Watcher) -> Result<Series, BakeError> {
    let Stored { lit, exact, places, .. } = *stored;
    let transport = lit.transport;
    let columns = lit.columns(exact);
    let mut points = Vec::new();
    for in_rays in IN_RAYS {
        watcher.advance(1, 0);
        if watcher.cancelled() {
            return Err(BakeError::Cancelled);
        }
        if budget.is_spent() {
            continue;
        }
        let tolerance = in_rays * one_ray(transport);
        let cut = cut_rows(&transport.receiver_from_patch, transport, &lit.marked(), tolerance);
        let x = megabytes(cut.bytes() + Kept::F32.bytes(&transport.patch_from_patch));
        let shown = lit.blended(&cut.gather(transport, &columns), places);
        points.push(Point {
            setting: format!("{in_rays} rays"),
            x,
            x_range: [x; 2],
            runs: 1,
            error: Error::of(&shown, truth, &weights(truth)),
            spread: 0.0,
            preset: None,
        });
    }
    Ok(Series::new("receivers' rows cut through a tree, f32", points))
}

fn point(stored: &Stored, truth: &[f64], how: Kept) -> Point {
    let Stored { lit, direct, exact, places, .. } = *stored;
    let [patches, receivers] = [&lit.transport.patch_from_patch, &lit.transport.receiver_from_patch];
    let [patch_rows, receiver_rows] = [kept(patches, how), kept(receivers, how)];
    let b = radiosity(lit, &patch_rows, direct, exact);
    let irradiance = engine::transport::solve::gather(&receiver_rows, &lit.columns(&b));
    let x = megabytes(how.bytes(&patch_rows) + how.bytes(&receiver_rows));
    Point {
        setting: how.name(),
        x,
        x_range: [x; 2],
        runs: 1,
        error: Error::of(&lit.blended(&irradiance, places), truth, &weights(truth)),
        spread: 0.0,
        preset: None,
    }
}

fn megabytes(bytes: usize) -> f64 {
    bytes as f64 * 1e-6
}

/// The rows as the file has them: all others are compared with these.
fn shipped(transport: &Transport) -> Point {
    let of_rows = |name: &str| {
        let part = name.strip_prefix("patch.").or(name.strip_prefix("receiver."));
        matches!(part, Some("starts" | "columns" | "weights" | "packed"))
    };
    let arrays = file::arrays(transport);
    let bytes = arrays.iter().filter(|(name, _)| of_rows(name)).map(|(_, bytes)| bytes.len()).sum::<usize>();
    let (x, preset) = (megabytes(bytes), Some("shipped".to_owned()));
    Point { setting: "as stored".to_owned(), x, x_range: [x; 2], runs: 1, preset, ..Point::default() }
}

/// The solution of rows that may have lost their symmetry, from one of rows like them: by two-level Jacobi, and where
/// that does not get there by Gauss-Seidel, which always does.
pub fn radiosity(lit: &Lit, rows: &Rows, direct: &[Vec3], start: &[DVec3]) -> Vec<DVec3> {
    let e = lit.e(rows, direct);
    let system = System { rows, patches: &lit.transport.patches, albedo: &lit.albedo };
    let mut b = vec![DVec3::ZERO; e.len()];
    for c in 0..3 {
        let channel = Channel::of(&system, c);
        let e: Vec<f64> = e.iter().map(|e| e[c]).collect();
        let start: Vec<f64> = start.iter().map(|b| b[c]).collect();
        let near = |method, products| {
            solve(method, &channel, &e, Some(&start), &Stop::at(NEAR, products), &mut |_| {})
        };
        let mut solved = near(Method::TwoLevel, FEW);
        if !solved.reached {
            solved = near(Method::GaussSeidel, MOST);
        }
        b.iter_mut().zip(solved.b).for_each(|(b, solved)| b[c] = solved);
    }
    b
}
