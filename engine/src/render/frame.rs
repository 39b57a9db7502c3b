//! THE frame: from the scene as it is now to a picture.
//!
//! ```text
//! lights and movers -> shadow maps -> direct light at patches (E) -> bounce (B) -> receivers, probes
//!                   -> surfaces -> sky -> blended surfaces -> exposure -> tonemap -> overlay
//! ```
//! What did not change is not done again: shadow maps, E, the bounce once it is solved, the gathers.

use std::borrow::Cow;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use bytemuck::{Pod, Zeroable};
use glam::{DAffine3, Mat4, Vec3, Vec4};

use super::asked::Asked;
use super::bounce::Bounce;
use super::casters::Casters;
use super::coarse::Coarse;
use super::dering::Dering;
use super::direct::{Direct, PatchShadows};
use super::drawn::Drawn;
use super::exposure::{self, Exposure};
use super::gather::Gather;
use super::instances::Instances;
use super::lines::Lines;
use super::materials::Materials;
use super::meshes::{Meshes, StillBuffers};
use super::objects::Objects;
use super::outline::Outline;
use super::overlay::Overlay;
use super::patches::Patches;
use super::picking::Picking;
use super::pictures::Pictures;
use super::probes::Probes;
use super::reflections::{Reflections, Seen};
use super::responses::Responses;
use super::rows::{self, PagedRows, Summed};
use super::shadow::{Asked as ShadowsAsked, Camera, Recording, Shadows};
use super::sky::SkyPass;
use super::sources::{Changed, Sources};
use super::spaces::Spaces;
use super::steering::Steering;
use super::surface::Surfaces;
use super::targets::{self, Targets};
use super::tonemap::{self, Tonemap};
use super::turns::Turns;
use super::unit::Rescale;
use super::uploads::Uploads;
use super::view::{Eye, View};
use super::wireframe::Wireframe;
use super::{RenderError, lights, shaders};
use crate::gpu::pass::{self, Binding};
use crate::gpu::timing::Timer;
use crate::gpu::{Gpu, buffer};
use crate::scene::assets::Assets;
use crate::scene::{Feature, Forced, Scene, Sky};
use crate::transport::{Depths, Occluders, Rows, Transport};

/// The scene as it is now, and where it is looked at from.
#[derive(Clone, Copy)]
pub struct Now<'a> {
    pub scene: &'a Scene,
    pub assets: &'a Assets,
    /// One an entity, with its motion.
    pub world_from_local: &'a [DAffine3],
    /// Seconds.
    pub time: f64,
    pub eye: Eye,
    pub view: View,
}

#[derive(Clone, Copy, Debug, Default)]
pub struct Settings {
    /// Samples a pixel; `None`: the most, up to 4.
    pub samples: Option<u32>,
    /// How rows are summed; `None`: as suits the adapter.
    pub summed: Option<Summed>,
    /// What tells patches whether a light reaches them; `None`: as suits adapter and scene.
    pub patch_shadows: Option<PatchShadows>,
    /// Waits for what a frame measures before the next one, so that pictures repeat.
    pub wait: bool,
    /// All lights in one list, for comparison with the grid.
    pub no_light_grid: bool,
    /// Albedo as authored, however long light bounces in a closed room.
    pub unlimited_gain: bool,
    /// Of every frame, to measure what they bring; `None`: as many as the bound asks for.
    pub products: Option<u32>,
    /// Bytes of meshes, and as many of pictures, that a frame brings to the GPU; `None`: all that it shows.
    pub uploads: Option<u64>,
}

/// `Frame` in `frame.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct FrameUniform {
    pub clip_from_world: Mat4,
    pub eye: Vec4,
    pub forward: Vec3,
    pub time: f32,
    pub right: Vec3,
    pub exposure: f32,
    pub up: Vec3,
    pub view: u32,
    /// Depths at which the cascades end; all 0: suns have their scene's map alone.
    pub cascade_ends: Vec4,
    pub cascade_texels: Vec4,
    pub eye_depth: f32,
    pub encode: u32,
    pub pre_exposure: f32,
    pub curve: u32,
    pub capture: u32,
    pub light_unit: f32,
    pub directional: u32,
    pub padding: u32,
}

/// Read back by those who ask how a picture was exposed.
const FRAME: wgpu::BufferUsages = wgpu::BufferUsages::UNIFORM.union(wgpu::BufferUsages::COPY_SRC);

