//! Coloured lines, one pixel wide, over what was drawn before; behind surfaces they are faint.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{Vec3, Vec4};
use wgpu::vertex_attr_array;

use super::{shaders, surface, targets};
use crate::gpu::buffer::Held;
use crate::gpu::pipeline::{Compiler, Pipelines, Variant};
use crate::gpu::{Gpu, pass};

/// From point to point, relative to the transport's origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    pub ends: [Vec3; 2],
    /// Linear RGB as it is to be displayed, and opacity.
    pub color: Vec4,
}

#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
struct End {
    position: Vec3,
    color: [f32; 4],
}

const END: [wgpu::VertexAttribute; 2] = vertex_attr_array![0 => Float32x3, 1 => Float32x4];

/// Lines behind surfaces or in front of them, on so many samples a pixel.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Side {
    behind: bool,
    samples: u32,
}

impl Variant for Side {
    fn name(&self) -> String {
        format!("lines, {}", if self.behind { "behind" } else { "in front" })
    }
}

pub struct Lines {
    layout: wgpu::PipelineLayout,
    /// Made when there is something to draw.
    ends: Option<Held<End>>,
    pipelines: Pipelines<Side, wgpu::RenderPipeline>,
}

impl Lines {
    pub fn new(gpu: &Gpu, compiler: &Arc<Compiler>, frame_layout: &wgpu::BindGroupLayout) -> Self {
        Self {
            layout: pass::pipeline_layout(gpu, &[Some(frame_layout)]),
            ends: None,
            pipelines: Pipelines::new(compiler, shaders::LINES),
        }
    }

    /// What is drawn from now on.
    pub fn set(&mut self, gpu: &Gpu, lines: &[Line]) {
        let end = |line: &Line| line.ends.map(|position| End { position, color: line.color.to_array() });
        let ends: Vec<End> = lines.iter().flat_map(end).collect();
        if self.ends.is_some() || !ends.is_empty() {
            let held = || Held::new(gpu, "lines", wgpu::BufferUsages::VERTEX);
            self.ends.get_or_insert_with(held).write(gpu, &ends);
        }
    }

    /// Returns the draws.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, frame: &wgpu::BindGroup, samples: u32) -> u32 {
        let Some(ends) = self.ends.as_ref().filter(|ends| !ends.items().is_empty()) else { return 0 };
        let count = ends.items().len() as u32;
        pass.set_bind_group(0, frame, &[]);
        pass.set_vertex_buffer(0, ends.buffer().slice(..));
        let mut draws = 0;
        for behind in [true, false] {
            let side = Side { behind, samples };
            let made = self.pipelines.get(side, |gpu, module| pipeline(gpu, module, &self.layout, side));
            let Some(pipeline) = made else { continue };
            pass.set_pipeline(&pipeline);
            pass.draw(0..count, 0..1);
            draws += 1;
        }
        draws
    }
}

/// Depth is reversed: what is less is behind.
fn pipeline(
    gpu: &Gpu,
    module: &wgpu::ShaderModule,
    layout: &wgpu::PipelineLayout,
    Side { behind, samples }: Side,
) -> wgpu::RenderPipeline {
    use wgpu::CompareFunction::{GreaterEqual, Less};
    let (entry, compare) = if behind { ("behind", Less) } else { ("in_front", GreaterEqual) };
    let ends = wgpu::VertexBufferLayout {
        array_stride: size_of::<End>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &END,
    };
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("lines"),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some("end"),
            compilation_options: Default::default(),
            buffers: &[Some(ends)],
        },
        primitive: wgpu::PrimitiveState { topology: wgpu::PrimitiveTopology::LineList, ..Default::default() },
        depth_stencil: Some(wgpu::DepthStencilState {
            depth_compare: Some(compare),
            ..surface::depth_state(false)
        }),
        multisample: wgpu::MultisampleState { count: samples, ..Default::default() },
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some(entry),
            compilation_options: Default::default(),
            targets: &[Some(wgpu::ColorTargetState {
                format: targets::RADIANCE,
                blend: Some(wgpu::BlendState::ALPHA_BLENDING),
                write_mask: wgpu::ColorWrites::ALL,
            })],
        }),
        multiview_mask: None,
        cache: None,
    })
}
