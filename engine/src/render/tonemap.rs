//! The end of the frame: from radiance to the display.

use std::collections::HashMap;

use super::shaders;
use super::targets::Targets;
use crate::gpu::pass::{self, Binding};
use crate::gpu::shader::Library;
use crate::gpu::timing::Timer;
use crate::gpu::{Gpu, GpuError};

pub struct Tonemap {
    module: wgpu::ShaderModule,
    /// For one sample a pixel, and for more.
    layouts: [wgpu::BindGroupLayout; 2],
    pipeline_layouts: [wgpu::PipelineLayout; 2],
    /// By the target's format and whether there are more samples.
    pipelines: HashMap<(wgpu::TextureFormat, bool), wgpu::RenderPipeline>,
}

impl Tonemap {
    pub fn new(
        gpu: &Gpu,
        library: &mut Library,
        frame_layout: &wgpu::BindGroupLayout,
    ) -> Result<Self, GpuError> {
        let layouts = [Binding::Texels, Binding::MultisampledTexels]
            .map(|texels| pass::layout(gpu, "tonemap", wgpu::ShaderStages::FRAGMENT, &[texels]));
        let pipeline_layouts = layouts
            .each_ref()
            .map(|layout| pass::pipeline_layout(gpu, &[Some(frame_layout), None, None, Some(layout)]));
        Ok(Self {
            module: library.module(gpu, shaders::TONEMAP)?,
            layouts,
            pipeline_layouts,
            pipelines: HashMap::new(),
        })
    }

    /// What reads these targets.
    pub fn group(&self, gpu: &Gpu, targets: &Targets) -> wgpu::BindGroup {
        let resource = wgpu::BindingResource::TextureView(&targets.radiance_view);
        pass::group(gpu, "tonemap", &self.layouts[usize::from(targets.samples_read() > 1)], &[resource])
    }

    pub fn draw(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        timer: &mut Timer,
        frame: &wgpu::BindGroup,
        (targets, radiance): &(Targets, wgpu::BindGroup),
        display: &wgpu::Texture,
    ) {
        let many = targets.samples_read() > 1;
        let format = display.format();
        let pipeline = self.pipelines.entry((format, many)).or_insert_with(|| {
            let entry = if many { "tonemap_samples" } else { "tonemap" };
            pass::over_picture(gpu, &self.module, entry, &self.pipeline_layouts[usize::from(many)], format)
        });
        let view = display.create_view(&Default::default());
        let mut pass = pass::draw_into(encoder, "tonemap", &view, timer.render("tonemap"));
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, frame, &[]);
        pass.set_bind_group(3, radiance, &[]);
        pass.draw(0..3, 0..1);
    }
}
