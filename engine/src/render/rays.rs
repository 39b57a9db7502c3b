//! What shadow rays meet on the GPU: the trees of the static surface and of every mesh that moves, and where those
//! stand now. A mesh's tree is built once; a frame writes a hundred bytes for each thing that moves.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{DAffine3, DMat3, DVec3, Vec3};
use wgpu::BufferUsages as Usage;

use super::casters::Casters;
use super::instances::{Draw, Instance, Pass};
use crate::gpu::buffer::{self, Held};
use crate::gpu::pass::{self, Binding};
use crate::gpu::{Gpu, GpuError};
use crate::scene::Mesh;
use crate::transport::bvh::Bvh;
use crate::transport::{Occluders, Transport};

/// `Triangle` in `transport/rays.wgsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct GpuTriangle {
    pub a: Vec3,
    pub part: u32,
    pub b: Vec3,
    pub ordered: u32,
    pub c: Vec3,
    pub padding: u32,
}

/// `Blocker` in `transport/rays.wgsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Blocker {
    pub row_x: [f32; 4],
    pub row_y: [f32; 4],
    pub row_z: [f32; 4],
    pub centre: Vec3,
    pub radius: f32,
    pub nodes: u32,
    pub triangles: u32,
    pub parts: u32,
    pub scale: f32,
}

/// `Count` in `transport/rays.wgsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct CountUniform {
    pub blockers: u32,
    pub offset: f32,
    pub padding: [u32; 2],
}

/// A tree and its triangles, as they are uploaded.
struct Tree {
    nodes: Vec<[u32; 20]>,
    triangles: Vec<GpuTriangle>,
    scale: f32,
    /// The mesh that it was built of; `None`: the static surface.
    mesh: Option<(usize, Arc<Mesh>)>,
}

/// In place of a share: rays see no pictures.
const ASK_THE_MAP: f32 = -1.0;

pub struct Rays {
    /// The static surface, then meshes.
    trees: Vec<Tree>,
    nodes: wgpu::Buffer,
    triangles: wgpu::Buffer,
    blockers: Held<Blocker>,
    stops: Held<f32>,
    count: Held<CountUniform>,
    group: wgpu::BindGroup,
    bound: [u64; 2],
    offset: f32,
    /// Something casts whose holes only maps know.
    asks_maps: bool,
}

