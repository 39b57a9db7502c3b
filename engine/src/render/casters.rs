//! Drawing what casts shadows, and numbers for it, by which one sees whether a map is still right.
//!
//! A map holds depths at the middles of its texels only, and a filter reads some texels about a point: a lit surface
//! would shade itself, and where it meets another lit one at an inner edge, either would shade the other. Therefore
//! the side of a surface that can be lit is drawn farther from the light by as much as it slopes over the filter's
//! width ([`PUSH`]). Its back is drawn where it is. It blocks where the front is too far off: behind thin walls, and
//! in rooms whose walls are single faces that look inside. What is lit from both sides has no back and stays where
//! it is.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;

use super::instances::{Draw, Instances, Pass};
use super::materials::Materials;
use super::meshes::{Meshes, StillBuffers};
use super::shadow_view::Seen;
use super::{shaders, surface};
use crate::gpu::Gpu;
use crate::gpu::pass;
use crate::gpu::pipeline::{self, Compiler, Pipelines};
use crate::scene::Forced;

/// Texels over which a front's slope counts: half the filter's width, and half a texel for where a texel's middle is.
const PUSH: f32 = 4.5;

/// What drawing casters needs.
pub struct Casters<'a> {
    pub instances: &'a Instances,
    pub still: &'a StillBuffers,
    pub meshes: &'a Meshes,
    pub materials: &'a Materials,
}

/// Numbers for everything that a light may see of casters, by draw, and one for all.
pub struct Stamps {
    each: Vec<u64>,
    pub all: u64,
}

impl Stamps {
    pub fn new(casters: &Casters<'_>) -> Self {
        let each: Vec<u64> = casters.instances.draws.iter().map(|draw| stamp(draw, casters)).collect();
        let mut hasher = DefaultHasher::new();
        each.hash(&mut hasher);
        Self { each, all: hasher.finish() }
    }

    /// Of all that a map shows, out of the draws that its light reaches.
    pub fn of_map(&self, seen: &Seen, reached: &[usize], draws: &[Draw]) -> u64 {
        let mut hasher = DefaultHasher::new();
        bytemuck::bytes_of(&seen.clip_from_world).hash(&mut hasher);
        for &index in reached.iter().filter(|&&index| seen.sees(&draws[index])) {
            self.each[index].hash(&mut hasher);
        }
        // 0 is a layer that was never drawn.
        hasher.finish().max(1)
    }
}

fn stamp(draw: &Draw, casters: &Casters<'_>) -> u64 {
    let mut hasher = DefaultHasher::new();
    (draw.casts, draw.mesh, &draw.indices, draw.double_sided, draw.mirrored).hash(&mut hasher);
    if draw.mesh.is_some() {
        let instance = &casters.instances.buffer.items()[draw.instance as usize];
        bytemuck::cast_slice::<_, u8>(&instance.rows).hash(&mut hasher);
    }
    if draw.pass != Pass::Opaque {
        (draw.material, casters.materials.holes(draw.material)).hash(&mut hasher);
    }
    hasher.finish()
}

/// What tells one pipeline from another.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Variant {
    moving: bool,
    holes: bool,
    cull: Option<wgpu::Face>,
    pushed: bool,
}

impl pipeline::Variant for Variant {
    fn name(&self) -> String {
        let said = [(self.moving, "moving"), (self.holes, "holes"), (self.pushed, "pushed")];
        let said = said.into_iter().filter(|(is, _)| *is).map(|(_, word)| word);
        ["shadow"].into_iter().chain(said).collect::<Vec<_>>().join(", ")
    }

    fn defines(&self) -> Vec<&'static str> {
        if self.holes { vec!["HOLES"] } else { Vec::new() }
    }
}

/// The sides of a caster that are drawn at once.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    Both,
    Front,
    Back,
}

