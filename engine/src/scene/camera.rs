//! A camera looks along its entity's -Z, with +Y up.

use serde::{Deserialize, Serialize};

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    pub projection: Projection,
    /// Metres.
    pub near: f32,
    /// Metres; `None`: no far plane.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub far: Option<f32>,
    /// Display = 2^exposure * radiance, before the tonemap.
    #[serde(default)]
    pub exposure: f32,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Projection {
    /// Vertical field of view, radians.
    Perspective { fov_y: f32 },
    /// Half the height that is seen, metres.
    Orthographic { half_height: f32 },
}

impl Default for Camera {
    fn default() -> Self {
        Self { projection: Projection::Perspective { fov_y: 0.9 }, near: 0.05, far: None, exposure: 0.0 }
    }
}
