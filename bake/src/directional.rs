//! Directional rows ([`engine::transport::directional`]): for receivers that surfaces with a normal map blend, and for
//! no others.
//!
//! ```text
//! V_t = Int L(w) f(w) dw  ~  Sum_j D_j B_j        D_j = 2/R * Sum over rays that hit j of f(w)
//! ```
//! with rays that are even over the half space (2 pi / R for its solid angle, 1/pi from radiosity to radiance): the
//! irradiance's own rays follow the cosine, and where f counts most, along the surface, they hardly go. An emitter that
//! rows are sampled towards takes the share that the irradiance has of it, times the mean of f / cos over what is seen of
//! it. What then is over of all that a point sees, with what is lost and what leaves, is taken from what chance
//! found, so that even light from everywhere has no direction.

use std::collections::BTreeMap;

use engine::scene::{MaterialId, Scene};
use engine::transport::directional::{AXES, MOST, any_directional, is_bumped, weight};
use engine::transport::packed::fold;
use engine::transport::surface::Blend;
use engine::transport::{Batch, Rows};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::directions::{Sobol, frame, hash, hemisphere_direction, unit};
use crate::emitter::Emitters;
use crate::rays::{Seen, Tracer};
use crate::receiver::{Place, Receivers};
use crate::split::Fine;
use crate::{BakeError, BakeError::Cancelled};

/// Moves receivers that surfaces with a normal map blend before all others, and says how many they are.
pub fn put_first(receivers: &mut Receivers, scene: &Scene, fine: &Fine, batches: &[Batch]) -> usize {
    if !any_directional(scene) {
        return 0;
    }
    let chosen = chosen(receivers, scene, fine, batches);
    let (first, rest): (Vec<usize>, Vec<usize>) = (0..chosen.len()).partition(|&receiver| chosen[receiver]);
    let order: Vec<usize> = first.iter().chain(&rest).copied().collect();
    let mut place_of = vec![0; order.len()];
    order.iter().enumerate().for_each(|(place, &receiver)| place_of[receiver] = place as u32);
    receivers.places = order.iter().map(|&receiver| receivers.places[receiver]).collect();
    for blend in receivers.blends.iter_mut().chain(&mut receivers.back_blends) {
        for (receiver, &weight) in blend.receivers.iter_mut().zip(&blend.weights) {
            *receiver = if weight > 0.0 { place_of[*receiver as usize] } else { 0 };
        }
    }
    first.len()
}

/// By receiver: does a vertex of a surface with a normal map blend it?
fn chosen(receivers: &Receivers, scene: &Scene, fine: &Fine, batches: &[Batch]) -> Vec<bool> {
    let bumped: Vec<bool> =
        batches.iter().map(|batch| is_bumped(scene, MaterialId(batch.material))).collect();
    let mut chosen = vec![false; receivers.places.len()];
    let mut choose = |blend: &Blend| {
        let used = blend.receivers.into_iter().zip(blend.weights).filter(|used| used.1 > 0.0);
        used.for_each(|(receiver, _)| chosen[receiver as usize] = true);
    };
    for (triangle, nodes) in fine.triangles.iter().zip(&receivers.node_of) {
        let batch = triangle.batch as usize;
        for &node in nodes.iter().filter(|_| bumped[batch]) {
            choose(&receivers.blends[node as usize]);
            if batches[batch].double_sided != 0 {
                choose(&receivers.back_blends[node as usize]);
            }
        }
    }
    chosen
}

/// Three rows for each of the first receivers, by whether they are valid; empty ones for those that are not.
pub fn rows(
    tracer: &Tracer,
    emitters: &Emitters,
    receiver_from_patch: &Rows,
    valid: &[bool],
    rays: u32,
) -> Result<Rows, BakeError> {
    let mut rows = Rows::default();
    if valid.is_empty() {
        return Ok(rows);
    }
    tracer.watcher.stage("directional rows", valid.len() as u64);
    let sobol = Sobol::new(rays);
    let traced: Result<Vec<Terms>, BakeError> = (0..valid.len())
        .into_par_iter()
        .map(|i| {
            if tracer.watcher.cancelled() {
                return Err(Cancelled);
            }
            let irradiance = receiver_from_patch.row(i);
            let place = &tracer.scene.receivers[i];
            let terms =
                if valid[i] { terms(tracer, emitters, place, irradiance, &sobol, rays) } else { Vec::new() };
            tracer.watcher.advance(1, u64::from(rays));
            Ok(terms)
        })
        .collect();
    for terms in traced? {
        for axis in 0..AXES {
            let mut row: Vec<(u32, f32)> =
                terms.iter().map(|&(column, term)| (column, term[axis] as f32)).collect();
            fold(&mut row);
            rows.push(row);
        }
    }
    Ok(rows)
}

