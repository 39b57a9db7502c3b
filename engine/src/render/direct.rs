//! Direct light at patches: E = M + rho * H, by the shadow maps that the surfaces use too or by shadow rays.

use super::casters::Casters;
use super::instances::{Draw, Pass};
use super::lights::{self, GpuLight};
use super::rays::Rays;
use super::shaders;
use super::spaces::Spaces;
use crate::gpu::pass::{self, Binding};
use crate::gpu::shader::Library;
use crate::gpu::timing::Timer;
use crate::gpu::{Gpu, GpuError};
use crate::transport::direct::PlacedLight;
use crate::transport::{Occluders, Transport};

/// What tells patches whether a light reaches them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PatchShadows {
    /// Honour holes of pictures; their filter blurs what is finer than a texel.
    Maps,
    /// Exact; whatever casts is solid.
    Rays,
}

impl PatchShadows {
    /// Rays, unless a caster has holes. Rays are exact, need no bias and no map; that they cost no more even where a
    /// processor draws was measured: 2400 patches of 4 samples take 8, 27 and 90 ms with 1, 4 and 16 lights on
    /// llvmpipe, by maps 7, 34 and 99 ms.
    pub fn best(holes: bool) -> Self {
        if holes { Self::Maps } else { Self::Rays }
    }
}

pub struct Direct {
    /// By maps, by rays.
    pipelines: [wgpu::ComputePipeline; 2],
    group: wgpu::BindGroup,
    rays: Rays,
    patch_count: u32,
    /// As set by the settings.
    chosen: Option<PatchShadows>,
    used: PatchShadows,
    lights: Vec<GpuLight>,
}

impl Direct {
    pub fn new(
        gpu: &Gpu,
        library: &mut Library,
        [frame_layout, scene_layout]: [&wgpu::BindGroupLayout; 2],
        spaces: &Spaces,
        transport: &Transport,
        occluders: &Occluders,
        chosen: Option<PatchShadows>,
    ) -> Result<Self, GpuError> {
        use Binding::{Read, Write};
        let module = library.module(gpu, shaders::DIRECT)?;
        let layout =
            pass::layout(gpu, "direct", wgpu::ShaderStages::COMPUTE, &[Read, Read, Read, Read, Write]);
        let rays = Rays::new(gpu, transport, occluders)?;
        let groups = [Some(frame_layout), Some(scene_layout), Some(&layout), Some(rays.layout())];
        Ok(Self {
            pipelines: ["direct", "direct_by_rays"].map(|entry| pass::compute(gpu, &module, entry, &groups)),
            group: pass::buffers(
                gpu,
                "direct",
                &layout,
                &[&spaces.patches, &spaces.samples, &spaces.albedo, &spaces.emitted, &spaces.exitance],
            ),
            rays,
            patch_count: spaces.patch_count,
            chosen,
            used: PatchShadows::Maps,
            lights: Vec::new(),
        })
    }

    /// Follows lights and casters. `maps_changed`: a light, or what its shadow map shows, differs from the last frame.
    /// Returns whether what arrives at patches does.
    pub fn follow(
        &mut self,
        gpu: &Gpu,
        placed: &[PlacedLight],
        casters: &Casters<'_>,
        maps: &[GpuLight],
        maps_changed: bool,
    ) -> bool {
        let shining = placed.iter().filter(|light| lights::shines(light));
        let casting = shining.clone().any(|light| light.light.casts_shadows);
        let now: Vec<GpuLight> = shining.map(lights::on_gpu).collect();
        let holes = casters.instances.draws.iter().any(|draw| draw.casts && has_holes(draw, casters));
        let used = self.chosen.unwrap_or_else(|| PatchShadows::best(holes));
        let asked = used == PatchShadows::Rays || maps.iter().any(|light| light.layer == lights::UNMAPPED);
        let moved = asked && casting && self.rays.follow(gpu, casters);
        let switched = used != self.used || now != self.lights;
        (self.used, self.lights) = (used, now);
        switched || moved || (maps_changed && used == PatchShadows::Maps)
    }

    pub fn used(&self) -> PatchShadows {
        self.used
    }

    pub fn bytes(&self) -> u64 {
        self.rays.bytes()
    }

    /// Returns the dispatches.
    pub fn run(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        timer: &mut Timer,
        frame: &wgpu::BindGroup,
        scene: &wgpu::BindGroup,
    ) -> u32 {
        if self.patch_count == 0 {
            return 0;
        }
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("direct"),
            timestamp_writes: timer.compute("direct"),
        });
        pass.set_pipeline(&self.pipelines[usize::from(self.used == PatchShadows::Rays)]);
        pass.set_bind_group(0, frame, &[]);
        pass.set_bind_group(1, scene, &[]);
        pass.set_bind_group(2, &self.group, &[]);
        pass.set_bind_group(3, self.rays.group(), &[]);
        pass::dispatch(&mut pass, self.patch_count);
        1
    }
}

/// Whether a picture says where the light gets through.
fn has_holes(draw: &Draw, casters: &Casters<'_>) -> bool {
    draw.pass != Pass::Opaque && casters.materials.material(draw.material).albedo.texture.is_some()
}
