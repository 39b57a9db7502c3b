//! The end of long paths: light that is known well enough after a few bounces.
//!
//! ```text
//! L_r(y_k) ~ (B_i - M_i) / pi          y_k on patch i, the k-th surface that a path meets
//! ```
//! In a room of white walls paths have a hundred bounces, and each adds its noise. What the radiosity B of patches, solved
//! elsewhere, is off by in detail, k bounces average away; what is left is how far the light of the whole room is off, and
//! paths without an end find that, over many points together. Flat, opaque and diffuse surfaces only.

use std::f64::consts::FRAC_1_PI;

use engine::transport::Transport;
use engine::transport::bvh::{Bvh, Holes, patch_of};
use glam::{DVec3, Vec3};

use super::world::Ray;

/// What patches reflect.
pub struct Tail {
    /// The surface at which a path ends, counted from 1.
    pub(super) bounces: u32,
    /// By patch [W/m2].
    reflected: Vec<DVec3>,
    patches: Vec<[u32; 2]>,
    bvh: Bvh,
    origin: DVec3,
}

impl Tail {
    /// `reflected`: radiosity but for what patches emit [W/m2].
    pub fn new(transport: &Transport, reflected: Vec<DVec3>, bounces: u32) -> Self {
        let surface = &transport.surface;
        let triangles: Vec<[Vec3; 3]> = (0..surface.triangles.len()).map(|t| surface.positions(t)).collect();
        Self {
            bounces,
            reflected,
            patches: surface.patches.clone(),
            bvh: Bvh::new(&triangles, Vec::new()),
            origin: transport.origin,
        }
    }

    /// Radiance that comes back along a ray, which starts so far from an origin of its own [W/m2/sr].
    pub(super) fn radiance(&self, ray: &Ray, origin: DVec3) -> DVec3 {
        let from = ray.origin + (origin - self.origin).as_vec3();
        let hit = self.bvh.closest(from, ray.normal, ray.direction, 0.5, &Opaque);
        let patch = hit.and_then(|hit| patch_of(&hit, &self.patches));
        patch.map_or(DVec3::ZERO, |patch| self.reflected[patch as usize] * FRAC_1_PI)
    }
}

struct Opaque;

impl Holes for Opaque {
    fn passes(&self, _triangle: u32, _barycentric: [f32; 2], _chance: f32) -> bool {
        false
    }
}
