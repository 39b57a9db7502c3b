//! Sanitise: all static triangles in one space, in f64, rebased to a near origin and scaled by a power of two.
//!
//! The origin snaps to a grid whose step is a power of two of the scene's size, and so does the unit: a scene
//! that is moved by whole steps, or scaled by 2^k, gives the same numbers and the same bake, bit for bit.

use std::collections::HashMap;

use engine::scene::assets::Assets;
use engine::scene::transform::normal_matrix;
use engine::scene::{Entity, Mesh, Scene, SceneError, Warning, world_from_local};
use engine::transport::Batch;
use glam::{DAffine3, DVec3, Vec2, Vec3};

/// Metres from the origin of the world: products of four lengths are floats.
pub const FARTHEST: f64 = 1e9;
/// Twice the area of a triangle, m2: squares of what is larger are floats.
const LEAST_AREA: f64 = 1e-18;

/// Everything static, in scaled space: world = origin + unit * position.
#[derive(Default)]
pub struct Surface {
    pub origin: DVec3,
    /// Metres; a power of two. The scene fits into about one unit.
    pub unit: f64,
    pub batches: Vec<Batch>,
    pub batch_names: Vec<String>,
    pub triangles: Vec<Triangle>,
    /// Without area or with repeated indices.
    pub dropped: usize,
    pub warnings: Vec<Warning>,
}

#[derive(Clone, Copy, Debug)]
pub struct Triangle {
    pub corners: [Corner; 3],
    pub batch: u32,
}

#[derive(Clone, Copy, Debug, Default)]
pub struct Corner {
    pub position: DVec3,
    pub normal: Vec3,
    pub tangent: [f32; 4],
    pub uv: [Vec2; 2],
    pub color: [f32; 4],
    /// Painted density times the object's scale.
    pub density: f32,
}

impl Triangle {
    pub fn positions(&self) -> [DVec3; 3] {
        self.corners.map(|corner| corner.position)
    }

    /// Twice the area, along the normal.
    pub fn cross(&self) -> DVec3 {
        let [a, b, c] = self.positions();
        (b - a).cross(c - a)
    }
}

/// Is this entity baked: static, visible (its ancestors too) and drawn?
pub fn is_baked(scene: &Scene, entity: &Entity) -> bool {
    entity.is_static && entity.mesh.is_some() && !scene.is_hidden(entity)
}

/// Gathers all static triangles. NaN, infinity and what is beyond all measure are refused with the entity's name.
pub fn sanitise(scene: &Scene, assets: &Assets) -> Result<Surface, SceneError> {
    let mut surface = Surface::default();
    let world = world_from_local(scene);
    let mut order: Vec<usize> =
        (0..scene.entities.len()).filter(|&i| is_baked(scene, &scene.entities[i])).collect();
    order.sort_by_key(|&i| scene.entities[i].id);
    for index in order {
        gather(scene, assets, &scene.entities[index], &world[index], &mut surface)?;
    }
    rebase(&mut surface);
    drop_degenerate(&mut surface);
    drop_duplicates(&mut surface);
    Ok(surface)
}

fn gather(
    scene: &Scene,
    assets: &Assets,
    entity: &Entity,
    world_from_local: &DAffine3,
    surface: &mut Surface,
) -> Result<(), SceneError> {
    let Some(renderer) = &entity.mesh else { return Ok(()) };
    let Some(mesh) = assets.meshes.get(&renderer.mesh) else { return Ok(()) };
    let refuse = |message: String| SceneError::Entity { entity: entity.name.clone(), message };
    mesh.validate().map_err(refuse)?;
    if !world_from_local.is_finite() {
        return Err(refuse("its transform is not finite: correct it or one of its parents'".to_owned()));
    }
    surface.warnings.extend(rounded(entity, mesh, world_from_local));
    let mirrored = world_from_local.matrix3.determinant() < 0.0;
    let placed: Vec<Corner> = (0..mesh.positions.len())
        .map(|vertex| place(mesh, vertex, world_from_local, renderer.density.at(mesh.original(vertex))))
        .collect();
    for (slot, primitive) in mesh.primitives.iter().enumerate() {
        let material = renderer.materials.get(slot).or(renderer.materials.last()).copied();
        let double_sided = material.and_then(|id| scene.material(id)).is_some_and(|m| m.double_sided);
        let batch = surface.batches.len() as u32;
        surface.batches.push(Batch {
            entity: [entity.id.0 as u32, (entity.id.0 >> 32) as u32],
            material: material.map_or(u32::MAX, |id| id.0),
            double_sided: u32::from(double_sided),
            first: 0,
            count: 0,
        });
        surface.batch_names.push(entity.name.clone());
        let indices = &mesh.indices[primitive.first as usize..][..primitive.count as usize];
        for t in indices.chunks_exact(3) {
            let mut corners = [t[0], t[1], t[2]].map(|vertex| placed[vertex as usize]);
            if corners.iter().any(|corner| !corner.position.is_finite()) {
                return Err(refuse("a vertex is not finite: repair the mesh".to_owned()));
            }
            if corners.iter().any(|corner| corner.position.abs().max_element() > FARTHEST) {
                return Err(refuse(format!("it reaches farther than {FARTHEST:e} m: move or scale it")));
            }
            if mirrored {
                corners.swap(1, 2);
            }
            surface.triangles.push(Triangle { corners, batch });
        }
    }
    Ok(())
}

