//! Hohlraum's engine.
//!
//! * [`scene`] is what an author placed: plain data, and how it is read and written.
//! * [`transport`] is how light moves between static surfaces: plain data that the baker writes, and
//!   the CPU solver that is the truth for the GPU.
//! * `gpu` is wgpu craft and knows neither scene nor light; `render` draws; `play` is the runtime loop.
//!   These three need the feature `gpu`.

pub mod scene;
pub mod transport;

#[cfg(feature = "gpu")]
pub mod gpu;
#[cfg(feature = "gpu")]
pub mod play;
#[cfg(feature = "gpu")]
pub mod render;
