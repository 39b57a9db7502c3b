//! The runtime: a project's scene, alive, in a window or frame by frame into files.

mod baked;
pub mod clock;
mod cubemaps;
mod fly;
mod headless;
mod light;
mod lose;
mod overlay;
mod show;
mod stage;
mod statistics;
mod window;
pub mod world;

use std::path::PathBuf;

use crate::gpu::GpuError;
use crate::render::{RenderError, View};
use crate::scene::SceneError;
use crate::transport::file::TransportError;
pub use world::World;

/// What the command line says.
#[derive(Clone, Debug)]
pub struct Options {
    pub project: PathBuf,
    /// `None`: the project's default scene.
    pub scene: Option<String>,
    /// No window: frames are drawn as fast as they come.
    pub headless: bool,
    /// Ends after so many. Headless: 1 where nothing is said.
    pub frames: Option<u64>,
    pub size: [u32; 2],
    /// Seconds from frame to frame, whatever the clock says; pictures then repeat.
    pub fixed_dt: Option<f64>,
    /// Headless: where pictures go. Window: where screenshots go.
    pub out: Option<PathBuf>,
    /// Headless: every so manieth frame is written, and the last.
    pub every: u64,
    pub stats: Option<PathBuf>,
    /// Where the light goes that the GPU solved, after the last frame.
    pub light: Option<PathBuf>,
    /// Of every frame, instead of what the bound asks for.
    pub products: Option<u32>,
    pub view: View,
    /// Instead of the camera's.
    pub exposure: Option<f32>,
    /// Pictures wait for the display.
    pub vsync: bool,
    /// Times and counts over the picture, from the start.
    pub overlay: bool,
    /// Plays a bake whose certificate does not hold.
    pub force: bool,
    /// Without all that moves.
    pub still: bool,
}

impl Options {
    pub fn new(project: impl Into<PathBuf>) -> Self {
        Self {
            project: project.into(),
            scene: None,
            headless: false,
            frames: None,
            size: [1280, 720],
            fixed_dt: None,
            out: None,
            every: 1,
            stats: None,
            light: None,
            products: None,
            view: View::Composite,
            exposure: None,
            vsync: true,
            overlay: false,
            force: false,
            still: false,
        }
    }
}

#[derive(Debug, thiserror::Error)]
pub enum PlayError {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Transport(#[from] TransportError),
    #[error(transparent)]
    Render(#[from] RenderError),
    #[error("{}: {message}", path.display())]
    Write { path: PathBuf, message: String },
    #[error("no window: {0}; `--headless` needs none")]
    Window(String),
}

impl From<GpuError> for PlayError {
    fn from(error: GpuError) -> Self {
        Self::Render(error.into())
    }
}

/// Plays until the window is closed or all frames are drawn. What stops nothing is said on stderr.
pub fn run(options: &Options) -> Result<(), PlayError> {
    let (mut world, warnings) = World::load(&options.project, options.scene.as_deref(), options.force)?;
    for warning in warnings {
        eprintln!("warning: {warning}");
    }
    if options.still {
        world.hold_still();
    }
    if options.headless { headless::run(options, world) } else { window::run(options, world) }
}
