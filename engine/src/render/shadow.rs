//! Shadow maps: what a light sees, as depth, drawn again only when the light or something that it sees changed.
//!
//! A sun has one map over the whole scene, so that patches that no camera sees are right too; a spot has one,
//! a point light six. They are layers of three array textures. Maps are drawn unculled: a back face blocks.

use std::hash::{DefaultHasher, Hash, Hasher};

use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec3, Vec4};
use wgpu::BufferUsages as Usage;

use super::instances::{Instances, Pass};
use super::lights::{self, GpuLight};
use super::materials::Materials;
use super::meshes::{Meshes, StillBuffers};
use super::shadow_view::{self, POINT, Seen, fit, kind_of};
use super::{shaders, surface};
use crate::gpu::buffer::Held;
use crate::gpu::pass::{self, Binding};
use crate::gpu::shader::Library;
use crate::gpu::timing::Timer;
use crate::gpu::{Gpu, GpuError, texture};
use crate::transport::direct::PlacedLight;

/// `ShadowView` in `shadow.wgsl`, and the room that a dynamic offset leaves.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ShadowView {
    pub clip_from_world: Mat4,
    pub padding: [Vec4; 12],
}

/// The most lights of each kind that cast shadows.
pub const MOST: [usize; 3] = [4, 32, 32];
pub struct Shadows {
    pipelines: [wgpu::RenderPipeline; 4],
    maps: [Maps; 3],
    slots: Held<ShadowView>,
    matrices: Held<Mat4>,
    lights: Held<GpuLight>,
    comparison: wgpu::Sampler,
    slot_layout: wgpu::BindGroupLayout,
    scene_layout: wgpu::BindGroupLayout,
    slot_group: wgpu::BindGroup,
    scene_group: wgpu::BindGroup,
    bound: [u64; 3],
    /// Lights that should cast a shadow, but are too many.
    pub left_out: usize,
    /// The sphere that sun maps cover.
    fit: (Vec3, f32),
}

struct Maps {
    texture: wgpu::Texture,
    /// Texels across a map, once there is one.
    size: u32,
    /// By layer: what is drawn there.
    drawn: Vec<u64>,
}

/// What drawing casters needs.
pub struct Casters<'a> {
    pub instances: &'a Instances,
    pub still: &'a StillBuffers,
    pub meshes: &'a Meshes,
    pub materials: &'a Materials,
}

/// What a frame's shadows came to.
pub struct Shadowed {
    /// A light, or what reaches a surface from it, differs from the last frame.
    pub changed: bool,
    pub draws: u32,
}

impl Shadows {
    pub fn new(
        gpu: &Gpu,
        library: &mut Library,
        material_layout: &wgpu::BindGroupLayout,
    ) -> Result<Self, GpuError> {
        use Binding::{Comparison, DepthLayers, Read};
        let both = wgpu::ShaderStages::FRAGMENT | wgpu::ShaderStages::COMPUTE;
        let slot_layout =
            pass::layout(gpu, "shadow view", wgpu::ShaderStages::VERTEX, &[Binding::UniformSlot]);
        let scene_layout = pass::layout(
            gpu,
            "scene",
            both,
            &[Read, Read, DepthLayers, DepthLayers, DepthLayers, Comparison],
        );
        let sizes = if gpu.software { [2048, 1024, 512] } else { [4096, 1024, 512] };
        let maps = [0, 1, 2].map(|kind| Maps::new(gpu, sizes[kind], 0));
        let slots = Held::new(gpu, "shadow views", Usage::UNIFORM);
        let matrices = Held::new(gpu, "shadow views", Usage::STORAGE);
        let lights = Held::new(gpu, "lights", Usage::STORAGE);
        let comparison = comparison(gpu);
        Ok(Self {
            pipelines: pipelines(gpu, library, &slot_layout, material_layout)?,
            slot_group: slot_group(gpu, &slot_layout, &slots),
            scene_group: scene_group(gpu, &scene_layout, &lights, &matrices, &maps, &comparison),
            bound: [0; 3],
            maps,
            slots,
            matrices,
            lights,
            comparison,
            slot_layout,
            scene_layout,
            left_out: 0,
            fit: (Vec3::ZERO, 1.0),
        })
    }

    /// Group 1: lights and their maps.
    pub fn scene_layout(&self) -> &wgpu::BindGroupLayout {
        &self.scene_layout
    }

    pub fn scene_group(&self) -> &wgpu::BindGroup {
        &self.scene_group
    }

