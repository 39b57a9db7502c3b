//! The bounce: products B <- E + rho P B, each followed by the coarse correction, and how far from the
//! solution the light is at most.
//!
//! |error| <= w * max|residual| with the cavity gain w = max (I - rho P)^-1 1, or what stands in for it,
//! 1 / (1 - max rho * max row sum). Both follow from I - rho P being an M-matrix.

use std::sync::Arc;

use super::channels::Channels;
use super::coarse::Coarse;
use super::rows::{PagedRows, Summed};
use super::shaders;
use super::spaces::Spaces;
use super::steering::Measured;
use crate::gpu::Gpu;
use crate::gpu::buffer::{self, Readback};
use crate::gpu::pass::{self, Binding};
use crate::gpu::pipeline::{Compiler, Compute};
use crate::gpu::timing::Timer;

pub struct Bounce {
    pipelines: Compute,
    layout: wgpu::BindGroupLayout,
    group: wgpu::BindGroup,
    channels: Channels,
    summed: Summed,
    rows: PagedRows,
    patch_count: u32,
    tally: wgpu::Buffer,
    /// Tagged with the version of the light and the unit of its radiosity.
    readback: Readback<((u64, f32), u32)>,
    sending: Option<usize>,
}

impl Bounce {
    pub fn new(
        gpu: &Gpu,
        compiler: &Arc<Compiler>,
        page_layout: &wgpu::BindGroupLayout,
        rows: PagedRows,
        summed: Summed,
        spaces: &Spaces,
    ) -> Self {
        let layout = pass::layout(
            gpu,
            "bounce",
            wgpu::ShaderStages::COMPUTE,
            &[Binding::Read, Binding::Read, Binding::Read, Binding::Write, Binding::Write],
        );
        let tally = buffer::empty(gpu, "tally", 64, wgpu::BufferUsages::STORAGE);
        let groups = [None, None, Some(&layout), Some(page_layout)];
        Self {
            pipelines: Compute::new(compiler, shaders::BOUNCE, &groups),
            group: group(gpu, &layout, spaces, &tally),
            layout,
            channels: spaces.channels,
            summed,
            rows,
            patch_count: spaces.patch_count,
            tally,
            readback: Readback::new(gpu, 64),
            sending: None,
        }
    }

    /// Light lies elsewhere.
    pub fn bind(&mut self, gpu: &Gpu, spaces: &Spaces) {
        self.group = group(gpu, &self.layout, spaces, &self.tally);
        self.channels = spaces.channels;
    }

    pub fn bytes(&self) -> u64 {
        self.rows.bytes
    }

    pub fn pages(&self) -> usize {
        self.rows.pages()
    }

    /// So many products; the last one is measured and the measure sent back with the light's version and unit. Returns
    /// the dispatches.
    pub fn run(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        timer: &mut Timer,
        coarse: &Coarse,
        products: u32,
        tag: (u64, f32),
    ) -> u32 {
        if self.patch_count == 0 || products == 0 {
            return 0;
        }
        encoder.clear_buffer(&self.tally, 0, None);
        let mut dispatches = 0;
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("bounce"),
            timestamp_writes: timer.compute("bounce"),
        });
        let defines = self.rows.defines(self.channels);
        for product in 1..=products {
            let entry = match self.summed {
                Summed::ByThread => "bounce",
                Summed::ByGroup => "bounce_by_group",
            };
            if !self.pipelines.set(&mut pass, entry, defines) {
                return 0;
            }
            pass.set_bind_group(2, &self.group, &[]);
            dispatches += self.rows.dispatch(&mut pass, self.summed);
            if product == products && self.pipelines.set(&mut pass, "measure", defines) {
                dispatches += self.rows.dispatch(&mut pass, Summed::ByThread);
            }
            dispatches += coarse.correct(&mut pass);
        }
        drop(pass);
        self.sending = self.readback.copy(encoder, &self.tally, (tag, products));
        dispatches
    }

    /// After the submit.
    pub fn sent(&mut self) {
        self.readback.send(self.sending.take());
    }

    /// What has arrived, oldest first.
    pub fn receive(&mut self) -> impl Iterator<Item = Measured> {
        self.readback.receive::<f32>().into_iter().map(|(((version, unit), products), tally)| Measured {
            version,
            products,
            residual: tally[0] * unit,
            largest: tally[1] * unit,
            exitance: tally[2] * unit,
        })
    }
}

fn group(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
    spaces: &Spaces,
    tally: &wgpu::Buffer,
) -> wgpu::BindGroup {
    let Spaces { radiosity, exitance, albedo, next, .. } = spaces;
    pass::buffers(gpu, "bounce", layout, &[radiosity, exitance, albedo, next, tally])
}
