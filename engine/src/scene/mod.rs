//! What the author placed: plain data, in metres, Y up, right-handed, linear RGB.
//!
//! A scene says nothing of patches, rows or GPUs. It is read and written by [`file`] alone; what its
//! entities refer to (meshes, pictures, clips) is read by [`assets`].

pub mod assets;
pub mod camera;
mod clip;
pub mod density;
pub mod entity;
pub mod error;
mod feature;
pub mod file;
pub mod import;
pub mod light;
pub mod light_probes;
pub mod material;
pub mod mesh;
pub mod motion;
pub mod reflection_probe;
pub mod shape;
pub mod sky;
pub mod transform;
mod validate;

use serde::{Deserialize, Serialize};

pub use camera::{AutoExposure, Camera, Projection, ToneCurve};
pub use density::Density;
pub use entity::{Entity, EntityId, MeshRenderer, Reflection};
pub use error::{SceneError, Warning};
pub use feature::{Feature, Forced};
pub use light::{Light, LightKind, Switching};
pub use light_probes::LightProbeGroup;
pub use material::{Albedo, Alpha, Emission, ImageSource, Material, MaterialId, Texture};
pub use mesh::{Mesh, MeshSource};
pub use motion::Motion;
pub use reflection_probe::{Faces, ReflectionProbe, Refresh};
pub use sky::{Sky, SkyKind};
pub use transform::{Transform, world_from_local};

/// How freely something may change while the scene plays. What may change less costs less.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Changes {
    /// Fixed when the scene is baked; the runtime may fold it away and does not let it be switched.
    Never,
    /// Its brightness changes, its colour and place do not.
    Intensity,
    #[default]
    Anything,
}

/// Everything in one scene file. Entities stand in the order of the hierarchy panel.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    #[serde(default)]
    pub sky: Sky,
    #[serde(default)]
    pub materials: Vec<Material>,
    #[serde(default)]
    pub entities: Vec<Entity>,
}

impl Scene {
    pub fn entity(&self, id: EntityId) -> Option<&Entity> {
        self.entities.iter().find(|entity| entity.id == id)
    }

    pub fn material(&self, id: MaterialId) -> Option<&Material> {
        self.materials.iter().find(|material| material.id == id)
    }

    /// An entity id that no entity has yet.
    pub fn free_entity_id(&self) -> EntityId {
        EntityId(self.entities.iter().map(|entity| entity.id.0 + 1).max().unwrap_or(1))
    }

    /// Is the entity hidden, or one that it stands under?
    pub fn is_hidden(&self, entity: &Entity) -> bool {
        let parent = |entity: &&Entity| entity.parent.and_then(|parent| self.entity(parent));
        // No chain is longer than there are entities: a circle ends too.
        std::iter::successors(Some(entity), parent).take(self.entities.len() + 1).any(|entity| entity.hidden)
    }

    /// The camera to look through: the first that the hierarchy names.
    pub fn camera(&self) -> Option<(&Entity, &Camera)> {
        self.entities.iter().find_map(|entity| Some((entity, entity.camera.as_ref()?)))
    }

    /// Refuses what no later stage could make sense of: ids that are used twice, references to
    /// nothing, parents in a circle, numbers that are not finite, negative light, static entities that are
    /// carried about. Each error names the entity and the remedy.
    pub fn validate(&self) -> Result<(), SceneError> {
        validate::validate(self)
    }
}
