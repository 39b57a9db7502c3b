//! One value of one entity: what inspectors, gizmos and the hierarchy set.

use engine::scene::{
    Camera, Density, Entity, EntityId, Light, LightProbeGroup, MaterialId, MeshRenderer, Motion, Reflection,
    ReflectionProbe, Transform,
};

/// A value that an entity can take. Large ones are boxed, so that an edit of thousands of names stays small.
#[derive(Clone, Debug, PartialEq)]
pub enum Field {
    Name(String),
    Parent(Option<EntityId>),
    Transform(Box<Transform>),
    Static(bool),
    Hidden(bool),
    Mesh(Option<Box<MeshRenderer>>),
    /// Of the entity's mesh; nothing where it has none.
    Materials(Vec<MaterialId>),
    CastsShadows(bool),
    Density(Box<Density>),
    Reflection(Box<Reflection>),
    Light(Option<Box<Light>>),
    Camera(Option<Box<Camera>>),
    LightProbes(Option<Box<LightProbeGroup>>),
    ReflectionProbe(Option<Box<ReflectionProbe>>),
    Motion(Option<Box<Motion>>),
}

impl Field {
    /// The entity takes the value; what it had is given back. `None`: it has it already, or no such component.
    pub(super) fn exchange(self, entity: &mut Entity) -> Option<Field> {
        let mesh = entity.mesh.as_mut();
        match self {
            Self::Name(new) => exchanged(Some(&mut entity.name), new, Self::Name),
            Self::Parent(new) => exchanged(Some(&mut entity.parent), new, Self::Parent),
            Self::Transform(new) => boxed(Some(&mut entity.transform), new, Self::Transform),
            Self::Static(new) => exchanged(Some(&mut entity.is_static), new, Self::Static),
            Self::Hidden(new) => exchanged(Some(&mut entity.hidden), new, Self::Hidden),
            Self::Mesh(new) => component(&mut entity.mesh, new, Self::Mesh),
            Self::Materials(new) => exchanged(mesh.map(|mesh| &mut mesh.materials), new, Self::Materials),
            Self::CastsShadows(new) => {
                exchanged(mesh.map(|mesh| &mut mesh.casts_shadows), new, Self::CastsShadows)
            }
            Self::Density(new) => boxed(mesh.map(|mesh| &mut mesh.density), new, Self::Density),
            Self::Reflection(new) => boxed(mesh.map(|mesh| &mut mesh.reflection), new, Self::Reflection),
            Self::Light(new) => component(&mut entity.light, new, Self::Light),
            Self::Camera(new) => component(&mut entity.camera, new, Self::Camera),
            Self::LightProbes(new) => component(&mut entity.light_probes, new, Self::LightProbes),
            Self::ReflectionProbe(new) => component(&mut entity.reflection_probe, new, Self::ReflectionProbe),
            Self::Motion(new) => component(&mut entity.motion, new, Self::Motion),
        }
    }

    /// What is done to an entity by setting it, as a menu says it.
    pub fn verb(&self) -> &'static str {
        match self {
            Self::Name(_) => "Rename",
            Self::Parent(_) => "Reparent",
            Self::Transform(_) => "Transform",
            Self::Static(_) => "Change static of",
            Self::Hidden(true) => "Hide",
            Self::Hidden(false) => "Show",
            Self::Mesh(_) => "Change mesh of",
            Self::Materials(_) => "Assign material to",
            Self::CastsShadows(_) => "Change shadows of",
            Self::Density(_) => "Change density of",
            Self::Reflection(_) => "Change reflections of",
            Self::Light(_) => "Change light of",
            Self::Camera(_) => "Change camera of",
            Self::LightProbes(_) => "Change light probes of",
            Self::ReflectionProbe(_) => "Change reflection probe of",
            Self::Motion(_) => "Change motion of",
        }
    }
}

fn exchanged<T: PartialEq>(place: Option<&mut T>, new: T, field: fn(T) -> Field) -> Option<Field> {
    let place = place.filter(|place| **place != new)?;
    Some(field(std::mem::replace(place, new)))
}

/// The box goes back with the old value in it.
fn boxed<T: PartialEq>(place: Option<&mut T>, mut new: Box<T>, field: fn(Box<T>) -> Field) -> Option<Field> {
    let place = place.filter(|place| **place != *new)?;
    std::mem::swap(place, &mut new);
    Some(field(new))
}

fn component<T: PartialEq>(
    place: &mut Option<T>,
    new: Option<Box<T>>,
    field: fn(Option<Box<T>>) -> Field,
) -> Option<Field> {
    let new = new.map(|new| *new);
    let old = (*place != new).then(|| std::mem::replace(place, new))?;
    Some(field(old.map(Box::new)))
}
