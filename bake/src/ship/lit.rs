//! Which patches light comes to, and what stands in its way.

use engine::scene::assets::Assets;
use engine::scene::{Changes, Entity, Scene, SkyKind, world_from_local};
use engine::transport::Transport;
use engine::transport::bvh::{Bvh, Holes};
use engine::transport::direct::{PlacedLight, irradiance_of_patches, placed_lights};
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

    /// By patch: it neither reflects nor emits.
    pub fn black(&self) -> Vec<bool> {
        let PatchMaterials { albedo, exitance } = self.materials();
        albedo
            .iter()
            .zip(exitance)
            .map(|(albedo, emits)| *albedo == Vec3::ZERO && emits == Vec3::ZERO)
            .collect()
    }

    /// By patch: no emitter, sky or light comes to its component, however bright they are made.
    pub fn unlit(&self) -> Vec<bool> {
        let patches = &self.full.patches;
        let bright = brightened(self.scene);
        if bright.entities.iter().any(|entity| entity.light.is_some() && roams(&bright, entity)) {
            return vec![false; patches.len()]; // who knows where to
        }
        let mut lit = vec![false; patches.len()];
        let emits = of_patches(self.full, &bright, self.assets).exitance;
        let arrives = self.from_lights(&bright);
        for (i, patch) in patches.iter().enumerate() {
            let shines = emits[i] != Vec3::ZERO || arrives[i] != Vec3::ZERO || self.sees_sky(i);
            lit[patch.component as usize] |= shines;
        }
        patches.iter().map(|patch| !lit[patch.component as usize]).collect()
    }

    fn sees_sky(&self, patch: usize) -> bool {
        let n = self.full.patches.len();
        let shines = self.scene.sky.kind != SkyKind::None;
        shines && self.full.patch_from_patch.row(patch).any(|(column, _)| column as usize >= n)
    }

    /// By patch: the irradiance from a scene's lights.
    fn from_lights(&self, scene: &Scene) -> Vec<Vec3> {
        let lights = placed_lights(scene, &world_from_local(scene), self.full.origin);
        let blockers = Blockers::new(self);
        irradiance_of_patches(self.full, &lights, &|a, b, c| blockers.visible(a, b, c))
    }
}

/// All that may shine does.
fn brightened(scene: &Scene) -> Scene {
    let mut bright = scene.clone();
    let lights = bright.entities.iter_mut().filter_map(|entity| entity.light.as_mut());
    for light in lights.filter(|light| light.changes != Changes::Never || light.switching.is_some()) {
        (light.on, light.intensity) = (true, light.intensity.max(1.0));
    }
    let emissions = bright.materials.iter_mut().map(|material| &mut material.emission);
    for emission in emissions.filter(|emission| emission.changes != Changes::Never) {
        emission.strength = emission.strength.max(1.0);
    }
    bright
}

/// Does it move, or what carries it?
fn roams(scene: &Scene, entity: &Entity) -> bool {
    let parent = |entity: &&Entity| entity.parent.and_then(|parent| scene.entity(parent));
    let chain = std::iter::successors(Some(entity), parent).take(scene.entities.len() + 1);
    chain.into_iter().any(|entity| entity.motion.is_some())
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
