//! What a renderer says of itself: bound, bytes, what it leaves out; and its light, for tests and reports.

use std::sync::Arc;

use super::frame::Renderer;
use super::spaces::Spaces;
use super::targets::Targets;
use crate::gpu::Gpu;
use crate::transport::Transport;

impl Renderer {
    /// The error of B is at most this share of the largest B.
    pub fn bound(&self) -> Option<f32> {
        Some(self.bounce.measured?.bound(self.sources.known_gain()))
    }

    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    pub fn transport(&self) -> &Arc<Transport> {
        &self.transport
    }

    /// The light as it lies on the GPU.
    pub fn spaces(&self) -> &Spaces {
        &self.spaces
    }

    /// What the last frame was drawn into before the tonemap.
    pub fn targets(&self) -> Option<&Targets> {
        self.target.as_ref().map(|(targets, _)| targets)
    }

    /// Lights that a point has to add up, on average over the scene.
    pub fn mean_lights(&self) -> f32 {
        self.shadows.light_grid().mean_lights()
    }

    /// Pages of patch rows.
    pub fn pages(&self) -> usize {
        self.bounce.pages()
    }

    /// Bytes on the GPU by kind.
    pub fn bytes(&self) -> [(&'static str, u64); 8] {
        [
            ("rows", self.bounce.bytes() + self.gather.bytes()),
            ("light", self.spaces.bytes),
            ("coarse correction", self.coarse.bytes),
            ("surface", self.still.bytes),
            ("meshes", self.meshes.bytes()),
            ("pictures", self.pictures.bytes),
            ("shadow maps", self.shadows.bytes()),
            ("targets", self.targets().map_or(0, Targets::bytes)),
        ]
    }

    /// What is not done, and why.
    pub fn left_out(&self) -> Vec<String> {
        let mut left_out = Vec::new();
        left_out.extend(self.shadows.left_out());
        if self.transport.sky_patches == 0 {
            left_out.push("sky patches: no sky".to_owned());
        }
        if !self.instances.any_moving() {
            left_out.push("light probes: nothing moves".to_owned());
        }
        if self.coarse.bytes == 0 {
            left_out.push("coarse correction: few bounces count".to_owned());
        }
        left_out
    }
}
