//! Punctual lights, as KHR_lights_punctual defines them. A light shines along its entity's -Z.

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::Changes;
use super::entity::yes;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Light {
    pub kind: LightKind,
    pub color: Vec3,
    /// Sun: irradiance on a facing surface [W/m2]. Point and spot: radiant intensity [W/sr].
    pub intensity: f32,
    /// Point and spot: the light is windowed to nothing at this distance [m]. `None`: it reaches all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<f32>,
    #[serde(default = "yes")]
    pub casts_shadows: bool,
    #[serde(default = "yes")]
    pub on: bool,
    #[serde(default)]
    pub changes: Changes,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LightKind {
    Sun,
    Point,
    /// Half angles in radians: full inside `inner`, nothing outside `outer`.
    Spot {
        inner: f32,
        outer: f32,
    },
}

impl Default for Light {
    fn default() -> Self {
        Self {
            kind: LightKind::Point,
            color: Vec3::ONE,
            intensity: 1.0,
            range: None,
            casts_shadows: true,
            on: true,
            changes: Changes::Anything,
        }
    }
}

impl Light {
    /// The spot's scale and offset: share = saturate(scale * cos(angle) + offset)^2 (KHR_lights_punctual).
    /// Point and sun: (0, 1).
    pub fn cone(&self) -> (f32, f32) {
        match self.kind {
            LightKind::Spot { inner, outer } => {
                let scale = 1.0 / (inner.cos() - outer.cos()).max(1e-4);
                (scale, -outer.cos() * scale)
            }
            _ => (0.0, 1.0),
        }
    }

    /// What the range leaves of the light at this distance: saturate(1 - (d/range)^4), 1 without a range.
    pub fn window(&self, distance: f32) -> f32 {
        self.range.map_or(1.0, |range| (1.0 - (distance / range).powi(4)).clamp(0.0, 1.0))
    }

    /// Its spectrum: colour times intensity where it is on.
    pub fn power(&self) -> Vec3 {
        if self.on { self.color * self.intensity } else { Vec3::ZERO }
    }
}
