//! Tangents where a normal map needs them and the file has none: MikkTSpace (Mikkelsen 2008), by which normal maps are
//! baked everywhere, from the texture coordinates that the map is read with.
//!
//! A vertex whose triangles disagree, above all where the texture is mirrored, is split: each side gets a copy with
//! a tangent of its own, at the end of the mesh's vertices. As glTF has it, the bitangent normal x tangent * w points up
//! in the picture, against v.

use std::collections::{HashMap, HashSet};

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{Vec3, Vec4};

use crate::scene::mesh::Primitive;
use crate::scene::{Mesh, MeshSource, Scene};

/// Of a mesh's primitives those that are drawn with a normal map somewhere, and the set of coordinates that it is read
/// with.
pub fn wanted(scene: &Scene, source: &MeshSource, primitives: usize) -> Vec<(usize, u8)> {
    let drawn = scene.entities.iter().filter_map(|entity| entity.mesh.as_ref());
    let drawn: Vec<_> = drawn.filter(|renderer| renderer.mesh == *source).collect();
    let set_of = |primitive: usize| {
        drawn.iter().find_map(|renderer| {
            let material = renderer.materials.get(primitive).or(renderer.materials.last())?;
            Some(scene.material(*material)?.normal_texture.as_ref()?.uv_set)
        })
    };
    (0..primitives).filter_map(|primitive| Some((primitive, set_of(primitive)?))).collect()
}

/// Gives a primitive tangents if it has texture coordinates of this set and no tangents.
pub fn complete(mesh: &mut Mesh, primitive: usize, uv_set: u8) {
    let Some(&primitive) = mesh.primitives.get(primitive) else { return };
    let corners = primitive.first as usize..(primitive.first + primitive.count) as usize;
    let has_tangent = |&vertex: &u32| {
        mesh.tangents.as_ref().is_some_and(|tangents| tangents[vertex as usize].truncate() != Vec3::ZERO)
    };
    if mesh.uvs[usize::from(uv_set.min(1))].is_none() || mesh.indices[corners.clone()].iter().any(has_tangent)
    {
        return;
    }
    let mut unwrapped = Unwrapped { mesh, primitive, uv_set, tangents: vec![Vec4::ZERO; corners.len()] };
    // No error is defined.
    let _ = generate_tangents(&mut unwrapped);
    let tangents = unwrapped.tangents;
    let mut made: HashMap<(u32, [u32; 4]), u32> = HashMap::new();
    let mut taken = HashSet::new();
    for (corner, tangent) in corners.zip(tangents) {
        let vertex = mesh.indices[corner];
        let bits = (tangent + Vec4::ZERO).to_array().map(f32::to_bits);
        mesh.indices[corner] = *made.entry((vertex, bits)).or_insert_with(|| {
            let vertex = if taken.insert(vertex) { vertex } else { copy(mesh, vertex) };
            let count = mesh.positions.len();
            let all = mesh.tangents.get_or_insert_with(Vec::new);
            all.resize(count, Vec4::ZERO);
            all[vertex as usize] = tangent;
            vertex
        });
    }
}

/// The copy's number.
fn copy(mesh: &mut Mesh, vertex: u32) -> u32 {
    fn again<T: Copy>(values: &mut Vec<T>, at: usize) {
        values.push(values[at]);
    }
    let at = vertex as usize;
    mesh.copies.push(mesh.original(at) as u32);
    again(&mut mesh.positions, at);
    again(&mut mesh.normals, at);
    mesh.uvs.iter_mut().flatten().for_each(|uvs| again(uvs, at));
    mesh.colors.iter_mut().for_each(|colors| again(colors, at));
    mesh.positions.len() as u32 - 1
}

/// A primitive as MikkTSpace asks for it.
struct Unwrapped<'a> {
    mesh: &'a Mesh,
    primitive: Primitive,
    uv_set: u8,
    /// By corner.
    tangents: Vec<Vec4>,
}

impl Unwrapped<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.mesh.indices[self.primitive.first as usize + face * 3 + corner] as usize
    }
}

impl Geometry for Unwrapped<'_> {
    fn num_faces(&self) -> usize {
        self.primitive.count as usize / 3
    }

    fn num_vertices_of_face(&self, _: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.mesh.positions[self.vertex(face, corner)].to_array()
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.mesh.normals[self.vertex(face, corner)].to_array()
    }

    /// v upwards.
    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        let uv = self.mesh.uv(self.uv_set, self.vertex(face, corner));
        [uv.x, -uv.y]
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, corner: usize) {
        let tangent = space.map_or(Vec4::ZERO, |space| Vec4::from(space.tangent_encoded()));
        self.tangents[face * 3 + corner] = if tangent.is_finite() { tangent } else { Vec4::ZERO };
    }
}
