//! Surfaces: the baked ones and what moves, opaque first, blended ones from back to front behind the sky.

use std::sync::Arc;

use glam::{Mat4, Vec3};
use wgpu::{VertexAttribute, VertexBufferLayout, VertexStepMode, vertex_attr_array};

use super::instances::{Draw, Instance, Instances, Pass};
use super::materials::Materials;
use super::meshes::{Meshes, StillBuffers};
use super::objects::Objects;
use super::reflections::Reflections;
use super::shaders;
use super::shadow_view::in_sight;
use super::spaces::Spaces;
use super::targets;
use crate::gpu::Gpu;
use crate::gpu::pass::{self, Binding};
use crate::gpu::pipeline::{self, Compiler, Pipelines};
use crate::scene::{Alpha, Material};
use crate::transport::Vertex;
use crate::transport::surface::Blend;

const VERTEX: [VertexAttribute; 5] =
    vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x4, 3 => Float32x4, 4 => Float32x4];
const BLEND: [VertexAttribute; 2] = vertex_attr_array![5 => Uint32x4, 6 => Float32x4];
const BACK_BLEND: [VertexAttribute; 2] = vertex_attr_array![7 => Uint32x4, 8 => Float32x4];
const INSTANCE: [VertexAttribute; 4] =
    vertex_attr_array![9 => Float32x4, 10 => Float32x4, 11 => Float32x4, 12 => Uint32x2];

const fn buffer<T>(
    step_mode: VertexStepMode,
    attributes: &'static [VertexAttribute],
) -> Option<VertexBufferLayout<'static>> {
    Some(VertexBufferLayout { array_stride: size_of::<T>() as u64, step_mode, attributes })
}

const STILL: [Option<VertexBufferLayout<'static>>; 3] = [
    buffer::<Vertex>(VertexStepMode::Vertex, &VERTEX),
    buffer::<Blend>(VertexStepMode::Vertex, &BLEND),
    buffer::<Blend>(VertexStepMode::Vertex, &BACK_BLEND),
];
const BARE: [Option<VertexBufferLayout<'static>>; 1] = [buffer::<Vertex>(VertexStepMode::Vertex, &VERTEX)];
const MOVING: [Option<VertexBufferLayout<'static>>; 2] = [
    buffer::<Vertex>(VertexStepMode::Vertex, &VERTEX),
    buffer::<Instance>(VertexStepMode::Instance, &INSTANCE),
];

/// `lit`: with what static surfaces need to read receivers.
pub fn vertex_layouts(moving: bool, lit: bool) -> &'static [Option<VertexBufferLayout<'static>>] {
    match (moving, lit) {
        (true, _) => &MOVING,
        (false, true) => &STILL,
        (false, false) => &BARE,
    }
}

/// Depth is reversed: nearer is greater.
pub fn depth_state(write: bool) -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format: wgpu::TextureFormat::Depth32Float,
        depth_write_enabled: Some(write),
        depth_compare: Some(wgpu::CompareFunction::GreaterEqual),
        stencil: Default::default(),
        bias: Default::default(),
    }
}

/// Sets vertices, indices, and the instance by an offset: OpenGL knows no first instance.
pub fn bind_mesh(
    pass: &mut wgpu::RenderPass<'_>,
    draw: &Draw,
    still: &StillBuffers,
    meshes: &Meshes,
    instances: &Instances,
    lit: bool,
) {
    let format = wgpu::IndexFormat::Uint32;
    if let Some(mesh) = draw.mesh {
        let mesh = &meshes.all[mesh];
        pass.set_vertex_buffer(0, mesh.vertices.slice(..));
        let offset = u64::from(draw.instance) * size_of::<Instance>() as u64;
        pass.set_vertex_buffer(1, instances.buffer.buffer().slice(offset..));
        pass.set_index_buffer(mesh.indices.slice(..), format);
        return;
    }
    pass.set_vertex_buffer(0, still.vertices.slice(..));
    if lit {
        pass.set_vertex_buffer(1, still.blends.slice(..));
        pass.set_vertex_buffer(2, still.back_blends.slice(..));
    }
    pass.set_index_buffer(still.indices.slice(..), format);
}

/// What tells one pipeline from another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Variant {
    moving: bool,
    blend: bool,
    bumped: bool,
    cull: Option<wgpu::Face>,
    samples: u32,
    mirrored: bool,
    parts: Parts,
}

impl pipeline::Variant for Variant {
    fn name(&self) -> String {
        let said =
            [(self.moving, "moving"), (self.cull.is_none(), "both sides"), (self.mirrored, "mirrored")];
        let said = said.into_iter().filter(|(is, _)| *is).map(|(_, word)| word.to_owned());
        let parts = self.parts.defines().into_iter().map(|part| part.to_lowercase().replace('_', " "));
        ["surface".to_owned()].into_iter().chain(said).chain(parts).collect::<Vec<_>>().join(", ")
    }

    fn defines(&self) -> Vec<&'static str> {
        self.parts.defines()
    }
}

