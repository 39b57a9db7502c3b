//! Channels of light on the GPU: three in four floats, or the one that all of them would be where nothing that light comes
//! from or meets has a colour ([`crate::scene::Feature::Colour`]).
//!
//! The author's promise that this stays so is weighed once, by the feature's rule. Whether it holds is seen in every frame
//! by what patches hold, what the sky sends and what lights shine with. Where it does not, all light is given other
//! buffers and is solved anew.

use glam::{Vec3, Vec4};

use super::RenderError;
use super::frame::Renderer;
use super::spaces::Spaces;
use crate::gpu::pipeline::Defines;
use crate::gpu::{Gpu, GpuError, buffer};
use crate::transport::direct::PlacedLight;

/// Shares of red, green and blue in how bright light seems (ITU-R BT.709).
const LUMINANCE: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);

/// `Stored` in `transport/channels.wgsl`, without GREY and with it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Channels {
    #[default]
    Three,
    One,
}

impl Channels {
    /// Bytes of what is stored of a vector.
    pub const fn stride(self) -> u64 {
        match self {
            Self::Three => size_of::<Vec4>() as u64,
            Self::One => size_of::<f32>() as u64,
        }
    }

    /// What is defined in shaders that read or write light.
    pub const fn defines(self) -> Defines {
        match self {
            Self::Three => &[],
            Self::One => &["GREY"],
        }
    }

    /// As it is stored.
    pub fn bytes_of(self, light: impl Iterator<Item = Vec3>) -> Vec<u8> {
        match self {
            Self::Three => {
                bytemuck::cast_slice(&light.map(|l| l.extend(0.0)).collect::<Vec<Vec4>>()).to_vec()
            }
            Self::One => bytemuck::cast_slice(&light.map(in_one).collect::<Vec<f32>>()).to_vec(),
        }
    }

    /// What a buffer holds, once the GPU is done. Blocks.
    pub fn read(self, gpu: &Gpu, buffer: &wgpu::Buffer) -> Result<Vec<Vec3>, GpuError> {
        Ok(match self {
            Self::Three => buffer::read(gpu, buffer)?.into_iter().map(Vec4::truncate).collect(),
            Self::One => buffer::read(gpu, buffer)?.into_iter().map(Vec3::splat).collect(),
        })
    }
}

/// The channel that all three are; where they are not alike, and the author does without colour, their luminance.
fn in_one(light: Vec3) -> f32 {
    if is_grey(&light) { light.x } else { light.dot(LUMINANCE) }
}

pub fn is_grey(light: &Vec3) -> bool {
    light.x == light.y && light.y == light.z
}

impl Renderer {
    /// As many channels as the light of the scene needs now. Returns whether that are others than before: then all light
    /// is gone.
    pub(super) fn follow_colour(&mut self, lights: &[PlacedLight]) -> Result<bool, RenderError> {
        let is_coloured = || match &self.transport.solved {
            Some(solved) => !self.responses.is_grey(solved),
            None => self.sources.is_coloured() || !lights.iter().all(|placed| is_grey(&placed.light.color)),
        };
        let channels = self.asked.channels(is_coloured);
        if channels == self.spaces.channels {
            return Ok(false);
        }
        let gpu = &*self.gpu;
        let with_probes = self.spaces.has_probes();
        self.spaces = Spaces::new(gpu, &self.transport, channels)?;
        self.spaces.hold_probes(gpu, with_probes);
        self.direct.bind(gpu, &self.spaces);
        self.bounce.bind(gpu, &self.spaces);
        self.coarse.bind(gpu, &self.spaces);
        self.gather.bind(gpu, &self.spaces);
        self.rescale.bind(gpu, &self.spaces);
        self.dering.bind(gpu, &self.spaces);
        self.objects.bind(gpu, &self.spaces);
        self.surfaces.unbind();
        self.responses.forget();
        self.probes_current = false;
        Ok(true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_grey_is_stored_as_it_is_and_what_is_not_by_its_luminance() {
        let grey = Vec3::splat(0.999_999);
        let stored = Channels::One.bytes_of([grey, Vec3::Y].into_iter());
        assert_eq!(bytemuck::pod_collect_to_vec::<u8, f32>(&stored), [0.999_999, 0.7152]);
        let three = Channels::Three.bytes_of([grey].into_iter());
        assert_eq!(three.len() as u64, Channels::Three.stride());
    }
}
