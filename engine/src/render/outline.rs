//! What an editor draws over a picture: lines in the world, and an outline around what is selected, seen through
//! whatever stands before it. The outline is made of a mask of the selected surfaces.

use std::collections::HashSet;
use std::sync::Arc;

use super::frame::Renderer;
use super::lines::Line;
use super::picking::{MASK, Numbered};
use super::shaders;
use crate::gpu::pass::{self, Binding};
use crate::gpu::pipeline::{Compiler, Pipelines, Variant};
use crate::gpu::{Gpu, texture};
use crate::scene::EntityId;

/// What is drawn over the scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Marks {
    /// Relative to the transport's origin.
    pub lines: Vec<Line>,
    pub outlined: HashSet<EntityId>,
    /// Edges of all meshes.
    pub wireframe: bool,
    /// What the bake has elsewhere or in another shape: drawn where it is now, in the light of probes.
    pub displaced: HashSet<EntityId>,
}

/// Into pictures of this format.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Display(wgpu::TextureFormat);

impl Variant for Display {
    fn name(&self) -> String {
        "outline".to_owned()
    }
}

pub struct Outline {
    layout: wgpu::PipelineLayout,
    mask_layout: wgpu::BindGroupLayout,
    pipelines: Pipelines<Display, wgpu::RenderPipeline>,
    pub(super) mask: Option<(wgpu::Texture, wgpu::BindGroup)>,
    outlined: HashSet<EntityId>,
}

impl Outline {
    pub fn new(gpu: &Gpu, compiler: &Arc<Compiler>, frame_layout: &wgpu::BindGroupLayout) -> Self {
        let mask_layout = pass::layout(gpu, "mask", wgpu::ShaderStages::FRAGMENT, &[Binding::Texels]);
        Self {
            layout: pass::pipeline_layout(gpu, &[Some(frame_layout), None, None, Some(&mask_layout)]),
            mask_layout,
            pipelines: Pipelines::new(compiler, shaders::OUTLINE),
            mask: None,
            outlined: HashSet::new(),
        }
    }

    fn fit(&mut self, gpu: &Gpu, size: [u32; 2]) {
        let fits = |mask: &wgpu::Texture| [mask.width(), mask.height()] == size;
        if self.mask.as_ref().is_some_and(|(mask, _)| fits(mask)) {
            return;
        }
        let mask = texture::target(gpu, "mask", size, 1, MASK);
        let view = mask.create_view(&Default::default());
        let group = pass::group(gpu, "mask", &self.mask_layout, &[wgpu::BindingResource::TextureView(&view)]);
        self.mask = Some((mask, group));
    }
}

impl Renderer {
    /// What is drawn over the pictures from now on.
    pub fn mark(&mut self, marks: &Marks) {
        let gpu = &*self.gpu.clone();
        self.guides.set(gpu, &marks.lines);
        self.wireframe.shown = marks.wireframe;
        self.outline.outlined.clone_from(&marks.outlined);
        self.instances.displaced.clone_from(&marks.displaced);
    }

    /// Returns the draws.
    pub(super) fn draw_outline(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        scene: &crate::scene::Scene,
        display: &wgpu::Texture,
    ) -> u32 {
        if self.outline.outlined.is_empty() {
            return 0;
        }
        self.picking.number(gpu, &self.instances.draws);
        self.outline.fit(gpu, [display.width(), display.height()]);
        let Outline { layout, pipelines, mask: Some((mask, group)), outlined, .. } = &self.outline else {
            return 0;
        };
        let is_outlined =
            |entity: usize| scene.entities.get(entity).is_some_and(|entity| outlined.contains(&entity.id));
        let view = mask.create_view(&Default::default());
        let mut pass = pass::draw_into(encoder, "mask", &view, self.timer.render("outline"));
        pass.set_bind_group(0, &self.frame_group, &[]);
        let numbered = Numbered { instances: &self.instances, still: &self.still, meshes: &self.meshes };
        let draws =
            self.picking.draw(&mut pass, &numbered, true, |draw| draw.entity.is_some_and(is_outlined));
        drop(pass);

        let format = display.format();
        let made = pipelines.get(Display(format), |gpu, module| {
            let blend = Some(wgpu::BlendState::ALPHA_BLENDING);
            let over = wgpu::ColorTargetState { format, blend, write_mask: wgpu::ColorWrites::ALL };
            pass::over_picture(gpu, module, "outline", layout, over)
        });
        let Some(pipeline) = made else { return draws };
        let view = display.create_view(&Default::default());
        let mut pass = pass::draw_over(encoder, "outline", &view, None);
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &self.frame_group, &[]);
        pass.set_bind_group(3, group, &[]);
        pass.draw(0..3, 0..1);
        draws + 1
    }
}
