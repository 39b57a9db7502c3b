//! Shadow maps: what a light sees, as depth, drawn again only when the light or something that it sees changed.
//!
//! A sun has one map over the whole scene, so that patches that no camera sees are right too, and four cascades about
//! what the camera sees, where the scene is too large for the one; a spot has one, a point light six. They are
//! layers of three array textures ([`super::shadow_maps`]). Front and back of surfaces block ([`super::casters`]).

use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Mat4, Vec3, Vec4};
use wgpu::BufferUsages as Usage;

use super::cascades::{self, CASCADES, Slices};
use super::casters::{CasterPass, Casters, Stamps};
use super::light_grid::{GridUniform, LightGrid};
use super::lights::{self, GpuLight};
use super::shadow_maps::{self, Maps};
use super::shadow_view::{self, POINT, Place, SPOT, SUN, Seen, fit, kind_of};
use super::view::Eye;
use crate::gpu::buffer::Held;
use crate::gpu::pass::{self, Binding};
use crate::gpu::pipeline::Compiler;
use crate::gpu::timing::Timer;
use crate::gpu::{Gpu, texture};
use crate::scene::{EntityId, Forced};
use crate::transport::direct::PlacedLight;

/// `ShadowView` in `shadow.wgsl`, and the room that a dynamic offset leaves.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ShadowView {
    pub clip_from_world: Mat4,
    pub padding: [Vec4; 12],
}

pub struct Shadows {
    casters: CasterPass,
    maps: [Maps; 3],
    slots: Held<ShadowView>,
    matrices: Held<Mat4>,
    lights: Held<GpuLight>,
    grid: LightGrid,
    comparison: wgpu::Sampler,
    slot_layout: wgpu::BindGroupLayout,
    scene_layout: wgpu::BindGroupLayout,
    slot_group: wgpu::BindGroup,
    scene_group: wgpu::BindGroup,
    bound: [u64; 5],
    /// Matrices without the camera's.
    steady: Vec<Mat4>,
    /// Lights that should cast a shadow, but are too many.
    too_many: usize,
    suns: usize,
    /// The sphere that sun maps cover.
    fit: (Vec3, f32),
    slices: Slices,
    asked: Asked,
}

/// What of shadows is not left to the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Asked {
    /// In: of lights that cast none, too, though nobody looks at those; out: nothing casts.
    pub maps: Option<Forced>,
    /// In: every caster is looked at for holes; out: none has any.
    pub holes: Option<Forced>,
    /// Lights with a range are found by the grid, and not all in one list.
    pub in_grid: bool,
}

/// Where a frame's commands go.
pub struct Recording<'a> {
    pub gpu: &'a Gpu,
    pub encoder: &'a mut wgpu::CommandEncoder,
    pub timer: &'a mut Timer,
}

/// The view that cascades are for.
pub struct Camera<'a> {
    pub eye: &'a Eye,
    pub origin: DVec3,
    pub aspect: f32,
}

/// What a frame's shadows came to.
pub struct Shadowed {
    /// A light, or what reaches a surface from it, differs from the last frame.
    pub changed: bool,
    pub draws: u32,
}

/// The lights that shine, and the maps to be seen to.
struct Assigned<'a> {
    /// Those that reach all come first.
    lights: Vec<GpuLight>,
    placed: Vec<&'a PlacedLight>,
    everywhere: usize,
    seen: Vec<Seen>,
}

impl Shadows {
    pub fn new(
        gpu: &Gpu,
        compiler: &Arc<Compiler>,
        material_layout: &wgpu::BindGroupLayout,
        asked: Asked,
    ) -> Self {
        use Binding::{Comparison, DepthLayers, Read, Uniform};
        let both = wgpu::ShaderStages::FRAGMENT | wgpu::ShaderStages::COMPUTE;
        let slot_layout =
            pass::layout(gpu, "shadow view", wgpu::ShaderStages::VERTEX, &[Binding::UniformSlot]);
        let bindings = [Read, Read, DepthLayers, DepthLayers, DepthLayers, Comparison, Uniform, Read];
        let scene_layout = pass::layout(gpu, "scene", both, &bindings);
        let maps = [SUN, SPOT, POINT].map(|kind| Maps::new(gpu, kind));
        let slots = Held::new(gpu, "shadow views", Usage::UNIFORM);
        let matrices = Held::new(gpu, "shadow views", Usage::STORAGE);
        let lights = Held::new(gpu, "lights", Usage::STORAGE);
        let grid = LightGrid::new(gpu);
        let comparison = comparison(gpu);
        let buffers = [lights.buffer(), matrices.buffer(), grid.uniform.buffer(), grid.lists.buffer()];
        Self {
            casters: CasterPass::new(gpu, compiler, [&slot_layout, material_layout], asked.holes),
            slot_group: slot_group(gpu, &slot_layout, &slots),
            scene_group: scene_group(gpu, &scene_layout, buffers, &maps, &comparison),
            bound: [0; 5],
            maps,
            slots,
            matrices,
            lights,
            grid,
            comparison,
            slot_layout,
            scene_layout,
            steady: Vec::new(),
            too_many: 0,
            suns: 0,
            fit: (Vec3::ZERO, 1.0),
            slices: Slices::default(),
            asked,
        }
    }

