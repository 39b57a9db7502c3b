//! Edges of meshes over the picture: of the meshes as they were authored, wherever they are, and not of the finer
//! triangles into which the bake divides them. A shared side is one edge.

use std::sync::Arc;

use super::frame::{Now, Renderer};
use super::instances::{Instance, rows};
use super::meshes::Meshes;
use super::surface::{depth_state, vertex_layouts};
use super::{shaders, targets};
use crate::gpu::buffer::{self, Held};
use crate::gpu::pipeline::{Compiler, Pipelines, Variant};
use crate::gpu::{Gpu, pass};
use crate::scene::Mesh;

/// A pixel's.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Samples(u32);

impl Variant for Samples {
    fn name(&self) -> String {
        "wireframe".to_owned()
    }
}

/// Of one mesh, two vertices an edge.
struct Edges {
    of: Arc<Mesh>,
    indices: wgpu::Buffer,
    count: u32,
}

pub struct Wireframe {
    layout: wgpu::PipelineLayout,
    pipelines: Pipelines<Samples, wgpu::RenderPipeline>,
    /// By mesh on the GPU.
    edges: Vec<Option<Edges>>,
    instances: Option<Held<Instance>>,
    /// By instance: its mesh.
    meshes: Vec<usize>,
    pub shown: bool,
}

impl Wireframe {
    pub fn new(gpu: &Gpu, compiler: &Arc<Compiler>, frame_layout: &wgpu::BindGroupLayout) -> Self {
        Self {
            layout: pass::pipeline_layout(gpu, &[Some(frame_layout)]),
            pipelines: Pipelines::new(compiler, shaders::WIREFRAME),
            edges: Vec::new(),
            instances: None,
            meshes: Vec::new(),
            shown: false,
        }
    }

    fn edges_of(&mut self, gpu: &Gpu, meshes: &Meshes, index: usize) {
        let mesh = &meshes.all[index].source;
        if self.edges.len() <= index {
            self.edges.resize_with(index + 1, || None);
        }
        if self.edges[index].as_ref().is_none_or(|edges| !Arc::ptr_eq(&edges.of, mesh)) {
            let edges = edges(mesh);
            let count = edges.len() as u32 * 2;
            let indices = buffer::filled(gpu, "edges", &edges, wgpu::BufferUsages::INDEX);
            self.edges[index] = Some(Edges { of: mesh.clone(), indices, count });
        }
    }

    /// Returns the draws.
    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        frame: &wgpu::BindGroup,
        meshes: &Meshes,
        samples: u32,
    ) -> u32 {
        let Some(instances) = self.instances.as_ref().filter(|_| self.shown) else { return 0 };
        let make = |gpu: &Gpu, module: &wgpu::ShaderModule| pipeline(gpu, module, &self.layout, samples);
        let Some(pipeline) = self.pipelines.get(Samples(samples), make) else { return 0 };
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, frame, &[]);
        let mut draws = 0;
        for (instance, &mesh) in self.meshes.iter().enumerate() {
            let Some(edges) = self.edges[mesh].as_ref().filter(|edges| edges.count > 0) else { continue };
            pass.set_vertex_buffer(0, meshes.all[mesh].vertices.slice(..));
            let offset = (instance * size_of::<Instance>()) as u64;
            pass.set_vertex_buffer(1, instances.buffer().slice(offset..));
            pass.set_index_buffer(edges.indices.slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed(0..edges.count, 0, 0..1);
            draws += 1;
        }
        draws
    }
}

impl Renderer {
    /// Where all edges are now.
    pub(super) fn follow_wireframe(&mut self, gpu: &Gpu, now: &Now<'_>) {
        if !self.wireframe.shown {
            return;
        }
        let mut items = Vec::new();
        self.wireframe.meshes.clear();
        for (index, entity) in now.scene.entities.iter().enumerate() {
            let Some(renderer) = entity.mesh.as_ref().filter(|_| !self.instances.hidden[index]) else {
                continue;
            };
            let Some(mesh) = self.meshes.find(gpu, now.assets, &renderer.mesh) else { continue };
            self.wireframe.edges_of(gpu, &self.meshes, mesh);
            self.wireframe.meshes.push(mesh);
            let rows = rows(&now.world_from_local[index], self.transport.origin);
            items.push(Instance { rows, object: 0, mirrored: 0 });
        }
        let held = || Held::new(gpu, "edges", wgpu::BufferUsages::VERTEX);
        self.wireframe.instances.get_or_insert_with(held).write(gpu, &items);
    }
}

/// Each once, the lower vertex first.
fn edges(mesh: &Mesh) -> Vec<[u32; 2]> {
    let sides = |[a, b, c]: [u32; 3]| [[a, b], [b, c], [c, a]].map(|[a, b]| [a.min(b), a.max(b)]);
    let mut edges: Vec<[u32; 2]> = mesh.triangles().flat_map(sides).collect();
    edges.sort_unstable();
    edges.dedup();
    edges
}

fn pipeline(
    gpu: &Gpu,
    module: &wgpu::ShaderModule,
    layout: &wgpu::PipelineLayout,
    samples: u32,
) -> wgpu::RenderPipeline {
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("wireframe"),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some("edge"),
            compilation_options: Default::default(),
            buffers: vertex_layouts(true, false),
        },
        primitive: wgpu::PrimitiveState { topology: wgpu::PrimitiveTopology::LineList, ..Default::default() },
        depth_stencil: Some(depth_state(false)),
        multisample: wgpu::MultisampleState { count: samples, ..Default::default() },
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some("edge_color"),
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::shape::{Shape, mesh};

    #[test]
    fn a_side_that_two_triangles_share_is_one_edge() {
        let quad = edges(&mesh(Shape::Quad));
        assert_eq!(quad.len(), 5, "four sides and the diagonal");
        assert!(quad.iter().all(|[a, b]| a < b));
        assert!(edges(&Mesh::default()).is_empty());
    }
}
