//! Pictures on the GPU, with all their smaller levels, and the ways to sample them.

use std::collections::HashMap;
use std::sync::Arc;

use super::shaders;
use super::uploads::Uploads;
use crate::gpu::Gpu;
use crate::gpu::pass::{self, Binding};
use crate::gpu::pipeline::{Compiler, Pipelines, Variant};
use crate::gpu::texture::{self, Encoding};
use crate::scene::assets::{Assets, Picture, Pixels};
use crate::scene::material::Wrap;
use crate::scene::{ImageSource, Texture};

/// How a texture is sampled, apart from its picture.
type Sampling = (Wrap, Wrap, bool, bool);

pub struct Pictures {
    known: HashMap<(ImageSource, Encoding), Known>,
    samplers: HashMap<Sampling, wgpu::Sampler>,
    white: wgpu::TextureView,
    shrink: Shrink,
    pub bytes: u64,
    /// Asked by those that have time.
    pub uploads: Uploads,
}

struct Known {
    view: wgpu::TextureView,
    source: Arc<Picture>,
}

impl Pictures {
    pub fn new(gpu: &Gpu, compiler: &Arc<Compiler>) -> Self {
        let white = texture::rgba8(gpu, "white", [1, 1], &[[255; 4]], Encoding::Linear);
        Self {
            known: HashMap::new(),
            samplers: HashMap::new(),
            white: white.create_view(&Default::default()),
            shrink: Shrink::new(gpu, compiler),
            bytes: 0,
            uploads: Uploads::default(),
        }
    }

    /// All ones: in place of a picture that is not there.
    pub fn white(&self) -> wgpu::TextureView {
        self.white.clone()
    }

    /// The picture of a texture; white where there is none or the assets do not have it.
    pub fn view(
        &mut self,
        gpu: &Gpu,
        assets: &Assets,
        image: Option<&ImageSource>,
        encoding: Encoding,
    ) -> wgpu::TextureView {
        let Some((image, picture)) = image.and_then(|image| Some((image, assets.images.get(image)?))) else {
            return self.white.clone();
        };
        let key = (image.clone(), encoding);
        if let Some(known) = self.known.get(&key).filter(|known| Arc::ptr_eq(&known.source, picture)) {
            return known.view.clone();
        }
        let Some(texture) = upload(gpu, picture, encoding) else { return self.white.clone() };
        self.shrink.all_levels(gpu, &texture);
        self.bytes += u64::from(texture.width()) * u64::from(texture.height()) * 16 / 3;
        let view = texture.create_view(&Default::default());
        self.known.insert(key, Known { view: view.clone(), source: picture.clone() });
        view
    }

    /// All pictures go.
    pub fn forget(&mut self) {
        self.known.clear();
        self.bytes = 0;
    }

    /// Whether these can be shown in this frame: what is not on the GPU yet may have to wait.
    pub fn has_time(
        &mut self,
        assets: &Assets,
        images: impl Iterator<Item = (ImageSource, Encoding)>,
    ) -> bool {
        let is_new = |image: &ImageSource, encoding: Encoding, picture: &Arc<Picture>| {
            let known = self.known.get(&(image.clone(), encoding));
            !known.is_some_and(|known| Arc::ptr_eq(&known.source, picture))
        };
        let bytes = images.filter_map(|(image, encoding)| {
            let picture = assets.images.get(&image).filter(|picture| is_new(&image, encoding, picture))?;
            Some(u64::from(picture.width) * u64::from(picture.height) * 16 / 3)
        });
        let bytes: u64 = bytes.sum();
        bytes == 0 || self.uploads.take(bytes)
    }

    pub fn sampler(&mut self, gpu: &Gpu, texture: Option<&Texture>) -> wgpu::Sampler {
        let sampling = texture.map_or((Wrap::Repeat, Wrap::Repeat, false, true), |texture| {
            (texture.wrap_u, texture.wrap_v, texture.nearest, texture.mipmaps)
        });
        self.samplers.entry(sampling).or_insert_with(|| sampler(gpu, sampling)).clone()
    }
}

