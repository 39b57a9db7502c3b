//! The gather: what arrives at receivers and light probes, from what is emitted and from what bounced; and what tilts it
//! towards the normals of normal maps, where there are any ([`crate::transport::directional`]).

use bytemuck::{Pod, Zeroable};

use super::rows::{PagedRows, Summed};
use super::shaders;
use super::spaces::Spaces;
use crate::gpu::pass::{self, Binding};
use crate::gpu::shader::Library;
use crate::gpu::timing::Timer;
use crate::gpu::{Gpu, GpuError, buffer};

/// `Mean` in `transport/mean.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct MeanUniform {
    pub receivers: u32,
    pub share: f32,
    pub probe: u32,
    pub padding: u32,
}

/// What is gathered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// Emitters and sky.
    Emitted = 0,
    Bounced = 1,
}

pub struct Gather {
    pipeline: wgpu::ComputePipeline,
    mean: wgpu::ComputePipeline,
    summed: Summed,
    receiver_rows: PagedRows,
    directional_rows: PagedRows,
    probe_rows: PagedRows,
    /// By source.
    receivers: [wgpu::BindGroup; 2],
    /// `None` where there are no directional rows.
    directional: Option<[wgpu::BindGroup; 2]>,
    probes: [wgpu::BindGroup; 2],
    means: [wgpu::BindGroup; 2],
    mean_own: wgpu::BindGroup,
    any_receivers: bool,
}

impl Gather {
    pub fn new(
        gpu: &Gpu,
        library: &mut Library,
        [frame_layout, page_layout]: [&wgpu::BindGroupLayout; 2],
        [receiver_rows, directional_rows, probe_rows]: [PagedRows; 3],
        summed: Summed,
        spaces: &Spaces,
    ) -> Result<Self, GpuError> {
        let compute = wgpu::ShaderStages::COMPUTE;
        let module = library.module(gpu, shaders::GATHER)?;
        let mean_module = library.module(gpu, shaders::MEAN)?;
        let layout = pass::layout(gpu, "gather", compute, &[Binding::Read, Binding::Write]);
        let mean_layout = pass::layout(gpu, "mean", compute, &[Binding::Uniform]);
        // From an element on.
        let groups_from = |from: [&wgpu::Buffer; 2], to: &[wgpu::Buffer; 2], first: u32| {
            let behind = |buffer| wgpu::BufferBinding { buffer, offset: u64::from(first) * 16, size: None };
            [0, 1].map(|i| {
                let resources = [from[i].as_entire_binding(), wgpu::BindingResource::Buffer(behind(&to[i]))];
                pass::group(gpu, "gather", &layout, &resources)
            })
        };
        let groups = |from, to| groups_from(from, to, 0);
        let entry = match summed {
            Summed::ByThread => "gather",
            Summed::ByGroup => "gather_by_group",
        };
        let uniform = MeanUniform {
            receivers: spaces.receiver_count,
            share: 1.0 / spaces.valid_receivers.max(1) as f32,
            probe: spaces.probe_count * 9,
            padding: 0,
        };
        let uniform = buffer::filled(gpu, "mean", &[uniform], wgpu::BufferUsages::UNIFORM);
        let sources = [&spaces.emitted, &spaces.bounced];
        Ok(Self {
            pipeline: pass::compute(
                gpu,
                &module,
                entry,
                &[Some(frame_layout), None, Some(&layout), Some(page_layout)],
            ),
            mean: pass::compute(gpu, &mean_module, "mean", &[None, None, Some(&layout), Some(&mean_layout)]),
            summed,
            receivers: groups(sources, &spaces.receivers),
            directional: (!directional_rows.is_empty())
                .then(|| groups_from(sources, &spaces.receivers, spaces.directional)),
            probes: groups(sources, &spaces.probes),
            means: groups(spaces.receivers.each_ref(), &spaces.probes),
            mean_own: pass::buffers(gpu, "mean", &mean_layout, &[&uniform]),
            any_receivers: !receiver_rows.is_empty(),
            receiver_rows,
            directional_rows,
            probe_rows,
        })
    }

    pub fn bytes(&self) -> u64 {
        let directional = if self.directional.is_some() { self.directional_rows.bytes } else { 0 };
        self.receiver_rows.bytes + directional + self.probe_rows.bytes
    }

    /// `moving`: whether anything reads probes. Returns the dispatches.
    pub fn run(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        timer: &mut Timer,
        frame: &wgpu::BindGroup,
        source: Source,
        moving: bool,
    ) -> u32 {
        if !self.any_receivers && self.probe_rows.is_empty() {
            return 0;
        }
        let which = source as usize;
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("gather"),
            timestamp_writes: timer.compute("gather"),
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, frame, &[]);
        pass.set_bind_group(2, &self.receivers[which], &[]);
        let mut dispatches = self.receiver_rows.dispatch(&mut pass, self.summed);
        if let Some(directional) = &self.directional {
            pass.set_bind_group(2, &directional[which], &[]);
            dispatches += self.directional_rows.dispatch(&mut pass, self.summed);
        }
        if !moving {
            return dispatches;
        }
        pass.set_bind_group(2, &self.probes[which], &[]);
        dispatches += self.probe_rows.dispatch(&mut pass, self.summed);
        pass.set_pipeline(&self.mean);
        pass.set_bind_group(2, &self.means[which], &[]);
        pass.set_bind_group(3, &self.mean_own, &[]);
        pass.dispatch_workgroups(1, 1, 1);
        dispatches + 1
    }
}
