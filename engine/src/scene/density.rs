//! Patch density: how finely an object is divided, against the scene's base length.

use serde::{Deserialize, Serialize};

/// The patch length at a point is base length / (scale * painted value there).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Density {
    /// Of the whole object. 2: patches of half the length.
    pub scale: f32,
    /// One value for each vertex of the mesh, or empty where nothing was painted (1 everywhere).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub painted: Vec<f32>,
}

/// Densities outside this range are clamped to it: paint of 0, infinity or NaN harms nothing.
pub const RANGE: std::ops::RangeInclusive<f32> = 1.0 / 16.0..=16.0;

impl Default for Density {
    fn default() -> Self {
        Self { scale: 1.0, painted: Vec::new() }
    }
}

impl Density {
    /// At a vertex of the mesh; NaN counts as 1.
    pub fn at(&self, vertex: usize) -> f32 {
        let density = self.scale * self.painted.get(vertex).copied().unwrap_or(1.0);
        if density.is_nan() { 1.0 } else { density.clamp(*RANGE.start(), *RANGE.end()) }
    }
}
