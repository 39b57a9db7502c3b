//! From a captured cubemap to what surfaces read: smaller levels, levels blurred by roughness, harmonics.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{Vec3, Vec4};

use super::super::shaders;
use super::super::targets::RADIANCE;
use crate::gpu::pass::{self, Binding};
use crate::gpu::pipeline::{Compiler, Compute, Pipelines};
use crate::gpu::timing::Timer;
use crate::gpu::{Gpu, GpuError, buffer, texture};
use crate::transport::reflection::cube::FACES;
use crate::transport::reflection::{Cube, ggx};

/// `Prefilter` in `prefilter.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct PrefilterUniform {
    pub forward: Vec3,
    pub count: u32,
    pub right: Vec3,
    pub padding: u32,
    pub up: Vec3,
    pub padding_2: u32,
    pub samples: [Vec4; MOST_SAMPLES],
}

/// `Project` in `prefilter.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ProjectUniform {
    pub size: u32,
    pub first: u32,
    pub padding: [u32; 2],
}

pub const MOST_SAMPLES: usize = 64;
/// Texels across the level that harmonics are taken from.
const HARMONICS_SIZE: u32 = 16;
/// Texels across the roughest level.
const SMALLEST: u32 = 8;

/// Pipelines, and what they need for cubemaps of each size.
pub struct Prefilter {
    draws: Pipelines<&'static str, wgpu::RenderPipeline>,
    layout: wgpu::PipelineLayout,
    project: Compute,
    draw_layout: wgpu::BindGroupLayout,
    project_layout: wgpu::BindGroupLayout,
    sampler: wgpu::Sampler,
    samples: u32,
}

/// Levels of a cubemap that surfaces read, from mirror to roughness 1.
pub fn levels(size: u32) -> u32 {
    (size / SMALLEST).max(1).ilog2() + 1
}

/// Perceptual roughness of a level.
pub fn roughness(level: u32, levels: u32) -> f32 {
    level as f32 / (levels - 1).max(1) as f32
}

/// A cubemap that is captured into, and everything that makes smaller levels of it and blurs it.
pub struct Source {
    pub size: u32,
    pub texture: wgpu::Texture,
    /// By level: face by face.
    pub views: Vec<Faces>,
    /// By level but the first: face by face.
    halves: Vec<[wgpu::BindGroup; 6]>,
    /// By level of the result: face by face.
    blurs: Vec<[wgpu::BindGroup; 6]>,
    /// What takes the harmonics.
    projection: wgpu::BindGroup,
}

/// Views of a cubemap's faces, to draw into.
pub type Faces = [wgpu::TextureView; 6];

/// By level: the faces of cubemap `index` of an array.
pub fn faces(cubes: &wgpu::Texture, index: u32) -> Vec<Faces> {
    let level = |level| [0, 1, 2, 3, 4, 5].map(|face| texture::layer_level(cubes, index * 6 + face, level));
    (0..cubes.mip_level_count()).map(level).collect()
}

impl Prefilter {
    pub fn new(gpu: &Gpu, compiler: &Arc<Compiler>) -> Self {
        use Binding::{Cube, Sampler, Uniform, Write};
        let draw_layout =
            pass::layout(gpu, "prefilter", wgpu::ShaderStages::FRAGMENT, &[Uniform, Cube, Sampler]);
        let project_layout =
            pass::layout(gpu, "project", wgpu::ShaderStages::COMPUTE, &[Uniform, Cube, Sampler, Write]);
        let groups = [None, None, None, Some(&project_layout)];
        Self {
            draws: Pipelines::new(compiler, shaders::PREFILTER),
            layout: pass::pipeline_layout(gpu, &[None, None, None, Some(&draw_layout)]),
            project: Compute::new(compiler, shaders::PREFILTER, &groups),
            draw_layout,
            project_layout,
            sampler: sampler(gpu),
            // A processor that draws pays for every tap.
            samples: if gpu.software { 32 } else { MOST_SAMPLES as u32 },
        }
    }

    fn drawing(&self, entry: &'static str) -> Option<wgpu::RenderPipeline> {
        self.draws.get(entry, |gpu, module| pass::over_picture(gpu, module, entry, &self.layout, RADIANCE))
    }

    pub fn sampler(&self) -> &wgpu::Sampler {
        &self.sampler
    }

    /// Directions to blur a level with.
    pub fn samples(&self, level: u32, levels: u32, size: u32) -> Vec<Vec4> {
        ggx::samples(roughness(level, levels), self.samples, size)
    }

    /// Room for captures of `size` texels a side, to be blurred into `levels` levels; its harmonics are those of
    /// cubemap `index`.
    pub fn source(&self, gpu: &Gpu, size: u32, levels: u32, harmonics: &wgpu::Buffer, index: u32) -> Source {
        let texture = texture::cubes(gpu, "capture", size, 1, size.ilog2() + 1);
        let whole = texture::as_cubes(&texture, wgpu::TextureViewDimension::Cube);
        let halves = (1..texture.mip_level_count())
            .map(|level| self.groups(gpu, &texture::cube_level(&texture, level - 1), &[]))
            .collect();
        let blurs =
            (0..levels).map(|level| self.groups(gpu, &whole, &self.samples(level, levels, size))).collect();
        let projection = self.projection(gpu, &texture, harmonics, index);
        Source { size, views: faces(&texture, 0), texture, halves, blurs, projection }
    }

