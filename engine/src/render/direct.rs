//! Direct light at patches: E = M + rho * H, by the shadow maps that the surfaces use too.

use super::shaders;
use super::spaces::Spaces;
use crate::gpu::pass::{self, Binding};
use crate::gpu::shader::Library;
use crate::gpu::timing::Timer;
use crate::gpu::{Gpu, GpuError};

pub struct Direct {
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
    patch_count: u32,
}

impl Direct {
    pub fn new(
        gpu: &Gpu,
        library: &mut Library,
        frame_layout: &wgpu::BindGroupLayout,
        scene_layout: &wgpu::BindGroupLayout,
        spaces: &Spaces,
    ) -> Result<Self, GpuError> {
        use Binding::{Read, Write};
        let module = library.module(gpu, shaders::DIRECT)?;
        let layout =
            pass::layout(gpu, "direct", wgpu::ShaderStages::COMPUTE, &[Read, Read, Read, Read, Write]);
        let groups = [Some(frame_layout), Some(scene_layout), Some(&layout)];
        Ok(Self {
            pipeline: pass::compute(gpu, &module, "direct", &groups),
            group: pass::buffers(
                gpu,
                "direct",
                &layout,
                &[&spaces.patches, &spaces.samples, &spaces.albedo, &spaces.emitted, &spaces.exitance],
            ),
            patch_count: spaces.patch_count,
        })
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
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, frame, &[]);
        pass.set_bind_group(1, scene, &[]);
        pass.set_bind_group(2, &self.group, &[]);
        pass::dispatch(&mut pass, self.patch_count);
        1
    }
}
