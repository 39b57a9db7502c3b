//! Text over the picture, in its upper left corner: drawn on the CPU into a panel of few texels, uploaded when it
//! changes, and laid over the display after the tone curve.

use std::convert::Infallible;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use embedded_graphics::mono_font::MonoTextStyle;
use embedded_graphics::mono_font::iso_8859_1::FONT_9X18 as FONT;
use embedded_graphics::pixelcolor::BinaryColor;
use embedded_graphics::prelude::{DrawTarget, Drawable, OriginDimensions, Pixel, Point, Size};
use embedded_graphics::text::{Baseline, Text};

use super::shaders;
use crate::gpu::pass::{self, Binding};
use crate::gpu::pipeline::{Compiler, Pipelines, Variant};
use crate::gpu::timing::Timer;
use crate::gpu::{Gpu, buffer};

/// `Panel` in `overlay.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct PanelUniform {
    pub size: [u32; 2],
    pub scale: u32,
    pub encode: u32,
    pub display: [u32; 2],
    pub padding: [u32; 2],
}

/// Texels between the text and the panel's edge.
const MARGIN: u32 = 6;
/// The panel lets little enough of the picture through that text is read on white as well as on black: it is
/// five times as bright as a white picture under it.
const PANEL: [u8; 4] = [12, 12, 16, 224];
const TEXT: [u8; 4] = [240, 240, 235, 255];
/// Columns and lines; what goes beyond them is cut off.
const MOST: [usize; 2] = [220, 110];

/// What is drawn onto.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Onto(wgpu::TextureFormat);

impl Variant for Onto {
    fn name(&self) -> String {
        "overlay".to_owned()
    }
}

pub struct Overlay {
    layout: wgpu::BindGroupLayout,
    pipelines: Pipelines<Onto, wgpu::RenderPipeline>,
    uniform: wgpu::Buffer,
    lines: Vec<String>,
    scale: u32,
    /// The lines that were drawn and uploaded last.
    uploaded: Option<Uploaded>,
}

struct Uploaded {
    lines: Vec<String>,
    size: [u32; 2],
    texture: wgpu::Texture,
    group: wgpu::BindGroup,
}

impl Overlay {
    pub fn new(gpu: &Gpu, compiler: &Arc<Compiler>) -> Self {
        let stages = wgpu::ShaderStages::VERTEX_FRAGMENT;
        Self {
            layout: pass::layout(gpu, "overlay", stages, &[Binding::Uniform, Binding::Texels]),
            pipelines: Pipelines::new(compiler, shaders::OVERLAY),
            uniform: buffer::filled(gpu, "overlay", &[PanelUniform::zeroed()], wgpu::BufferUsages::UNIFORM),
            lines: Vec::new(),
            scale: 1,
            uploaded: None,
        }
    }

    /// These lines from the next picture on, each texel as `scale` x `scale` pixels; no lines: nothing.
    pub fn show(&mut self, lines: Vec<String>, scale: u32) {
        self.lines = lines;
        self.scale = scale.max(1);
    }

    pub fn bytes(&self) -> u64 {
        self.uploaded.as_ref().map_or(0, |uploaded| {
            u64::from(uploaded.texture.width()) * u64::from(uploaded.texture.height()) * 4
        })
    }

