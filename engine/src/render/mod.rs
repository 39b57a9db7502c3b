//! The frame on the GPU: one file a pass, named as its shader; [`frame`] tells them in order.
//!
//! Long-lived pipelines and buffers lie in [`Renderer`]; what a frame shows is handed in as [`Now`], the scene as
//! it is at this moment. Nothing is remembered of a scene beyond what is needed to see that something changed.
//!
//! Bind groups of all shaders: 0 view and time, 1 scene, 2 transport, 3 the pass's own.

mod account;
pub mod asked;
pub mod bounce;
mod captures;
pub mod cascades;
pub mod casters;
pub mod channels;
pub mod coarse;
pub mod dering;
pub mod direct;
mod drawn;
pub mod exposure;
pub mod frame;
pub mod gather;
pub mod instances;
pub mod light_grid;
pub mod lights;
pub mod lines;
pub mod materials;
pub mod meshes;
pub mod objects;
pub mod outline;
pub mod overlay;
mod paint;
pub mod patches;
pub mod picking;
pub mod pictures;
pub mod probes;
mod radiosity;
pub mod rays;
pub mod reflections;
mod responses;
pub mod rows;
pub mod shaders;
pub mod shadow;
pub mod shadow_maps;
mod shadow_view;
pub mod sky;
pub mod sources;
pub mod spaces;

pub mod surface;
pub mod targets;
pub mod tonemap;
mod turns;
pub mod unit;
pub mod uploads;
pub mod view;
pub mod wireframe;

use crate::gpu::GpuError;
pub use crate::transport::steering;
pub use account::Solved;
pub use asked::Asked;
pub use channels::Channels;
pub use direct::PatchShadows;
pub use drawn::Drawn;
pub use frame::{Now, Renderer, Settings};
pub use view::{Eye, View};

#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    #[error(transparent)]
    Gpu(#[from] GpuError),
    #[error("the bake makes no sense: {0}; delete it and bake again")]
    Transport(String),
}
