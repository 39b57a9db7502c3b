//! What a frame came to.

use crate::gpu::timing::Passes;

/// What a frame came to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drawn {
    /// Of direct light, bounce, gather and what makes moving objects' light of it.
    pub transport_dispatches: u32,
    pub products: u32,
    pub draws: u32,
    pub shadow_draws: u32,
    /// Faces of cubemaps.
    pub captures: u32,
    /// Meshes and materials that are not shown yet, as they are still on their way to the GPU.
    pub waiting: u32,
    /// All of them: of shadow maps, captures, the picture, light.
    pub passes: Passes,
    /// The error of B is at most this share of the largest B: measured last, which is before this frame's last
    /// product. `None`: nothing was measured yet.
    pub bound: Option<f32>,
}

impl Drawn {
    /// Whether another picture of the same scene would be the same: light has settled, nothing is being captured.
    pub fn is_settled(&self) -> bool {
        self.products == 0 && self.captures == 0 && self.transport_dispatches == 0 && self.waiting == 0
    }
}
