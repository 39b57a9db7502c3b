//! Light probes after the gather: no irradiance below 0 ([`crate::transport::dering`]).

use std::sync::Arc;

use super::channels::Channels;
use super::gather::Source;
use super::shaders;
use super::spaces::Spaces;
use crate::gpu::Gpu;
use crate::gpu::pass::{self, Binding};
use crate::gpu::pipeline::{Compiler, Compute};
use crate::gpu::timing::Timer;

pub struct Dering {
    pipeline: Compute,
    /// By source.
    probes: [wgpu::BindGroup; 2],
    count: u32,
    channels: Channels,
    layout: wgpu::BindGroupLayout,
}

impl Dering {
    pub fn new(gpu: &Gpu, compiler: &Arc<Compiler>, spaces: &Spaces) -> Self {
        let layout = pass::layout(gpu, "dering", wgpu::ShaderStages::COMPUTE, &[Binding::Write]);
        Self {
            pipeline: Compute::new(compiler, shaders::DERING, &[None, None, Some(&layout)]),
            probes: groups(gpu, &layout, spaces),
            count: spaces.probe_count,
            channels: spaces.channels,
            layout,
        }
    }

    /// The light of probes lies elsewhere.
    pub fn bind(&mut self, gpu: &Gpu, spaces: &Spaces) {
        self.probes = groups(gpu, &self.layout, spaces);
        self.channels = spaces.channels;
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
        if !self.pipeline.set(&mut pass, "dering", self.channels.defines()) {
            return 0;
        }
        pass.set_bind_group(2, &self.probes[source as usize], &[]);
        pass::dispatch(&mut pass, self.count);
        1
    }
}

fn groups(gpu: &Gpu, layout: &wgpu::BindGroupLayout, spaces: &Spaces) -> [wgpu::BindGroup; 2] {
    spaces.probes.each_ref().map(|probes| pass::buffers(gpu, "dering", layout, &[probes]))
}
