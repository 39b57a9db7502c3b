//! Which entity is seen where: the scene drawn once more, each surface in the number of its entity, into a picture as
//! large as the rectangle that is asked for. What lies beneath is found by asking again without what lies above.

use std::collections::{BTreeSet, HashSet};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec4};

use super::frame::{FrameUniform, Now, Renderer};
use super::instances::{Draw, Instances};
use super::meshes::{Meshes, StillBuffers};
use super::surface::{self, Side};
use super::{RenderError, shaders};
use crate::gpu::buffer::{self, Held};
use crate::gpu::pass::{self, Binding};
use crate::gpu::pipeline::{self, Compiler, Pipelines};
use crate::gpu::{Gpu, texture};
use crate::scene::EntityId;

/// `Object` in `picking.wgsl`, in a slot of a uniform buffer.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ObjectUniform {
    pub number: u32,
    pub padding: [u32; 63],
}

const NUMBERS: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;
pub(super) const MASK: wgpu::TextureFormat = wgpu::TextureFormat::R8Unorm;

/// Pixels of a picture: from `low` up to, but without, `high`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pixels {
    pub low: [u32; 2],
    pub high: [u32; 2],
}

/// What tells one pipeline from another.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Variant {
    moving: bool,
    cull: Option<wgpu::Face>,
    /// Into a mask, whatever lies before it.
    mask: bool,
}

impl pipeline::Variant for Variant {
    fn name(&self) -> String {
        let into = if self.mask { "mask" } else { "picking" };
        let said = [(self.moving, ", moving"), (self.cull.is_none(), ", both sides")];
        said.iter().filter(|(is, _)| *is).fold(into.to_owned(), |name, (_, word)| name + word)
    }
}

/// Buffers and pipelines are made when something is first picked or outlined.
pub struct Picking {
    layout: wgpu::PipelineLayout,
    pipelines: Pipelines<Variant, wgpu::RenderPipeline>,
    frame_layout: wgpu::BindGroupLayout,
    object_layout: wgpu::BindGroupLayout,
    objects: Option<Objects>,
    frame: Option<Frame>,
}

/// One a draw.
struct Objects {
    numbers: Held<ObjectUniform>,
    bound: Option<(u64, wgpu::BindGroup)>,
}

/// The view of a rectangle.
struct Frame {
    buffer: wgpu::Buffer,
    group: wgpu::BindGroup,
}

/// What is drawn with numbers.
pub(super) struct Numbered<'a> {
    pub instances: &'a Instances,
    pub still: &'a StillBuffers,
    pub meshes: &'a Meshes,
}

impl Picking {
    pub fn new(gpu: &Gpu, compiler: &Arc<Compiler>, frame_layout: &wgpu::BindGroupLayout) -> Self {
        let stages = wgpu::ShaderStages::FRAGMENT;
        let object_layout = pass::layout(gpu, "object", stages, &[Binding::UniformSlot]);
        Self {
            layout: pass::pipeline_layout(gpu, &[Some(frame_layout), None, None, Some(&object_layout)]),
            pipelines: Pipelines::new(compiler, shaders::PICKING),
            frame_layout: frame_layout.clone(),
            object_layout,
            objects: None,
            frame: None,
        }
    }