    /// Group 1: lights, their grid and their maps.
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

    /// The camera's slices, and the widths of their texels [m].
    pub fn cascades(&self) -> (Slices, Vec4) {
        (self.slices, self.slices.texels(self.maps[SUN].size.max(64)))
    }

    pub fn light_grid(&self) -> &LightGrid {
        &self.grid
    }

    pub fn bytes(&self) -> u64 {
        self.maps.iter().map(Maps::bytes).sum()
    }

    /// What is not done, and why.
    pub fn left_out(&self) -> Vec<String> {
        let mut left_out = Vec::new();
        if self.too_many > 0 {
            left_out.push(format!("shadows of {} lights: too many lights", self.too_many));
        }
        if self.suns > 0 && self.maps[SUN].each == 1 {
            let texel = 2000.0 * self.fit.1 / self.maps[SUN].size.max(1) as f32;
            left_out.push(format!("sun cascades: the map of the whole scene has texels of {texel:.1} mm"));
        }
        left_out
    }

    /// Follows lights and casters, and draws the maps that are not what they should be.
    pub fn update(
        &mut self,
        recording: &mut Recording<'_>,
        placed: &[PlacedLight],
        casters: &Casters<'_>,
        camera: &Camera<'_>,
    ) -> Shadowed {
        let gpu = recording.gpu;
        self.fit = fit(self.fit, casters.instances);
        self.make_room(gpu, placed);
        self.slices = match self.maps[SUN].each {
            1 => Slices::default(),
            _ => Slices::new(camera.eye, camera.origin, camera.aspect, self.fit.1),
        };
        let assigned = self.assign(placed);
        let changed = self.write(gpu, &assigned, casters);
        self.bind(gpu);
        let mut shadowed = Shadowed { changed, draws: 0 };
        self.draw_stale(recording, &assigned.seen, casters, &mut shadowed);
        shadowed
    }

    /// Layers for every light that casts shadows.
    fn make_room(&mut self, gpu: &Gpu, placed: &[PlacedLight]) {
        let mut wanted: [Vec<EntityId>; 3] = Default::default();
        for light in placed.iter().filter(|light| self.has_map(light)) {
            wanted[kind_of(light)].push(light.entity);
        }
        self.suns = wanted[SUN].len();
        self.too_many = 0;
        let needed = cascades::are_needed(self.fit.1, shadow_maps::largest_sun(gpu));
        for (kind, maps) in self.maps.iter_mut().enumerate() {
            let each = shadow_maps::layers_each(kind, if needed { CASCADES } else { 0 });
            if maps.keep(gpu, &wanted[kind], each) {
                // Bound anew.
                self.bound = [u64::MAX; 5];
            }
            self.too_many += maps.left_out(wanted[kind].len());
        }
    }

    fn has_map(&self, light: &PlacedLight) -> bool {
        match self.asked.maps {
            Some(forced) => forced == Forced::In,
            None => light.light.casts_shadows,
        }
    }

