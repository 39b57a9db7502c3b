//! What the create menu makes.

use engine::scene::shape::Shape;
use engine::scene::{
    Camera, Density, Entity, EntityId, Light, LightKind, LightProbeGroup, Material, MaterialId, MeshRenderer,
    MeshSource, Reflection, ReflectionProbe, Scene, Sky, SkyKind, Transform,
};
use glam::{DQuat, DVec3, EulerRot, Vec3};

use crate::document::Document;
use crate::edit::{Edit, copies, tree};

/// One entry of the create menu.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Primitive {
    Empty,
    Cube,
    Sphere,
    Cylinder,
    Plane,
    Quad,
    Sun,
    PointLight,
    SpotLight,
    Camera,
    LightProbeGroup,
    ReflectionProbe,
    Sky,
}

impl Primitive {
    pub const ALL: [Self; 13] = [
        Self::Empty,
        Self::Cube,
        Self::Sphere,
        Self::Cylinder,
        Self::Plane,
        Self::Quad,
        Self::Sun,
        Self::PointLight,
        Self::SpotLight,
        Self::Camera,
        Self::LightProbeGroup,
        Self::ReflectionProbe,
        Self::Sky,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::Empty => "Empty",
            Self::Cube => "Cube",
            Self::Sphere => "Sphere",
            Self::Cylinder => "Cylinder",
            Self::Plane => "Plane",
            Self::Quad => "Quad",
            Self::Sun => "Sun",
            Self::PointLight => "Point light",
            Self::SpotLight => "Spot light",
            Self::Camera => "Camera",
            Self::LightProbeGroup => "Light probe group",
            Self::ReflectionProbe => "Reflection probe",
            Self::Sky => "Sky",
        }
    }

    fn shape(self) -> Option<Shape> {
        Some(match self {
            Self::Cube => Shape::Cube,
            Self::Sphere => Shape::Sphere,
            Self::Cylinder => Shape::Cylinder,
            Self::Plane => Shape::Plane,
            Self::Quad => Shape::Quad,
            _ => return None,
        })
    }

    /// An entity that carries it, without a place. The sky is no entity.
    fn entity(self) -> Entity {
        let light = |kind, intensity| Some(Light { kind, intensity, ..Light::default() });
        let mut entity = Entity { name: self.name().to_owned(), ..Entity::default() };
        match self {
            Self::Sun => {
                entity.light = light(LightKind::Sun, 3.0);
                // The sun of an afternoon, not of noon: shadows show it.
                entity.transform.rotation = DQuat::from_euler(EulerRot::YXZ, 0.6, -0.9, 0.0);
            }
            Self::PointLight => entity.light = light(LightKind::Point, 10.0),
            Self::SpotLight => {
                entity.light = light(LightKind::Spot { inner: 0.35, outer: 0.5 }, 20.0);
                // Down, as a lamp hangs.
                entity.transform.rotation = DQuat::from_rotation_x(-std::f64::consts::FRAC_PI_2);
            }
            Self::Camera => entity.camera = Some(Camera::default()),
            Self::LightProbeGroup => entity.light_probes = Some(probes()),
            Self::ReflectionProbe => entity.reflection_probe = Some(ReflectionProbe::default()),
            _ => {}
        }
        entity
    }
}

/// The corners of two metres.
fn probes() -> LightProbeGroup {
    let corner = |n: u32| Vec3::from([0, 1, 2].map(|axis| if n >> axis & 1 == 0 { -1.0 } else { 1.0 }));
    LightProbeGroup { positions: (0..8).map(corner).collect() }
}

/// A day's: enough to see by, without a sun of its own.
pub fn day() -> Sky {
    let kind = SkyKind::Gradient {
        zenith: Vec3::new(0.25, 0.45, 0.9),
        horizon: Vec3::new(0.7, 0.8, 0.95),
        ground: Vec3::splat(0.2),
        sun: None,
        sun_diameter: 0.0093,
    };
    Sky { kind, ..Sky::default() }
}

/// The material that shapes get: a light grey, as of plaster.
pub fn plaster(id: MaterialId) -> Material {
    let mut material = Material { id, name: "plaster".to_owned(), roughness: 0.8, ..Material::default() };
    material.albedo.color = Vec3::splat(0.7);
    material
}

