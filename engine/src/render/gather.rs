//! The gather: what arrives at receivers and light probes, from what is emitted and from what bounced; and what tilts it
//! towards the normals of normal maps, where there are any ([`crate::transport::directional`]).

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use super::channels::Channels;
use super::rows::{PagedRows, Summed};
use super::shaders;
use super::spaces::Spaces;
use crate::gpu::pass::{self, Binding};
use crate::gpu::pipeline::{Compiler, Compute};
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
    pipelines: Compute,
    mean: Compute,
    summed: Summed,
    receiver_rows: PagedRows,
    directional_rows: PagedRows,
    layout: wgpu::BindGroupLayout,
    page_layout: wgpu::BindGroupLayout,
    /// By source.
    receivers: [wgpu::BindGroup; 2],
    channels: Channels,
    /// `None` where there are no directional rows.
    directional: Option<[wgpu::BindGroup; 2]>,
    mean_own: wgpu::BindGroup,
    /// While somebody reads them.
    probes: Option<OfProbes>,
}

/// What probes gather by.
struct OfProbes {
    rows: PagedRows,
    /// By source.
    groups: [wgpu::BindGroup; 2],
    means: [wgpu::BindGroup; 2],
}

impl Gather {
    pub fn new(
        gpu: &Gpu,
        compiler: &Arc<Compiler>,
        [frame_layout, page_layout]: [&wgpu::BindGroupLayout; 2],
        [receiver_rows, directional_rows]: [PagedRows; 2],
        summed: Summed,
        spaces: &Spaces,
    ) -> Self {
        let compute = wgpu::ShaderStages::COMPUTE;
        let layout = pass::layout(gpu, "gather", compute, &[Binding::Read, Binding::Write]);
        let mean_layout = pass::layout(gpu, "mean", compute, &[Binding::Uniform]);
        let uniform = MeanUniform {
            receivers: spaces.receiver_count,
            share: 1.0 / spaces.valid_receivers.max(1) as f32,
            probe: spaces.probe_count * 9,
            padding: 0,
        };
        let uniform = buffer::filled(gpu, "mean", &[uniform], wgpu::BufferUsages::UNIFORM);
        let groups_of_rows = [Some(frame_layout), None, Some(&layout), Some(page_layout)];
        let groups_of_mean = [None, None, Some(&layout), Some(&mean_layout)];
        Self {
            pipelines: Compute::new(compiler, shaders::GATHER, &groups_of_rows),
            mean: Compute::new(compiler, shaders::MEAN, &groups_of_mean),
            summed,
            receivers: to_receivers(gpu, &layout, spaces, 0),
            directional: (!directional_rows.is_empty())
                .then(|| to_receivers(gpu, &layout, spaces, spaces.directional)),
            channels: spaces.channels,
            mean_own: pass::buffers(gpu, "mean", &mean_layout, &[&uniform]),
            receiver_rows,
            directional_rows,
            probes: None,
            page_layout: page_layout.clone(),
            layout,
        }
    }

    /// Light lies elsewhere.
    pub fn bind(&mut self, gpu: &Gpu, spaces: &Spaces) {
        let to_receivers = |first| to_receivers(gpu, &self.layout, spaces, first);
        self.receivers = to_receivers(0);
        self.directional = self.directional.take().map(|_| to_receivers(spaces.directional));
        if let Some(probes) = &mut self.probes {
            (probes.groups, probes.means) = to_probes(gpu, &self.layout, spaces);
        }
        self.channels = spaces.channels;
    }

    /// Uploads the rows of probes, or gives them back.
    pub fn hold_probes(
        &mut self,
        gpu: &Gpu,
        rows: impl FnOnce(&wgpu::BindGroupLayout) -> Result<PagedRows, GpuError>,
        spaces: &Spaces,
        held: bool,
    ) -> Result<(), GpuError> {
        self.probes = None;
        if held {
            let (groups, means) = to_probes(gpu, &self.layout, spaces);
            self.probes = Some(OfProbes { rows: rows(&self.page_layout)?, groups, means });
        }
        Ok(())
    }

