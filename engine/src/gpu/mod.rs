//! The craft of wgpu: devices, buffers, textures, shaders, passes, timing. Nothing here knows a scene or light.

pub mod buffer;
pub mod device;
pub mod error;
pub mod pass;
pub mod pipeline;
pub mod shader;
pub mod texture;
pub mod timing;

pub use device::{Gpu, backends};
pub use error::GpuError;
