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
                let probed = has_light_probes(scene);
                let field = |(id, field): &(EntityId, Field)| {
                    Some(of_field(field, scene.position(*id)?, scene, probed))
                };
                fields.iter().filter_map(field).max().unwrap_or_default()
            }
            Self::Insert(entities) => {
                let probed = has_light_probes(scene);
                entities.iter().map(|(_, new)| presence(new, probed)).max().unwrap_or_default()
            }
            Self::Remove(ids) => {
                let probed = has_light_probes(scene);
                let gone = ids.iter().filter_map(|id| scene.entity(*id));
                gone.map(|gone| presence(gone, probed)).max().unwrap_or_default()
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

/// Before the entity at this place of the scene's list takes the value. `probed`: [`has_light_probes`].
pub(super) fn of_field(field: &Field, at: usize, scene: &IndexedScene, probed: bool) -> Stale {
    let entity = &scene.scene().entities[at];
    let below = || scene.subtree(entity.id).into_iter().filter_map(|id| scene.entity(id));
    match field {
        Field::Name(_) => Stale::Nothing,
        Field::Transform(_) => below().map(|entity| presence(entity, false)).max().unwrap_or_default(),
        // What stands under something hidden is hidden, too.
        Field::Parent(_) | Field::Hidden(_) => {
            below().map(|entity| presence(entity, probed)).max().unwrap_or_default()
        }
        Field::Static(_) => transport_if(entity.mesh.is_some()),
        Field::Mesh(new) => {
            let flips = probed && entity.mesh.is_some() != new.is_some();
            let rebakes = entity.is_static && baked(entity.mesh.as_ref()) != baked(new.as_deref());
            transport_if(flips || rebakes)
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

/// What it costs that an entity is there, is not there, or is elsewhere. `probed`: a mesh that is not static decides
/// whether light probes are baked at all, for who else would read them?
fn presence(entity: &Entity, probed: bool) -> Stale {
    transport_if(entity.light_probes.is_some() || (entity.mesh.is_some() && (entity.is_static || probed)))
}

pub(super) fn has_light_probes(scene: &IndexedScene) -> bool {
    scene.scene().entities.iter().any(|entity| entity.light_probes.is_some())
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
