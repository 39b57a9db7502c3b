//! Textures: pictures with their mipmaps, render targets, layers of depth, and pictures read back.

use super::{Gpu, GpuError, buffer};

/// What a picture's bytes are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Encoding {
    /// Colours as stored in files.
    Srgb,
    /// Data, or colours that are linear already.
    Linear,
}

/// Layers of an array texture that holds at least `wanted`. A count of 1, or one that six divides, is passed
/// over: wgpu's OpenGL takes textures of such a shape for something else than an array (a plain texture, a
/// cube map), and then binding them as an array fails.
pub fn array_layers(wanted: u32) -> u32 {
    let layers = wanted.max(2);
    if layers.is_multiple_of(6) { layers + 1 } else { layers }
}

/// A texture to draw into and to read.
pub fn target(
    gpu: &Gpu,
    label: &str,
    size: [u32; 2],
    samples: u32,
    format: wgpu::TextureFormat,
) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: extent(size, 1),
        mip_level_count: 1,
        sample_count: samples,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::TEXTURE_BINDING
            | if samples == 1 { wgpu::TextureUsages::COPY_SRC } else { wgpu::TextureUsages::empty() },
        view_formats: &[],
    })
}

/// A texture to draw into and nothing else.
pub fn samples(
    gpu: &Gpu,
    label: &str,
    size: [u32; 2],
    samples: u32,
    format: wgpu::TextureFormat,
) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: extent(size, 1),
        mip_level_count: 1,
        sample_count: samples,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    })
}

pub fn depth_layers(gpu: &Gpu, label: &str, size: u32, layers: u32) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: extent([size, size], array_layers(layers)),
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Depth32Float,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    })
}

/// Layers of depth to draw into and to copy.
pub fn copied_depth(gpu: &Gpu, label: &str, size: u32, layers: u32) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: extent([size, size], layers),
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Depth32Float,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::COPY_SRC
            | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    })
}

/// All layers, to be read.
pub fn as_layers(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..Default::default()
    })
}

/// One layer, to be drawn into.
pub fn layer(texture: &wgpu::Texture, layer: u32) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2),
        base_array_layer: layer,
        array_layer_count: Some(1),
        ..Default::default()
    })
}

/// Cubemaps with their smaller levels, to draw into and to read, of half floats. wgpu's OpenGL takes one cube for
/// something else than an array of cubes: to be bound as an array there have to be two.
pub fn cubes(gpu: &Gpu, label: &str, size: u32, cubes: u32, levels: u32) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: extent([size, size], cubes * 6),
        mip_level_count: levels,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba16Float,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_SRC
            | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    })
}

/// The whole of a cubemap, or of an array of them, to be read.
pub fn as_cubes(texture: &wgpu::Texture, dimension: wgpu::TextureViewDimension) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor { dimension: Some(dimension), ..Default::default() })
}

/// One level of a cubemap, to be read.
pub fn cube_level(texture: &wgpu::Texture, level: u32) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::Cube),
        base_mip_level: level,
        mip_level_count: Some(1),
        ..Default::default()
    })
}

/// One level of one layer, to be drawn into.
pub fn layer_level(texture: &wgpu::Texture, layer: u32, level: u32) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2),
        base_mip_level: level,
        mip_level_count: Some(1),
        base_array_layer: layer,
        array_layer_count: Some(1),
        ..Default::default()
    })
}

/// A picture without its smaller levels yet: 8 bits RGBA rows from the top.
pub fn rgba8(
    gpu: &Gpu,
    label: &str,
    size: [u32; 2],
    pixels: &[[u8; 4]],
    encoding: Encoding,
) -> wgpu::Texture {
    let format = match encoding {
        Encoding::Srgb => wgpu::TextureFormat::Rgba8UnormSrgb,
        Encoding::Linear => wgpu::TextureFormat::Rgba8Unorm,
    };
    picture(gpu, label, size, bytemuck::cast_slice(pixels), 4, format)
}

/// The same of half floats.
pub fn rgba16(gpu: &Gpu, label: &str, size: [u32; 2], pixels: &[[u16; 4]]) -> wgpu::Texture {
    picture(gpu, label, size, bytemuck::cast_slice(pixels), 8, wgpu::TextureFormat::Rgba16Float)
}

