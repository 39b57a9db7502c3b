//! Rows towards emitters are not left to chance: a small lamp is sampled towards.
//!
//! The form factor from a point to a polygon is Lambert's,
//! ```text
//! F = 1/(2 pi) Sum_e angle_e * n . (r_e x r_e+1) / |r_e x r_e+1|
//! ```
//! over the edges of the polygon clipped to the horizon; it is times the share of the emitter that is seen, from
//! shadow rays weighted by what each would carry.

use std::f32::consts::PI;

use glam::Vec3;
use rayon::prelude::*;

use crate::BakeError;
use crate::directions::{Sobol, hash, unit};
use crate::layout::{Places, RayScene, SAMPLES};
use crate::rays::Tracer;

/// Patches that rows are sampled towards.
pub struct Emitters {
    pub patches: Vec<u32>,
    /// By patch: is it one of those?
    pub is_emitter: Vec<bool>,
    /// Centres and radii of `patches`.
    balls: Vec<(Vec3, f32)>,
    sobol: Sobol,
    rays: u32,
}

/// More than this share of all surface is large enough for chance.
const LARGE: f64 = 0.1;
/// Beyond this many triangles a patch is sampled by area, without the polygon's form factor.
const MANY: usize = 64;
/// So many times more points of a patch look at an emitter that is nearer than so many times their radii: along an edge
/// that the two share the form factor falls from a half to little within the emitter's height.
const MORE: u32 = 16;
const NEAR: f32 = 2.0;

impl Emitters {
    /// `marked`: by patch, does its author want it sampled towards?
    pub fn choose(scene: &RayScene, marked: &[bool]) -> Self {
        let area = |all: bool| -> f64 {
            (0..marked.len()).filter(|&i| all || marked[i]).map(|i| scene.patch_areas[i]).sum()
        };
        let few = area(false) <= LARGE * area(true);
        let is_emitter: Vec<bool> = marked.iter().map(|&marked| marked && few).collect();
        let patches: Vec<u32> = (0..marked.len() as u32).filter(|&i| is_emitter[i as usize]).collect();
        let rays = (256 / patches.len().max(1)).next_power_of_two().clamp(4, 64) as u32;
        let balls = patches.iter().map(|&patch| ball(scene, patch as usize)).collect();
        Self { patches, is_emitter, balls, sobol: Sobol::new(4 * rays), rays }
    }

    /// The same with this many shadow rays towards each patch, a power of two of at least 4.
    pub fn with_rays(self, rays: u32) -> Self {
        Self { sobol: Sobol::new(4 * rays), rays, ..self }
    }

    /// Shares of what arrives at a point from each emitter, zeros left out.
    pub fn row(&self, tracer: &Tracer, position: Vec3, normal: Vec3, key: u64) -> Vec<(u32, f64)> {
        let mut row = Vec::new();
        for &patch in &self.patches {
            let share = self.share(tracer, position, normal, patch, key, self.rays);
            if share > 0.0 {
                row.push((patch, f64::from(share)));
            }
        }
        row
    }

    /// The mean of the above over points of a patch: more of them for emitters that are near. `sobol`: of as many points as are taken near them.
    pub fn patch_row(&self, tracer: &Tracer, patch: usize, sobol: &Sobol) -> Vec<(u32, f64)> {
        let places = Places::of(tracer.scene, patch);
        let key = tracer.scene.patch_keys[patch];
        let (centre, radius) = ball(tracer.scene, patch);
        let rays = (self.rays / 4).max(4);
        let share = |emitter: u32, k: u32| {
            let [u, v, ..] = sobol.point(k, key ^ 0xe1);
            let (position, normal, _) = places.at(u, v);
            f64::from(self.share(tracer, position, normal, emitter, hash(key ^ u64::from(k)), rays))
        };
        let mean = |(&emitter, &(its_centre, its_radius)): (&u32, &(Vec3, f32))| {
            let is_near = centre.distance(its_centre) < NEAR * (radius + its_radius);
            let points = if is_near { MORE * SAMPLES } else { SAMPLES };
            (emitter, (0..points).map(|k| share(emitter, k)).sum::<f64>() / f64::from(points))
        };
        self.patches.iter().zip(&self.balls).map(mean).filter(|share| share.1 > 0.0).collect()
    }

