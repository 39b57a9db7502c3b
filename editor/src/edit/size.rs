//! How much memory an edit holds, near enough for a budget.

use std::mem::size_of;

use engine::scene::{Entity, EntityId, Material, MeshRenderer, MeshSource, Motion, Scene, Texture};

use super::{Edit, Field};

impl Edit {
    /// Of the edit and of all that it owns.
    pub fn bytes(&self) -> usize {
        let own = match self {
            Self::Set(fields) => {
                fields.iter().map(|(_, field)| size_of::<(EntityId, Field)>() + of_field(field)).sum()
            }
            Self::Insert(entities) => {
                entities.iter().map(|(_, new)| size_of::<usize>() + of_entity(new)).sum()
            }
            Self::Remove(ids) => size_of_val(ids.as_slice()),
            Self::Order(places) => size_of_val(places.as_slice()),
            Self::SetMaterials(materials) => materials.iter().map(of_material).sum(),
            Self::InsertMaterials(materials) => {
                materials.iter().map(|(_, new)| size_of::<usize>() + of_material(new)).sum()
            }
            Self::RemoveMaterials(ids) => size_of_val(ids.as_slice()),
            Self::Sky(sky) => size_of_val(&**sky),
            Self::Whole(scene) => of_scene(scene),
            Self::Several { name, edits } => name.len() + edits.iter().map(Self::bytes).sum::<usize>(),
        };
        size_of::<Self>() + own
    }
}

/// Behind the field's own size.
fn of_field(field: &Field) -> usize {
    match field {
        Field::Name(name) => name.len(),
        Field::Transform(boxed) => size_of_val(&**boxed),
        Field::Mesh(mesh) => mesh.as_ref().map_or(0, |mesh| size_of_val(&**mesh) + behind_mesh(mesh)),
        Field::Materials(materials) => size_of_val(materials.as_slice()),
        Field::Density(density) => size_of_val(&**density) + size_of_val(density.painted.as_slice()),
        Field::Reflection(reflection) => {
            size_of_val(&**reflection)
                + reflection.probes.as_ref().map_or(0, |probes| size_of_val(probes.as_slice()))
        }
        Field::Light(light) => light.as_ref().map_or(0, |light| size_of_val(&**light)),
        Field::Camera(camera) => camera.as_ref().map_or(0, |camera| size_of_val(&**camera)),
        Field::LightProbes(probes) => probes
            .as_ref()
            .map_or(0, |probes| size_of_val(&**probes) + size_of_val(probes.positions.as_slice())),
        Field::ReflectionProbe(probe) => probe.as_ref().map_or(0, |probe| size_of_val(&**probe)),
        Field::Motion(motion) => {
            motion.as_ref().map_or(0, |motion| size_of_val(&**motion) + behind_motion(motion))
        }
        Field::Parent(_) | Field::Static(_) | Field::Hidden(_) | Field::CastsShadows(_) => 0,
    }
}

fn of_scene(scene: &Scene) -> usize {
    let entities: usize = scene.entities.iter().map(of_entity).sum();
    let materials: usize = scene.materials.iter().map(of_material).sum();
    size_of::<Scene>() + entities + materials
}

fn of_entity(entity: &Entity) -> usize {
    let probes = entity.light_probes.as_ref().map_or(0, |probes| size_of_val(probes.positions.as_slice()));
    let behind =
        entity.mesh.as_ref().map_or(0, behind_mesh) + entity.motion.as_ref().map_or(0, behind_motion);
    size_of::<Entity>() + entity.name.len() + probes + behind
}

fn behind_mesh(mesh: &MeshRenderer) -> usize {
    let file = if let MeshSource::File { file, .. } = &mesh.mesh { file.len() } else { 0 };
    let probes = mesh.reflection.probes.as_ref().map_or(0, |probes| size_of_val(probes.as_slice()));
    file + size_of_val(mesh.materials.as_slice()) + size_of_val(mesh.density.painted.as_slice()) + probes
}

fn behind_motion(motion: &Motion) -> usize {
    match motion {
        Motion::Spin { .. } => 0,
        Motion::PingPong { points, .. } => size_of_val(points.as_slice()),
        Motion::Clip { file, .. } => file.len(),
    }
}

fn of_material(material: &Material) -> usize {
    let textures = [
        &material.albedo.texture,
        &material.metallic_roughness_texture,
        &material.normal_texture,
        &material.emission.texture,
    ];
    let names = textures.into_iter().flatten().map(|texture: &Texture| texture.image.file.len());
    size_of::<Material>() + material.name.len() + names.sum::<usize>()
}
