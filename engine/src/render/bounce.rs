//! The bounce: products B <- E + rho P B, each followed by the coarse correction, and how far from the
//! solution the light is at most.
//!
//! |error| <= w * max|residual| with the cavity gain w = max (I - rho P)^-1 1, or what stands in for it,
//! 1 / (1 - max rho * max row sum). Both follow from I - rho P being an M-matrix.

use super::coarse::Coarse;
use super::rows::{PagedRows, Summed};
use super::shaders;
use super::spaces::Spaces;
use crate::gpu::buffer::{self, Readback};
use crate::gpu::pass::{self, Binding};
use crate::gpu::shader::Library;
use crate::gpu::timing::Timer;
use crate::gpu::{Gpu, GpuError};

/// Of the largest B; below it the light counts as solved.
pub const TOLERANCE: f32 = 1e-3;

pub struct Bounce {
    product: wgpu::ComputePipeline,
    measure: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
    summed: Summed,
    rows: PagedRows,
    patch_count: u32,
    tally: wgpu::Buffer,
    readback: Readback<u64>,
    sending: Option<usize>,
    /// What the last frame that came back said.
    pub measured: Option<Measured>,
}

/// Of the light before the last product of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// Counts changes of what the bounce starts from.
    pub version: u64,
    /// Largest |E + rho P B - B| [W/m2].
    pub residual: f32,
    /// Largest radiosity [W/m2].
    pub largest: f32,
}

impl Measured {
    /// The error is at most this share of the largest B. A NaN is never below a tolerance.
    pub fn bound(&self, cavity_gain: f32) -> f32 {
        if self.largest == 0.0 && self.residual == 0.0 {
            return 0.0;
        }
        cavity_gain * self.residual / self.largest
    }
}

impl Bounce {
    pub fn new(
        gpu: &Gpu,
        library: &mut Library,
        page_layout: &wgpu::BindGroupLayout,
        rows: PagedRows,
        summed: Summed,
        spaces: &Spaces,
    ) -> Result<Self, GpuError> {
        let module = library.module(gpu, shaders::BOUNCE)?;
        let layout = pass::layout(
            gpu,
            "bounce",
            wgpu::ShaderStages::COMPUTE,
            &[Binding::Read, Binding::Read, Binding::Read, Binding::Write, Binding::Write],
        );
        let tally = buffer::empty(gpu, "tally", 64, wgpu::BufferUsages::STORAGE);
        let group = pass::buffers(
            gpu,
            "bounce",
            &layout,
            &[&spaces.radiosity, &spaces.exitance, &spaces.albedo, &spaces.next, &tally],
        );
        let entry = match summed {
            Summed::ByThread => "bounce",
            Summed::ByGroup => "bounce_by_group",
        };
        let groups = [None, None, Some(&layout), Some(page_layout)];
        Ok(Self {
            product: pass::compute(gpu, &module, entry, &groups),
            measure: pass::compute(gpu, &module, "measure", &groups),
            group,
            summed,
            rows,
            patch_count: spaces.patch_count,
            tally,
            readback: Readback::new(gpu, 64),
            sending: None,
            measured: None,
        })
    }

    pub fn bytes(&self) -> u64 {
        self.rows.bytes
    }

    pub fn pages(&self) -> usize {
        self.rows.pages()
    }

    /// So many products; the last one is measured and the measure sent back. Returns the dispatches.
    pub fn run(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        timer: &mut Timer,
        coarse: &Coarse,
        products: u32,
        version: u64,
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
        for product in 1..=products {
            pass.set_pipeline(&self.product);
            pass.set_bind_group(2, &self.group, &[]);
            dispatches += self.rows.dispatch(&mut pass, self.summed);
            if product == products {
                pass.set_pipeline(&self.measure);
                dispatches += self.rows.dispatch(&mut pass, Summed::ByThread);
            }
            dispatches += coarse.correct(&mut pass);
        }
        drop(pass);
        self.sending = self.readback.copy(encoder, &self.tally, version);
        dispatches
    }

    /// After the submit.
    pub fn sent(&mut self) {
        self.readback.send(self.sending.take());
    }

    /// Takes in what has arrived.
    pub fn receive(&mut self) {
        for (version, tally) in self.readback.receive::<f32>() {
            self.measured = Some(Measured { version, residual: tally[0], largest: tally[1] });
        }
    }
}