    /// Those that shine, with their maps.
    pub fn lights(&self) -> &[GpuLight] {
        self.lights.items()
    }

    pub fn light_count(&self) -> u32 {
        self.lights.items().len() as u32
    }

    pub fn bytes(&self) -> u64 {
        let of = |maps: &Maps| {
            let texels = u64::from(maps.texture.width()) * u64::from(maps.texture.height());
            texels * 4 * u64::from(maps.texture.depth_or_array_layers())
        };
        self.maps.iter().map(of).sum()
    }

    /// Follows lights and casters, and draws the maps that are not what they should be.
    pub fn update(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        timer: &mut Timer,
        placed: &[PlacedLight],
        casters: &Casters<'_>,
    ) -> Shadowed {
        self.fit = fit(self.fit, casters.instances);
        self.make_room(gpu, placed);
        let (on_gpu, seen) = self.assign(placed);
        let matrices: Vec<Mat4> = seen.iter().map(|seen| seen.clip_from_world).collect();
        let slots: Vec<ShadowView> = matrices
            .iter()
            .map(|&clip_from_world| ShadowView { clip_from_world, padding: [Vec4::ZERO; 12] })
            .collect();
        self.slots.write(gpu, &slots);
        let mut changed = self.matrices.write(gpu, &matrices);
        changed |= self.lights.write(gpu, &on_gpu);
        self.bind(gpu);
        let mut draws = 0;
        for (slot, seen) in seen.iter().enumerate() {
            let signature = signature(seen, casters);
            if self.maps[seen.kind].drawn[seen.layer] != signature {
                self.maps[seen.kind].drawn[seen.layer] = signature;
                draws += self.draw(encoder, timer, slot, seen, casters);
                changed = true;
            }
        }
        Shadowed { changed, draws }
    }

    /// Textures with a layer for every light that casts shadows.
    fn make_room(&mut self, gpu: &Gpu, placed: &[PlacedLight]) {
        let mut wanted = [0; 3];
        for light in placed.iter().filter(|light| light.light.casts_shadows) {
            wanted[kind_of(light)] += 1;
        }
        self.left_out = (0..3).map(|kind| wanted[kind] - MOST[kind].min(wanted[kind])).sum();
        for (kind, maps) in self.maps.iter_mut().enumerate() {
            let layers = wanted[kind].min(MOST[kind]) * if kind == POINT { 6 } else { 1 };
            if layers > maps.drawn.len() {
                *maps = Maps::new(gpu, maps.size, layers);
                // Bound anew.
                self.bound = [u64::MAX; 3];
            }
        }
    }

    /// Which light has which map, for all lights that shine.
    fn assign(&self, placed: &[PlacedLight]) -> (Vec<GpuLight>, Vec<Seen>) {
        let (mut on_gpu, mut seen) = (Vec::new(), Vec::new());
        let mut next = [0; 3];
        for light in placed {
            let kind = kind_of(light);
            let mut described = lights::on_gpu(light);
            if light.light.casts_shadows && next[kind] >= MOST[kind] {
                described.layer = lights::UNMAPPED;
            }
            if light.light.casts_shadows && next[kind] < MOST[kind] {
                let layer = next[kind] * if kind == POINT { 6 } else { 1 };
                next[kind] += 1;
                if lights::shines(light) {
                    described.layer = layer as i32;
                    described.first_view = seen.len() as u32;
                    described.texel =
                        shadow_view::see(light, layer, self.maps[kind].size, self.fit, &mut seen);
                }
            }
            if lights::shines(light) {
                on_gpu.push(described);
            }
        }
        (on_gpu, seen)
    }

    fn bind(&mut self, gpu: &Gpu) {
        let now = [self.slots.generation, self.matrices.generation, self.lights.generation];
        if self.bound != now {
            self.bound = now;
            self.slot_group = slot_group(gpu, &self.slot_layout, &self.slots);
            self.scene_group = scene_group(
                gpu,
                &self.scene_layout,
                &self.lights,
                &self.matrices,
                &self.maps,
                &self.comparison,
            );
        }
    }

