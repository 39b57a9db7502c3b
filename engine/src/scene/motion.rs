//! How an entity moves while the scene plays, as a function of time alone.

use glam::DVec3;
use serde::{Deserialize, Serialize};

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Motion {
    /// Turns about an axis through its own origin, in its parent's space.
    Spin { axis: DVec3, radians_per_second: f64 },
    /// Goes along the points (in its parent's space) and back, there and back in `seconds`, slowing at the ends.
    PingPong { points: Vec<DVec3>, seconds: f64 },
    /// A node's animation out of an imported glTF file, repeated for ever.
    Clip { file: String, animation: u32, node: u32, speed: f64 },
}
