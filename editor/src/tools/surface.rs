//! What a ray from the mouse meets: where dropped things come to stand, and what they are dropped on.

use std::collections::HashSet;

use engine::scene::{EntityId, MaterialId};
use glam::DVec3;

use crate::document::Document;
use crate::edit::{Edit, Field};
use crate::lens::Ray;
use crate::scenery::Scenery;

/// The first surface on a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    pub entity: EntityId,
    /// Of its mesh: which material is shown there.
    pub primitive: usize,
    pub place: DVec3,
    /// Metres from the ray's origin.
    away: f64,
}

type Seen<'a> = (&'a Document, &'a Scenery<'a>);

pub fn first(seen: Seen<'_>, ray: &Ray) -> Option<Hit> {
    let hits = shown(seen).filter_map(|(entity, world)| {
        let mesh = seen.1.assets.meshes.get(&entity.mesh.as_ref()?.mesh)?;
        let local_from_world = world.inverse();
        let from = local_from_world.transform_point3(ray.origin);
        let way = local_from_world.transform_vector3(ray.direction);
        let (triangle, away) = mesh.first_hit(from, way)?;
        let corner = triangle as u32 * 3;
        let primitive = mesh.primitives.iter().position(|p| (p.first..p.first + p.count).contains(&corner));
        let place = ray.origin + ray.direction * away;
        Some(Hit { entity: entity.id, primitive: primitive.unwrap_or(0), place, away })
    });
    hits.min_by(|a, b| a.away.total_cmp(&b.away))
}

/// Entities with meshes that neither are hidden nor stand under what is.
fn shown<'a>(
    (document, scenery): Seen<'a>,
) -> impl Iterator<Item = (&'a engine::scene::Entity, &'a glam::DAffine3)> {
    let indexed = document.indexed();
    let hidden = scenery.scene.entities.iter().filter(|entity| entity.hidden);
    let hidden: HashSet<EntityId> = hidden.flat_map(|entity| indexed.subtree(entity.id)).collect();
    scenery.placed().filter(move |(entity, _)| entity.mesh.is_some() && !hidden.contains(&entity.id))
}

/// Where something comes to stand that is dropped along a ray: on the first surface, else on the ground, else `far` away.
pub fn place(seen: Seen<'_>, ray: &Ray, far: f64) -> DVec3 {
    let surface = first(seen, ray).map(|hit| hit.place);
    let ground =
        || ray.meets(DVec3::ZERO, DVec3::Y).filter(|at| at.distance(ray.origin) < 1e4 * far.max(1.0));
    surface.or_else(ground).unwrap_or(ray.origin + ray.direction * far)
}

/// A material for what an entity shows in one primitive, or in all. `None`: it has no mesh.
pub fn assign(
    document: &Document,
    entity: EntityId,
    primitive: Option<usize>,
    material: MaterialId,
) -> Option<Edit> {
    let mut materials = document.entity(entity)?.mesh.as_ref()?.materials.clone();
    match primitive {
        Some(primitive) => {
            // The last stands for those that are not named.
            let last = materials.last().copied().unwrap_or(material);
            materials.resize(materials.len().max(primitive + 1), last);
            materials[primitive] = material;
        }
        None => materials.fill(material),
    }
    if materials.is_empty() {
        materials.push(material);
    }
    Some(Edit::set(entity, Field::Materials(materials)))
}

/// The material that is shown there.
pub fn material_at(document: &Document, hit: &Hit) -> Option<MaterialId> {
    let materials = &document.entity(hit.entity)?.mesh.as_ref()?.materials;
    materials.get(hit.primitive).or(materials.last()).copied()
}
