//! Cubemaps that are captured once and kept: what came from disk, and what is to go there.

use std::collections::HashMap;

use super::Reflections;
use super::capture::Set;
use super::cubes::unit_of;
use crate::gpu::{Gpu, GpuError, texture};
use crate::scene::{EntityId, Refresh};
use crate::transport::reflection::Cube;

impl Reflections {
    /// Cubemaps of baked probes, from disk: they need no capture.
    pub fn give(&mut self, cubes: HashMap<EntityId, Cube>) {
        self.given.extend(cubes);
    }

    /// Cubemaps of baked probes that were captured for good. Blocks where there are any.
    pub fn finished(&self, gpu: &Gpu) -> Result<Vec<(EntityId, Cube)>, GpuError> {
        let finished = self
            .probes
            .iter()
            .filter(|probe| probe.settings.refresh == Refresh::Baked && probe.schedule.is_done());
        finished
            .map(|probe| {
                let cube = self.prefilter.read(gpu, &probe.source.texture, 0)?;
                let radiance = cube.texels().iter().map(|texel| *texel * probe.read_unit).collect();
                Ok((probe.entity, Cube::new(cube.size(), radiance)))
            })
            .collect()
    }

    /// Returns whether any were taken.
    pub(super) fn take_given(&mut self, encoder: &mut wgpu::CommandEncoder, set: &mut Set<'_>) -> bool {
        if self.given.is_empty() {
            return false;
        }
        for (index, probe) in self.probes.iter_mut().enumerate() {
            let Some(cube) = self.given.remove(&probe.entity) else { continue };
            if probe.settings.refresh == Refresh::Baked && cube.size() == probe.source.size as usize {
                let brightest = cube.texels().iter().map(|texel| texel.max_element()).fold(0.0, f32::max);
                probe.unit = unit_of(brightest, 1.0);
                probe.read_unit = probe.unit;
                upload(set.gpu, &probe.source.texture, &cube, probe.unit);
                self.prefilter.run(encoder, set.timer, &probe.source, &self.cubes.faces[index + 1]);
                probe.schedule.keep();
            }
        }
        self.given.clear();
        self.write_probes(set.gpu);
        true
    }
}

/// Into the largest level, over `unit`.
pub fn upload(gpu: &Gpu, texture: &wgpu::Texture, cube: &Cube, unit: f32) {
    let size = cube.size() as u32;
    for (face, texels) in (0..).zip(cube.texels().chunks_exact((size * size) as usize)) {
        let halves: Vec<[u16; 4]> =
            texels.iter().map(|texel| (*texel / unit).extend(1.0).to_array().map(texture::half)).collect();
        let origin = wgpu::Origin3d { x: 0, y: 0, z: face };
        gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo { origin, ..texture.as_image_copy() },
            bytemuck::cast_slice(&halves),
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(size * 8), rows_per_image: None },
            wgpu::Extent3d { width: size, height: size, depth_or_array_layers: 1 },
        );
    }
}