    fn share(&self, tracer: &Tracer, position: Vec3, normal: Vec3, patch: u32, key: u64, rays: u32) -> f32 {
        let scene = tracer.scene;
        let range = scene.patch_triangles[patch as usize].clone();
        let back = scene.patch_back[patch as usize];
        let triangles = &scene.triangles[range.clone()];
        let polygon = (range.len() <= MANY)
            .then(|| triangles.iter().map(|t| triangle_share(position, normal, t, back)).sum::<f32>());
        if polygon.is_some_and(|share| share < 1e-9) {
            return 0.0;
        }
        let Carried { seen, all, rays, .. } =
            self.carried(tracer, position, normal, patch, key, rays, |_| Vec3::ZERO);
        match polygon {
            Some(polygon) if all > 0.0 => polygon * (seen / all),
            Some(_) => 0.0,
            None => {
                let area = scene.patch_areas[patch as usize] as f32;
                (seen * area / (PI * rays as f32)).min(1.0)
            }
        }
    }

    /// Of the light that arrives from an emitter: the mean of a function of its direction, per cosine.
    pub fn mean_per_cosine(
        &self,
        tracer: &Tracer,
        (position, normal): (Vec3, Vec3),
        patch: u32,
        key: u64,
        of: impl Fn(Vec3) -> Vec3,
    ) -> Vec3 {
        let per_cosine = |direction: Vec3| of(direction) / normal.dot(direction);
        let Carried { seen, weighted, .. } =
            self.carried(tracer, position, normal, patch, key, self.rays, per_cosine);
        if seen > 0.0 { weighted / seen } else { Vec3::ZERO }
    }

    /// `of`: a function of the direction, summed over what is seen.
    #[expect(clippy::too_many_arguments)]
    fn carried(
        &self,
        tracer: &Tracer,
        position: Vec3,
        normal: Vec3,
        patch: u32,
        key: u64,
        rays: u32,
        of: impl Fn(Vec3) -> Vec3,
    ) -> Carried {
        let scene = tracer.scene;
        let places = Places::of(scene, patch as usize);
        let seed = hash(key ^ scene.patch_keys[patch as usize]);
        let mut sums = Carried { seen: 0.0, all: 0.0, weighted: Vec3::ZERO, rays };
        let mut k = 0;
        while k < sums.rays {
            let [u, v, ..] = self.sobol.point(k, seed);
            let (at, facing, _) = places.at(u, v);
            let way = at - position;
            let distance2 = way.length_squared();
            let carried = normal.dot(way).max(0.0) * (-facing.dot(way)).max(0.0) / (distance2 * distance2);
            if carried > 0.0 && carried.is_finite() {
                let chance = unit(hash(seed ^ u64::from(k)) as u32);
                sums.all += carried;
                if tracer.bvh.free_between([position, normal], [at, facing], chance, tracer.holes) {
                    sums.seen += carried;
                    sums.weighted += of(way / distance2.sqrt()) * carried;
                }
            }
            k += 1;
            if k == rays && sums.seen > 0.0 && sums.seen < sums.all {
                sums.rays = 4 * rays; // in the penumbra it takes more
            }
        }
        sums
    }
}

/// What shadow rays towards an emitter carry: unblocked, in all, and weighted of what is unblocked; and how many they
/// were.
struct Carried {
    seen: f32,
    all: f32,
    weighted: Vec3,
    rays: u32,
}

/// Lambert's form factor from a point to a triangle's front (or back), 0 where it is seen from the other side.
pub fn triangle_share(position: Vec3, normal: Vec3, triangle: &[Vec3; 3], back: bool) -> f32 {
    let [a, b, c] = *triangle;
    let facing = (b - a).cross(c - a) * if back { -1.0 } else { 1.0 };
    if facing.dot(position - a) <= 0.0 {
        return 0.0;
    }
    let mut clipped = [Vec3::ZERO; 4];
    let n = clip_to_horizon(triangle.map(|corner| corner - position), normal, &mut clipped);
    let mut sum = 0.0;
    for k in 0..n {
        let (p, q) = (clipped[k], clipped[(k + 1) % n]);
        let cross = p.cross(q);
        let length = cross.length();
        if length > 0.0 {
            sum += length.atan2(p.dot(q)) * normal.dot(cross) / length;
        }
    }
    // Seen from the front the corners run the other way round.
    (sum.abs() / (2.0 * PI)).min(1.0)
}

