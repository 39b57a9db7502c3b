//! What surrounds the scene. A ray that leaves the scene sees the sky's radiance.

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::{Changes, EntityId, ImageSource};

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sky {
    #[serde(default)]
    pub kind: SkyKind,
    #[serde(default)]
    pub changes: Changes,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SkyKind {
    /// Black: light that leaves is gone, and nothing is drawn.
    #[default]
    None,
    /// The same radiance [W/m2/sr] from everywhere, from below too.
    Constant { radiance: Vec3 },
    /// Radiance [W/m2/sr] from the horizon up to the zenith, and the ground's below it.
    Gradient {
        zenith: Vec3,
        horizon: Vec3,
        ground: Vec3,
        /// A sun light of the scene, whose disc is drawn. Its light comes from that light alone.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        sun: Option<EntityId>,
        /// Apparent diameter of the disc, radians.
        #[serde(default = "sun_diameter")]
        sun_diameter: f32,
    },
    /// An equirectangular picture: its middle looks along -Z when `turn` is 0.
    Picture {
        image: ImageSource,
        /// Times the picture's values [W/m2/sr].
        strength: f32,
        /// Radians about Y.
        #[serde(default)]
        turn: f32,
    },
}

fn sun_diameter() -> f32 {
    0.0093
}

/// Gradient: the weight of the zenith's colour at this height (y of the unit direction, >= 0).
pub fn zenith_weight(height: f32) -> f32 {
    height.max(0.0).sqrt().min(1.0)
}
