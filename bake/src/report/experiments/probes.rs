//! Light probes: what objects read between them, against a fresh row at the same place.
//!
//! Irradiance towards the six axes, halfway between neighbouring probes, where interpolation knows least; both from the
//! same solved radiosity, both without ringing, as the runtime has them. Places inside solids are not asked. A field of its own, at places in the air: no part of the chain on surfaces.

use std::f64::consts::PI;

use engine::transport::Transport;
use engine::transport::dering::dering;
use engine::transport::probe_field::{Cell, ProbeField};
use engine::transport::sh::{COEFFICIENTS, basis};
use engine::transport::solve::gather;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::lit::{Lit, field, weights};
use crate::report::model::{Error, Part};
use crate::report::numbers::share;

/// Places that are asked, at most, and rays of a fresh row.
const PLACES: usize = 64;
const RAYS: u32 = 1 << 14;
pub const SEED: u64 = 0x9a0b_e500;
const AXES: [Vec3; 6] = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];

/// A patch is bright that has so many times the mean radiosity.
const BRIGHT: f64 = 10.0;

/// Between two neighbours.
struct Halfway {
    at: Vec3,
    /// From probe to probe [m].
    span: f32,
}

/// Towards the axes, as objects read it there and by a row of its own.
type Both = ([DVec3; 6], [DVec3; 6]);

/// `b`: solved, by patch.
pub fn part(lit: &Lit, b: &[DVec3]) -> Part {
    let name = "light probes".to_owned();
    let transport = lit.transport;
    let look = lit.look(RAYS, SEED);
    let places: Vec<Halfway> =
        halfway(transport).into_iter().filter(|place| !lit.is_inside(&look, place.at)).collect();
    if places.is_empty() {
        let why = "the scene has no two light probes with light between them".to_owned();
        return Part { name, left_out: Some(why), is_apart: true, ..Part::default() };
    }
    let columns = lit.columns(b);
    let stored = gather(&transport.probe_from_patch, &columns);
    let stored: Vec<Light> = stored.chunks_exact(COEFFICIENTS).map(without_ringing).collect();
    let probes = ProbeField::new(transport);
    let both = |place: &Halfway| -> Both {
        let read = probes.weights(place.at, &mut Cell::default());
        let blended = std::array::from_fn(|k| {
            let of = |slot: usize| stored[read.probes[slot] as usize][k] * f64::from(read.weights[slot]);
            (0..4).map(of).sum()
        });
        let fresh = without_ringing(&lit.probe(&look, place.at, &columns));
        (towards_axes(&blended), towards_axes(&fresh))
    };
    let both: Vec<Both> = places.par_iter().map(both).collect();
    let found = field(both.iter().flat_map(|both| both.0));
    let fresh = field(both.iter().flat_map(|both| both.1));
    Part {
        name,
        compared: compared(&places, &both, |at| nearest_bright(lit, b, at)),
        error: Error::of(&found, &fresh, &weights(&fresh)),
        left_out: None,
        is_apart: true,
    }
}

/// What is counted, what is usual, and where the largest part of it is: near to what shines, light falls with the square
/// of the distance, and nothing that is blended from afar follows it.
fn compared(places: &[Halfway], both: &[Both], nearest_bright: impl Fn(Vec3) -> Option<f32>) -> String {
    let squares = |of: &dyn Fn(usize) -> DVec3| (0..6).map(|k| of(k).length_squared()).sum::<f64>();
    let far = |(found, fresh): &Both| squares(&|k| found[k] - fresh[k]);
    let mut own: Vec<f64> = both
        .iter()
        .map(|both| (far(both) / squares(&|k| both.1[k]).max(f64::MIN_POSITIVE)).sqrt())
        .filter(|share| share.is_finite())
        .collect();
    own.sort_by(f64::total_cmp);
    let usual = own.get(own.len() / 2).copied().unwrap_or(0.0);
    let all: f64 = both.iter().map(far).sum();
    let worst = (0..both.len()).max_by(|&a, &b| far(&both[a]).total_cmp(&far(&both[b])));
    let worst = worst.filter(|_| all > 0.0).map_or(String::new(), |k| {
        let Halfway { at, span } = places[k];
        let bright = nearest_bright(at)
            .map_or(String::new(), |distance| format!(", {distance:.2} m from the nearest bright patch"));
        format!("; one pair {span:.2} m apart has {} of all squares{bright}", share(far(&both[k]) / all))
    });
    format!(
        "light read halfway between {} pairs of neighbours against fresh probe rows there, in six directions; half of the \
         places are off by less than {} of their own light{worst}",
        places.len(),
        share(usual),
    )
}

/// Metres to the nearest patch that is bright; none where none is.
fn nearest_bright(lit: &Lit, b: &[DVec3], at: Vec3) -> Option<f32> {
    let patches = &lit.transport.patches;
    let area: f64 = patches.iter().map(|patch| f64::from(patch.area)).sum();
    let mean =
        b.iter().zip(patches).map(|(b, patch)| b.element_sum() * f64::from(patch.area)).sum::<f64>() / area;
    let bright = b.iter().zip(patches).filter(|(b, _)| b.element_sum() > BRIGHT * mean);
    bright.map(|(_, patch)| patch.centre.distance(at)).min_by(f32::total_cmp)
}

type Light = [DVec3; COEFFICIENTS];

/// As the runtime keeps them.
fn without_ringing(light: &[DVec3]) -> Light {
    let mut singles: [Vec3; COEFFICIENTS] = std::array::from_fn(|k| light[k].as_vec3());
    dering(&mut singles);
    singles.map(Vec3::as_dvec3)
}

/// Evenly among all edges.
fn halfway(transport: &Transport) -> Vec<Halfway> {
    let edges = ProbeField::new(transport).edges();
    let count = edges.len().min(PLACES);
    let at = |probe: u32| transport.probes[probe as usize].position;
    let middle = |k: usize| {
        let [a, b] = edges[k * edges.len() / count].probes.map(at);
        Halfway { at: 0.5 * (a + b), span: a.distance(b) }
    };
    (0..count).map(middle).collect()
}

/// E(n) = Sum_l A_l Sum_m L_lm Y_lm(n) and nowhere below 0, A = pi, 2 pi / 3, pi / 4 (Ramamoorthi and Hanrahan 2001).
fn towards_axes(light: &[DVec3; COEFFICIENTS]) -> [DVec3; 6] {
    let band = |k: usize| [PI, 2.0 * PI / 3.0, PI / 4.0][usize::from(k > 0) + usize::from(k > 3)];
    AXES.map(|axis| {
        let y = basis(axis);
        (0..COEFFICIENTS).map(|k| light[k] * (band(k) * f64::from(y[k]))).sum::<DVec3>().max(DVec3::ZERO)
    })
}
