//! Light probes after the gather: no irradiance below 0 ([`crate::transport::dering`]).

use super::gather::Source;
use super::shaders;
use super::spaces::Spaces;
use crate::gpu::pass::{self, Binding};
use crate::gpu::shader::Library;
use crate::gpu::timing::Timer;
use crate::gpu::{Gpu, GpuError};

pub struct Dering {
    pipeline: wgpu::ComputePipeline,
    /// By source.
    probes: [wgpu::BindGroup; 2],
    count: u32,
}

impl Dering {
    pub fn new(gpu: &Gpu, library: &mut Library, spaces: &Spaces) -> Result<Self, GpuError> {
        let module = library.module(gpu, shaders::DERING)?;
        let layout = pass::layout(gpu, "dering", wgpu::ShaderStages::COMPUTE, &[Binding::Write]);
        let group = |probes: &wgpu::Buffer| pass::buffers(gpu, "dering", &layout, &[probes]);
        Ok(Self {
            pipeline: pass::compute(gpu, &module, "dering", &[None, None, Some(&layout)]),
            probes: spaces.probes.each_ref().map(group),
            count: spaces.probe_count,
        })
    }

    /// Returns the dispatches.
    pub fn run(&self, encoder: &mut wgpu::CommandEncoder, timer: &mut Timer, source: Source) -> u32 {
        if self.count == 0 {
            return 0;
        }
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("dering"),
            timestamp_writes: timer.compute("dering"),
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(2, &self.probes[source as usize], &[]);
        pass::dispatch(&mut pass, self.count);
        1
    }
}
