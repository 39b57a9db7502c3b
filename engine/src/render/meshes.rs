//! Meshes on the GPU: the baked surface of all static ones, and meshes of what moves.

use std::collections::HashMap;
use std::sync::Arc;

use glam::Vec3;
use wgpu::BufferUsages as Usage;

use super::uploads::Uploads;
use crate::gpu::{Gpu, GpuError, buffer};
use crate::scene::assets::Assets;
use crate::scene::mesh::Primitive;
use crate::scene::{Mesh, MeshSource};
use crate::transport::{Transport, Vertex};

pub struct MeshBuffers {
    pub vertices: wgpu::Buffer,
    pub indices: wgpu::Buffer,
    pub primitives: Vec<Primitive>,
    /// Box about all vertices, in the mesh's space.
    pub low: Vec3,
    pub high: Vec3,
    /// What it was made of: another mesh under the same name is uploaded anew.
    pub source: Arc<Mesh>,
}

/// The baked surface.
pub struct StillBuffers {
    pub vertices: wgpu::Buffer,
    pub blends: wgpu::Buffer,
    /// The blends once more where no batch is double-sided.
    pub back_blends: wgpu::Buffer,
    pub indices: wgpu::Buffer,
    pub bytes: u64,
}

impl StillBuffers {
    pub fn new(gpu: &Gpu, transport: &Transport) -> Result<Self, GpuError> {
        let surface = &transport.surface;
        let limit = gpu.device.limits().max_buffer_size;
        let bytes = size_of_val(surface.vertices.as_slice()) as u64;
        if bytes > limit {
            return Err(GpuError::TooLarge { what: "vertices".to_owned(), bytes, limit });
        }
        let blends = buffer::filled(gpu, "blends", &surface.blends, Usage::VERTEX);
        let back_blends = if surface.back_blends.is_empty() {
            blends.clone()
        } else {
            buffer::filled(gpu, "back blends", &surface.back_blends, Usage::VERTEX)
        };
        let bytes = size_of_val(surface.vertices.as_slice())
            + size_of_val(surface.blends.as_slice())
            + size_of_val(surface.back_blends.as_slice())
            + size_of_val(surface.triangles.as_slice());
        Ok(Self {
            vertices: buffer::filled(gpu, "vertices", &surface.vertices, Usage::VERTEX),
            blends,
            back_blends,
            indices: buffer::filled(gpu, "triangles", &surface.triangles, Usage::INDEX),
            bytes: bytes as u64,
        })
    }
}

/// Meshes by the name under which a scene knows them.
#[derive(Default)]
pub struct Meshes {
    known: HashMap<MeshSource, usize>,
    pub all: Vec<MeshBuffers>,
    pub uploads: Uploads,
}

impl Meshes {
    pub fn new(uploads: Uploads) -> Self {
        Self { uploads, ..Self::default() }
    }

    /// The place of a mesh in `all`; uploads it the first time. `None`: the assets do not have it, or it has to wait.
    pub fn find(&mut self, gpu: &Gpu, assets: &Assets, source: &MeshSource) -> Option<usize> {
        let mesh = assets.meshes.get(source)?;
        if let Some(&index) = self.known.get(source) {
            if !Arc::ptr_eq(&self.all[index].source, mesh) && self.uploads.take(bytes(mesh)) {
                self.all[index] = upload(gpu, mesh);
            }
            return Some(index);
        }
        if !self.uploads.take(bytes(mesh)) {
            return None;
        }
        self.known.insert(source.clone(), self.all.len());
        self.all.push(upload(gpu, mesh));
        Some(self.all.len() - 1)
    }

    /// All of them go.
    pub fn forget(&mut self) {
        self.known.clear();
        self.all.clear();
    }

    pub fn bytes(&self) -> u64 {
        self.all.iter().map(|mesh| mesh.vertices.size() + mesh.indices.size()).sum()
    }
}

/// On the GPU.
fn bytes(mesh: &Mesh) -> u64 {
    (mesh.positions.len() * size_of::<Vertex>() + size_of_val(mesh.indices.as_slice())) as u64
}

fn upload(gpu: &Gpu, mesh: &Arc<Mesh>) -> MeshBuffers {
    let vertices: Vec<Vertex> = (0..mesh.positions.len())
        .map(|i| Vertex {
            position: mesh.positions[i],
            normal: mesh.normals[i],
            tangent: mesh.tangents.as_ref().map_or([0.0; 4], |tangents| tangents[i].to_array()),
            uv: [mesh.uv(0, i), mesh.uv(1, i)],
            color: mesh.color(i).to_array(),
        })
        .collect();
    let inside = |fold: fn(Vec3, Vec3) -> Vec3| mesh.positions.iter().copied().reduce(fold);
    MeshBuffers {
        vertices: buffer::filled(gpu, "mesh", &vertices, Usage::VERTEX),
        indices: buffer::filled(gpu, "mesh", &mesh.indices, Usage::INDEX),
        primitives: mesh.primitives.clone(),
        low: inside(Vec3::min).unwrap_or_default(),
        high: inside(Vec3::max).unwrap_or_default(),
        source: mesh.clone(),
    }
}
