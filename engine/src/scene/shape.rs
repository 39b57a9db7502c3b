//! Meshes that the engine makes itself.

use serde::{Deserialize, Serialize};

/// One metre across, about the origin.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    Cube,
    Sphere,
    Cylinder,
    /// In the XZ plane, facing +Y.
    Plane,
    /// In the XY plane, facing +Z.
    Quad,
}