fn clip_to_horizon(corners: [Vec3; 3], normal: Vec3, out: &mut [Vec3; 4]) -> usize {
    let heights = corners.map(|corner| corner.dot(normal));
    let mut n = 0;
    for k in 0..3 {
        let next = (k + 1) % 3;
        if heights[k] >= 0.0 {
            out[n] = corners[k];
            n += 1;
        }
        if (heights[k] < 0.0) != (heights[next] < 0.0) {
            out[n] = corners[k].lerp(corners[next], heights[k] / (heights[k] - heights[next]));
            n += 1;
        }
    }
    if n < 3 { 0 } else { n }
}

/// The middle of a patch's box, and its farthest corner's distance from there.
fn ball(scene: &RayScene, patch: usize) -> (Vec3, f32) {
    let corners = || scene.triangles[scene.patch_triangles[patch].clone()].iter().flatten();
    let low = corners().fold(Vec3::INFINITY, |low, p| low.min(*p));
    let high = corners().fold(Vec3::NEG_INFINITY, |high, p| high.max(*p));
    let centre = low.midpoint(high);
    (centre, corners().fold(0.0, |radius: f32, p| radius.max(p.distance(centre))))
}

/// By row: shares of what arrives from each emitter.
pub type Towards = Vec<Vec<(u32, f64)>>;

pub fn patches_towards_emitters(tracer: &Tracer, emitters: &Emitters) -> Result<Towards, BakeError> {
    let points = Sobol::new(MORE * SAMPLES);
    rows_towards(tracer, emitters, "patches towards emitters", tracer.scene.patch_areas.len(), |i| {
        if emitters.is_emitter[i] { Vec::new() } else { emitters.patch_row(tracer, i, &points) }
    })
}

pub fn receivers_towards_emitters(tracer: &Tracer, emitters: &Emitters) -> Result<Towards, BakeError> {
    rows_towards(tracer, emitters, "receivers towards emitters", tracer.scene.receivers.len(), |i| {
        let place = &tracer.scene.receivers[i];
        emitters.row(tracer, place.position.as_vec3(), place.normal, place.key)
    })
}

fn rows_towards(
    tracer: &Tracer,
    emitters: &Emitters,
    stage: &str,
    rows: usize,
    row: impl Fn(usize) -> Vec<(u32, f64)> + Sync,
) -> Result<Towards, BakeError> {
    if emitters.patches.is_empty() {
        return Ok(vec![Vec::new(); rows]);
    }
    tracer.watcher.stage(stage, rows as u64);
    (0..rows)
        .into_par_iter()
        .map(|i| {
            if tracer.watcher.cancelled() {
                return Err(BakeError::Cancelled);
            }
            let row = row(i);
            tracer.watcher.advance(1, 0);
            Ok(row)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A unit square facing +Y at y = 0 seen from a point above, and the reverse.
    fn square(y: f32, up: bool) -> [[Vec3; 3]; 2] {
        let p = |x: f32, z: f32| Vec3::new(x, y, z);
        let q = [p(0.0, 0.0), p(0.0, 1.0), p(1.0, 1.0), p(1.0, 0.0)];
        if up { [[q[0], q[1], q[2]], [q[0], q[2], q[3]]] } else { [[q[0], q[2], q[1]], [q[0], q[3], q[2]]] }
    }

    fn seen(position: Vec3, normal: Vec3, y: f32, up: bool) -> f32 {
        square(y, up).iter().map(|t| triangle_share(position, normal, t, false)).sum()
    }

    #[test]
    fn a_square_has_the_form_factor_of_the_closed_form() {
        // Howell: parallel, under a corner, a = b = c = 1; centred at distance 1; perpendicular.
        assert!((seen(Vec3::new(0.0, 0.0, 0.0), Vec3::Y, 1.0, false) - 0.138_532).abs() < 1e-5);
        assert!((seen(Vec3::new(0.5, 0.0, 0.5), Vec3::Y, 1.0, false) - 0.239_456).abs() < 1e-5);
        assert!((seen(Vec3::new(0.0, 1.0, 0.0), Vec3::X, 0.0, true) - 0.055_734_2).abs() < 1e-5);
        assert_eq!(seen(Vec3::new(0.5, 0.0, 0.5), Vec3::Y, 1.0, true), 0.0);
        assert_eq!(seen(Vec3::new(0.5, 0.0, 0.5), -Vec3::Y, 1.0, false), 0.0);
    }
}