/// Parts of the shader that not every surface needs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Parts {
    pub normal_map: bool,
    pub mask: bool,
    pub blend: bool,
    pub unlit: bool,
    /// Punctual lights shine.
    pub lights: bool,
    /// There are cubemaps.
    pub cubemaps: bool,
    /// Light has one channel.
    pub grey: bool,
}

impl Parts {
    pub const ALL: Self = Self {
        normal_map: true,
        mask: true,
        blend: true,
        unlit: true,
        lights: true,
        cubemaps: true,
        grey: true,
    };

    /// As they are defined in `surface.wgsl`.
    pub fn defines(&self) -> Vec<&'static str> {
        let all = [
            (self.normal_map, "NORMAL_MAP"),
            (self.mask, "MASK"),
            (self.blend, "BLEND"),
            (self.unlit, "UNLIT"),
            (self.lights, "LIGHTS"),
            (self.cubemaps, "CUBEMAPS"),
            (self.grey, "GREY"),
        ];
        all.into_iter().filter(|(is, _)| *is).map(|(_, name)| name).collect()
    }

    /// What a material asks for, of what there is.
    fn of(material: &Material, there: &Self) -> Self {
        let lit = !material.unlit;
        Self {
            normal_map: there.normal_map && material.normal_texture.is_some(),
            mask: there.mask && matches!(material.alpha, Alpha::Mask { .. }),
            blend: there.blend && material.alpha == Alpha::Blend,
            unlit: there.unlit && material.unlit,
            lights: there.lights && lit,
            cubemaps: there.cubemaps && lit,
            grey: there.grey,
        }
    }
}

/// Which parts the surfaces of a frame have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Variants {
    /// What there is at all.
    pub there: Parts,
    /// All surfaces have all of it, whatever their materials ask for.
    pub alike: bool,
    /// Mesa's software Vulkan (22.3) was seen to crash over shaders that read cubemaps and discard nothing: those have
    /// the part for masks, too.
    pub masks_with_cubemaps: bool,
}

pub struct Surfaces {
    layout: wgpu::PipelineLayout,
    light_layout: wgpu::BindGroupLayout,
    pipelines: Pipelines<Variant, wgpu::RenderPipeline>,
    /// Group 2, and what it binds.
    light: Option<([u64; 4], wgpu::BindGroup)>,
    order: Vec<usize>,
}

/// Where surfaces are looked at from, and on what they are drawn.
pub struct Look<'a> {
    pub frame: &'a wgpu::BindGroup,
    pub clip_from_world: Mat4,
    /// Relative to the transport's origin.
    pub eye: Vec3,
    pub samples: u32,
    /// The picture is mirrored, as cubemaps are: front faces turn the other way.
    pub mirrored: bool,
}

/// Which surfaces.
#[derive(Clone, Copy, Debug)]
pub struct Which {
    pub blended: bool,
    pub still: bool,
    pub moving: bool,
}

/// What surfaces are drawn with.
pub struct Scenery<'a> {
    pub scene: &'a wgpu::BindGroup,
    pub instances: &'a Instances,
    pub still: &'a StillBuffers,
    pub meshes: &'a Meshes,
    pub materials: &'a Materials,
    pub variants: Variants,
}

impl Surfaces {
    pub fn new(
        gpu: &Gpu,
        compiler: &Arc<Compiler>,
        frame_layout: &wgpu::BindGroupLayout,
        scene_layout: &wgpu::BindGroupLayout,
        material_layout: &wgpu::BindGroupLayout,
    ) -> Self {
        use Binding::{Cubes, Picture, Read, Sampler, UniformSlot};
        let light_layout = pass::layout(
            gpu,
            "light",
            wgpu::ShaderStages::VERTEX_FRAGMENT,
            &[Read, Read, Read, Read, UniformSlot, Read, Read, Cubes, Sampler, Picture],
        );
        let groups = [Some(frame_layout), Some(scene_layout), Some(&light_layout), Some(material_layout)];
        Self {
            layout: pass::pipeline_layout(gpu, &groups),
            light_layout,
            pipelines: Pipelines::new(compiler, shaders::SURFACE),
            light: None,
            order: Vec::new(),
        }
    }

    /// Binds what surfaces read of light and reflections.
    pub fn bind(&mut self, gpu: &Gpu, spaces: &Spaces, objects: &Objects, reflections: &Reflections) {
        let [a, b, c] = reflections.generation();
        let generation = [a, b, c, objects.generation()];
        if self.light.as_ref().is_some_and(|(bound, _)| *bound == generation) {
            return;
        }
        let light = spaces.receivers.iter().chain(objects.light()).map(wgpu::Buffer::as_entire_binding);
        let resources: Vec<_> = light.chain(reflections.resources()).collect();
        self.light = Some((generation, pass::group(gpu, "light", &self.light_layout, &resources)));
    }

    /// Light lies elsewhere: what was bound is bound no more.
    pub fn unbind(&mut self) {
        self.light = None;
    }

