//! The unit of radiosity on the GPU: 2^k W/m2, so that neither starlight nor a furnace leaves what floats can hold.
//!
//! k follows the brightest that shines or still bounces, and only where that is 2^24 times larger or smaller than the
//! unit: most scenes keep 1 W/m2. Powers of two change no digit, so that light scaled by one gives the same light
//! scaled. Receivers and probes are in W/m2 again: what is read there is gathered anew in every frame.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use super::channels::Channels;
use super::shaders;
use super::spaces::Spaces;
use crate::gpu::Gpu;
use crate::gpu::buffer;
use crate::gpu::pass::{self, Binding};
use crate::gpu::pipeline::{Compiler, Compute};
use crate::gpu::timing::Timer;

/// Powers of two between the unit and the brightest at which the unit changes.
const ROOM: f32 = 24.0;
/// Farther units could not be divided by.
const MOST: f32 = 120.0;

/// `Rescale` in `transport/unit.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct RescaleUniform {
    pub columns: u32,
    pub factor: f32,
    pub padding: [u32; 2],
}

/// The exponent for a brightest light [W/m2], given the one at hand.
pub fn exponent(now: i32, brightest: f32) -> i32 {
    if !(brightest > 0.0 && brightest.is_finite()) {
        return now;
    }
    let level = brightest.log2().clamp(-MOST, MOST);
    if (level - now as f32).abs() <= ROOM { now } else { level.round() as i32 }
}

/// Multiplies what is stored.
pub struct Rescale {
    pipeline: Compute,
    /// Of B, and of B without what is emitted.
    lights: [wgpu::BindGroup; 2],
    own: wgpu::BindGroup,
    uniform: wgpu::Buffer,
    columns: u32,
    layout: wgpu::BindGroupLayout,
    channels: Channels,
}

impl Rescale {
    pub fn new(gpu: &Gpu, compiler: &Arc<Compiler>, spaces: &Spaces) -> Self {
        let compute = wgpu::ShaderStages::COMPUTE;
        let light = pass::layout(gpu, "unit", compute, &[Binding::Write]);
        let own = pass::layout(gpu, "unit", compute, &[Binding::Uniform]);
        let uniform = buffer::empty(gpu, "unit", 16, wgpu::BufferUsages::UNIFORM);
        let groups = [None, None, Some(&light), Some(&own)];
        Self {
            pipeline: Compute::new(compiler, shaders::UNIT, &groups),
            lights: lights(gpu, &light, spaces),
            own: pass::buffers(gpu, "unit", &own, &[&uniform]),
            uniform,
            columns: spaces.patch_count,
            layout: light,
            channels: spaces.channels,
        }
    }

    /// Light lies elsewhere.
    pub fn bind(&mut self, gpu: &Gpu, spaces: &Spaces) {
        self.lights = lights(gpu, &self.layout, spaces);
        self.channels = spaces.channels;
    }

    /// Returns the dispatches.
    pub fn run(&self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, timer: &mut Timer, factor: f32) -> u32 {
        if self.columns == 0 {
            return 0;
        }
        let uniform = RescaleUniform { columns: self.columns, factor, padding: [0; 2] };
        gpu.queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&uniform));
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("rescale"),
            timestamp_writes: timer.compute("rescale"),
        });
        if !self.pipeline.set(&mut pass, "rescale", self.channels.defines()) {
            return 0;
        }
        pass.set_bind_group(3, &self.own, &[]);
        for light in &self.lights {
            pass.set_bind_group(2, light, &[]);
            pass::dispatch(&mut pass, self.columns);
        }
        self.lights.len() as u32
    }
}

fn lights(gpu: &Gpu, layout: &wgpu::BindGroupLayout, spaces: &Spaces) -> [wgpu::BindGroup; 2] {
    [&spaces.radiosity, &spaces.bounced].map(|buffer| pass::buffers(gpu, "unit", layout, &[buffer]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unit_follows_the_brightest_with_room_on_both_sides() {
        assert_eq!(exponent(0, 1e7), 0);
        assert_eq!(exponent(0, 1e-7), 0);
        assert_eq!(exponent(0, 0.0), 0);
        assert_eq!(exponent(3, f32::NAN), 3);
        let large = exponent(0, 2.0_f32.powi(60));
        assert_eq!(large, 60);
        assert_eq!(exponent(large, 2.0_f32.powi(40)), 60);
        assert_eq!(exponent(large, 1.0), 0);
        assert_eq!(exponent(0, 1e-40), -120);
    }
}