/// Long-lived pipelines and the bake on the GPU.
pub struct Renderer {
    pub(super) gpu: Arc<Gpu>,
    pub(super) transport: Arc<Transport>,
    pub(super) occluders: Occluders,
    pub(super) settings: Settings,
    pub(super) samples: u32,
    pub timer: Timer,
    /// The last picture is done.
    pub(super) drawn: Arc<AtomicBool>,
    pub(super) pictures: Pictures,
    pub(super) materials: Materials,
    pub(super) meshes: Meshes,
    pub(super) still: StillBuffers,
    pub(super) instances: Instances,
    pub(super) spaces: Spaces,
    pub(super) sources: Sources,
    pub(super) shadows: Shadows,
    pub(super) direct: Direct,
    pub(super) bounce: Bounce,
    pub(super) coarse: Coarse,
    pub(super) gather: Gather,
    pub(super) dering: Dering,
    pub(super) objects: Objects,
    pub(super) reflections: Reflections,
    pub(super) surfaces: Surfaces,
    pub(super) patches: Patches,
    pub(super) probes: Probes,
    pub(super) tetrahedra: Lines,
    /// Over the scene, for who edits it.
    pub(super) guides: Lines,
    pub(super) wireframe: Wireframe,
    pub(super) picking: Picking,
    pub(super) outline: Outline,
    pub(super) sky: SkyPass,
    pub(super) exposure: Exposure,
    pub(super) tonemap: Tonemap,
    /// Text over the picture.
    pub overlay: Overlay,
    pub(super) frame: wgpu::Buffer,
    pub(super) frame_group: wgpu::BindGroup,
    pub(super) target: Option<(Targets, wgpu::BindGroup)>,
    pub(super) rescale: Rescale,
    pub(super) steering: Steering,
    /// Probes hold what is current.
    pub(super) probes_current: bool,
    /// What captures show, and changes of the sky.
    pub(super) seen: (Seen, u64),
    pub(super) moved: u64,
    pub(super) asked: Asked,
    pub(super) responses: Responses,
    pub(super) turns: Turns,
}

impl Renderer {
    /// As the scene asks, frame by frame.
    pub fn new(
        gpu: Arc<Gpu>,
        transport: Arc<Transport>,
        assets: &Assets,
        settings: Settings,
    ) -> Result<Self, RenderError> {
        Self::asked(gpu, transport, assets, settings, Asked::default())
    }