    fn draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        timer: &mut Timer,
        slot: usize,
        seen: &Seen,
        casters: &Casters<'_>,
    ) -> u32 {
        let view = texture::layer(&self.maps[seen.kind].texture, seen.layer as u32);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("shadow"),
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &view,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            timestamp_writes: timer.render("shadow"),
            ..Default::default()
        });
        pass.set_bind_group(0, &self.slot_group, &[(slot * size_of::<ShadowView>()) as u32]);
        let mut draws = 0;
        for draw in casters.instances.draws.iter().filter(|draw| seen.sees(draw)) {
            let holes = draw.pass != Pass::Opaque;
            pass.set_pipeline(&self.pipelines[usize::from(draw.mesh.is_some()) * 2 + usize::from(holes)]);
            if holes {
                pass.set_bind_group(3, casters.materials.group(draw.material), &[]);
            }
            surface::bind_mesh(&mut pass, draw, casters.still, casters.meshes, casters.instances, false);
            pass.draw_indexed(draw.indices.clone(), 0, 0..1);
            draws += 1;
        }
        draws
    }
}

/// A number for everything that a map shows.
fn signature(seen: &Seen, casters: &Casters<'_>) -> u64 {
    let mut hasher = DefaultHasher::new();
    bytemuck::bytes_of(&seen.clip_from_world).hash(&mut hasher);
    for draw in casters.instances.draws.iter().filter(|draw| seen.sees(draw)) {
        (draw.mesh, &draw.indices).hash(&mut hasher);
        if draw.mesh.is_some() {
            let instance = &casters.instances.buffer.items()[draw.instance as usize];
            bytemuck::cast_slice::<_, u8>(&instance.rows).hash(&mut hasher);
        }
        if draw.pass != Pass::Opaque {
            (draw.material, casters.materials.holes(draw.material)).hash(&mut hasher);
        }
    }
    // 0 is a layer that was never drawn.
    hasher.finish().max(1)
}

impl Maps {
    fn new(gpu: &Gpu, size: u32, layers: usize) -> Self {
        let texels = if layers == 0 { 1 } else { size };
        let texture = texture::depth_layers(gpu, "shadow maps", texels, layers as u32);
        Self { texture, size, drawn: vec![0; layers] }
    }
}

fn comparison(gpu: &Gpu) -> wgpu::Sampler {
    gpu.device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("nearer"),
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        // Depth is reversed.
        compare: Some(wgpu::CompareFunction::GreaterEqual),
        ..Default::default()
    })
}

fn slot_group(gpu: &Gpu, layout: &wgpu::BindGroupLayout, slots: &Held<ShadowView>) -> wgpu::BindGroup {
    let slot = wgpu::BindingResource::Buffer(wgpu::BufferBinding {
        buffer: slots.buffer(),
        offset: 0,
        size: wgpu::BufferSize::new(64),
    });
    pass::group(gpu, "shadow view", layout, &[slot])
}

fn scene_group(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
    lights: &Held<GpuLight>,
    matrices: &Held<Mat4>,
    maps: &[Maps; 3],
    comparison: &wgpu::Sampler,
) -> wgpu::BindGroup {
    let views = maps.each_ref().map(|maps| texture::as_layers(&maps.texture));
    let mut resources = vec![lights.buffer().as_entire_binding(), matrices.buffer().as_entire_binding()];
    resources.extend(views.iter().map(wgpu::BindingResource::TextureView));
    resources.push(wgpu::BindingResource::Sampler(comparison));
    pass::group(gpu, "scene", layout, &resources)
}

/// Still, still with holes, moving, moving with holes.
fn pipelines(
    gpu: &Gpu,
    library: &mut Library,
    slot_layout: &wgpu::BindGroupLayout,
    material_layout: &wgpu::BindGroupLayout,
) -> Result<[wgpu::RenderPipeline; 4], GpuError> {
    let module = library.module(gpu, shaders::SHADOW)?;
    let make = |moving: bool, holes: bool| {
        let material = holes.then_some(material_layout);
        let fragment = holes.then(|| wgpu::FragmentState {
            module: &module,
            entry_point: Some("holes"),
            compilation_options: Default::default(),
            targets: &[],
        });
        gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("shadow"),
            layout: Some(&pass::pipeline_layout(gpu, &[Some(slot_layout), None, None, material])),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some(if moving { "moving" } else { "still" }),
                compilation_options: Default::default(),
                buffers: surface::vertex_layouts(moving, false),
            },
            primitive: Default::default(),
            depth_stencil: Some(surface::depth_state(true)),
            multisample: Default::default(),
            fragment,
            multiview_mask: None,
            cache: None,
        })
    };
    Ok([make(false, false), make(false, true), make(true, false), make(true, true)])
}
