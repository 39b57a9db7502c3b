//! Two views of the bake: every patch in a colour of its own, and patches by their size.
//!
//! Triangles get vertices of their own, as OpenGL tells a shader no number of the triangle; they are made when
//! one of these views is first chosen.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use wgpu::vertex_attr_array;

use super::surface;
use super::{shaders, targets};
use crate::gpu::pipeline::{Compiler, Pipelines, Variant};
use crate::gpu::{Gpu, buffer, pass};
use crate::transport::{NONE, Transport};

#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
struct Corner {
    position: Vec3,
    patches: [u32; 2],
    sizes: [f32; 2],
}

const CORNER: [wgpu::VertexAttribute; 3] = vertex_attr_array![0 => Float32x3, 1 => Uint32x2, 2 => Float32x2];

pub struct Patches {
    layout: wgpu::PipelineLayout,
    pipelines: Pipelines<Sided, wgpu::RenderPipeline>,
    corners: Option<wgpu::Buffer>,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Sided {
    double: bool,
    samples: u32,
}

impl Variant for Sided {
    fn name(&self) -> String {
        format!("patches{}", if self.double { ", double-sided" } else { "" })
    }
}

impl Patches {
    pub fn new(gpu: &Gpu, compiler: &Arc<Compiler>, frame_layout: &wgpu::BindGroupLayout) -> Self {
        Self {
            layout: pass::pipeline_layout(gpu, &[Some(frame_layout)]),
            pipelines: Pipelines::new(compiler, shaders::PATCHES),
            corners: None,
        }
    }

    /// Draws batches that are shown. Returns the draws.
    pub fn draw(
        &mut self,
        gpu: &Gpu,
        pass: &mut wgpu::RenderPass<'_>,
        frame: &wgpu::BindGroup,
        transport: &Transport,
        shown: impl Fn(usize) -> bool,
        samples: u32,
    ) -> u32 {
        let corners = self.corners.get_or_insert_with(|| {
            buffer::filled(gpu, "patch corners", &corners(transport), wgpu::BufferUsages::VERTEX)
        });
        pass.set_bind_group(0, frame, &[]);
        pass.set_vertex_buffer(0, corners.slice(..));
        let mut draws = 0;
        for (_, batch) in transport.surface.batches.iter().enumerate().filter(|(index, _)| shown(*index)) {
            let sided = Sided { double: batch.double_sided == 1, samples };
            let made = self.pipelines.get(sided, |gpu, module| pipeline(gpu, module, &self.layout, sided));
            let Some(pipeline) = made else { continue };
            pass.set_pipeline(&pipeline);
            pass.draw(batch.first * 3..(batch.first + batch.count) * 3, 0..1);
            draws += 1;
        }
        draws
    }
}

fn corners(transport: &Transport) -> Vec<Corner> {
    let length = |area: f32| area.sqrt().log2();
    let lengths = transport.patches.iter().map(|patch| length(patch.area));
    let least = lengths.clone().fold(f32::INFINITY, f32::min);
    let most = lengths.fold(f32::NEG_INFINITY, f32::max);
    let size = |patch: u32| {
        if patch == NONE || most <= least {
            return 0.5;
        }
        (length(transport.patches[patch as usize].area) - least) / (most - least)
    };
    let surface = &transport.surface;
    (0..surface.triangles.len())
        .flat_map(|triangle| {
            let patches = surface.patches[triangle];
            let sizes = patches.map(size);
            surface.positions(triangle).map(|position| Corner { position, patches, sizes })
        })
        .collect()
}

fn pipeline(
    gpu: &Gpu,
    module: &wgpu::ShaderModule,
    layout: &wgpu::PipelineLayout,
    Sided { double, samples }: Sided,
) -> wgpu::RenderPipeline {
    let corners = wgpu::VertexBufferLayout {
        array_stride: size_of::<Corner>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &CORNER,
    };
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("patches"),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some("corner"),
            compilation_options: Default::default(),
            buffers: &[Some(corners)],
        },
        primitive: wgpu::PrimitiveState {
            cull_mode: (!double).then_some(wgpu::Face::Back),
            ..Default::default()
        },
        depth_stencil: Some(surface::depth_state(true)),
        multisample: wgpu::MultisampleState { count: samples, ..Default::default() },
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some("flat_color"),
            compilation_options: Default::default(),
            targets: &[Some(targets::RADIANCE.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}
