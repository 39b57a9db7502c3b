//! An entity: a name, a place in the hierarchy, a transform, and the components that it carries.

use serde::{Deserialize, Serialize};

use super::{
    Camera, Density, Light, LightProbeGroup, MaterialId, MeshSource, Motion, ReflectionProbe, Transform,
};

/// Stable for the life of a scene; patches are keyed by it, so that it is never reused or renumbered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct EntityId(pub u64);

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Entity {
    pub id: EntityId,
    pub name: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parent: Option<EntityId>,
    #[serde(default)]
    pub transform: Transform,
    /// Takes part in the bake, and never moves. A static entity's parents do not move either.
    #[serde(default)]
    pub is_static: bool,
    /// Not drawn and not baked; neither are its children.
    #[serde(default, skip_serializing_if = "is_false")]
    pub hidden: bool,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mesh: Option<MeshRenderer>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub light: Option<Light>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub camera: Option<Camera>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub light_probes: Option<LightProbeGroup>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reflection_probe: Option<ReflectionProbe>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<Motion>,
}

/// Draws a mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeshRenderer {
    pub mesh: MeshSource,
    /// One for each primitive of the mesh, in its order. Where there are fewer, the last one stands
    /// for the rest.
    pub materials: Vec<MaterialId>,
    #[serde(default = "yes", skip_serializing_if = "is_true")]
    pub casts_shadows: bool,
    #[serde(default)]
    pub density: Density,
    #[serde(default)]
    pub reflection: Reflection,
}

/// How an object shows reflections.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reflection {
    /// 0 (none) to 1 (as its material says).
    pub strength: f32,
    /// Choose probes for this entity's place instead of the object's own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub anchor: Option<EntityId>,
    /// Use these probes and no others. `None`: all whose volumes hold the object.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub probes: Option<Vec<EntityId>>,
}

impl Default for Reflection {
    fn default() -> Self {
        Self { strength: 1.0, anchor: None, probes: None }
    }
}

pub(crate) fn yes() -> bool {
    true
}

pub(crate) fn is_true(value: &bool) -> bool {
    *value
}

pub(crate) fn is_false(value: &bool) -> bool {
    !*value
}
