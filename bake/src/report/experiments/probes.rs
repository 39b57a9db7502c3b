//! Light probes: what objects read between them, against a fresh row at the same place.
//!
//! Irradiance towards the six axes, halfway between neighbouring probes, where interpolation knows least; both from the
//! same solved radiosity. A field of its own, at places in the air: no part of the chain on surfaces.

use std::f64::consts::PI;

use engine::transport::Transport;
use engine::transport::probe_field::{Cell, ProbeField};
use engine::transport::sh::{COEFFICIENTS, basis};
use engine::transport::solve::gather;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::lit::{Lit, field, weights};
use crate::report::model::{Error, Part};

/// Places that are asked, at most, and rays of a fresh row.
const PLACES: usize = 64;
const RAYS: u32 = 1 << 14;
pub const SEED: u64 = 0x9a0b_e500;
const AXES: [Vec3; 6] = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];

/// `b`: solved, by patch.
pub fn part(lit: &Lit, b: &[DVec3]) -> Part {
    let name = "light probes".to_owned();
    let transport = lit.transport;
    let look = lit.look(RAYS, SEED);
    let places: Vec<Vec3> =
        halfway(transport).into_iter().filter(|&place| !lit.is_inside(&look, place)).collect();
    if places.is_empty() {
        let why = "the scene has no two light probes with light between them".to_owned();
        return Part { name, left_out: Some(why), is_apart: true, ..Part::default() };
    }
    let columns = lit.columns(b);
    let stored = gather(&transport.probe_from_patch, &columns);
    let probes = ProbeField::new(transport);
    let both: Vec<([DVec3; 6], [DVec3; 6])> = places
        .par_iter()
        .map(|&place| {
            let read = probes.weights(place, &mut Cell::default());
            let blended = std::array::from_fn(|k| {
                let of = |slot: usize| {
                    stored[read.probes[slot] as usize * COEFFICIENTS + k] * f64::from(read.weights[slot])
                };
                (0..4).map(of).sum()
            });
            (towards_axes(&blended), towards_axes(&lit.probe(&look, place, &columns)))
        })
        .collect();
    let found = field(both.iter().flat_map(|both| both.0));
    let fresh = field(both.iter().flat_map(|both| both.1));
    Part {
        name,
        compared: format!(
            "light read halfway between {} pairs of neighbours against fresh probe rows there",
            places.len()
        ),
        error: Error::of(&found, &fresh, &weights(&fresh)),
        left_out: None,
        is_apart: true,
    }
}

/// Evenly among all edges.
fn halfway(transport: &Transport) -> Vec<Vec3> {
    let edges = ProbeField::new(transport).edges();
    let count = edges.len().min(PLACES);
    let at = |probe: u32| transport.probes[probe as usize].position;
    let middle = |k: usize| {
        let [a, b] = edges[k * edges.len() / count].probes;
        0.5 * (at(a) + at(b))
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