    /// Returns the draws.
    pub fn draw(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        timer: Option<&mut Timer>,
        display: &wgpu::Texture,
    ) -> u32 {
        if self.lines.is_empty() {
            return 0;
        }
        self.upload(gpu);
        let Some(uploaded) = &self.uploaded else { return 0 };
        let format = display.format();
        let uniform = PanelUniform {
            size: uploaded.size,
            scale: self.scale,
            encode: u32::from(!format.is_srgb()),
            display: [display.width(), display.height()],
            padding: [0; 2],
        };
        gpu.queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&uniform));
        let made =
            self.pipelines.get(Onto(format), |gpu, module| pipeline(gpu, module, &self.layout, format));
        let Some(pipeline) = made else { return 0 };
        let view = display.create_view(&Default::default());
        let stamps = timer.and_then(|timer| timer.render("overlay"));
        let mut pass = pass::draw_over(encoder, "overlay", &view, stamps);
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(3, &uploaded.group, &[]);
        pass.draw(0..4, 0..1);
        1
    }

    /// Where the lines are others than those that are on the GPU.
    fn upload(&mut self, gpu: &Gpu) {
        if self.uploaded.as_ref().is_some_and(|uploaded| uploaded.lines == self.lines) {
            return;
        }
        let panel = Panel::of(&self.lines);
        let kept = self.uploaded.take().filter(|uploaded| {
            uploaded.texture.width() >= panel.size[0] && uploaded.texture.height() >= panel.size[1]
        });
        let (texture, group) = match kept {
            Some(Uploaded { texture, group, .. }) => (texture, group),
            None => self.texture(gpu, panel.size),
        };
        let rows = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(panel.size[0] * 4),
            rows_per_image: None,
        };
        let [width, height] = panel.size;
        let extent = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        let texels = bytemuck::cast_slice(&panel.texels);
        gpu.queue.write_texture(texture.as_image_copy(), texels, rows, extent);
        self.uploaded = Some(Uploaded { lines: self.lines.clone(), size: panel.size, texture, group });
    }

    fn texture(&self, gpu: &Gpu, size: [u32; 2]) -> (wgpu::Texture, wgpu::BindGroup) {
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("overlay"),
            size: wgpu::Extent3d {
                width: size[0].next_multiple_of(256),
                height: size[1].next_multiple_of(128),
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8Unorm,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let view = texture.create_view(&Default::default());
        let resources = [self.uniform.as_entire_binding(), wgpu::BindingResource::TextureView(&view)];
        let group = pass::group(gpu, "overlay", &self.layout, &resources);
        (texture, group)
    }
}

fn pipeline(
    gpu: &Gpu,
    module: &wgpu::ShaderModule,
    layout: &wgpu::BindGroupLayout,
    format: wgpu::TextureFormat,
) -> wgpu::RenderPipeline {
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("overlay"),
        layout: Some(&pass::pipeline_layout(gpu, &[None, None, None, Some(layout)])),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some("corner"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState {
            topology: wgpu::PrimitiveTopology::TriangleStrip,
            ..Default::default()
        },
        depth_stencil: None,
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some("overlay"),
            compilation_options: Default::default(),
            targets: &[Some(wgpu::ColorTargetState {
                format,
                blend: Some(wgpu::BlendState::ALPHA_BLENDING),
                write_mask: wgpu::ColorWrites::COLOR,
            })],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// Lines of text on a ground that hides most of the picture.
struct Panel {
    size: [u32; 2],
    texels: Vec<[u8; 4]>,
}

impl Panel {
    fn of(lines: &[String]) -> Self {
        let cell = FONT.character_size;
        let shown = &lines[..lines.len().min(MOST[1])];
        let columns = shown.iter().map(|line| line.chars().count().min(MOST[0])).max().unwrap_or(0) as u32;
        let size = [columns * cell.width + 2 * MARGIN, shown.len() as u32 * cell.height + 2 * MARGIN];
        let mut panel = Self { size, texels: vec![PANEL; (size[0] * size[1]) as usize] };
        let style = MonoTextStyle::new(&FONT, BinaryColor::On);
        for (row, line) in shown.iter().enumerate() {
            let line: String = line.chars().take(MOST[0]).collect();
            let at = Point::new(MARGIN as i32, (MARGIN + row as u32 * cell.height) as i32);
            let Ok(_) = Text::with_baseline(&line, at, style, Baseline::Top).draw(&mut panel);
        }
        panel
    }
}

impl OriginDimensions for Panel {
    fn size(&self) -> Size {
        Size::new(self.size[0], self.size[1])
    }
}

impl DrawTarget for Panel {
    type Color = BinaryColor;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<BinaryColor>>>(&mut self, pixels: I) -> Result<(), Infallible> {
        let [width, height] = self.size;
        for Pixel(at, color) in pixels {
            let inside = (0..width as i32).contains(&at.x) && (0..height as i32).contains(&at.y);
            if inside && color.is_on() {
                self.texels[at.y as usize * width as usize + at.x as usize] = TEXT;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_panel_is_as_large_as_its_text_and_never_larger_than_it_may_be() {
        let panel = Panel::of(&["Hohlraum".to_owned(), "é".to_owned()]);
        assert_eq!(panel.size, [8 * 9 + 12, 2 * 18 + 12]);
        assert!(panel.texels.contains(&TEXT) && panel.texels.contains(&PANEL));
        let long = vec!["x".repeat(10_000); 1000];
        let panel = Panel::of(&long);
        assert!(panel.size.iter().all(|&side| side <= 2048), "{:?}", panel.size);
    }
}