impl Rays {
    pub fn layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
        use Binding::{Read, Uniform};
        pass::layout(gpu, "rays", wgpu::ShaderStages::COMPUTE, &[Read, Read, Read, Read, Uniform])
    }

    pub fn new(
        gpu: &Gpu,
        layout: &wgpu::BindGroupLayout,
        transport: &Transport,
        occluders: &Occluders,
    ) -> Result<Self, GpuError> {
        let trees = vec![Tree::of_surface(transport, occluders.bvh())];
        gpu.fits("triangles", size_of_val(trees[0].triangles.as_slice()) as u64)?;
        let (nodes, triangles) = upload(gpu, &trees);
        let mut blockers = Held::new(gpu, "blockers", Usage::STORAGE);
        // No binding may be smaller than what it holds one of.
        blockers.write(gpu, &[Blocker::default()]);
        let stops = Held::new(gpu, "stops", Usage::STORAGE);
        let count = Held::new(gpu, "count", Usage::UNIFORM);
        let buffers = [&nodes, &triangles, blockers.buffer(), stops.buffer(), count.buffer()];
        Ok(Self {
            group: pass::buffers(gpu, "rays", layout, &buffers),
            trees,
            nodes,
            triangles,
            blockers,
            stops,
            count,
            bound: [0; 2],
            offset: occluders.bvh().offset(),
            asks_maps: false,
        })
    }

    pub fn group(&self) -> &wgpu::BindGroup {
        &self.group
    }

    /// Whether some rays end at maps: those that meet something with holes.
    pub fn asks_maps(&self) -> bool {
        self.asks_maps
    }

    pub fn bytes(&self) -> u64 {
        self.nodes.size() + self.triangles.size()
    }

    /// Follows what casts shadows. Returns whether anything differs from the last frame.
    pub fn follow(&mut self, gpu: &Gpu, layout: &wgpu::BindGroupLayout, casters: &Casters<'_>) -> bool {
        let grown = self.grow(gpu, casters);
        let draws = &casters.instances.draws;
        let still = draws.iter().take_while(|draw| draw.mesh.is_none()).count();
        let mut stops: Vec<f32> = draws[..still].iter().map(|draw| stops_light(draw, casters)).collect();
        let mut blockers = Vec::new();
        if !self.trees[0].nodes.is_empty() {
            blockers.push(still_blocker(&self.trees[0]));
        }
        // The primitives of a mesh follow each other.
        for things in draws[still..].chunk_by(|a, b| a.instance == b.instance) {
            let shares = things.iter().map(|draw| stops_light(draw, casters));
            let instance = &casters.instances.buffer.items()[things[0].instance as usize];
            let blocker = self.moving_blocker(&things[0], instance, stops.len() as u32);
            if let Some(blocker) = blocker.filter(|_| shares.clone().any(|share| share != 0.0)) {
                blockers.push(blocker);
                stops.extend(shares);
            }
        }
        self.asks_maps = stops.contains(&ASK_THE_MAP);
        let count = CountUniform { blockers: blockers.len() as u32, offset: self.offset, padding: [0; 2] };
        let mut changed = self.blockers.write(gpu, &blockers);
        changed |= self.stops.write(gpu, &stops);
        changed |= self.count.write(gpu, &[count]);
        let bound = [self.blockers.generation, self.stops.generation];
        if grown || self.bound != bound {
            self.bound = bound;
            let buffers = [
                &self.nodes,
                &self.triangles,
                self.blockers.buffer(),
                self.stops.buffer(),
                self.count.buffer(),
            ];
            self.group = pass::buffers(gpu, "rays", layout, &buffers);
        }
        changed || grown
    }

    /// A tree for every mesh that moves and casts. Returns whether there are new ones.
    fn grow(&mut self, gpu: &Gpu, casters: &Casters<'_>) -> bool {
        let mut grown = false;
        for draw in casters.instances.draws.iter().filter(|draw| draw.casts) {
            let Some(index) = draw.mesh else { continue };
            let source = &casters.meshes.all[index].source;
            if self.tree_of(index).is_some_and(|tree| self.trees[tree].is_of(source)) {
                continue;
            }
            // Another mesh under the same name takes its place.
            self.trees.retain(|tree| tree.mesh.as_ref().is_none_or(|(other, _)| *other != index));
            self.trees.push(Tree::of_mesh(index, source));
            grown = true;
        }
        if grown {
            (self.nodes, self.triangles) = upload(gpu, &self.trees);
        }
        grown
    }

    fn tree_of(&self, mesh: usize) -> Option<usize> {
        self.trees.iter().position(|tree| tree.mesh.as_ref().is_some_and(|(index, _)| *index == mesh))
    }

    /// `None` for what has no extent.
    fn moving_blocker(&self, draw: &Draw, instance: &Instance, parts: u32) -> Option<Blocker> {
        let tree = self.tree_of(draw.mesh?)?;
        let (before, tree) = (&self.trees[..tree], &self.trees[tree]);
        let scale = f64::from(tree.scale);
        let world = affine(&instance.rows);
        let inverse = world.inverse();
        if tree.nodes.is_empty() || !inverse.is_finite() {
            return None;
        }
        let row = |i: usize| {
            let axes = [inverse.matrix3.x_axis[i], inverse.matrix3.y_axis[i], inverse.matrix3.z_axis[i]];
            [axes[0], axes[1], axes[2], inverse.translation[i]].map(|x| (x * scale) as f32)
        };
        let blocker = Blocker {
            row_x: row(0),
            row_y: row(1),
            row_z: row(2),
            centre: draw.centre,
            radius: draw.radius,
            nodes: before.iter().map(|tree| tree.nodes.len() as u32).sum(),
            triangles: before.iter().map(|tree| tree.triangles.len() as u32).sum(),
            parts,
            scale: tree.scale,
        };
        Some(blocker)
    }
}