fn sampler(gpu: &Gpu, (u, v, nearest, mipmaps): Sampling) -> wgpu::Sampler {
    let address = |wrap| match wrap {
        Wrap::Repeat => wgpu::AddressMode::Repeat,
        Wrap::Mirror => wgpu::AddressMode::MirrorRepeat,
        Wrap::Clamp => wgpu::AddressMode::ClampToEdge,
    };
    let filter = if nearest { wgpu::FilterMode::Nearest } else { wgpu::FilterMode::Linear };
    gpu.device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("picture"),
        address_mode_u: address(u),
        address_mode_v: address(v),
        mag_filter: filter,
        min_filter: filter,
        mipmap_filter: if nearest { wgpu::MipmapFilterMode::Nearest } else { wgpu::MipmapFilterMode::Linear },
        lod_max_clamp: if mipmaps { 32.0 } else { 0.0 },
        // A processor that draws pays for every tap.
        anisotropy_clamp: if nearest || !mipmaps || gpu.software { 1 } else { 8 },
        ..Default::default()
    })
}

fn upload(gpu: &Gpu, picture: &Picture, encoding: Encoding) -> Option<wgpu::Texture> {
    let size = [picture.width, picture.height];
    let most = gpu.device.limits().max_texture_dimension_2d;
    if size.contains(&0) || size.iter().any(|&side| side > most) {
        return None;
    }
    Some(match &picture.pixels {
        Pixels::Rgba8(pixels) => texture::rgba8(gpu, "picture", size, pixels, encoding),
        Pixels::Rgb32f(pixels) => {
            let halves: Vec<[u16; 4]> =
                pixels.iter().map(|[r, g, b]| [*r, *g, *b, 1.0].map(texture::half)).collect();
            texture::rgba16(gpu, "picture", size, &halves)
        }
    })
}

/// What is drawn into.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Target(wgpu::TextureFormat);

impl Variant for Target {
    fn name(&self) -> String {
        "mipmap".to_owned()
    }
}

/// Draws each level from the one above it.
struct Shrink {
    layout: wgpu::BindGroupLayout,
    sampler: wgpu::Sampler,
    pipelines: Pipelines<Target, wgpu::RenderPipeline>,
}

impl Shrink {
    fn new(gpu: &Gpu, compiler: &Arc<Compiler>) -> Self {
        Self {
            layout: pass::layout(
                gpu,
                "mipmap",
                wgpu::ShaderStages::FRAGMENT,
                &[Binding::Picture, Binding::Sampler],
            ),
            sampler: gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                ..Default::default()
            }),
            pipelines: Pipelines::new(compiler, shaders::MIPMAP),
        }
    }

    fn all_levels(&self, gpu: &Gpu, texture: &wgpu::Texture) {
        let format = texture.format();
        let made = self.pipelines.get(Target(format), |gpu, module| {
            let layout = pass::pipeline_layout(gpu, &[None, None, None, Some(&self.layout)]);
            pass::over_picture(gpu, module, "smaller", &layout, format)
        });
        let Some(pipeline) = made else { return };
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        for level in 1..texture.mip_level_count() {
            let view = |level| {
                texture.create_view(&wgpu::TextureViewDescriptor {
                    base_mip_level: level,
                    mip_level_count: Some(1),
                    ..Default::default()
                })
            };
            let resources = [
                wgpu::BindingResource::TextureView(&view(level - 1)),
                wgpu::BindingResource::Sampler(&self.sampler),
            ];
            let group = pass::group(gpu, "mipmap", &self.layout, &resources);
            let target = view(level);
            let mut draw = pass::draw_into(&mut encoder, "mipmap", &target, None);
            draw.set_pipeline(&pipeline);
            draw.set_bind_group(3, &group, &[]);
            draw.draw(0..3, 0..1);
        }
        gpu.queue.submit([encoder.finish()]);
    }
}
