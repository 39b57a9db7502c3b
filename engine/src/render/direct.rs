//! Direct light at patches: E = M + rho * H, by the shadow maps that the surfaces use too or by shadow rays.

use std::sync::Arc;

use super::casters::Casters;
use super::lights::{self, GpuLight};
use super::rays::Rays;
use super::shaders;
use super::spaces::Spaces;
use crate::gpu::pass::{self, Binding};
use crate::gpu::pipeline::{Compiler, Compute};
use crate::gpu::timing::Timer;
use crate::gpu::{Gpu, GpuError, buffer};
use crate::transport::direct::PlacedLight;
use crate::transport::{Occluders, Transport};

/// What tells patches whether a light reaches them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PatchShadows {
    /// Honour holes of pictures; their filter blurs what is finer than a texel.
    Maps,
    /// Exact; a ray that meets something with holes asks the map. They need no bias, and cost no more even where a
    /// processor draws (2400 patches of 4 samples, a thread a patch, on llvmpipe: 8, 27 and 90 ms with 1, 4 and 16
    /// lights, by maps 7, 34 and 99 ms).
    #[default]
    Rays,
}

/// What light meets on its way to patches, and what arrives.
struct Met {
    rays: Rays,
    /// By sample.
    arrived: wgpu::Buffer,
    group: wgpu::BindGroup,
}

pub struct Direct {
    pipelines: Compute,
    layout: wgpu::BindGroupLayout,
    rays_layout: wgpu::BindGroupLayout,
    /// Once a light shines.
    met: Option<Met>,
    /// As set by the settings.
    chosen: Option<PatchShadows>,
    used: PatchShadows,
    lights: Vec<GpuLight>,
}

impl Direct {
    pub fn new(
        gpu: &Gpu,
        compiler: &Arc<Compiler>,
        [frame_layout, scene_layout]: [&wgpu::BindGroupLayout; 2],
        chosen: Option<PatchShadows>,
    ) -> Self {
        use Binding::{Read, Write};
        let layout =
            pass::layout(gpu, "direct", wgpu::ShaderStages::COMPUTE, &[Read, Read, Read, Read, Write, Write]);
        let rays_layout = Rays::layout(gpu);
        let groups = [Some(frame_layout), Some(scene_layout), Some(&layout), Some(&rays_layout)];
        Self {
            pipelines: Compute::new(compiler, shaders::DIRECT, &groups),
            layout,
            rays_layout,
            met: None,
            chosen,
            used: PatchShadows::Maps,
            lights: Vec::new(),
        }
    }

    /// Follows lights and casters. `maps_changed`: a light, or what its shadow map shows, differs from the last frame.
    /// Returns whether what arrives at patches does.
    pub fn follow(
        &mut self,
        gpu: &Gpu,
        spaces: &Spaces,
        (transport, occluders): (&Transport, &Occluders),
        placed: &[PlacedLight],
        casters: &Casters<'_>,
        (maps, maps_changed): (&[GpuLight], bool),
    ) -> Result<bool, GpuError> {
        if spaces.patch_count == 0 {
            return Ok(false);
        }
        let shining = placed.iter().filter(|light| lights::shines(light));
        let casting = shining.clone().any(|light| light.light.casts_shadows);
        let now: Vec<GpuLight> = shining.map(lights::on_gpu).collect();
        let used = self.chosen.unwrap_or_default();
        let asked = used == PatchShadows::Rays || maps.iter().any(|light| light.layer == lights::UNMAPPED);
        if placed.is_empty() {
            self.met = None;
        } else if self.met.is_none() && !now.is_empty() {
            let rays = Rays::new(gpu, &self.rays_layout, transport, occluders)?;
            let (arrived, group) = arriving(gpu, &self.layout, spaces);
            self.met = Some(Met { rays, arrived, group });
        }
        let follows = |met: &mut Met| asked && casting && met.rays.follow(gpu, &self.rays_layout, casters);
        let moved = self.met.as_mut().is_some_and(follows);
        let switched = used != self.used || now != self.lights;
        (self.used, self.lights) = (used, now);
        let by_maps = used == PatchShadows::Maps || self.met.as_ref().is_some_and(|met| met.rays.asks_maps());
        Ok(switched || moved || (maps_changed && by_maps))
    }

    /// Light lies elsewhere.
    pub fn bind(&mut self, gpu: &Gpu, spaces: &Spaces) {
        if let Some(met) = &mut self.met {
            (met.arrived, met.group) = arriving(gpu, &self.layout, spaces);
        }
    }

    pub fn used(&self) -> PatchShadows {
        self.used
    }

    pub fn bytes(&self) -> u64 {
        self.met.as_ref().map_or(0, |met| met.rays.bytes() + met.arrived.size())
    }

    /// Returns the dispatches.
    pub fn run(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        timer: &mut Timer,
        [frame, scene]: [&wgpu::BindGroup; 2],
        spaces: &Spaces,
    ) -> u32 {
        if spaces.patch_count == 0 {
            return 0;
        }
        let Some(met) = self.met.as_ref().filter(|_| !self.lights.is_empty()) else {
            // No light shines: E = M.
            encoder.copy_buffer_to_buffer(&spaces.emitted, 0, &spaces.exitance, 0, spaces.exitance.size());
            return 0;
        };
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("direct"),
            timestamp_writes: timer.compute("direct"),
        });
        let entry = if self.used == PatchShadows::Rays { "direct_by_rays" } else { "direct" };
        let defines = spaces.channels.defines();
        if !self.pipelines.set(&mut pass, entry, defines) {
            return 0;
        }
        pass.set_bind_group(0, frame, &[]);
        pass.set_bind_group(1, scene, &[]);
        pass.set_bind_group(2, &met.group, &[]);
        pass.set_bind_group(3, met.rays.group(), &[]);
        pass::dispatch(&mut pass, spaces.sample_count);
        if !self.pipelines.set(&mut pass, "leave", defines) {
            return 1;
        }
        pass::dispatch(&mut pass, spaces.patch_count);
        2
    }
}

/// What arrives by sample, and the group that it is bound in.
fn arriving(gpu: &Gpu, layout: &wgpu::BindGroupLayout, spaces: &Spaces) -> (wgpu::Buffer, wgpu::BindGroup) {
    let bytes = u64::from(spaces.sample_count) * spaces.channels.stride();
    let arrived = buffer::empty(gpu, "arrived", bytes, wgpu::BufferUsages::STORAGE);
    let Spaces { patches, samples, albedo, emitted, exitance, .. } = spaces;
    let group =
        pass::buffers(gpu, "direct", layout, &[patches, samples, albedo, emitted, exitance, &arrived]);
    (arrived, group)
}
