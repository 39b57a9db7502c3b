//! A mesh: indexed triangles with attributes, in its own space.

use glam::{Vec2, Vec3, Vec4};
use serde::{Deserialize, Serialize};

use super::shape::Shape;

/// Where a mesh comes from.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MeshSource {
    /// The n-th mesh of an imported file (glTF: `meshes[n]`; OBJ: the n-th object), relative to the project.
    File { file: String, mesh: u32 },
    /// Made by the engine.
    Shape(Shape),
}

/// All arrays that are present have one entry a vertex. Front faces are counter-clockwise.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    pub positions: Vec<Vec3>,
    /// Unit length. Where a file has none, each triangle is flat and has vertices of its own.
    pub normals: Vec<Vec3>,
    /// xyz and the bitangent's sign: the file's, or MikkTSpace's where a normal map needs them. 0 where neither is.
    pub tangents: Option<Vec<Vec4>>,
    pub uvs: [Option<Vec<Vec2>>; 2],
    /// Linear RGBA.
    pub colors: Option<Vec<Vec4>>,
    pub indices: Vec<u32>,
    pub primitives: Vec<Primitive>,
    /// The last vertices are copies of these, with tangents of their own.
    pub copies: Vec<u32>,
}

/// A run of triangles that share a material: indices `first .. first + count`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Primitive {
    pub first: u32,
    pub count: u32,
}

impl Mesh {
    pub fn triangles(&self) -> impl ExactSizeIterator<Item = [u32; 3]> + '_ {
        self.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]])
    }

    /// The vertex of the file that a vertex was made of: what is painted is painted there.
    pub fn original(&self, vertex: usize) -> usize {
        let first_copy = self.positions.len().saturating_sub(self.copies.len());
        vertex
            .checked_sub(first_copy)
            .and_then(|copy| self.copies.get(copy))
            .map_or(vertex, |&of| of as usize)
    }

    pub fn uv(&self, set: u8, vertex: usize) -> Vec2 {
        self.uvs[usize::from(set.min(1))].as_ref().map_or(Vec2::ZERO, |uvs| uvs[vertex])
    }

    pub fn color(&self, vertex: usize) -> Vec4 {
        self.colors.as_ref().map_or(Vec4::ONE, |colors| colors[vertex])
    }

    /// Array lengths agree, indices are in range, primitives tile the index array.
    pub fn validate(&self) -> Result<(), String> {
        let n = self.positions.len();
        let lengths = [
            ("normals", Some(self.normals.len())),
            ("tangents", self.tangents.as_ref().map(Vec::len)),
            ("texture coordinates 0", self.uvs[0].as_ref().map(Vec::len)),
            ("texture coordinates 1", self.uvs[1].as_ref().map(Vec::len)),
            ("colours", self.colors.as_ref().map(Vec::len)),
        ];
        for (what, length) in lengths {
            if length.is_some_and(|length| length != n) {
                return Err(format!("{} {what} for {n} positions", length.unwrap_or(0)));
            }
        }
        if let Some(index) = self.indices.iter().find(|&&index| index as usize >= n) {
            return Err(format!("an index is {index}, but there are {n} vertices"));
        }
        let mut next = 0;
        for primitive in &self.primitives {
            if primitive.first != next || primitive.count % 3 != 0 {
                return Err("primitives do not follow each other".to_owned());
            }
            next += primitive.count;
        }
        if next as usize != self.indices.len() {
            return Err(format!("primitives hold {next} of {} indices", self.indices.len()));
        }
        Ok(())
    }
}
