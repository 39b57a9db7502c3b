//! Light-probe rows: what each patch and sky patch adds to the nine SH coefficients of the light at a point.
//!
//! ```text
//! L_lm = Int L(w) Y_lm(w) dw  ~  Sum_t W_lm,t B_t        W_lm,t = 4/R * Sum over rays that hit t of Y_lm
//! ```
//! (4 pi / R for the sphere's solid angle, 1/pi from radiosity to radiance.) Emitters are sampled towards, with
//! A cos / (r^2 n) in place of 4 pi / R; what chance found is then scaled so that the row closes: with what is lost
//! and what leaves, all that is seen is the sphere, whatever the noise of both.

use std::f32::consts::PI;

use engine::transport::sh::{COEFFICIENTS, basis};
use glam::Vec3;

use crate::directions::{Sobol, hash, sphere_direction, unit};
use crate::emitter::Emitters;
use crate::layout::Places;
use crate::rays::{Seen, Tracer};

/// Nine weights by column, columns ascending.
pub struct ProbeRow {
    pub entries: Vec<(u32, [f64; COEFFICIENTS])>,
    /// Share of rays that met back faces.
    pub lost: f64,
}

pub fn probe_row(
    tracer: &Tracer,
    emitters: &Emitters,
    position: Vec3,
    sobol: &Sobol,
    rays: u32,
    key: u64,
) -> ProbeRow {
    let mut weights: std::collections::BTreeMap<u32, [f64; COEFFICIENTS]> = std::collections::BTreeMap::new();
    let (mut lost, mut left) = (0_u32, 0_u32);
    for ray in 0..rays {
        let [u, v, ..] = sobol.point(ray, key);
        let direction = sphere_direction(u, v);
        let chance = unit(hash(key ^ u64::from(ray)) as u32);
        match tracer.column(position, Vec3::ZERO, direction, chance) {
            Seen::Column(column) if !is_emitter(emitters, column) => {
                add(weights.entry(column).or_default(), direction, 4.0 / f64::from(rays));
            }
            Seen::Back => lost += 1,
            Seen::Column(_) => {} // an emitter
            _ => left += 1,
        }
    }
    let mut towards = towards_all(tracer, emitters, position, sobol, key, 64);
    let all = 4.0 * f64::from(basis(Vec3::Y)[0]);
    let target = all * (1.0 - f64::from(lost + left) / f64::from(rays));
    close(&mut weights, &mut towards, target);
    weights.extend(towards);
    ProbeRow { entries: weights.into_iter().collect(), lost: f64::from(lost) / f64::from(rays) }
}

/// What was sampled towards takes its share of what is seen, and chance the rest.
fn close(
    by_chance: &mut std::collections::BTreeMap<u32, [f64; COEFFICIENTS]>,
    towards: &mut [(u32, [f64; COEFFICIENTS])],
    target: f64,
) {
    if towards.is_empty() {
        return; // chance alone closes
    }
    let found: f64 = by_chance.values().map(|weights| weights[0]).sum();
    let sampled: f64 = towards.iter().map(|(_, weights)| weights[0]).sum();
    let sampled_scale = if sampled > target { target.max(0.0) / sampled } else { 1.0 };
    let scale = if found > 0.0 { (target - sampled * sampled_scale).max(0.0) / found } else { 0.0 };
    by_chance.values_mut().flatten().for_each(|weight| *weight *= scale);
    towards.iter_mut().flat_map(|(_, weights)| weights).for_each(|weight| *weight *= sampled_scale);
}

fn is_emitter(emitters: &Emitters, column: u32) -> bool {
    emitters.is_emitter.get(column as usize).copied().unwrap_or(false)
}

fn add(weights: &mut [f64; COEFFICIENTS], direction: Vec3, weight: f64) {
    for (sum, y) in weights.iter_mut().zip(basis(direction)) {
        *sum += weight * f64::from(y);
    }
}

/// Weights of the emitters that are sampled towards and seen, each by this many shadow rays.
pub fn towards_all(
    tracer: &Tracer,
    emitters: &Emitters,
    position: Vec3,
    sobol: &Sobol,
    key: u64,
    rays: u32,
) -> Vec<(u32, [f64; COEFFICIENTS])> {
    let of = |&patch: &u32| (patch, towards(tracer, position, patch, sobol, key, rays));
    emitters.patches.iter().map(of).filter(|(_, weights)| weights[0] > 0.0).collect()
}

fn towards(
    tracer: &Tracer,
    position: Vec3,
    patch: u32,
    sobol: &Sobol,
    key: u64,
    rays: u32,
) -> [f64; COEFFICIENTS] {
    let places = Places::of(tracer.scene, patch as usize);
    let area = tracer.scene.patch_areas[patch as usize] as f32;
    let seed = hash(key ^ tracer.scene.patch_keys[patch as usize]);
    let mut weights = [0.0; COEFFICIENTS];
    for k in 0..rays {
        let [u, v, ..] = sobol.point(k, seed);
        let (at, facing, _) = places.at(u, v);
        let way = at - position;
        let distance = way.length();
        let solid_angle = area * (-facing.dot(way)).max(0.0) / (distance * distance * distance * rays as f32);
        let chance = unit(hash(seed ^ u64::from(k)) as u32);
        if solid_angle > 0.0
            && tracer.bvh.free_between([position, Vec3::ZERO], [at, facing], chance, tracer.holes)
        {
            add(&mut weights, way / distance, f64::from(solid_angle.min(4.0 * PI) / PI));
        }
    }
    weights
}