impl Tree {
    fn of_surface(transport: &Transport, bvh: &Bvh) -> Self {
        let surface = &transport.surface;
        let mut triangles: Vec<GpuTriangle> =
            (0..surface.triangles.len()).map(|t| triangle(surface.positions(t), 0)).collect();
        for (part, batch) in surface.batches.iter().enumerate() {
            let range = batch.first as usize..(batch.first + batch.count) as usize;
            triangles[range].iter_mut().for_each(|triangle| triangle.part = part as u32);
        }
        Self::new(triangles, bvh, None)
    }

    fn of_mesh(index: usize, mesh: &Arc<Mesh>) -> Self {
        let position = |vertex: u32| mesh.positions[vertex as usize];
        let corners: Vec<[Vec3; 3]> = mesh.triangles().map(|triangle| triangle.map(position)).collect();
        let mut triangles: Vec<GpuTriangle> = corners.iter().map(|&corners| triangle(corners, 0)).collect();
        for (part, primitive) in mesh.primitives.iter().enumerate() {
            let range = primitive.first as usize / 3..(primitive.first + primitive.count) as usize / 3;
            triangles[range].iter_mut().for_each(|triangle| triangle.part = part as u32);
        }
        Self::new(triangles, &Bvh::new(&corners, Vec::new()), Some((index, mesh.clone())))
    }

    fn new(mut triangles: Vec<GpuTriangle>, bvh: &Bvh, mesh: Option<(usize, Arc<Mesh>)>) -> Self {
        // A tree may name a triangle twice.
        triangles.resize(triangles.len().max(bvh.order().len()), GpuTriangle::default());
        for (triangle, &ordered) in triangles.iter_mut().zip(bvh.order()) {
            triangle.ordered = ordered;
        }
        Self { nodes: bvh.nodes().to_vec(), triangles, scale: bvh.scale(), mesh }
    }

    fn is_of(&self, source: &Arc<Mesh>) -> bool {
        self.mesh.as_ref().is_some_and(|(_, mesh)| Arc::ptr_eq(mesh, source))
    }
}

fn triangle([a, b, c]: [Vec3; 3], part: u32) -> GpuTriangle {
    GpuTriangle { a, b, c, part, ..GpuTriangle::default() }
}

fn still_blocker(tree: &Tree) -> Blocker {
    let s = tree.scale;
    Blocker {
        row_x: [s, 0.0, 0.0, 0.0],
        row_y: [0.0, s, 0.0, 0.0],
        row_z: [0.0, 0.0, s, 0.0],
        radius: 1e18,
        scale: s,
        ..Blocker::default()
    }
}

/// The share of light that a draw's triangles stop; [`ASK_THE_MAP`] where a picture says where they have holes.
fn stops_light(draw: &Draw, casters: &Casters<'_>) -> f32 {
    let material = casters.materials.material(draw.material);
    match (draw.casts, draw.pass) {
        (false, _) => 0.0,
        (true, Pass::Opaque) => 1.0,
        (true, _) if material.albedo.texture.is_some() => ASK_THE_MAP,
        (true, Pass::Mask) => 1.0,
        (true, Pass::Blend) => material.opacity.clamp(0.0, 1.0),
    }
}

fn affine(rows: &[[f32; 4]; 3]) -> DAffine3 {
    let column = |i: usize| DVec3::new(rows[0][i].into(), rows[1][i].into(), rows[2][i].into());
    DAffine3 { matrix3: DMat3::from_cols(column(0), column(1), column(2)), translation: column(3) }
}

fn upload(gpu: &Gpu, trees: &[Tree]) -> (wgpu::Buffer, wgpu::Buffer) {
    let mut nodes: Vec<[u32; 20]> = trees.iter().flat_map(|tree| tree.nodes.iter().copied()).collect();
    nodes.resize(nodes.len().max(1), [0; 20]);
    let triangles: Vec<GpuTriangle> = trees.iter().flat_map(|tree| tree.triangles.iter().copied()).collect();
    (
        buffer::filled(gpu, "nodes", &nodes, Usage::STORAGE),
        buffer::filled(gpu, "triangles", &triangles, Usage::STORAGE),
    )
}
