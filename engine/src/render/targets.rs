//! What a frame is drawn into before the tonemap: radiance and depth.

use crate::gpu::{Gpu, texture};

pub const RADIANCE: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

pub struct Targets {
    pub size: [u32; 2],
    pub samples: u32,
    /// What the tonemap reads: one sample a pixel, or all of them.
    pub radiance: wgpu::Texture,
    pub radiance_view: wgpu::TextureView,
    /// All samples, where the tonemap reads their mean.
    drawn: Option<wgpu::TextureView>,
    depth_view: wgpu::TextureView,
}

impl Targets {
    pub fn new(gpu: &Gpu, size: [u32; 2], samples: u32) -> Self {
        let resolved = samples > 1 && !reads_samples(gpu);
        let radiance = texture::target(gpu, "radiance", size, if resolved { 1 } else { samples }, RADIANCE);
        let drawn = resolved.then(|| texture::samples(gpu, "radiance", size, samples, RADIANCE));
        let depth = texture::samples(gpu, "depth", size, samples, wgpu::TextureFormat::Depth32Float);
        Self {
            size,
            samples,
            radiance_view: radiance.create_view(&Default::default()),
            drawn: drawn.map(|drawn| drawn.create_view(&Default::default())),
            depth_view: depth.create_view(&Default::default()),
            radiance,
        }
    }

    /// Samples of a pixel that the tonemap reads.
    pub fn samples_read(&self) -> u32 {
        self.radiance.sample_count()
    }

    pub fn bytes(&self) -> u64 {
        let resolved = if self.drawn.is_some() { 8 } else { 0 };
        u64::from(self.size[0]) * u64::from(self.size[1]) * (u64::from(self.samples) * 12 + resolved)
    }

    /// Clears both.
    pub fn begin<'a>(
        &self,
        encoder: &'a mut wgpu::CommandEncoder,
        timestamp_writes: Option<wgpu::RenderPassTimestampWrites<'_>>,
    ) -> wgpu::RenderPass<'a> {
        let store = wgpu::StoreOp::Store;
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("surface"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: self.drawn.as_ref().unwrap_or(&self.radiance_view),
                depth_slice: None,
                resolve_target: self.drawn.is_some().then_some(&self.radiance_view),
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth_view,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store }),
                stencil_ops: None,
            }),
            timestamp_writes,
            ..Default::default()
        })
    }
}

/// 4 where the adapter draws and reads radiance with 4 samples a pixel, else 1.
pub fn most_samples(gpu: &Gpu) -> u32 {
    let can = |format| gpu.adapter.get_texture_format_features(format).flags.sample_count_supported(4);
    if can(RADIANCE) && can(wgpu::TextureFormat::Depth32Float) { 4 } else { 1 }
}

/// wgpu's OpenGL makes textures of many samples that no shader can read.
fn reads_samples(gpu: &Gpu) -> bool {
    gpu.info.backend != wgpu::Backend::Gl
}
