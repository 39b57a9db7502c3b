//! A group of light probes: points at which the light from all around is known, for objects that move.

use glam::Vec3;
use serde::{Deserialize, Serialize};

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LightProbeGroup {
    /// In the entity's space, metres.
    pub positions: Vec<Vec3>,
}
