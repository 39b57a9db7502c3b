//! A GPU device that is lost on purpose, to test what comes after: before the picture whose number
//! HOHLRAUM_LOSE_DEVICE names, or by a key.

use crate::gpu::Gpu;

const VARIABLE: &str = "HOHLRAUM_LOSE_DEVICE";

pub struct LoseDevice(Option<u64>);

impl LoseDevice {
    pub fn from_environment() -> Self {
        Self(std::env::var(VARIABLE).ok().and_then(|frame| frame.parse().ok()))
    }

    /// Called before each picture.
    pub fn at(&self, frame: u64, gpu: &Gpu) {
        if self.0 == Some(frame) {
            gpu.device.destroy();
        }
    }
}
