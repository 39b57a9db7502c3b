//! A scene's light: the surfaces that it falls on, and what stands in its way.

use engine::scene::Scene;
use engine::scene::assets::Assets;
use engine::transport::Transport;
use engine::transport::bvh::{Bvh, Holes};
use engine::transport::materials::{PatchMaterials, of_patches};
use engine::transport::solve::limit_gain;
use glam::Vec3;

use crate::directions::{hash, unit};
use crate::holes::AlphaHoles;

/// A scene's light, and the surfaces that it falls on.
pub struct Sources<'a> {
    pub scene: &'a Scene,
    pub assets: &'a Assets,
    pub full: &'a Transport,
    pub unlimited_gain: bool,
}

impl Sources<'_> {
    pub fn materials(&self) -> PatchMaterials {
        of_patches(self.full, self.scene, self.assets)
    }

    /// By patch, as closed rooms can bear it.
    pub fn albedo(&self) -> Vec<Vec3> {
        let mut albedo = self.materials().albedo;
        if !self.unlimited_gain {
            limit_gain(&self.full.patch_from_patch, &self.full.patches, &mut albedo);
        }
        albedo
    }
}

/// Static surfaces that cast shadows, with their holes.
pub struct Blockers<'a> {
    bvh: Bvh,
    holes: AlphaHoles<'a>,
    /// By triangle: it casts none.
    open: Vec<bool>,
}

impl<'a> Blockers<'a> {
    pub fn new(sources: &Sources<'a>) -> Self {
        let surface = &sources.full.surface;
        let holes = AlphaHoles::new(surface, sources.scene, sources.assets);
        let mut open = vec![false; surface.triangles.len()];
        for batch in &surface.batches {
            let renderer = sources.scene.entity(batch.entity()).and_then(|entity| entity.mesh.as_ref());
            let is_open = renderer.is_some_and(|renderer| !renderer.casts_shadows);
            open[batch.first as usize..][..batch.count as usize].fill(is_open);
        }
        let mut holed = holes.holed();
        if open.contains(&true) {
            holed.resize(open.len(), false);
            holed.iter_mut().zip(&open).for_each(|(holed, open)| *holed |= open);
        }
        let corners: Vec<[Vec3; 3]> = (0..surface.triangles.len()).map(|t| surface.positions(t)).collect();
        Self { bvh: Bvh::new(&corners, holed), holes, open }
    }

    /// Is the way from a point on a surface free?
    pub fn visible(&self, from: Vec3, normal: Vec3, to: Vec3) -> bool {
        self.bvh.visible(from, normal, to, unit(hash(u64::from(from.x.to_bits())) as u32), self)
    }
}

impl Holes for Blockers<'_> {
    fn passes(&self, triangle: u32, barycentric: [f32; 2], chance: f32) -> bool {
        self.open[triangle as usize] || self.holes.passes(triangle, barycentric, chance)
    }
}
