//! A file's meshes as one mesh, each where its entity stands, for those who want an object and not a hierarchy.

use glam::{DAffine3, Vec2, Vec3, Vec4};

use super::settings::stem;
use crate::scene::mesh::Primitive;
use crate::scene::transform::normal_matrix;
use crate::scene::{
    Density, Entity, EntityId, MaterialId, Mesh, MeshRenderer, MeshSource, Reflection, Scene,
    world_from_local,
};

/// Vertices and indices that a mesh may have.
const MOST: usize = 1 << 25;

/// `scene`: as the file says it; `mesh`: the file's n-th. `scene_from_file` is applied to all vertices. Also gives the
/// material of each primitive.
pub fn joined(
    scene: &Scene,
    scene_from_file: &DAffine3,
    mesh: impl Fn(u32) -> Result<Mesh, String>,
) -> Result<(Mesh, Vec<MaterialId>), String> {
    let (mut whole, mut materials) = (Mesh::default(), Vec::new());
    for (entity, world) in scene.entities.iter().zip(world_from_local(scene)) {
        let Some(renderer) = entity.mesh.as_ref().filter(|_| !scene.is_hidden(entity)) else { continue };
        let MeshSource::File { mesh: n, .. } = renderer.mesh else { continue };
        let part = mesh(n)?;
        let size = |mesh: &Mesh| mesh.positions.len().max(mesh.indices.len());
        if size(&whole) + size(&part) > MOST {
            return Err(format!("has more than {MOST} vertices or indices in one: import it as a hierarchy"));
        }
        let material = |n: usize| renderer.materials.get(n).or(renderer.materials.last()).copied();
        materials.extend((0..part.primitives.len()).filter_map(material));
        append(&mut whole, part, &(*scene_from_file * world));
    }
    Ok((whole, materials))
}

/// The scene of one entity that draws it.
pub fn scene_of(whole: Scene, file: &str, materials: Vec<MaterialId>) -> Scene {
    let mesh = MeshRenderer {
        mesh: MeshSource::File { file: file.to_owned(), mesh: 0 },
        materials,
        casts_shadows: true,
        density: Density::default(),
        reflection: Reflection::default(),
    };
    let is_static = whole.entities.iter().all(|entity| entity.is_static || entity.mesh.is_none());
    let entity =
        Entity { id: EntityId(1), name: stem(file), is_static, mesh: Some(mesh), ..Entity::default() };
    Scene { entities: vec![entity], ..whole }
}

/// What one part has and another has not is as if absent there: white, no texture coordinates, no tangents.
fn append(whole: &mut Mesh, part: Mesh, world_from_local: &DAffine3) {
    let (before, count) = (whole.positions.len(), part.positions.len());
    let normals = normal_matrix(world_from_local);
    let is_mirror = world_from_local.matrix3.determinant() < 0.0;
    let direction = |v: glam::DVec3| v.try_normalize().map_or(Vec3::Y, |v| v.as_vec3());
    whole
        .positions
        .extend(part.positions.iter().map(|p| world_from_local.transform_point3(p.as_dvec3()).as_vec3()));
    whole.normals.extend(part.normals.iter().map(|n| direction(normals * n.as_dvec3())));
    let tangents = part.tangents.map(|tangents| {
        let sign = if is_mirror { -1.0 } else { 1.0 };
        let turned =
            |t: Vec4| match world_from_local.transform_vector3(t.truncate().as_dvec3()).try_normalize() {
                Some(turned) => turned.as_vec3().extend(t.w * sign),
                None => Vec4::ZERO,
            };
        tangents.into_iter().map(turned).collect()
    });
    extend(&mut whole.tangents, tangents, before, count, Vec4::ZERO);
    for (all, own) in whole.uvs.iter_mut().zip(part.uvs) {
        extend(all, own, before, count, Vec2::ZERO);
    }
    extend(&mut whole.colors, part.colors, before, count, Vec4::ONE);
    let first = whole.indices.len() as u32;
    let order = if is_mirror { [0, 2, 1] } else { [0, 1, 2] };
    let corners = part.indices.chunks_exact(3).flat_map(|t| order.map(|corner| t[corner] + before as u32));
    whole.indices.extend(corners);
    let primitives = part.primitives.iter();
    whole.primitives.extend(primitives.map(|run| Primitive { first: first + run.first, count: run.count }));
}

fn extend<T: Copy>(all: &mut Option<Vec<T>>, own: Option<Vec<T>>, before: usize, count: usize, absent: T) {
    if all.is_none() && own.is_none() {
        return;
    }
    let all = all.get_or_insert_default();
    all.resize(before, absent);
    match own {
        Some(own) => all.extend(own),
        None => all.resize(before + count, absent),
    }
}
