//! What is dropped on surfaces: where it comes to stand, and what it changes there.

use engine::scene::{EntityId, MaterialId};
use glam::DVec3;

use crate::document::Document;
use crate::edit::{Edit, Field};
use crate::lens::Ray;
use crate::tools::hit::Hit;

/// Where something comes to stand that is dropped along a ray: on the surface that it meets, else on the ground, else
/// `far` away.
pub fn place(hit: Option<&Hit>, ray: &Ray, far: f64) -> DVec3 {
    let ground =
        || ray.meets(DVec3::ZERO, DVec3::Y).filter(|at| at.distance(ray.origin) < 1e4 * far.max(1.0));
    hit.map(|hit| hit.at).or_else(ground).unwrap_or(ray.origin + ray.direction * far)
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
