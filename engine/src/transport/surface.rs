//! The refined render mesh of all static surfaces, in one vertex buffer, cut into batches that share an
//! entity and a material.

use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3};

/// All vertices and triangles of the static scene, relative to the transport's origin, in metres.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    pub vertices: Vec<Vertex>,
    /// One a vertex: where its irradiance comes from, front side.
    pub blends: Vec<Blend>,
    /// The same for the back side of double-sided batches; one a vertex, or empty where there are none.
    pub back_blends: Vec<Blend>,
    /// Counter-clockwise from the front, batch after batch, patch after patch.
    pub triangles: Vec<[u32; 3]>,
    /// One a triangle: the patches of its front and back, [`super::NONE`] where it has none.
    pub patches: Vec<[u32; 2]>,
    pub batches: Vec<Batch>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Vertex {
    pub position: Vec3,
    pub normal: Vec3,
    /// xyz and the bitangent's sign; zero where the mesh has none.
    pub tangent: [f32; 4],
    pub uv: [Vec2; 2],
    /// Linear RGBA.
    pub color: [f32; 4],
}

/// Irradiance at a vertex: the weighted mean of up to four receivers of its own surface; weights sum to 1
/// (unused ones are 0).
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Blend {
    pub receivers: [u32; 4],
    pub weights: [f32; 4],
}

/// Triangles `first .. first + count` of one entity with one material.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Batch {
    /// The entity's id, low and high half.
    pub entity: [u32; 2],
    /// Its [`crate::scene::MaterialId`].
    pub material: u32,
    pub double_sided: u32,
    pub first: u32,
    pub count: u32,
}

impl Batch {
    /// Of an entity that has changed since the bake or is gone ([`super::Transport::leave_out`]): not drawn, and
    /// in no light's way.
    pub fn is_stale(&self) -> bool {
        self.entity == [super::NONE; 2]
    }

    pub fn entity(&self) -> crate::scene::EntityId {
        crate::scene::EntityId(u64::from(self.entity[0]) | u64::from(self.entity[1]) << 32)
    }
}

impl Blend {
    pub fn one(receiver: u32) -> Self {
        Self { receivers: [receiver, 0, 0, 0], weights: [1.0, 0.0, 0.0, 0.0] }
    }
}

impl Surface {
    pub fn positions(&self, triangle: usize) -> [Vec3; 3] {
        self.triangles[triangle].map(|vertex| self.vertices[vertex as usize].position)
    }

    pub fn validate(&self) -> Result<(), String> {
        let n = self.vertices.len();
        if self.blends.len() != n || !(self.back_blends.is_empty() || self.back_blends.len() == n) {
            return Err(format!("{n} vertices, but {} blends", self.blends.len()));
        }
        if self.patches.len() != self.triangles.len() {
            return Err(format!("{} triangles name {} patches", self.triangles.len(), self.patches.len()));
        }
        if self.triangles.iter().flatten().any(|&vertex| vertex as usize >= n) {
            return Err("a triangle names a vertex that does not exist".to_owned());
        }
        if self.vertices.iter().any(|vertex| !vertex.position.is_finite() || !vertex.normal.is_finite()) {
            return Err("a vertex is not finite".to_owned());
        }
        let end = |batch: &Batch| u64::from(batch.first) + u64::from(batch.count);
        if self.batches.iter().any(|batch| end(batch) > self.triangles.len() as u64) {
            return Err("a batch names triangles that do not exist".to_owned());
        }
        Ok(())
    }
}