/// D_j by column, columns ascending.
type Terms = Vec<(u32, DVec3)>;

fn terms(
    tracer: &Tracer,
    emitters: &Emitters,
    place: &Place,
    irradiance: impl Iterator<Item = (u32, f32)>,
    sobol: &Sobol,
    rays: u32,
) -> Terms {
    let Chance { mut found, over, missed } = by_chance(tracer, emitters, place, sobol, rays);
    let towards: Terms = irradiance
        .filter(|&(column, _)| is_emitter(emitters, column))
        .map(|(column, share)| {
            let at = (place.position.as_vec3(), place.normal);
            let of = |direction: Vec3| weight(direction, place.normal);
            let mean = emitters.mean_per_cosine(tracer, at, column, place.key, of);
            (column, mean.as_dvec3() * f64::from(share))
        })
        .collect();
    let over = over + towards.iter().map(|towards| towards.1).sum::<DVec3>();
    let hits = missed + found.values().map(|found| found.count).sum::<u32>();
    found.values_mut().for_each(|found| found.sum -= over * f64::from(found.count) / f64::from(hits));
    let by_chance = found.into_iter().map(|(column, found)| (column, found.sum));
    let mut terms: Terms = by_chance.chain(towards).collect();
    terms.sort_unstable_by_key(|term| term.0);
    bound(&mut terms);
    terms
}

#[derive(Default)]
struct Found {
    count: u32,
    sum: DVec3,
}

/// What chance found, but for emitters.
struct Chance {
    found: BTreeMap<u32, Found>,
    /// Of all that was found, lost or left.
    over: DVec3,
    /// Rays that were lost or left.
    missed: u32,
}

fn by_chance(tracer: &Tracer, emitters: &Emitters, place: &Place, sobol: &Sobol, rays: u32) -> Chance {
    // Others than those of the irradiance.
    let key = hash(place.key ^ 0xd1);
    let (position, normal) = (place.position.as_vec3(), place.normal);
    let (x, y) = frame(normal);
    let mut chance = Chance { found: BTreeMap::new(), over: DVec3::ZERO, missed: 0 };
    for ray in 0..rays {
        let [a, b, ..] = sobol.point(ray, key);
        let local = hemisphere_direction(a, b);
        let direction = x * local.x + y * local.y + normal * local.z;
        let term = weight(direction, normal).as_dvec3() * (2.0 / f64::from(rays));
        match tracer.column(position, normal, direction, unit(hash(key ^ u64::from(ray)) as u32)) {
            Seen::Column(column) if is_emitter(emitters, column) => continue,
            Seen::Column(column) => {
                let found = chance.found.entry(column).or_default();
                found.count += 1;
                found.sum += term;
            }
            Seen::Back | Seen::Nothing => chance.missed += 1,
        }
        chance.over += term;
    }
    chance
}

fn is_emitter(emitters: &Emitters, column: u32) -> bool {
    emitters.is_emitter.get(column as usize).copied().unwrap_or(false)
}

/// No axis says more than all light can by.
fn bound(terms: &mut Terms) {
    let sizes: DVec3 = terms.iter().map(|term| term.1.abs()).sum();
    let scale = (MOST / sizes.max_element().max(MOST)).min(1.0);
    terms.iter_mut().for_each(|term| term.1 *= scale);
}

/// max over rows of the sum of their sizes beyond [`MOST`].
pub fn sum_excess(rows: &Rows) -> f64 {
    let size = |row: usize| rows.row(row).map(|entry| f64::from(entry.1).abs()).sum::<f64>();
    (0..rows.len()).map(|row| size(row) - MOST).fold(0.0, f64::max)
}