    /// Numbers the draws as they are now.
    pub(super) fn number(&mut self, gpu: &Gpu, draws: &[Draw]) {
        let object = |draw: &Draw| ObjectUniform {
            number: draw.entity.map_or(0, |entity| entity as u32 + 1),
            padding: [0; 63],
        };
        let Objects { numbers, bound } = self.objects.get_or_insert_with(|| Objects {
            numbers: Held::new(gpu, "objects", wgpu::BufferUsages::UNIFORM),
            bound: None,
        });
        numbers.write(gpu, &draws.iter().map(object).collect::<Vec<_>>());
        if bound.as_ref().is_some_and(|(generation, _)| *generation == numbers.generation) {
            return;
        }
        let slot = wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: numbers.buffer(),
            offset: 0,
            size: wgpu::BufferSize::new(size_of::<ObjectUniform>() as u64),
        });
        *bound = Some((numbers.generation, pass::group(gpu, "object", &self.object_layout, &[slot])));
    }

    /// From now on rectangles are seen so. Returns group 0.
    fn look(&mut self, gpu: &Gpu, uniform: &FrameUniform) -> wgpu::BindGroup {
        let frame = self.frame.get_or_insert_with(|| {
            let buffer = buffer::filled(gpu, "picking", &[*uniform], wgpu::BufferUsages::UNIFORM);
            let group = pass::buffers(gpu, "picking", &self.frame_layout, &[&buffer]);
            Frame { buffer, group }
        });
        gpu.queue.write_buffer(&frame.buffer, 0, bytemuck::bytes_of(uniform));
        frame.group.clone()
    }

    /// Draws what is chosen; group 0 is set. Returns the draws.
    pub(super) fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        numbered: &Numbered<'_>,
        mask: bool,
        chosen: impl Fn(&Draw) -> bool,
    ) -> u32 {
        let Some((_, objects)) = self.objects.as_ref().and_then(|objects| objects.bound.as_ref()) else {
            return 0;
        };
        let mut draws = 0;
        for (index, draw) in numbered.instances.draws.iter().enumerate() {
            if !draw.shown || draw.indices.is_empty() || !chosen(draw) {
                continue;
            }
            let variant =
                Variant { moving: draw.mesh.is_some(), cull: surface::culled(draw, &Side::Any), mask };
            let made =
                self.pipelines.get(variant, |gpu, module| pipeline(gpu, module, &self.layout, variant));
            let Some(pipeline) = made else { continue };
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(3, objects, &[(index * size_of::<ObjectUniform>()) as u32]);
            surface::bind_mesh(pass, draw, numbered.still, numbered.meshes, numbered.instances, false);
            pass.draw_indexed(draw.indices.clone(), 0, 0..1);
            draws += 1;
        }
        draws
    }
}

/// What is seen in a rectangle, on its way from the GPU.
pub struct Sought {
    /// `None`: the rectangle holds no pixel.
    numbers: Option<texture::Rows>,
    /// Of the scene that was looked at: it may be another when the answer is there.
    entities: Vec<EntityId>,
}

impl Sought {
    /// What is seen there, in the scene's order. `None`: the GPU has not come so far. Waits for nothing; it comes once.
    pub fn take(&self, gpu: &Gpu) -> Option<Result<Vec<EntityId>, RenderError>> {
        let Some(numbers) = &self.numbers else { return Some(Ok(Vec::new())) };
        let bytes = numbers.take(gpu)?;
        Some(bytes.map(|bytes| self.entities_in(&bytes)).map_err(RenderError::from))
    }

    fn entities_in(&self, bytes: &[u8]) -> Vec<EntityId> {
        let numbers =
            bytes.chunks_exact(4).map(|texel| u32::from_le_bytes([texel[0], texel[1], texel[2], texel[3]]));
        let seen: BTreeSet<u32> = numbers.filter(|&number| number > 0).collect();
        seen.into_iter().filter_map(|number| self.entities.get(number as usize - 1).copied()).collect()
    }
}

impl Renderer {
    /// True as soon as the last picture is drawn and [`Gpu::look`] or a frame has seen it.
    pub fn drawn(&self) -> Arc<AtomicBool> {
        self.drawn.clone()
    }

