//! The end of a product: the coarse correction over room-sized aggregates, the clamp B >= E, and B without
//! what is emitted.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use wgpu::BufferUsages as Usage;

use super::channels::Channels;
use super::shaders;
use super::spaces::Spaces;
use crate::gpu::pass::{self, Binding, GROUP};
use crate::gpu::pipeline::{Compiler, Compute};
use crate::gpu::{Gpu, GpuError, buffer};
use crate::transport::solve;

/// `Coarse` in `transport/coarse.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct CoarseUniform {
    pub patches: u32,
    pub aggregates: u32,
    pub chunks: u32,
    pub padding: u32,
}

/// The most aggregates: one workgroup solves for them.
const MOST: usize = GROUP as usize;

pub struct Coarse {
    /// What solves, and what corrects.
    pipelines: [Compute; 2],
    layouts: [wgpu::BindGroupLayout; 4],
    before: wgpu::BindGroup,
    light: wgpu::BindGroup,
    own: [wgpu::BindGroup; 2],
    channels: Channels,
    uniform: CoarseUniform,
    pub bytes: u64,
}

impl Coarse {
    /// Without aggregates, until [`Self::set`].
    pub fn new(gpu: &Gpu, compiler: &Arc<Compiler>, spaces: &Spaces) -> Self {
        use Binding::{Read, Uniform, Write};
        let layout =
            |bindings: &[Binding]| pass::layout(gpu, "coarse", wgpu::ShaderStages::COMPUTE, bindings);
        let layouts = [
            layout(&[Read, Read]),
            layout(&[Uniform, Read, Write, Read, Write]),
            layout(&[Read, Read, Read, Read, Read, Write, Write]),
            layout(&[Uniform, Read]),
        ];
        let pipelines = [0, 2].map(|light| {
            let groups = [None, None, Some(&layouts[light]), Some(&layouts[light + 1])];
            Compute::new(compiler, shaders::COARSE, &groups)
        });
        let uniform = CoarseUniform {
            patches: spaces.patch_count,
            aggregates: 0,
            chunks: spaces.patch_count.div_ceil(GROUP),
            padding: 0,
        };
        Self {
            pipelines,
            before: before(gpu, &layouts, spaces),
            light: light(gpu, &layouts, spaces),
            own: own(gpu, &layouts, (uniform, spaces.channels), &[], &[]),
            channels: spaces.channels,
            layouts,
            uniform,
            bytes: 0,
        }
    }

    /// Light lies elsewhere. There are no aggregates again, until [`Self::set`].
    pub fn bind(&mut self, gpu: &Gpu, spaces: &Spaces) {
        self.before = before(gpu, &self.layouts, spaces);
        self.light = light(gpu, &self.layouts, spaces);
        (self.channels, self.uniform.aggregates, self.bytes) = (spaces.channels, 0, 0);
        self.own = own(gpu, &self.layouts, (self.uniform, self.channels), &[], &[]);
    }

    /// No aggregates: no correction, and a product ends with one dispatch instead of three. Done again when albedo
    /// changes.
    pub fn set(&mut self, gpu: &Gpu, coarse: &solve::Coarse) -> Result<(), GpuError> {
        gpu.fits("coarse correction", coarse.restricted.len() as u64 * self.channels.stride())?;
        // One workgroup solves: more aggregates than it has threads are as good as none.
        let aggregates = if coarse.m <= MOST { coarse.m } else { 0 };
        let restricted = coarse.restricted[..aggregates * self.uniform.patches as usize].iter();
        let restricted: Vec<Vec3> = restricted.map(|restricted| restricted.truncate()).collect();
        let [red, green, blue] = &coarse.inverse;
        let inverse: Vec<Vec3> =
            (0..aggregates * aggregates).map(|i| Vec3::new(red[i], green[i], blue[i])).collect();
        self.uniform.aggregates = aggregates as u32;
        self.own = own(gpu, &self.layouts, (self.uniform, self.channels), &restricted, &inverse);
        self.bytes = (restricted.len() + inverse.len()) as u64 * self.channels.stride();
        Ok(())
    }

    /// Turns `next` into `radiosity` and `bounced`. Returns the dispatches.
    pub fn correct(&self, pass: &mut wgpu::ComputePass<'_>) -> u32 {
        let defines = self.channels.defines();
        let mut dispatches = 1;
        if self.uniform.aggregates > 0 {
            pass.set_bind_group(2, &self.before, &[]);
            pass.set_bind_group(3, &self.own[0], &[]);
            if self.pipelines[0].set(pass, "restrict_change", defines) {
                pass::dispatch(pass, self.uniform.aggregates * self.uniform.chunks);
            }
            if self.pipelines[0].set(pass, "solve", defines) {
                pass.dispatch_workgroups(1, 1, 1);
            }
            dispatches += 2;
        }
        if !self.pipelines[1].set(pass, "correct", defines) {
            return 0;
        }
        pass.set_bind_group(2, &self.light, &[]);
        pass.set_bind_group(3, &self.own[1], &[]);
        pass::dispatch(pass, self.uniform.patches);
        dispatches
    }
}

fn own(
    gpu: &Gpu,
    layouts: &[wgpu::BindGroupLayout; 4],
    (uniform, channels): (CoarseUniform, Channels),
    restricted: &[Vec3],
    inverse: &[Vec3],
) -> [wgpu::BindGroup; 2] {
    let parts = u64::from(uniform.aggregates) * u64::from(uniform.chunks) * channels.stride();
    let uniform = buffer::filled(gpu, "coarse", &[uniform], Usage::UNIFORM);
    let filled = |label, values: &[Vec3]| {
        buffer::filled(gpu, label, &channels.bytes_of(values.iter().copied()), Usage::STORAGE)
    };
    let (restricted, inverse) = (filled("restricted", restricted), filled("inverse", inverse));
    let parts = buffer::empty(gpu, "coarse parts", parts, Usage::STORAGE);
    let correction = buffer::empty(gpu, "correction", MOST as u64 * channels.stride(), Usage::STORAGE);
    [
        pass::buffers(gpu, "coarse", &layouts[1], &[&uniform, &restricted, &parts, &inverse, &correction]),
        pass::buffers(gpu, "coarse", &layouts[3], &[&uniform, &correction]),
    ]
}

fn before(gpu: &Gpu, layouts: &[wgpu::BindGroupLayout; 4], spaces: &Spaces) -> wgpu::BindGroup {
    pass::buffers(gpu, "coarse", &layouts[0], &[&spaces.radiosity, &spaces.next])
}

fn light(gpu: &Gpu, layouts: &[wgpu::BindGroupLayout; 4], spaces: &Spaces) -> wgpu::BindGroup {
    let Spaces { patches, next, exitance, emitted, albedo, radiosity, bounced, .. } = spaces;
    let buffers = [patches, next, exitance, emitted, albedo, radiosity, bounced];
    pass::buffers(gpu, "coarse", &layouts[2], &buffers)
}
