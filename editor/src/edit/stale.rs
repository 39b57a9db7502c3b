//! What an edit costs. This is the one place that knows that a lamp is free and a wall costs a bake; the baker's
//! own answer, which reads every vertex, is [`engine::transport::key::inputs`], and a test compares the two.

use engine::scene::{Alpha, Entity, EntityId, Material, MeshRenderer, SkyKind};

use super::{Edit, Field, IndexedScene};

/// What does not hold any more after an edit. Ordered: the later, the dearer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Stale {
    /// A name, an order: the picture is the same.
    #[default]
    Nothing,
    /// The next frame shows it.
    Light,
    /// The bake does not fit any more.
    Transport,
}

impl Edit {
    /// Before it is applied to the scene.
    pub fn stale(&self, scene: &IndexedScene) -> Stale {
        match self {
            Self::Set(fields) => {
                let field =
                    |(id, field): &(EntityId, Field)| Some(of_field(field, scene.position(*id)?, scene));
                fields.iter().filter_map(field).max().unwrap_or_default()
            }
            Self::Insert(entities) => entities.iter().map(|(_, new)| presence(new)).max().unwrap_or_default(),
            Self::Remove(ids) => {
                ids.iter().filter_map(|id| scene.entity(*id)).map(presence).max().unwrap_or_default()
            }
            Self::SetMaterials(materials) => {
                let change = |new: &Material| Some(material_change(scene.material(new.id)?, new));
                materials.iter().filter_map(change).max().unwrap_or_default()
            }
            // What draws them says what that costs.
            Self::InsertMaterials(_) | Self::RemoveMaterials(_) => Stale::Nothing,
            // The first camera of the hierarchy is looked through.
            Self::Order(_) => Stale::Light,
            Self::Sky(sky) => {
                let is_lit = |kind: &SkyKind| *kind != SkyKind::None;
                transport_if(is_lit(&sky.kind) != is_lit(&scene.scene().sky.kind))
            }
            Self::Whole(_) => Stale::Transport,
            Self::Several { edits, .. } => {
                edits.iter().map(|edit| edit.stale(scene)).max().unwrap_or_default()
            }
        }
    }
}

/// Before the entity at this place of the scene's list takes the value.
pub(super) fn of_field(field: &Field, at: usize, scene: &IndexedScene) -> Stale {
    let entity = &scene.scene().entities[at];
    match field {
        Field::Name(_) => Stale::Nothing,
        Field::Parent(_) | Field::Transform(_) | Field::Hidden(_) => {
            let below = scene.subtree(entity.id).into_iter().filter_map(|id| scene.entity(id));
            below.map(presence).max().unwrap_or_default()
        }
        Field::Static(_) => transport_if(entity.mesh.is_some()),
        Field::Mesh(new) => {
            transport_if(entity.is_static && baked(entity.mesh.as_ref()) != baked(new.as_deref()))
        }
        Field::Materials(_) | Field::Density(_) => transport_if(entity.is_static && entity.mesh.is_some()),
        Field::LightProbes(_) => Stale::Transport,
        Field::CastsShadows(_)
        | Field::Reflection(_)
        | Field::Light(_)
        | Field::Camera(_)
        | Field::ReflectionProbe(_)
        | Field::Motion(_) => Stale::Light,
    }
}

/// What it costs that an entity is there, is not there, or is elsewhere.
fn presence(entity: &Entity) -> Stale {
    let is_surface = entity.is_static && entity.mesh.is_some();
    transport_if(is_surface || entity.light_probes.is_some())
}

/// What of a mesh the bake takes.
fn baked(mesh: Option<&MeshRenderer>) -> Option<impl PartialEq> {
    mesh.map(|mesh| (mesh.mesh.clone(), mesh.materials.clone(), mesh.density.clone()))
}

fn material_change(old: &Material, new: &Material) -> Stale {
    let renamed = Material { name: new.name.clone(), ..old.clone() };
    if renamed == *new {
        return Stale::Nothing;
    }
    // Sides, holes, what rays are sent towards, and the texture coordinates that vertices are made of.
    let shape = |m: &Material| {
        (m.double_sided, m.emission.sampled, m.alpha, m.normal_texture.as_ref().map(|map| map.uv_set))
    };
    let holes = |m: &Material| (m.alpha != Alpha::Opaque).then(|| (m.opacity, m.albedo.texture.clone()));
    transport_if(shape(old) != shape(new) || holes(old) != holes(new))
}

fn transport_if(bakes: bool) -> Stale {
    if bakes { Stale::Transport } else { Stale::Light }
}