/// A vertex is rounded by more than this share of its mesh's size where the mesh lies far from its own origin.
const COARSE: f64 = 1e-4;

/// Numbers far from 0 are coarse: floats in a mesh 1000 km from its origin by 6 cm. An entity may stand as far away as
/// it likes, as its place is in f64.
fn rounded(entity: &Entity, mesh: &Mesh, world_from_local: &DAffine3) -> Option<Warning> {
    let low = mesh.positions.iter().fold(Vec3::INFINITY, |low, p| low.min(*p)).as_dvec3();
    let high = mesh.positions.iter().fold(Vec3::NEG_INFINITY, |high, p| high.max(*p)).as_dvec3();
    let (size, far) = ((high - low).max_element(), low.abs().max(high.abs()).max_element());
    let step = f64::from((far as f32).next_up()) - f64::from(far as f32);
    let metres = world_from_local.matrix3.x_axis.length();
    let message = || {
        format!(
            "its vertices lie up to {:.0} m from its own origin, where floats are {:.2e} m apart: move the mesh to its \
             origin, and the entity to its place",
            far * metres,
            step * metres
        )
    };
    (step > COARSE * size).then(|| Warning::new(format!("entity `{}`", entity.name), message()))
}

fn place(mesh: &Mesh, vertex: usize, world_from_local: &DAffine3, density: f32) -> Corner {
    let normal = normal_matrix(world_from_local) * mesh.normals[vertex].as_dvec3();
    let tangent = mesh.tangents.as_ref().map_or([0.0; 4], |tangents| {
        let t = world_from_local.transform_vector3(tangents[vertex].truncate().as_dvec3());
        let mirror = if world_from_local.matrix3.determinant() < 0.0 { -1.0 } else { 1.0 };
        t.normalize_or_zero().as_vec3().extend(tangents[vertex].w * mirror).to_array()
    });
    Corner {
        position: world_from_local.transform_point3(mesh.positions[vertex].as_dvec3()),
        normal: normal.normalize_or_zero().as_vec3(),
        tangent,
        uv: [mesh.uv(0, vertex), mesh.uv(1, vertex)],
        color: mesh.color(vertex).to_array(),
        density,
    }
}

/// Moves the scene near the origin and scales it to about one unit, both by powers of two.
fn rebase(surface: &mut Surface) {
    let positions = || surface.triangles.iter().flat_map(Triangle::positions);
    let low = positions().fold(DVec3::INFINITY, DVec3::min);
    let high = positions().fold(DVec3::NEG_INFINITY, DVec3::max);
    let extent = (high - low).max_element();
    let unit = if extent > 0.0 && extent.is_finite() { extent.log2().ceil().exp2() } else { 1.0 };
    // Halves go up on both sides of 0: `round` would send them away from it, and a scene that crosses it with them.
    let middle = (low + high) * (0.5 / unit);
    let origin = if extent.is_finite() { (middle + 0.5).floor() * unit } else { DVec3::ZERO };
    for corner in surface.triangles.iter_mut().flat_map(|triangle| &mut triangle.corners) {
        corner.position = (corner.position - origin) / unit;
    }
    (surface.origin, surface.unit) = (origin, unit);
}

/// Without area: nothing to see and nothing to divide by. Slivers of aspect 1e6 stay.
fn drop_degenerate(surface: &mut Surface) {
    let before = surface.triangles.len();
    let least = LEAST_AREA / (surface.unit * surface.unit);
    surface.triangles.retain(|triangle| {
        let [a, b, c] = triangle.positions().map(|p| p.as_vec3());
        let longest = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
        let cross = triangle.cross().length();
        a != b && b != c && c != a && cross > 1e-9 * f64::from(longest) && cross > least.max(1e-18)
    });
    surface.dropped += before - surface.triangles.len();
    for triangle in &mut surface.triangles {
        let normal = triangle.cross().normalize_or_zero().as_vec3();
        for corner in &mut triangle.corners {
            // A shading normal that looks away from its own face is no normal.
            if corner.normal.dot(normal) < 1e-3 {
                corner.normal = normal;
            }
        }
    }
}

/// The same triangle twice, facing the same way: the first one stays.
fn drop_duplicates(surface: &mut Surface) {
    let mut seen: HashMap<[[u32; 3]; 3], ()> = HashMap::with_capacity(surface.triangles.len());
    let mut duplicates: Vec<usize> = vec![0; surface.batches.len()];
    surface.triangles.retain(|triangle| {
        let mut key = triangle.positions().map(|p| (p.as_vec3() + 0.0).to_array().map(f32::to_bits));
        let first = (0..3).min_by_key(|&i| key[i]).unwrap_or(0);
        key.rotate_left(first);
        let new = seen.insert(key, ()).is_none();
        duplicates[triangle.batch as usize] += usize::from(!new);
        new
    });
    for (batch, &count) in duplicates.iter().enumerate().filter(|&(_, &count)| count > 0) {
        let message =
            format!("{count} triangles lie exactly on others that face the same way; they are left out");
        surface.warnings.push(Warning::new(&surface.batch_names[batch], message));
        surface.dropped += count;
    }
}