    /// Draws the opaque or the blended surfaces that are in sight. Returns the draws.
    pub fn draw(
        &mut self,
        pass: &mut wgpu::RenderPass<'_>,
        scenery: &Scenery<'_>,
        look: &Look<'_>,
        which: Which,
    ) -> u32 {
        self.sort(scenery, look, which);
        let Some((_, light)) = &self.light else { return 0 };
        pass.set_bind_group(0, look.frame, &[]);
        pass.set_bind_group(1, scenery.scene, &[]);
        let mut draws = 0;
        for &index in &self.order {
            let draw = &scenery.instances.draws[index];
            for side in sides(draw) {
                let parts = scenery.variants.of(scenery.materials.material(draw.material));
                let variant = Variant {
                    moving: draw.mesh.is_some(),
                    blend: which.blended,
                    bumped: draw.bumped && parts.normal_map,
                    cull: culled(draw, side),
                    samples: look.samples,
                    mirrored: look.mirrored,
                    parts,
                };
                let made =
                    self.pipelines.get(variant, |gpu, module| pipeline(gpu, module, &self.layout, variant));
                let Some(pipeline) = made else { continue };
                pass.set_pipeline(&pipeline);
                pass.set_bind_group(2, light, &[Reflections::offset(index)]);
                pass.set_bind_group(3, scenery.materials.group(draw.material), &[]);
                bind_mesh(pass, draw, scenery.still, scenery.meshes, scenery.instances, true);
                if *side == Side::Back {
                    pass.set_vertex_buffer(1, scenery.still.back_blends.slice(..));
                }
                pass.draw_indexed(draw.indices.clone(), 0, 0..1);
                draws += 1;
            }
        }
        draws
    }

    /// Opaque ones from front to back, so that little is drawn over; blended ones from back to front.
    fn sort(&mut self, scenery: &Scenery<'_>, look: &Look<'_>, which: Which) {
        let draws = &scenery.instances.draws;
        let chosen = |index: &usize| {
            let draw = &draws[*index];
            let kind = if draw.mesh.is_some() { which.moving } else { which.still };
            kind && draw.shown
                && !draw.indices.is_empty()
                && (draw.pass == Pass::Blend) == which.blended
                && in_sight(&look.clip_from_world, draw.centre, draw.radius)
        };
        self.order.clear();
        self.order.extend((0..draws.len()).filter(chosen));
        if which.blended {
            let distance = |index: usize| draws[index].centre.distance_squared(look.eye);
            self.order.sort_by(|&a, &b| distance(b).total_cmp(&distance(a)));
        } else {
            let nearest = |index: usize| draws[index].centre.distance(look.eye) - draws[index].radius;
            self.order.sort_by(|&a, &b| nearest(a).total_cmp(&nearest(b)));
        }
    }
}

impl Variants {
    fn of(&self, material: &Material) -> Parts {
        let parts = if self.alike { self.there } else { Parts::of(material, &self.there) };
        Parts { mask: parts.mask || self.masks_with_cubemaps && parts.cubemaps, ..parts }
    }
}

/// What of a surface is drawn at once.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// All that is seen of it.
    Any,
    Front,
    Back,
}

/// Directional terms are many: those of one side at once pass from vertices to pixels.
fn sides(draw: &Draw) -> &'static [Side] {
    let each = draw.bumped && draw.double_sided && draw.mesh.is_none();
    if each { &[Side::Back, Side::Front] } else { &[Side::Any] }
}

/// Faces that are not drawn.
pub fn culled(draw: &Draw, side: &Side) -> Option<wgpu::Face> {
    match (side, draw.double_sided, draw.mirrored) {
        (Side::Front, ..) => Some(wgpu::Face::Back),
        (Side::Back, ..) => Some(wgpu::Face::Front),
        (Side::Any, true, _) => None,
        (Side::Any, false, false) => Some(wgpu::Face::Back),
        (Side::Any, false, true) => Some(wgpu::Face::Front),
    }
}

/// Of vertices and of pixels.
fn entries(variant: Variant) -> [&'static str; 2] {
    match (variant.moving, variant.bumped) {
        (false, false) => ["still", "shade"],
        (false, true) => ["still_bumped", "shade_bumped"],
        (true, false) => ["moving", "shade"],
        (true, true) => ["moving_bumped", "shade_moving_bumped"],
    }
}

fn pipeline(
    gpu: &Gpu,
    module: &wgpu::ShaderModule,
    layout: &wgpu::PipelineLayout,
    variant: Variant,
) -> wgpu::RenderPipeline {
    let [vertex, fragment] = entries(variant);
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("surface"),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some(vertex),
            compilation_options: Default::default(),
            buffers: vertex_layouts(variant.moving, true),
        },
        primitive: wgpu::PrimitiveState {
            cull_mode: variant.cull,
            front_face: if variant.mirrored { wgpu::FrontFace::Cw } else { wgpu::FrontFace::Ccw },
            ..Default::default()
        },
        depth_stencil: Some(depth_state(!variant.blend)),
        multisample: wgpu::MultisampleState { count: variant.samples, ..Default::default() },
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some(fragment),
            compilation_options: Default::default(),
            targets: &[Some(wgpu::ColorTargetState {
                format: targets::RADIANCE,
                blend: variant.blend.then_some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING),
                write_mask: wgpu::ColorWrites::ALL,
            })],
        }),
        multiview_mask: None,
        cache: None,
    })
}
