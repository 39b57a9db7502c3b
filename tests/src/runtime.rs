//! A bake in the real renderer, its light read back from the GPU.

use engine::gpu::buffer;
use engine::render::{Drawn, Eye, Settings, View};
use engine::scene::Scene;
use glam::{DVec3, Vec3, Vec4};

use crate::picture::{Studio, gpu};
use crate::solution::Solved;

pub struct Runtime {
    pub studio: Studio,
}

impl Runtime {
    /// `None`, said in one line, where there is no GPU.
    pub fn new(solved: &Solved) -> Option<Self> {
        let settings =
            Settings { samples: Some(1), unlimited_gain: solved.unlimited_gain, ..Settings::default() };
        let eye = Eye::looking(DVec3::new(0.5, 0.5, 0.9), DVec3::splat(0.5));
        let transport = (*solved.transport).clone();
        let mut studio = Studio::with(gpu()?, transport, eye, [8, 8], settings);
        studio.assets = solved.assets.clone();
        Some(Self { studio })
    }

    pub fn frame(&mut self, scene: &Scene) -> Drawn {
        self.studio.draw(scene, View::Composite)
    }

    /// Until nothing is left to do.
    pub fn settle(&mut self, scene: &Scene) -> Drawn {
        self.studio.settle(scene, View::Composite)
    }

    /// B by patch [W/m2].
    pub fn radiosity(&self) -> Vec<Vec3> {
        self.of_patches(&self.studio.renderer.spaces().radiosity)
    }

    /// E by patch [W/m2].
    pub fn exitance(&self) -> Vec<Vec3> {
        self.of_patches(&self.studio.renderer.spaces().exitance)
    }

    fn of_patches(&self, buffer: &wgpu::Buffer) -> Vec<Vec3> {
        let renderer = &self.studio.renderer;
        let values = &self.read(buffer)[..renderer.transport().patches.len()];
        values.iter().map(|value| *value * renderer.light_unit()).collect()
    }

    /// What receivers and probes hold: emitted light's, then that of what is reflected.
    pub fn gathered(&self) -> Vec<Vec3> {
        let spaces = self.studio.renderer.spaces();
        spaces.receivers.iter().chain(&spaces.probes).flat_map(|buffer| self.read(buffer)).collect()
    }

    fn read(&self, buffer: &wgpu::Buffer) -> Vec<Vec3> {
        let all: Vec<Vec4> = buffer::read(self.studio.renderer.gpu(), buffer).expect("a buffer");
        all.iter().map(|value| value.truncate()).collect()
    }
}