    /// Where no row is gathered: what is where no probe is. Returns the dispatches.
    pub fn mean_of_receivers(&self, encoder: &mut wgpu::CommandEncoder, timer: &mut Timer) -> u32 {
        let Some(probes) = &self.probes else { return 0 };
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("gather"),
            timestamp_writes: timer.compute("gather"),
        });
        if !self.mean.set(&mut pass, "mean", self.channels.defines()) {
            return 0;
        }
        pass.set_bind_group(3, &self.mean_own, &[]);
        for means in &probes.means {
            pass.set_bind_group(2, means, &[]);
            pass.dispatch_workgroups(1, 1, 1);
        }
        2
    }

    /// Of the rows of receivers, and of probes.
    pub fn bytes(&self) -> [u64; 2] {
        let directional = if self.directional.is_some() { self.directional_rows.bytes } else { 0 };
        let receivers = self.receiver_rows.bytes + directional;
        [receivers, self.probes.as_ref().map_or(0, |probes| probes.rows.bytes)]
    }

    /// Returns the dispatches.
    pub fn run(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        timer: &mut Timer,
        frame: &wgpu::BindGroup,
        source: Source,
    ) -> u32 {
        let probe_rows = self.probes.as_ref().map(|probes| &probes.rows);
        if self.receiver_rows.is_empty() && probe_rows.is_none_or(PagedRows::is_empty) {
            return 0;
        }
        let which = source as usize;
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("gather"),
            timestamp_writes: timer.compute("gather"),
        });
        let entry = match self.summed {
            Summed::ByThread => "gather",
            Summed::ByGroup => "gather_by_group",
        };
        pass.set_bind_group(0, frame, &[]);
        let mut dispatches = 0;
        if self.pipelines.set(&mut pass, entry, self.receiver_rows.defines(self.channels)) {
            pass.set_bind_group(2, &self.receivers[which], &[]);
            dispatches += self.receiver_rows.dispatch(&mut pass, self.summed);
        }
        if let Some(directional) = &self.directional
            && self.pipelines.set(&mut pass, entry, self.directional_rows.defines(self.channels))
        {
            pass.set_bind_group(2, &directional[which], &[]);
            dispatches += self.directional_rows.dispatch(&mut pass, self.summed);
        }
        let Some(probes) = &self.probes else { return dispatches };
        if self.pipelines.set(&mut pass, entry, probes.rows.defines(self.channels)) {
            pass.set_bind_group(2, &probes.groups[which], &[]);
            dispatches += probes.rows.dispatch(&mut pass, self.summed);
        }
        if !self.mean.set(&mut pass, "mean", self.channels.defines()) {
            return dispatches;
        }
        pass.set_bind_group(2, &probes.means[which], &[]);
        pass.set_bind_group(3, &self.mean_own, &[]);
        pass.dispatch_workgroups(1, 1, 1);
        dispatches + 1
    }
}

/// By source: to receivers, or to their terms, from an element on.
fn to_receivers(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
    spaces: &Spaces,
    first: u32,
) -> [wgpu::BindGroup; 2] {
    let offset = u64::from(first) * spaces.channels.stride();
    groups(gpu, layout, [&spaces.emitted, &spaces.bounced], (&spaces.receivers, offset))
}

/// By source: what they gather, and the mean of receivers.
fn to_probes(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
    spaces: &Spaces,
) -> ([wgpu::BindGroup; 2], [wgpu::BindGroup; 2]) {
    let to = |from| groups(gpu, layout, from, (&spaces.probes, 0));
    (to([&spaces.emitted, &spaces.bounced]), to(spaces.receivers.each_ref()))
}

/// By source. Written from a byte on.
fn groups(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
    from: [&wgpu::Buffer; 2],
    (to, offset): (&[wgpu::Buffer; 2], u64),
) -> [wgpu::BindGroup; 2] {
    [0, 1].map(|source| {
        let buffer = &to[source];
        let written = wgpu::BufferBinding { buffer, offset, size: None };
        let resources = [from[source].as_entire_binding(), wgpu::BindingResource::Buffer(written)];
        pass::group(gpu, "gather", layout, &resources)
    })
}