fn picture(
    gpu: &Gpu,
    label: &str,
    size: [u32; 2],
    bytes: &[u8],
    texel: u32,
    format: wgpu::TextureFormat,
) -> wgpu::Texture {
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: extent(size, 1),
        mip_level_count: size[0].max(size[1]).max(1).ilog2() + 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_DST
            | wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(size[0] * texel), rows_per_image: None };
    gpu.queue.write_texture(texture.as_image_copy(), bytes, layout, extent(size, 1));
    texture
}

fn extent(size: [u32; 2], layers: u32) -> wgpu::Extent3d {
    wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: layers }
}

/// Rows from the top, `texel` bytes a texel, without the padding that copies need. Blocks.
pub fn read(gpu: &Gpu, texture: &wgpu::Texture, texel: u32) -> Result<Vec<u8>, GpuError> {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let copied = Copied::of(gpu, &mut encoder, texture, texel);
    gpu.queue.submit([encoder.finish()]);
    let rows = copied.sent();
    gpu.wait()?;
    rows.take(gpu).unwrap_or_else(|| Err(buffer::not_there()))
}

/// A texture in a staging buffer, once its commands have run.
pub struct Copied {
    staging: wgpu::Buffer,
    /// Bytes of a row, and with the padding that copies need.
    row: u32,
    padded: u32,
}

/// A texture on its way to the processor.
pub struct Rows {
    arriving: buffer::Arriving,
    row: u32,
    padded: u32,
}

impl Copied {
    /// At this point of the commands; `texel` bytes a texel.
    pub fn of(gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, texture: &wgpu::Texture, texel: u32) -> Self {
        let (width, height) = (texture.width(), texture.height());
        let row = width * texel;
        let padded = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let staging = buffer::staging(gpu, u64::from(padded) * u64::from(height));
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(padded), rows_per_image: None };
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo { buffer: &staging, layout },
            extent([width, height], 1),
        );
        Self { staging, row, padded }
    }

    /// After the submit.
    pub fn sent(self) -> Rows {
        Rows { arriving: buffer::Arriving::new(self.staging), row: self.row, padded: self.padded }
    }
}

impl Rows {
    /// Rows from the top, without padding. `None`: the GPU has not come so far. Waits for nothing; they come once.
    pub fn take(&self, gpu: &Gpu) -> Option<Result<Vec<u8>, GpuError>> {
        let bytes = self.arriving.take::<u8>(gpu)?;
        let unpadded = |bytes: Vec<u8>| {
            let lines = bytes.chunks_exact(self.padded as usize);
            lines.flat_map(|line| &line[..self.row as usize]).copied().collect()
        };
        Some(bytes.map(unpadded))
    }
}

/// The nearest half float (IEEE 754 binary16), ties to even; what is larger becomes the largest.
pub fn half(value: f32) -> u16 {
    let sign = ((value.to_bits() >> 16) & 0x8000) as u16;
    let size = value.abs();
    if size.is_nan() {
        return 0;
    }
    if size >= 65504.0 {
        return sign | 0x7bff;
    }
    if size < 6.103_515_6e-5 {
        // Subnormal: a multiple of 2^-24.
        return sign | (size * 16_777_216.0).round_ties_even() as u16;
    }
    let bits = size.to_bits();
    let rounded = bits + 0xfff + ((bits >> 13) & 1);
    sign | (((rounded >> 13) - (112 << 10)) as u16).min(0x7bff)
}

/// The value of a half float.
pub fn single(half: u16) -> f32 {
    let sign = if half & 0x8000 == 0 { 1.0 } else { -1.0 };
    let (exponent, fraction) = (i32::from(half >> 10 & 31), f32::from(half & 1023));
    match exponent {
        0 => sign * fraction / 16_777_216.0,
        31 => sign * if fraction == 0.0 { f32::INFINITY } else { f32::NAN },
        _ => sign * (1.0 + fraction / 1024.0) * 2f32.powi(exponent - 15),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_floats_go_there_and_back() {
        for bits in (0..0x7c00).chain(0x8000..0xfc00) {
            assert_eq!(half(single(bits)), bits, "{bits:#x}");
        }
        assert_eq!(half(1e9), 0x7bff);
        assert_eq!(half(f32::NAN), 0);
        assert_eq!(single(half(1.0 / 3.0)), 0.333_251_95);
    }

    #[test]
    fn layers_are_never_taken_for_a_cube() {
        assert_eq!([1, 2, 6, 7, 12].map(array_layers), [2, 2, 7, 7, 13]);
    }
}
