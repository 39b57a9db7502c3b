//! The engine in the editor: one renderer on the window's own device, and pictures that it draws for panels. A picture is
//! drawn again only where it would come out otherwise: something in it changed, or its light has not settled yet.

pub mod cube;
pub mod grid;
pub mod marks;

use std::collections::HashMap;
use std::sync::Arc;
use std::thread::{self, ThreadId};
use std::time::{Duration, Instant};

use eframe::egui_wgpu::RenderState;
use eframe::{egui, wgpu};
use egui::{TextureId, Vec2};
use engine::gpu::{Gpu, texture};
use engine::play::world::placed_at;
use engine::render::outline::Marks;
use engine::render::{Asked, Drawn, Eye, Now, RenderError, Renderer, Settings, View};
use engine::scene::assets::Assets;
use engine::scene::{EntityId, Scene};
use engine::transport::Transport;
use engine::transport::reflection::Cube;
use glam::DVec3;

use crate::job::Job;

/// egui shows textures as they are stored.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
/// An eye that adapts by itself is watched for so long after the last change.
const ADAPTS: Duration = Duration::from_secs(3);

/// Bytes of meshes, and as many of pictures, that one picture brings to the GPU.
const UPLOADS: u64 = 24 << 20;

/// The renderer, and what it lights scenes with.
pub struct Stage {
    state: RenderState,
    gpu: Arc<Gpu>,
    pub renderer: Renderer,
    transport: Arc<Transport>,
    settings: Settings,
    /// What the author says of features.
    features: Asked,
    /// The renderer that follows.
    coming: Option<Job<Result<Ready, RenderError>>>,
    made_on: ThreadId,
    /// Of the editor.
    picture: u64,
    /// What was drawn last stays.
    is_held: bool,
    drawing: Duration,
}

/// What a renderer is made of besides its device.
pub struct Plan {
    pub transport: Arc<Transport>,
    pub assets: Arc<Assets>,
    pub settings: Settings,
    /// What the author says of features.
    pub features: Asked,
    /// Of reflection probes, as they were baked.
    pub cubemaps: HashMap<EntityId, Cube>,
}

/// A renderer that has drawn its first pictures.
pub struct Ready {
    renderer: Renderer,
    settings: Settings,
    features: Asked,
    made_on: ThreadId,
}

impl Ready {
    /// Takes its time: for a thread that nobody waits for.
    pub fn make(gpu: &Arc<Gpu>, plan: Plan, scene: &Scene, eye: Eye) -> Result<Self, RenderError> {
        let Plan { transport, assets, settings, features, cubemaps } = plan;
        let settings = Settings { uploads: Some(UPLOADS), ..settings };
        let mut renderer = Renderer::asked(gpu.clone(), transport, &assets, settings, features.clone())?;
        renderer.give_cubemaps(cubemaps);
        warm(&mut renderer, gpu, scene, &assets, eye)?;
        Ok(Self { renderer, settings, features, made_on: thread::current().id() })
    }
}

/// A new renderer draws so often, in small, before it is shown: pipelines are made, meshes lie on the GPU, light has come
/// to rest.
const FIRST_PICTURES: usize = 24;
const SMALL: [u32; 2] = [96, 54];

impl Stage {
    pub fn new(
        state: &RenderState,
        transport: Arc<Transport>,
        assets: &Assets,
        (settings, features): (Settings, Asked),
    ) -> Result<Self, RenderError> {
        let gpu = Gpu::from_device(state.adapter.clone(), state.device.clone(), state.queue.clone())?;
        let gpu = Arc::new(gpu);
        let settings = Settings { uploads: Some(UPLOADS), ..settings };
        let renderer = Renderer::asked(gpu.clone(), transport.clone(), assets, settings, features.clone())?;
        Ok(Self {
            state: state.clone(),
            gpu,
            renderer,
            transport,
            settings,
            features,
            coming: None,
            made_on: thread::current().id(),
            picture: 0,
            is_held: false,
            drawing: Duration::ZERO,
        })
    }

    /// Another picture of the editor.
    pub fn begin(&mut self, picture: u64) {
        self.picture = picture;
    }

    /// Something is to be submitted as soon as what was drawn is done: nothing is drawn that it would wait for as well.
    pub fn hold(&mut self, is_held: bool) {
        self.is_held = is_held;
    }

    /// What the processor needed for all that was drawn so far; a driver that draws on it is waited for there.
    pub fn drawing(&self) -> Duration {
        self.drawing
    }

    /// Where the renderer was made: on the window's own thread only the first.
    pub fn made_on(&self) -> ThreadId {
        self.made_on
    }

    /// Another renderer takes over, and one that was to come is given up.
    pub fn show(&mut self, ready: Ready) {
        let Ready { renderer, settings, features, made_on } = ready;
        self.transport = renderer.transport().clone();
        (self.renderer, self.settings, self.features) = (renderer, settings, features);
        (self.made_on, self.coming) = (made_on, None);
    }

    pub fn gpu(&self) -> &Arc<Gpu> {
        &self.gpu
    }

    pub fn transport(&self) -> &Arc<Transport> {
        &self.transport
    }

    /// World coordinates of the renderer are relative to it.
    pub fn origin(&self) -> DVec3 {
        self.transport.origin
    }

    /// Another bake is to light the scene. Its renderer is made on a thread of its own, and the one that is there draws
    /// on until [`Self::take_relit`] finds it ready. One that was still to come is given up.
    pub fn relight(
        &mut self,
        transport: Arc<Transport>,
        scene: Scene,
        assets: Arc<Assets>,
        eye: Eye,
    ) -> std::io::Result<()> {
        let (gpu, settings, features) = (self.gpu.clone(), self.settings, self.features.clone());
        let plan = Plan { transport, assets, settings, features, cubemaps: HashMap::new() };
        let make = move || Ready::make(&gpu, plan, &scene, eye);
        self.coming = Some(Job::start("relight", make)?);
        Ok(())
    }