    /// Which light has which map, for all lights that shine.
    fn assign<'a>(&self, placed: &'a [PlacedLight]) -> Assigned<'a> {
        let shining = placed.iter().filter(|light| lights::shines(light));
        let (everywhere, local): (Vec<_>, Vec<_>) = shining.partition(|light| lights::is_everywhere(light));
        let count = if self.asked.in_grid { everywhere.len() } else { everywhere.len() + local.len() };
        let placed: Vec<&PlacedLight> = everywhere.into_iter().chain(local).collect();
        let mut seen = Vec::new();
        let lights = placed.iter().enumerate();
        let lights = lights.map(|(number, light)| self.described(number, light, &mut seen)).collect();
        Assigned { lights, placed, everywhere: count, seen }
    }

    fn described(&self, number: usize, light: &PlacedLight, seen: &mut Vec<Seen>) -> GpuLight {
        let mut described = lights::on_gpu(light);
        if !self.has_map(light) {
            return described;
        }
        let maps = &self.maps[kind_of(light)];
        let casts = light.light.casts_shadows;
        described.layer = if casts { lights::UNMAPPED } else { -1 };
        if let Some(layer) = maps.layer(light.entity) {
            let place = Place { light: number, layer, size: maps.size, fit: self.fit };
            described.layer = if casts { layer as i32 } else { -1 };
            described.first_view = seen.len() as u32;
            described.texel = shadow_view::see(light, &place, &self.slices, seen);
        }
        described
    }

    /// Returns whether a light differs from the last frame.
    fn write(&mut self, gpu: &Gpu, assigned: &Assigned<'_>, casters: &Casters<'_>) -> bool {
        let matrices: Vec<Mat4> = assigned.seen.iter().map(|seen| seen.clip_from_world).collect();
        let slot = |&clip_from_world: &Mat4| ShadowView { clip_from_world, padding: [Vec4::ZERO; 12] };
        self.slots.write(gpu, &matrices.iter().map(slot).collect::<Vec<_>>());
        self.matrices.write(gpu, &matrices);
        let steady = assigned.seen.iter().filter(|seen| !seen.of_camera).map(|seen| seen.clip_from_world);
        let steady: Vec<Mat4> = steady.collect();
        let moved = self.steady != steady;
        self.steady = steady;
        let changed = self.lights.write(gpu, &assigned.lights);
        self.grid.update(gpu, &assigned.placed, assigned.everywhere, casters.instances, changed);
        changed || moved
    }

    fn bind(&mut self, gpu: &Gpu) {
        let (uniform, lists) = (&self.grid.uniform, &self.grid.lists);
        let now = [
            self.slots.generation,
            self.matrices.generation,
            self.lights.generation,
            uniform.generation,
            lists.generation,
        ];
        if self.bound != now {
            self.bound = now;
            self.slot_group = slot_group(gpu, &self.slot_layout, &self.slots);
            let buffers = [self.lights.buffer(), self.matrices.buffer(), uniform.buffer(), lists.buffer()];
            self.scene_group = scene_group(gpu, &self.scene_layout, buffers, &self.maps, &self.comparison);
        }
    }

    /// Draws the maps that show something else than they should.
    fn draw_stale(
        &mut self,
        recording: &mut Recording<'_>,
        all: &[Seen],
        casters: &Casters<'_>,
        shadowed: &mut Shadowed,
    ) {
        let stamps = Stamps::new(casters);
        let everything = &casters.instances.draws;
        let mut reached: (usize, Vec<usize>) = (usize::MAX, Vec::new());
        for (slot, seen) in all.iter().enumerate() {
            let looked_at = look(seen, &stamps);
            let content = &mut self.maps[seen.kind].drawn[seen.layer];
            if content.looked_at == looked_at {
                continue;
            }
            content.looked_at = looked_at;
            if reached.0 != seen.light {
                let reaches = |index: &usize| seen.reaches(&everything[*index]);
                reached = (seen.light, (0..everything.len()).filter(reaches).collect());
            }
            let signature = stamps.of_map(seen, &reached.1, everything);
            if content.signature != signature {
                content.signature = signature;
                shadowed.draws += self.draw(recording, (slot, seen), &reached.1, casters);
                shadowed.changed |= !seen.of_camera;
            }
        }
    }

    /// Returns the draws.
    fn draw(
        &mut self,
        recording: &mut Recording<'_>,
        (slot, seen): (usize, &Seen),
        reached: &[usize],
        casters: &Casters<'_>,
    ) -> u32 {
        let view = texture::layer(&self.maps[seen.kind].texture, seen.layer as u32);
        let mut pass = recording.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("shadow"),
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &view,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            timestamp_writes: recording.timer.render("shadow"),
            ..Default::default()
        });
        pass.set_bind_group(0, &self.slot_group, &[(slot * size_of::<ShadowView>()) as u32]);
        self.casters.draw(&mut pass, seen, reached, casters)
    }
}

/// A number for the view of a map and for all that could be seen in it.
fn look(seen: &Seen, stamps: &Stamps) -> u64 {
    let mut hasher = DefaultHasher::new();
    bytemuck::bytes_of(&seen.clip_from_world).hash(&mut hasher);
    (seen.reach.map(|(_, reach)| reach.to_bits()), stamps.all).hash(&mut hasher);
    // 0 is a layer that was never looked at.
    hasher.finish().max(1)
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

/// `buffers`: lights, views, grid, lists.
fn scene_group(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
    buffers: [&wgpu::Buffer; 4],
    maps: &[Maps; 3],
    comparison: &wgpu::Sampler,
) -> wgpu::BindGroup {
    let views = maps.each_ref().map(|maps| texture::as_layers(&maps.texture));
    let [lights, matrices, grid, lists] = buffers.map(wgpu::Buffer::as_entire_binding);
    let [suns, spots, points] = views.each_ref().map(wgpu::BindingResource::TextureView);
    let nearer = wgpu::BindingResource::Sampler(comparison);
    pass::group(gpu, "scene", layout, &[lights, matrices, suns, spots, points, nearer, grid, lists])
}

const _: () = assert!(size_of::<GridUniform>() <= 64, "an empty uniform buffer has room for 64 bytes");
