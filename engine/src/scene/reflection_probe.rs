//! A reflection probe: a camera that takes a cubemap, and the box in which it is used.

use glam::Vec3;
use serde::{Deserialize, Serialize};

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReflectionProbe {
    /// Pixels along a cube face.
    pub resolution: u32,
    /// Half the box of influence, in the entity's space (metres), about `offset`: the room whose walls the probe
    /// shows. All of the box reads the probe.
    pub half_size: Vec3,
    #[serde(default)]
    pub offset: Vec3,
    /// Metres beyond the box over which the probe fades. Thicker than a wall, it reaches the next room.
    pub blend_distance: f32,
    /// The higher one wins where boxes overlap.
    #[serde(default)]
    pub importance: i32,
    /// Reflections follow the box instead of lying at infinity.
    pub box_projection: bool,
    pub refresh: Refresh,
    pub faces: Faces,
    /// Metres.
    pub near: f32,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Refresh {
    Baked,
    #[default]
    OnChange,
    EveryFrame,
}

/// How many faces are taken in one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Faces {
    #[default]
    AllAtOnce,
    Sliced,
}

impl Default for ReflectionProbe {
    fn default() -> Self {
        Self {
            resolution: 128,
            half_size: Vec3::splat(2.5),
            offset: Vec3::ZERO,
            blend_distance: 0.25,
            importance: 0,
            box_projection: true,
            refresh: Refresh::OnChange,
            faces: Faces::AllAtOnce,
            near: 0.05,
        }
    }
}