    /// Asks for the entities that are seen in a rectangle of a picture of `size`, without those named. One submission;
    /// the answer is taken later.
    pub fn seek(
        &mut self,
        now: &Now<'_>,
        size: [u32; 2],
        pixels: Pixels,
        without: &HashSet<EntityId>,
    ) -> Sought {
        let side = |axis: usize| pixels.high[axis].min(size[axis]).saturating_sub(pixels.low[axis]);
        let asked = [side(0), side(1)];
        let entities = now.scene.entities.iter().map(|entity| entity.id).collect();
        if asked.contains(&0) {
            return Sought { numbers: None, entities };
        }
        let gpu = &*self.gpu.clone();
        self.instances.update(gpu, now, &self.transport, &self.materials, &mut self.meshes);
        self.picking.number(gpu, &self.instances.draws);
        let aspect = size[0] as f32 / size[1] as f32;
        let uniform = FrameUniform {
            clip_from_world: cropped(size, pixels) * now.eye.clip_from_world(self.transport.origin, aspect),
            ..FrameUniform::zeroed()
        };
        let frame_group = self.picking.look(gpu, &uniform);

        let numbers = texture::target(gpu, "numbers", asked, 1, NUMBERS);
        let depth = texture::samples(gpu, "depth", asked, 1, wgpu::TextureFormat::Depth32Float);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let mut pass = begin(&mut encoder, &numbers, &depth);
        pass.set_bind_group(0, &frame_group, &[]);
        let numbered = Numbered { instances: &self.instances, still: &self.still, meshes: &self.meshes };
        let left = |draw: &Draw| {
            let entity = draw.entity.and_then(|index| now.scene.entities.get(index));
            entity.is_some_and(|entity| !without.contains(&entity.id))
        };
        self.picking.draw(&mut pass, &numbered, false, left);
        drop(pass);
        let copied = texture::Copied::of(gpu, &mut encoder, &numbers, 4);
        gpu.queue.submit([encoder.finish()]);
        Sought { numbers: Some(copied.sent()), entities }
    }
}

/// The map from a picture's clip space to that of a rectangle of it.
fn cropped(size: [u32; 2], pixels: Pixels) -> Mat4 {
    let range = |axis: usize, flip: f32| {
        let at = |pixel: u32| flip * (2.0 * pixel as f32 / size[axis] as f32 - 1.0);
        let (a, b) = (at(pixels.low[axis]), at(pixels.high[axis].min(size[axis])));
        let (low, high) = (a.min(b), a.max(b));
        (2.0 / (high - low), -(high + low) / (high - low))
    };
    let ((x, from_x), (y, from_y)) = (range(0, 1.0), range(1, -1.0));
    Mat4::from_cols(Vec4::X * x, Vec4::Y * y, Vec4::Z, Vec4::new(from_x, from_y, 0.0, 1.0))
}

fn begin<'a>(
    encoder: &'a mut wgpu::CommandEncoder,
    numbers: &wgpu::Texture,
    depth: &wgpu::Texture,
) -> wgpu::RenderPass<'a> {
    let clear = wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT);
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("picking"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: &numbers.create_view(&Default::default()),
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: clear, store: wgpu::StoreOp::Store },
        })],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &depth.create_view(&Default::default()),
            depth_ops: Some(wgpu::Operations {
                load: wgpu::LoadOp::Clear(0.0),
                store: wgpu::StoreOp::Discard,
            }),
            stencil_ops: None,
        }),
        ..Default::default()
    })
}

fn pipeline(
    gpu: &Gpu,
    module: &wgpu::ShaderModule,
    layout: &wgpu::PipelineLayout,
    variant: Variant,
) -> wgpu::RenderPipeline {
    let (entry, format) = if variant.mask { ("mask", MASK) } else { ("number", NUMBERS) };
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("picking"),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some(if variant.moving { "moving" } else { "still" }),
            compilation_options: Default::default(),
            buffers: surface::vertex_layouts(variant.moving, false),
        },
        primitive: wgpu::PrimitiveState { cull_mode: variant.cull, ..Default::default() },
        depth_stencil: (!variant.mask).then(|| surface::depth_state(true)),
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some(entry),
            compilation_options: Default::default(),
            targets: &[Some(format.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rectangle_fills_its_own_clip_space() {
        let crop = cropped([200, 100], Pixels { low: [50, 10], high: [100, 60] });
        let at = |x: f32, y: f32| {
            let clip = crop * Vec4::new(2.0 * x / 200.0 - 1.0, 1.0 - 2.0 * y / 100.0, 0.5, 1.0);
            [clip.x / clip.w, clip.y / clip.w]
        };
        for (pixel, clip) in
            [([50.0, 10.0], [-1.0, 1.0]), ([100.0, 60.0], [1.0, -1.0]), ([75.0, 35.0], [0.0, 0.0])]
        {
            let found = at(pixel[0], pixel[1]);
            assert!((found[0] - clip[0]).abs() < 1e-5 && (found[1] - clip[1]).abs() < 1e-5, "{found:?}");
        }
    }
}
