//! The cubemaps that surfaces read, in one array, with their harmonics; and the table of how much of them leaves a
//! surface.

use super::prefilter::{Faces, faces, levels};
use crate::gpu::{Gpu, buffer, texture};
use crate::transport::reflection::ggx;

/// Texels across the table of [`ggx::table`].
const TABLE: u32 = 64;
/// The array that surfaces read.
pub struct Cubes {
    pub texture: wgpu::Texture,
    pub view: wgpu::TextureView,
    /// By cubemap and level.
    pub faces: Vec<Vec<Faces>>,
    pub harmonics: wgpu::Buffer,
}

impl Cubes {
    pub fn new(gpu: &Gpu, size: u32, count: u32) -> Self {
        let texture = texture::cubes(gpu, "reflections", size, count, levels(size));
        Self {
            view: texture::as_cubes(&texture, wgpu::TextureViewDimension::CubeArray),
            faces: (0..count).map(|index| faces(&texture, index)).collect(),
            harmonics: buffer::empty(gpu, "harmonics", u64::from(count) * 144, wgpu::BufferUsages::STORAGE),
            texture,
        }
    }
}

/// Radiance of one unit of a cubemap: a power of two, so that half floats hold the brightest and the rest; 1 for
/// most scenes. The old one stays while it does.
pub fn unit_of(brightest: f32, old: f32) -> f32 {
    let fits = |unit: f32| (1e-3..=4096.0).contains(&(brightest / unit));
    if !(brightest > 0.0 && brightest.is_finite()) || fits(old) {
        return old;
    }
    if fits(1.0) { 1.0 } else { brightest.log2().round().clamp(-100.0, 100.0).exp2() }
}

pub fn split_sum(gpu: &Gpu) -> wgpu::TextureView {
    let texels: Vec<[u16; 4]> = ggx::table(TABLE)
        .into_iter()
        .map(|[scale, bias]| [scale, bias, 0.0, 1.0].map(texture::half))
        .collect();
    texture::rgba16(gpu, "split sum", [TABLE, TABLE], &texels)
        .create_view(&wgpu::TextureViewDescriptor { mip_level_count: Some(1), ..Default::default() })
}