    /// Uploads what is needed of the bake. Pipelines are made when they are first used.
    ///
    /// What the author says of features holds; all else is there while the scene asks for it.
    pub fn asked(
        gpu: Arc<Gpu>,
        transport: Arc<Transport>,
        assets: &Assets,
        settings: Settings,
        asked: Asked,
    ) -> Result<Self, RenderError> {
        transport.validate().map_err(RenderError::Transport)?;
        let forced = |feature| asked.said(feature);
        let transport = match forced(Feature::LightProbes) {
            Some(Forced::Out) => without_probes(transport),
            _ => transport,
        };
        let gpu_ref = gpu.as_ref();
        let compiler = &shaders::compiler(&gpu)?;
        let stages = wgpu::ShaderStages::VERTEX_FRAGMENT | wgpu::ShaderStages::COMPUTE;
        let frame_layout = &pass::layout(gpu_ref, "frame", stages, &[Binding::Uniform]);
        let frame = buffer::filled(gpu_ref, "frame", &[FrameUniform::zeroed()], FRAME);
        let page = &rows::page_layout(gpu_ref);
        let summed = settings.summed.unwrap_or_else(|| Summed::best(gpu_ref));
        let row_layout = layout_of_rows(&asked);
        let paged = |what, rows| PagedRows::new(gpu_ref, page, what, (rows, transport.columns()), row_layout);
        let patch_rows = paged("patch", &transport.patch_from_patch)?;
        let read_rows = [
            paged("receiver", &transport.receiver_from_patch)?,
            paged("directional", &transport.directional_from_patch)?,
        ];
        let spaces = Spaces::new(gpu_ref, &transport, asked.channels(|| false))?;
        let occluders = Occluders::new(&transport);
        let mut pictures = Pictures::new(gpu_ref, compiler);
        pictures.uploads = Uploads::at_most(settings.uploads);
        let materials = Materials::new(gpu_ref, assets, &mut pictures);
        let of_shadows = ShadowsAsked {
            maps: forced(Feature::ShadowMaps),
            holes: forced(Feature::Holes),
            in_grid: !settings.no_light_grid,
        };
        let shadows = Shadows::new(gpu_ref, compiler, materials.layout(), of_shadows);
        let scene_layout = shadows.scene_layout();
        let renderer = Self {
            samples: settings.samples.unwrap_or_else(|| targets::most_samples(gpu_ref)),
            timer: Timer::new(gpu_ref),
            drawn: Arc::new(AtomicBool::new(true)),
            meshes: Meshes::new(Uploads::at_most(settings.uploads)),
            still: StillBuffers::new(gpu_ref, &transport)?,
            instances: Instances::new(gpu_ref, &transport),
            sources: Sources::new(transport.clone(), &settings, forced(Feature::CoarseCorrection)),
            direct: Direct::new(gpu_ref, compiler, [frame_layout, scene_layout], settings.patch_shadows),
            bounce: Bounce::new(gpu_ref, compiler, page, patch_rows, summed, &spaces),
            coarse: Coarse::new(gpu_ref, compiler, &spaces),
            gather: Gather::new(gpu_ref, compiler, [frame_layout, page], read_rows, summed, &spaces),
            rescale: Rescale::new(gpu_ref, compiler, &spaces),
            dering: Dering::new(gpu_ref, compiler, &spaces),
            objects: Objects::new(gpu_ref, compiler, transport.clone(), &spaces),
            reflections: Reflections::new(gpu_ref, compiler, frame_layout, &asked),
            surfaces: Surfaces::new(gpu_ref, compiler, frame_layout, scene_layout, materials.layout()),
            patches: Patches::new(gpu_ref, compiler, frame_layout),
            probes: Probes::new(gpu_ref, compiler, frame_layout),
            tetrahedra: Lines::new(gpu_ref, compiler, frame_layout),
            guides: Lines::new(gpu_ref, compiler, frame_layout),
            wireframe: Wireframe::new(gpu_ref, compiler, frame_layout),
            picking: Picking::new(gpu_ref, compiler, frame_layout),
            outline: Outline::new(gpu_ref, compiler, frame_layout),
            sky: SkyPass::new(gpu_ref, compiler, frame_layout, &pictures, asked.has(Feature::Sky, false)),
            exposure: Exposure::new(gpu_ref, compiler, frame_layout),
            tonemap: Tonemap::new(gpu_ref, compiler, frame_layout),
            overlay: Overlay::new(gpu_ref, compiler),
            frame_group: pass::buffers(gpu_ref, "frame", frame_layout, &[&frame]),
            frame,
            occluders,
            shadows,
            spaces,
            pictures,
            materials,
            target: None,
            steering: Steering::default(),
            probes_current: false,
            seen: (Seen::default(), 0),
            moved: 0,
            asked,
            responses: Responses::default(),
            turns: Turns::default(),
            transport,
            settings,
            gpu,
        };
        renderer.gpu.check()?;
        Ok(renderer)
    }

    /// Meshes, pictures and materials of what was drawn go: the next scene has none of them.
    pub fn forget(&mut self) {
        self.meshes.forget();
        self.pictures.forget();
        self.materials.forget();
    }

    /// Draws the scene as it is now into `display`.
    pub fn draw(&mut self, now: &Now<'_>, display: &wgpu::Texture) -> Result<Drawn, RenderError> {
        let gpu = &*self.gpu.clone();
        self.receive();
        self.meshes.uploads.begin();
        self.pictures.uploads.begin();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());

        // What stands where, what it is made of, what shines.
        let materials_changed = self.materials.update(gpu, now.assets, &mut self.pictures, now.scene);
        self.instances.update(gpu, now, &self.transport, &self.materials, &mut self.meshes);
        let probes_read = self.follow_probes(now.view)?;
        self.objects.update(gpu, &self.instances, &self.spaces);
        let lights = lights::placed(now, &self.instances, self.transport.origin);
        let sky = self.sky_of(now);
        let sky_changed = self.sky.update(gpu, now.assets, &mut self.pictures, &sky.kind, &lights);
        let brightest = lights::brightest(&lights).max(self.steering.brightest());
        let emitted = self.sources.update((now, &sky), materials_changed, brightest);
        let emitted = if self.follow_colour(&lights)? { emitted.and_all() } else { emitted };
        self.sources.upload(gpu, emitted, &self.spaces, &mut self.coarse)?;

        // What the lights see.
        let casters = Casters {
            instances: &self.instances,
            still: &self.still,
            meshes: &self.meshes,
            materials: &self.materials,
        };
        let aspect = display.width() as f32 / display.height().max(1) as f32;
        let camera = Camera { eye: &now.eye, origin: self.transport.origin, aspect };
        let mut recording = Recording { gpu, encoder: &mut encoder, timer: &mut self.timer };
        let shadowed = self.shadows.update(&mut recording, &lights, &casters, &camera);
        if shadowed.draws > 0 {
            pass::drawn_before_computed(gpu, &mut encoder);
        }
        let mapped = self.shadows.lights();
        let still = (&*self.transport, &self.occluders);
        let changed = (mapped, shadowed.changed);
        let lit = self.direct.follow(gpu, &self.spaces, still, &lights, &casters, changed)?;
        let uniform = self.write_frame(gpu, now, display);