    fn groups(&self, gpu: &Gpu, view: &wgpu::TextureView, samples: &[Vec4]) -> [wgpu::BindGroup; 6] {
        let mut filled = [Vec4::ZERO; MOST_SAMPLES];
        filled[..samples.len()].copy_from_slice(samples);
        FACES.map(|[forward, right, up]| {
            let count = samples.len() as u32;
            let uniform =
                PrefilterUniform { forward, count, right, padding: 0, up, padding_2: 0, samples: filled };
            let uniform = buffer::filled(gpu, "prefilter", &[uniform], wgpu::BufferUsages::UNIFORM);
            let resources = [
                uniform.as_entire_binding(),
                wgpu::BindingResource::TextureView(view),
                wgpu::BindingResource::Sampler(&self.sampler),
            ];
            pass::group(gpu, "prefilter", &self.draw_layout, &resources)
        })
    }

    fn projection(
        &self,
        gpu: &Gpu,
        source: &wgpu::Texture,
        harmonics: &wgpu::Buffer,
        index: u32,
    ) -> wgpu::BindGroup {
        let size = source.width();
        let level = size.ilog2().saturating_sub(HARMONICS_SIZE.ilog2());
        let uniform = ProjectUniform { size: size.min(HARMONICS_SIZE), first: index * 9, padding: [0; 2] };
        let uniform = buffer::filled(gpu, "project", &[uniform], wgpu::BufferUsages::UNIFORM);
        let resources = [
            uniform.as_entire_binding(),
            wgpu::BindingResource::TextureView(&texture::cube_level(source, level)),
            wgpu::BindingResource::Sampler(&self.sampler),
            harmonics.as_entire_binding(),
        ];
        pass::group(gpu, "project", &self.project_layout, &resources)
    }

    /// What one level of a cubemap holds, drawn face by face into a plain picture: wgpu's OpenGL copies nothing out
    /// of cubemaps. Blocks.
    pub fn read(&self, gpu: &Gpu, cube: &wgpu::Texture, level: u32) -> Result<Cube, GpuError> {
        let size = cube.width() >> level;
        let picture = texture::target(gpu, "face", [size, size], 1, RADIANCE);
        let view = picture.create_view(&Default::default());
        let Some(halve) = self.drawing("halve") else {
            return gpu.check().map(|()| Cube::new(0, Vec::new()));
        };
        let mut texels = Vec::new();
        for group in self.groups(gpu, &texture::cube_level(cube, level), &[]) {
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            let mut pass = pass::draw_into(&mut encoder, "face", &view, None);
            pass.set_pipeline(&halve);
            pass.set_bind_group(3, &group, &[]);
            pass.draw(0..3, 0..1);
            drop(pass);
            gpu.queue.submit([encoder.finish()]);
            let bytes = texture::read(gpu, &picture, 8)?;
            let value = |at: &[u8]| texture::single(u16::from_le_bytes([at[0], at[1]]));
            let texel = |at: &[u8]| Vec3::new(value(at), value(&at[2..]), value(&at[4..]));
            texels.extend(bytes.chunks_exact(8).map(texel));
        }
        Ok(Cube::new(size as usize, texels))
    }

    /// Blurs what was captured into the levels of a cubemap.
    pub fn run(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        timer: &mut Timer,
        source: &Source,
        into: &[Faces],
    ) {
        let (Some(halve), Some(blur)) = (self.drawing("halve"), self.drawing("blur")) else { return };
        let mut draw = |pipeline, group: &wgpu::BindGroup, view: &wgpu::TextureView| {
            let mut pass = pass::draw_into(encoder, "prefilter", view, timer.render("prefilter"));
            pass.set_pipeline(pipeline);
            pass.set_bind_group(3, group, &[]);
            pass.draw(0..3, 0..1);
        };
        for (groups, views) in source.halves.iter().zip(&source.views[1..]) {
            groups.iter().zip(views).for_each(|(group, view)| draw(&halve, group, view));
        }
        for (groups, views) in source.blurs.iter().zip(into) {
            groups.iter().zip(views).for_each(|(group, view)| draw(&blur, group, view));
        }
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("project"),
            timestamp_writes: timer.compute("prefilter"),
        });
        if self.project.set(&mut pass, "project", &[]) {
            pass.set_bind_group(3, &source.projection, &[]);
            pass.dispatch_workgroups(1, 1, 1);
        }
    }
}

fn sampler(gpu: &Gpu) -> wgpu::Sampler {
    gpu.device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("smooth"),
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        mipmap_filter: wgpu::MipmapFilterMode::Linear,
        ..Default::default()
    })
}
