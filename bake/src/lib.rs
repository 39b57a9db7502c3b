//! The bake: from a scene to its light transport. A library that needs no GPU; `hohlraum-bake` is its
//! command line.

mod bvh;
mod chart;
mod cut;
mod directions;
mod split;
mod surface;

use std::path::Path;

use engine::scene::file::Quality;
use engine::scene::{SceneError, Warning};
use engine::transport::file::TransportError;
use engine::transport::{Certificate, Transport};
use glam::{DVec3, Vec3};

/// What the command line says; where it says nothing, the project's settings hold.
#[derive(Clone, Debug, Default)]
pub struct Settings {
    pub quality: Option<Quality>,
    /// Rays a row.
    pub rays: Option<u32>,
    /// Metres.
    pub patch_length: Option<f64>,
    /// `None`: as many as the machine has.
    pub threads: Option<usize>,
    /// Bake everything anew, whatever is there.
    pub force: bool,
}

/// Follows a bake, from any thread.
pub trait Watcher: Sync {
    /// A new stage begins, of `steps` steps.
    fn stage(&self, _name: &str, _steps: u64) {}
    /// Some steps of the stage are done, with this many rays.
    fn advance(&self, _steps: u64, _rays: u64) {}
    /// Asked often: a bake that is told to stop does so within a second, and keeps what is reusable.
    fn cancelled(&self) -> bool {
        false
    }
}

/// Watches nothing.
pub struct Silent;

impl Watcher for Silent {}

/// What a bake gives.
pub struct Baked {
    pub transport: Transport,
    /// Where it was written.
    pub file: std::path::PathBuf,
    pub warnings: Vec<Warning>,
    /// Nothing had changed: the file on disk was current and no ray was traced.
    pub unchanged: bool,
}

#[derive(Debug, thiserror::Error)]
pub enum BakeError {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Transport(#[from] TransportError),
    #[error("cancelled; what was traced so far is kept and the next bake goes on from there")]
    Cancelled,
    #[error(
        "scene `{scene}` has no bake at quality {quality}: run `hohlraum-bake {project} --scene {scene}`"
    )]
    Missing { project: String, scene: String, quality: String },
    #[error("the bake of scene `{scene}` is stale ({why}): run `hohlraum-bake {project} --scene {scene}`")]
    Stale { project: String, scene: String, why: String },
    #[error("{0}")]
    Other(String),
}

/// What would be baked, without baking it.
#[derive(Clone, Debug, Default, serde::Serialize)]
pub struct Plan {
    pub scene: String,
    pub quality: String,
    /// Metres.
    pub patch_length: f64,
    pub patches: usize,
    pub receivers: usize,
    pub probes: usize,
    pub sky_patches: usize,
    pub triangles: usize,
    pub rays: u64,
    /// Of those, how many are on disk already.
    pub rays_kept: u64,
    /// Estimated by tracing a few thousand rays.
    pub seconds: f64,
    pub bytes: u64,
    pub left_out: Vec<String>,
    pub warnings: Vec<String>,
}

/// A point on a surface, with its normal.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    pub position: DVec3,
    pub normal: DVec3,
}

/// Irradiance at a point [W/m2].
#[derive(Clone, Copy, Debug, Default)]
pub struct Irradiance {
    /// Seen unblocked from emitters, sky and punctual lights.
    pub direct: DVec3,
    pub indirect: DVec3,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// What the runtime shows there.
    #[default]
    Receivers,
    /// A fresh final gather from the solved radiosity.
    Gather,
}

/// Bakes a scene of a project (`None`: its default scene) and writes `baked/NAME/`.
pub fn bake(
    _project: &Path,
    _scene: Option<&str>,
    _settings: &Settings,
    _watcher: &dyn Watcher,
) -> Result<Baked, BakeError> {
    todo!()
}

/// What [`bake`] would do.
pub fn plan(_project: &Path, _scene: Option<&str>, _settings: &Settings) -> Result<Plan, BakeError> {
    todo!()
}

/// The certificate of the bake on disk, every statement computed again from the stored arrays.
pub fn check(_project: &Path, _scene: Option<&str>, _settings: &Settings) -> Result<Certificate, BakeError> {
    todo!()
}

/// Irradiance at points, in their order. A point too far from any front face is an error that names its
/// place in the list (from 1).
pub fn query_points(
    _project: &Path,
    _scene: Option<&str>,
    _settings: &Settings,
    _points: &[Point],
    _method: Method,
) -> Result<Vec<Irradiance>, BakeError> {
    todo!()
}

/// SH coefficients of incoming radiance at points, in their order, fresh rows from the solved radiosity.
pub fn query_probes(
    _project: &Path,
    _scene: Option<&str>,
    _settings: &Settings,
    _points: &[DVec3],
) -> Result<Vec<[Vec3; 9]>, BakeError> {
    todo!()
}
