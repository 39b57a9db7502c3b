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

impl Camera {
    /// It sees something: an opening between nothing and a half turn, planes in their order.
    pub fn validate(&self) -> Result<(), String> {
        let (is_open, least_near) = match self.projection {
            Projection::Perspective { fov_y } => {
                (fov_y > 0.0 && fov_y < std::f32::consts::PI, f32::MIN_POSITIVE)
            }
            Projection::Orthographic { half_height } => (half_height > 0.0 && half_height.is_finite(), 0.0),
        };
        if !is_open {
            return Err(
                "the camera's field of view has to be larger than 0, and smaller than a half turn".to_owned()
            );
        }
        let has_depth =
            self.near >= least_near && self.near.is_finite() && self.far.is_none_or(|far| far > self.near);
        if !has_depth {
            return Err(
                "the camera's near plane has to lie before it, and its far plane beyond that".to_owned()
            );
        }
        if self.exposure.is_finite() { Ok(()) } else { Err("the camera's exposure is not finite".to_owned()) }
    }
}
