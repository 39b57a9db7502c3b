//! Two views of the light probes: each as a small sphere in its own light, and the tetrahedra between them as lines.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{Vec3, Vec4};
use wgpu::vertex_attr_array;

use super::channels::Channels;
use super::lines::Line;
use super::spaces::Spaces;
use super::{shaders, surface, targets};
use crate::gpu::pass::{self, Binding};
use crate::gpu::pipeline::{Compiler, Pipelines, Variant};
use crate::gpu::{Gpu, buffer};
use crate::scene::shape::{self, Shape};
use crate::transport::Transport;
use crate::transport::probe_field::ProbeField;

/// Of a sphere, in the median length of edges between probes; and where there are none [m].
const RADIUS: f32 = 0.07;
const RADIUS_ALONE: f32 = 0.1;
/// Edges of the hull, and inside; linear.
const ON_HULL: Vec4 = Vec4::new(1.0, 0.55, 0.05, 0.9);
const INSIDE: Vec4 = Vec4::new(0.1, 0.6, 1.0, 0.6);

#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
struct Sphere {
    position: Vec3,
    radius: f32,
    probe: u32,
    valid: u32,
}

const CORNER: [wgpu::VertexAttribute; 1] = vertex_attr_array![0 => Float32x3];
const SPHERE: [wgpu::VertexAttribute; 2] = vertex_attr_array![1 => Float32x4, 2 => Uint32x2];

pub struct Probes {
    layout: wgpu::PipelineLayout,
    light_layout: wgpu::BindGroupLayout,
    pipelines: Pipelines<Drawn, wgpu::RenderPipeline>,
    made: Option<Made>,
}

struct Made {
    corners: wgpu::Buffer,
    indices: wgpu::Buffer,
    index_count: u32,
    spheres: wgpu::Buffer,
}

/// What tells one pipeline from another.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Drawn {
    /// A pixel's.
    samples: u32,
    channels: Channels,
}

impl Variant for Drawn {
    fn name(&self) -> String {
        "probes".to_owned()
    }

    fn defines(&self) -> Vec<&'static str> {
        self.channels.defines().to_vec()
    }
}

impl Probes {
    pub fn new(gpu: &Gpu, compiler: &Arc<Compiler>, frame_layout: &wgpu::BindGroupLayout) -> Self {
        let vertex = wgpu::ShaderStages::VERTEX;
        let light_layout = pass::layout(gpu, "probes", vertex, &[Binding::Read, Binding::Read]);
        Self {
            pipelines: Pipelines::new(compiler, shaders::PROBES),
            layout: pass::pipeline_layout(gpu, &[Some(frame_layout), None, Some(&light_layout)]),
            light_layout,
            made: None,
        }
    }

    /// Returns the draws.
    #[allow(clippy::too_many_arguments)] // a draw, told in full
    pub fn draw(
        &mut self,
        gpu: &Gpu,
        pass: &mut wgpu::RenderPass<'_>,
        frame: &wgpu::BindGroup,
        (transport, field): (&Transport, &ProbeField),
        spaces: &Spaces,
        samples: u32,
    ) -> u32 {
        if transport.probes.is_empty() {
            return 0;
        }
        let light = self.light(gpu, spaces);
        let made = self.made.get_or_insert_with(|| make(gpu, transport, field));
        let drawn = Drawn { samples, channels: spaces.channels };
        let pipeline = self.pipelines.get(drawn, |gpu, module| pipeline(gpu, module, &self.layout, samples));
        let Some(pipeline) = pipeline else { return 0 };
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, frame, &[]);
        pass.set_bind_group(2, &light, &[]);
        pass.set_vertex_buffer(0, made.corners.slice(..));
        pass.set_vertex_buffer(1, made.spheres.slice(..));
        pass.set_index_buffer(made.indices.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..made.index_count, 0, 0..transport.probes.len() as u32);
        1
    }

    fn light(&self, gpu: &Gpu, spaces: &Spaces) -> wgpu::BindGroup {
        pass::buffers(gpu, "probes", &self.light_layout, &spaces.probes.each_ref())
    }
}

fn make(gpu: &Gpu, transport: &Transport, field: &ProbeField) -> Made {
    use wgpu::BufferUsages as Usage;
    let mesh = shape::mesh(Shape::Sphere);
    Made {
        corners: buffer::filled(gpu, "sphere", &mesh.positions, Usage::VERTEX),
        indices: buffer::filled(gpu, "sphere", &mesh.indices, Usage::INDEX),
        index_count: mesh.indices.len() as u32,
        spheres: buffer::filled(gpu, "probes", &spheres(transport, field), Usage::VERTEX),
    }
}

fn spheres(transport: &Transport, field: &ProbeField) -> Vec<Sphere> {
    let position = |probe: u32| transport.probes[probe as usize].position;
    let length = |[a, b]: [u32; 2]| position(a).distance(position(b));
    let mut lengths: Vec<f32> = field.edges().iter().map(|edge| length(edge.probes)).collect();
    lengths.sort_by(f32::total_cmp);
    let radius = lengths.get(lengths.len() / 2).map_or(RADIUS_ALONE, |median| RADIUS * median);
    let probes = (0..).zip(&transport.probes);
    let sphere = |(index, probe): (u32, &crate::transport::Probe)| Sphere {
        position: probe.position,
        radius,
        probe: index,
        valid: u32::from(probe.valid > 0.5),
    };
    probes.map(sphere).collect()
}

/// The tetrahedra's edges, those of the hull in a colour of their own.
pub fn tetrahedra(transport: &Transport, field: &ProbeField) -> Vec<Line> {
    let position = |probe: u32| transport.probes[probe as usize].position;
    let edges = field.edges().into_iter();
    let color = |on_hull| if on_hull { ON_HULL } else { INSIDE };
    edges.map(|edge| Line { ends: edge.probes.map(position), color: color(edge.on_hull) }).collect()
}

fn pipeline(
    gpu: &Gpu,
    module: &wgpu::ShaderModule,
    layout: &wgpu::PipelineLayout,
    samples: u32,
) -> wgpu::RenderPipeline {
    let buffer = |array_stride: usize, step_mode, attributes| {
        Some(wgpu::VertexBufferLayout { array_stride: array_stride as u64, step_mode, attributes })
    };
    let corners = buffer(size_of::<Vec3>(), wgpu::VertexStepMode::Vertex, &CORNER[..]);
    let spheres = buffer(size_of::<Sphere>(), wgpu::VertexStepMode::Instance, &SPHERE[..]);
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("probes"),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some("sphere"),
            compilation_options: Default::default(),
            buffers: &[corners, spheres],
        },
        primitive: wgpu::PrimitiveState { cull_mode: Some(wgpu::Face::Back), ..Default::default() },
        depth_stencil: Some(surface::depth_state(true)),
        multisample: wgpu::MultisampleState { count: samples, ..Default::default() },
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some("glow"),
            compilation_options: Default::default(),
            targets: &[Some(targets::RADIANCE.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}
