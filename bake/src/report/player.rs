//! What only the player can say: the scene's picture, milliseconds on the GPU, and the light that the GPU solved.
//!
//! It is run from beside this program's own executable, without a window; where it is missing or cannot draw, the
//! report goes on without.

use std::path::Path;

use glam::DVec3;

use super::Budget;
use crate::{BakeError, Watcher};

/// What the player showed and said.
#[derive(Clone, Debug, Default)]
pub struct Played {
    /// As it draws the scene, PNG.
    pub picture: Option<Vec<u8>>,
    pub adapter: String,
    /// Whether its passes were timed by the GPU; else these are the times to record them on the CPU.
    pub on_gpu: bool,
    pub passes: Vec<PassTime>,
    /// The error of B is at most this share of the largest B, as the last frame said.
    pub bound: Option<f64>,
    /// Solved, the scene as it is at the start.
    pub light: Option<GpuLight>,
    /// From darkness, one frame of so many products, by number of products.
    pub sweep: Vec<Swept>,
}

/// Milliseconds a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PassTime {
    pub name: String,
    pub median: f64,
    pub p99: f64,
}

/// Light as it lies on the GPU [W/m2].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GpuLight {
    /// E by patch: emitted, and reflected once from punctual lights.
    pub exitance: Vec<DVec3>,
    /// B by patch, then the sky patches' pi times radiance.
    pub radiosity: Vec<DVec3>,
    /// By receiver, without what comes straight from punctual lights.
    pub irradiance: Vec<DVec3>,
    /// Nine a probe [W/m2/sr]; empty where nothing reads probes.
    pub probes: Vec<DVec3>,
}

/// So many products in one frame, from darkness.
#[derive(Clone, Debug, Default)]
pub struct Swept {
    pub products: u32,
    /// Of the bounce in a frame of so many products: median, least and largest of `frames` [ms].
    pub milliseconds: f64,
    pub range: [f64; 2],
    pub frames: usize,
    pub light: GpuLight,
}

/// What the player said, or why it said nothing.
pub fn play(
    _project: &Path,
    _scene: &str,
    _budget: &Budget,
    _watcher: &dyn Watcher,
) -> Result<(Option<Played>, Vec<String>), BakeError> {
    Ok((None, Vec::new()))
}