    /// Another renderer is on its way.
    pub fn is_relighting(&self) -> bool {
        self.coming.is_some()
    }

    /// The renderer that is ready takes over; what could not be made is an error, and the one before stays.
    pub fn take_relit(&mut self) -> Option<Result<(), String>> {
        let made = self.coming.as_mut()?.poll()?;
        self.coming = None;
        Some(match made {
            Ok(Ok(ready)) => {
                self.show(ready);
                Ok(())
            }
            Ok(Err(error)) => Err(error.to_string()),
            Err(panicked) => Err(panicked),
        })
    }
}

fn warm(
    renderer: &mut Renderer,
    gpu: &Gpu,
    scene: &Scene,
    assets: &Assets,
    eye: Eye,
) -> Result<(), RenderError> {
    let display = texture::target(gpu, "first pictures", SMALL, 1, FORMAT);
    let world_from_local = placed_at(scene, assets, 0.0);
    let view = View::Composite;
    let now = Now { scene, assets, world_from_local: &world_from_local, time: 0.0, eye, view };
    for _ in 0..FIRST_PICTURES {
        if renderer.draw(&now, &display)?.is_settled() {
            break;
        }
    }
    Ok(())
}

/// All that tells one picture from another.
#[derive(Clone, Debug, PartialEq)]
struct Shown {
    /// Of the scene.
    revision: u64,
    time: f64,
    eye: Eye,
    view: View,
    marks: Marks,
    size: [u32; 2],
}

/// A picture in a panel.
#[derive(Default)]
pub struct Picture {
    /// Pictures that are drawn in turn each have one of their own.
    number: u32,
    texture: Option<(wgpu::Texture, TextureId)>,
    shown: Option<Shown>,
    changed: Option<Instant>,
    settled: bool,
    /// The picture of the editor for which it was drawn last.
    shown_in: u64,
    /// What the last one came to.
    pub drawn: Drawn,
    /// What the processor needed for the last one.
    pub took: Duration,
    /// How many there were.
    pub count: u64,
    pub error: Option<String>,
}

impl Picture {
    pub fn numbered(number: u32) -> Self {
        Self { number, ..Self::default() }
    }

    /// Pixels of a picture that fills so many points.
    pub fn pixels(gpu: &Gpu, points: Vec2, pixels_per_point: f32) -> [u32; 2] {
        let most = gpu.device.limits().max_texture_dimension_2d;
        let side = |points: f32| ((points * pixels_per_point).round() as u32).clamp(1, most);
        [side(points.x), side(points.y)]
    }

    /// The picture of the scene as it is now. `None`: nothing could be drawn yet, `error` says why.
    pub fn show(
        &mut self,
        stage: &mut Stage,
        now: &Now<'_>,
        revision: u64,
        marks: &Marks,
        size: [u32; 2],
    ) -> Option<TextureId> {
        if stage.is_held && self.fits(size) {
            return self.texture.as_ref().map(|(_, id)| *id);
        }
        let shown =
            Shown { revision, time: now.time, eye: now.eye, view: now.view, marks: marks.clone(), size };
        let differs = self.shown.as_ref() != Some(&shown);
        if differs {
            self.changed = Some(Instant::now());
        }
        // A panel that did not fit is laid out once more in the same picture of the editor.
        let again = self.shown_in == stage.picture;
        if differs || !self.settled && !again {
            self.shown_in = stage.picture;
            self.fit(stage, size);
            self.draw(stage, now, marks);
            self.shown = Some(shown);
            let adapts = now.eye.auto_exposure.is_some()
                && self.changed.is_some_and(|changed| changed.elapsed() < ADAPTS);
            self.settled = self.error.is_some() || self.drawn.is_settled() && !adapts;
        }
        self.texture.as_ref().map(|(_, id)| *id)
    }

    /// Another picture is due soon, though nothing changes.
    pub fn is_settled(&self) -> bool {
        self.settled
    }

    /// The next one is drawn whatever changed: the stage is another.
    pub fn forget(&mut self) {
        self.shown = None;
    }

    fn fits(&self, size: [u32; 2]) -> bool {
        self.texture.as_ref().is_some_and(|(texture, _)| [texture.width(), texture.height()] == size)
    }

    fn fit(&mut self, stage: &Stage, size: [u32; 2]) {
        if self.fits(size) {
            return;
        }
        let texture = texture::target(&stage.gpu, "picture", size, 1, FORMAT);
        let view = texture.create_view(&Default::default());
        let mut renderer = stage.state.renderer.write();
        let filter = wgpu::FilterMode::Nearest;
        let id = match &self.texture {
            Some((_, id)) => {
                renderer.update_egui_texture_from_wgpu_texture(&stage.gpu.device, &view, filter, *id);
                *id
            }
            None => renderer.register_native_texture(&stage.gpu.device, &view, filter),
        };
        self.texture = Some((texture, id));
    }

    fn draw(&mut self, stage: &mut Stage, now: &Now<'_>, marks: &Marks) {
        let Some((texture, _)) = &self.texture else { return };
        let since = Instant::now();
        stage.renderer.turn_to(self.number);
        stage.renderer.mark(marks);
        match stage.renderer.draw(now, texture) {
            Ok(drawn) => (self.drawn, self.error) = (drawn, None),
            Err(error) => self.error = Some(error.to_string()),
        }
        self.took = since.elapsed();
        stage.drawing += self.took;
        self.count += 1;
    }
}