/// What creating it does, and the entity to select. It stands at `place` (of the world), under `parent`, static
/// where it is a shape: what moves is the exception. `size`: how large it is, where 1 is as a rule.
pub fn create(
    document: &mut Document,
    primitive: Primitive,
    (place, size): (DVec3, f64),
    parent: Option<EntityId>,
) -> (Edit, Option<EntityId>) {
    let name = format!("Create {}", primitive.name().to_lowercase());
    if primitive == Primitive::Sky {
        return (Edit::several(name, [Edit::Sky(Box::new(day()))]), None);
    }
    let parent = parent.filter(|parent| document.entity(*parent).is_some());
    let mut edits = Vec::new();
    let mut entity = Entity { id: document.new_entity_id(), parent, ..primitive.entity() };
    let world_from_parent = parent.map(|parent| document.world_from_local(parent)).unwrap_or_default();
    let local = world_from_parent.inverse().transform_point3(place);
    entity.transform.translation = if local.is_finite() { local } else { DVec3::ZERO };
    if let Some(shape) = primitive.shape() {
        let material = shared_plaster(document, &mut edits);
        entity.mesh = Some(renderer(shape, material));
        entity.is_static = !is_carried(document, parent);
    }
    resize(&mut entity, size);
    entity.name = copies::Names::beside(document.indexed()).free(parent, &entity.name);
    let id = entity.id;
    let at = parent
        .map_or(document.scene().entities.len(), |parent| tree::end_of_subtree(document.indexed(), parent));
    edits.push(Edit::Insert(vec![(at, entity)]));
    (Edit::several(name, edits), Some(id))
}

/// A shape and a probe's box are so large; a lamp makes what stands in the same proportion to it as bright as ever:
/// E = I / r^2.
fn resize(entity: &mut Entity, size: f64) {
    if entity.mesh.is_some() {
        entity.transform.scale *= size;
    }
    if let Some(light) = entity.light.as_mut().filter(|light| light.kind != LightKind::Sun) {
        light.intensity *= (size * size) as f32;
    }
    if let Some(group) = &mut entity.light_probes {
        group.positions.iter_mut().for_each(|position| *position *= size as f32);
    }
    if let Some(probe) = &mut entity.reflection_probe {
        probe.half_size *= size as f32;
        probe.blend_distance *= size as f32;
    }
}

pub fn cube(material: MaterialId) -> MeshRenderer {
    renderer(Shape::Cube, material)
}

fn renderer(shape: Shape, material: MaterialId) -> MeshRenderer {
    MeshRenderer {
        mesh: MeshSource::Shape(shape),
        materials: vec![material],
        casts_shadows: true,
        density: Density::default(),
        reflection: Reflection::default(),
    }
}

/// The scene's own plaster, or a new one.
fn shared_plaster(document: &mut Document, edits: &mut Vec<Edit>) -> MaterialId {
    let same = |material: &&Material| **material == plaster(material.id);
    if let Some(material) = document.scene().materials.iter().find(same) {
        return material.id;
    }
    let id = document.new_material_id();
    edits.push(Edit::InsertMaterials(vec![(document.scene().materials.len(), plaster(id))]));
    id
}

/// Does anything above move? What is static must not be carried about.
fn is_carried(document: &Document, parent: Option<EntityId>) -> bool {
    let above = parent
        .into_iter()
        .flat_map(|parent| document.entity(parent).into_iter().chain(document.indexed().ancestors(parent)));
    above.into_iter().any(|entity| entity.motion.is_some())
}

/// A new scene: a floor, a cube, a sun in a sky, and a camera that sees them.
pub fn first_scene() -> Scene {
    let mut materials = vec![plaster(MaterialId(1))];
    materials[0].albedo.color = Vec3::splat(0.6);
    let make = |id, primitive: Primitive, transform: Transform| {
        let mesh = primitive.shape().map(|shape| renderer(shape, MaterialId(1)));
        Entity { id: EntityId(id), is_static: mesh.is_some(), mesh, transform, ..primitive.entity() }
    };
    let floor = Transform { scale: DVec3::splat(10.0), ..Transform::default() };
    let eye = Transform {
        translation: DVec3::new(4.0, 3.0, 6.0),
        rotation: DQuat::from_euler(EulerRot::YXZ, 0.588, -0.334, 0.0),
        ..Transform::default()
    };
    let sun = Primitive::Sun.entity().transform;
    let entities = vec![
        make(1, Primitive::Plane, floor),
        make(2, Primitive::Cube, Transform::at(DVec3::Y * 0.5)),
        make(3, Primitive::Sun, Transform { translation: DVec3::Y * 4.0, ..sun }),
        make(4, Primitive::Camera, eye),
    ];
    let mut sky = day();
    sky = tree::with_sun(&sky, Some(EntityId(3)));
    Scene { sky, materials, entities }
}