        // Light on patches, then from patch to patch, then to receivers and probes.
        let transport = self.transport.clone();
        let (mut drawn, relit) = match &transport.solved {
            Some(solved) => self.responded(&mut encoder, solved, now.scene, probes_read),
            None => {
                let dark = !self.sources.shines() && !lights.iter().any(lights::shines);
                (self.light(&mut encoder, lit, emitted, dark, probes_read), false)
            }
        };

        // What reflection probes see.
        let stirred = shadowed.changed
            || materials_changed
            || lit
            || relit
            || drawn.products > 0
            || emitted != Changed::default();
        self.follow(stirred, sky_changed);
        let captured = self.reflect(gpu, &mut encoder, now, uniform, drawn.transport_dispatches == 0);
        drawn.captures = captured.faces;

        // The picture.
        drawn.shadow_draws = shadowed.draws;
        drawn.draws = shadowed.draws + captured.draws + self.paint(gpu, &mut encoder, now, display);
        drawn.passes = self.timer.count();
        self.timer.resolve(&mut encoder);
        self.drawn = Gpu::done(&encoder);
        gpu.queue.submit([encoder.finish()]);
        self.timer.sent();
        self.bounce.sent();
        self.reflections.sent();
        self.exposure.sent();
        self.finish(gpu)?;
        drawn.bound = self.bound();
        drawn.waiting = self.meshes.uploads.waiting() + self.pictures.uploads.waiting();
        Ok(drawn)
    }

    /// The scene's, unless its author does without.
    fn sky_of<'a>(&self, now: &Now<'a>) -> Cow<'a, Sky> {
        let there = self.asked.has(Feature::Sky, true);
        if there { Cow::Borrowed(&now.scene.sky) } else { Cow::Owned(Sky::default()) }
    }

    fn write_frame(&self, gpu: &Gpu, now: &Now<'_>, display: &wgpu::Texture) -> FrameUniform {
        let aspect = display.width() as f32 / display.height().max(1) as f32;
        let origin = self.transport.origin;
        let (eye, [forward, right, up]) = now.eye.rays(origin, aspect);
        let (slices, cascade_texels) = self.shadows.cascades();
        let shows_light = now.view.shows_light();
        let uniform = FrameUniform {
            clip_from_world: now.eye.clip_from_world(origin, aspect),
            eye,
            forward,
            time: now.time as f32,
            right,
            exposure: exposure::exposure(now.eye.exposure),
            up,
            view: now.view as u32,
            cascade_ends: slices.ends,
            cascade_texels,
            eye_depth: slices.eye,
            encode: u32::from(!display.format().is_srgb()),
            pre_exposure: if shows_light { exposure::pre_exposure(now.eye.exposure) } else { 1.0 },
            curve: tonemap::curve_of(now.view, now.eye.tonemap),
            capture: 0,
            light_unit: self.sources.unit(),
            directional: self.spaces.directional,
            padding: 0,
        };
        gpu.queue.write_buffer(&self.frame, 0, bytemuck::bytes_of(&uniform));
        uniform
    }

    fn finish(&mut self, gpu: &Gpu) -> Result<(), RenderError> {
        if self.settings.wait {
            gpu.wait()?;
        } else {
            // What comes of it is seen in `check`.
            let _ = gpu.device.poll(wgpu::PollType::Poll);
        }
        gpu.check()?;
        self.receive();
        Ok(())
    }

    /// What earlier frames measured.
    fn receive(&mut self) {
        self.bounce.receive().for_each(|measured| self.steering.receive(measured));
        self.reflections.receive();
        self.timer.receive();
        self.exposure.receive();
    }
}

/// What moves reads the mean of all receivers then.
fn without_probes(transport: Arc<Transport>) -> Arc<Transport> {
    Arc::new(Transport {
        probes: Vec::new(),
        depths: Depths::default(),
        probe_from_patch: Rows::default(),
        ..(*transport).clone()
    })
}

pub(super) fn layout_of_rows(asked: &Asked) -> rows::Layout {
    match asked.said(Feature::Columns) {
        Some(Forced::In) => rows::Layout::Sparse,
        Some(Forced::Out) => rows::Layout::Dense,
        None => rows::Layout::AsSuits,
    }
}