impl Variant {
    /// `None`: the draw has no such side.
    fn of(draw: &Draw, side: Side, holes: Option<Forced>) -> Option<Self> {
        use wgpu::Face::{Back, Front};
        let moving = draw.mesh.is_some();
        let holes = holes.map_or(draw.pass != Pass::Opaque, |forced| forced == Forced::In);
        let cull = match (side, draw.mirrored) {
            (Side::Both, _) => None,
            (Side::Front, false) | (Side::Back, true) => Some(Back),
            (Side::Front, true) | (Side::Back, false) => Some(Front),
        };
        let has = draw.double_sided == (side == Side::Both);
        has.then_some(Self { moving, holes, cull, pushed: side == Side::Front })
    }
}

/// Pipelines into shadow maps.
pub struct CasterPass {
    plain: wgpu::PipelineLayout,
    with_holes: wgpu::PipelineLayout,
    pipelines: Pipelines<Variant, wgpu::RenderPipeline>,
    /// What the author says of holes.
    holes: Option<Forced>,
}

impl CasterPass {
    pub fn new(
        gpu: &Gpu,
        compiler: &Arc<Compiler>,
        [view_layout, material_layout]: [&wgpu::BindGroupLayout; 2],
        holes: Option<Forced>,
    ) -> Self {
        Self {
            plain: pass::pipeline_layout(gpu, &[Some(view_layout)]),
            with_holes: pass::pipeline_layout(gpu, &[Some(view_layout), None, None, Some(material_layout)]),
            pipelines: Pipelines::new(compiler, shaders::SHADOW),
            holes,
        }
    }

    /// Draws what a map sees of what its light reaches; group 0 is set. Returns the draws.
    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        seen: &Seen,
        reached: &[usize],
        casters: &Casters<'_>,
    ) -> u32 {
        let mut draws = 0;
        for side in [Side::Both, Side::Front, Side::Back] {
            let all = reached.iter().map(|&index| &casters.instances.draws[index]);
            for draw in all.filter(|draw| seen.sees(draw)) {
                let Some(variant) = Variant::of(draw, side, self.holes) else { continue };
                let Some(pipeline) = self.pipeline(variant) else { continue };
                pass.set_pipeline(&pipeline);
                if variant.holes {
                    pass.set_bind_group(3, casters.materials.group(draw.material), &[]);
                }
                surface::bind_mesh(pass, draw, casters.still, casters.meshes, casters.instances, false);
                pass.draw_indexed(draw.indices.clone(), 0, 0..1);
                draws += 1;
            }
        }
        draws
    }

    fn pipeline(&self, variant: Variant) -> Option<wgpu::RenderPipeline> {
        let layout = if variant.holes { &self.with_holes } else { &self.plain };
        self.pipelines.get(variant, |gpu, module| pipeline(gpu, module, layout, variant))
    }
}

fn pipeline(
    gpu: &Gpu,
    module: &wgpu::ShaderModule,
    layout: &wgpu::PipelineLayout,
    variant: Variant,
) -> wgpu::RenderPipeline {
    let fragment = variant.holes.then(|| wgpu::FragmentState {
        module,
        entry_point: Some("holes"),
        compilation_options: Default::default(),
        targets: &[],
    });
    // Depth is reversed.
    let slope_scale = if variant.pushed { -PUSH } else { 0.0 };
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("shadow"),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some(if variant.moving { "moving" } else { "still" }),
            compilation_options: Default::default(),
            buffers: surface::vertex_layouts(variant.moving, false),
        },
        primitive: wgpu::PrimitiveState { cull_mode: variant.cull, ..Default::default() },
        depth_stencil: Some(wgpu::DepthStencilState {
            bias: wgpu::DepthBiasState { constant: 0, slope_scale, clamp: 0.0 },
            ..surface::depth_state(true)
        }),
        multisample: Default::default(),
        fragment,
        multiview_mask: None,
        cache: None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shader_counts_on_the_same_push() {
        let light = shaders::IMPORTED.iter().find(|source| source.name == "scene/light");
        assert!(light.is_some_and(|source| source.text.contains(&format!("const PUSH: f32 = {PUSH:?};"))));
    }
}
