//! The sky behind the scene.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use std::sync::Arc;

use super::pictures::Pictures;
use super::{shaders, surface, targets};
use crate::gpu::pass::{self, Binding};
use crate::gpu::pipeline::{Compiler, Pipelines, Variant};
use crate::gpu::texture::Encoding;
use crate::gpu::{Gpu, buffer};
use crate::scene::assets::{Assets, Picture};
use crate::scene::{ImageSource, SkyKind};
use crate::transport::direct::PlacedLight;

/// `Sky` in `sky.wgsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct SkyUniform {
    pub zenith: Vec3,
    pub kind: u32,
    pub horizon: Vec3,
    pub sun_radius: f32,
    pub ground: Vec3,
    pub turn: f32,
    pub sun: Vec3,
    pub strength: f32,
    pub sun_radiance: Vec3,
    pub padding: f32,
}

/// A pixel's.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Samples(u32);

impl Variant for Samples {
    fn name(&self) -> String {
        format!("sky, {} a pixel", self.0)
    }
}

pub struct SkyPass {
    pipelines: Pipelines<Samples, wgpu::RenderPipeline>,
    pipeline_layout: wgpu::PipelineLayout,
    layout: wgpu::BindGroupLayout,
    uniform: wgpu::Buffer,
    held: SkyUniform,
    /// Drawn though there is none.
    forced: bool,
    image: Option<ImageSource>,
    /// What is shown of it: a picture that comes later is bound anew.
    shown: Option<Arc<Picture>>,
    group: wgpu::BindGroup,
    sampler: wgpu::Sampler,
}

impl SkyPass {
    pub fn new(
        gpu: &Gpu,
        compiler: &Arc<Compiler>,
        frame_layout: &wgpu::BindGroupLayout,
        pictures: &Pictures,
        forced: bool,
    ) -> Self {
        let layout = pass::layout(
            gpu,
            "sky",
            wgpu::ShaderStages::FRAGMENT,
            &[Binding::Uniform, Binding::Picture, Binding::Sampler],
        );
        let uniform = buffer::filled(gpu, "sky", &[SkyUniform::default()], wgpu::BufferUsages::UNIFORM);
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            address_mode_u: wgpu::AddressMode::Repeat,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        Self {
            pipelines: Pipelines::new(compiler, shaders::SKY),
            pipeline_layout: pass::pipeline_layout(gpu, &[Some(frame_layout), None, None, Some(&layout)]),
            group: group(gpu, &layout, &uniform, &pictures.white(), &sampler),
            layout,
            uniform,
            held: SkyUniform::default(),
            forced,
            image: None,
            shown: None,
            sampler,
        }
    }

    /// Follows the scene's sky and the light that is its sun. Returns whether it looks otherwise now.
    pub fn update(
        &mut self,
        gpu: &Gpu,
        assets: &Assets,
        pictures: &mut Pictures,
        sky: &SkyKind,
        lights: &[PlacedLight],
    ) -> bool {
        let (now, image) = uniform(sky, lights);
        let shown = image.and_then(|image| assets.images.get(image));
        let repainted =
            image != self.image.as_ref() || shown.map(Arc::as_ptr) != self.shown.as_ref().map(Arc::as_ptr);
        let changed = now != self.held || repainted;
        if now != self.held {
            gpu.queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&now));
            self.held = now;
        }
        if repainted {
            (self.image, self.shown) = (image.cloned(), shown.cloned());
            let view = pictures.view(gpu, assets, image, Encoding::Srgb);
            self.group = group(gpu, &self.layout, &self.uniform, &view, &self.sampler);
        }
        changed
    }

    /// Returns the draws.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, frame: &wgpu::BindGroup, samples: u32) -> u32 {
        if self.held.kind == 0 && !self.forced {
            return 0;
        }
        let made = self
            .pipelines
            .get(Samples(samples), |gpu, module| pipeline(gpu, module, &self.pipeline_layout, samples));
        let Some(pipeline) = made else { return 0 };
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, frame, &[]);
        pass.set_bind_group(3, &self.group, &[]);
        pass.draw(0..3, 0..1);
        1
    }
}

fn group(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
    uniform: &wgpu::Buffer,
    view: &wgpu::TextureView,
    sampler: &wgpu::Sampler,
) -> wgpu::BindGroup {
    let resources = [
        uniform.as_entire_binding(),
        wgpu::BindingResource::TextureView(view),
        wgpu::BindingResource::Sampler(sampler),
    ];
    pass::group(gpu, "sky", layout, &resources)
}

fn uniform<'a>(sky: &'a SkyKind, lights: &[PlacedLight]) -> (SkyUniform, Option<&'a ImageSource>) {
    let mut uniform = SkyUniform { sun: Vec3::Y, ..Default::default() };
    let mut picture = None;
    match sky {
        SkyKind::None => {}
        SkyKind::Constant { radiance } => {
            uniform.kind = 1;
            uniform.zenith = *radiance;
            uniform.horizon = *radiance;
        }
        SkyKind::Gradient { zenith, horizon, ground, sun, sun_diameter } => {
            uniform.kind = 2;
            uniform.zenith = *zenith;
            uniform.horizon = *horizon;
            uniform.ground = *ground;
            let light = sun.and_then(|sun| lights.iter().find(|light| light.entity == sun));
            if let Some(light) = light.filter(|_| *sun_diameter > 0.0) {
                uniform.sun_radius = sun_diameter * 0.5;
                uniform.sun = -light.direction;
                // A disc of this radius and radiance gives the light's irradiance.
                let solid_angle = std::f32::consts::PI * uniform.sun_radius * uniform.sun_radius;
                uniform.sun_radiance = light.light.power() / solid_angle;
            }
        }
        SkyKind::Picture { image, strength, turn } => {
            uniform.kind = 3;
            uniform.strength = *strength;
            uniform.turn = *turn;
            picture = Some(image);
        }
    }
    (uniform, picture)
}

fn pipeline(
    gpu: &Gpu,
    module: &wgpu::ShaderModule,
    layout: &wgpu::PipelineLayout,
    samples: u32,
) -> wgpu::RenderPipeline {
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("sky"),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some("corner"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: Default::default(),
        depth_stencil: Some(surface::depth_state(false)),
        multisample: wgpu::MultisampleState { count: samples, ..Default::default() },
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some("behind"),
            compilation_options: Default::default(),
            targets: &[Some(targets::RADIANCE.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}
