//! Surfaces that lie on others and face the same way: the floor of one module of a kit on the floor of the next.
//!
//! A ray that comes down on both meets the one of the lower number, always. The other would send light to patches that
//! send it none, and both together would be twice as large to all others as what is seen of them. So what is covered
//! takes no part in the exchange: no row, and nobody's column. Its receivers see what lies around all the same.

use engine::transport::bvh::{Bvh, Holes, patch_of};
use rayon::prelude::*;

use crate::directions::Sobol;
use crate::layout::{Places, RayScene, SAMPLES};

/// What may have holes covers nothing.
struct Open;

impl Holes for Open {
    fn passes(&self, _: u32, _: [f32; 2], _: f32) -> bool {
        true
    }
}

/// By patch: does it lie under others, at all of its points? `holed`: one a triangle, or empty.
pub fn covered(scene: &RayScene, bvh: &Bvh, holed: &[bool]) -> Vec<bool> {
    let sobol = Sobol::new(SAMPLES);
    let is_holed = |patch: usize| scene.patch_triangles[patch].clone().any(|t| holed.get(t) == Some(&true));
    let is_covered = |patch: usize| {
        let places = Places::of(scene, patch);
        (0..SAMPLES).all(|k| {
            let [u, v, ..] = sobol.point(k, scene.patch_keys[patch] ^ 0x5a);
            lies_under(scene, bvh, patch, &places, [u, v])
        })
    };
    (0..scene.patch_areas.len()).into_par_iter().map(|patch| !is_holed(patch) && is_covered(patch)).collect()
}

/// Is another patch met where this one should be, seen from where its rays start?
fn lies_under(scene: &RayScene, bvh: &Bvh, patch: usize, places: &Places, [u, v]: [f32; 2]) -> bool {
    let (position, normal, _) = places.at(u, v);
    bvh.closest(position, normal, -normal, 0.0, &Open).is_some_and(|hit| {
        let met = patch_of(&hit, &scene.patches);
        bvh.distance(&hit) <= 2.0 * bvh.offset() && met.is_some_and(|met| met as usize != patch)
    })
}
