//! What can go wrong on the way to the GPU, each with its remedy.

#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    #[error(
        "no GPU adapter found: install a Vulkan or OpenGL driver, on Debian or Ubuntu \
         `apt install mesa-vulkan-drivers` or `libegl1 libgl1-mesa-dri`"
    )]
    NoAdapter,
    #[error("the GPU adapter {adapter} lacks {what}: choose another by WGPU_BACKEND=vulkan or gl")]
    Lacks { adapter: String, what: &'static str },
    #[error("the GPU adapter {adapter} gives no device: {message}")]
    NoDevice { adapter: String, message: String },
    #[error("shader {name}: {message}")]
    Shader { name: &'static str, message: String },
    #[error("{what}: {bytes} bytes in one piece, the GPU allows {limit}; bake at a lower quality")]
    TooLarge { what: String, bytes: u64, limit: u64 },
    #[error("the GPU reports: {0}")]
    Reported(String),
    #[error("the GPU device was lost: {0}")]
    Lost(String),
}
