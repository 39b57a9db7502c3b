//! Pictures without a window, for tests.

use std::cell::RefCell;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use engine::gpu::{Gpu, texture};
use engine::render::{Asked, Drawn, Eye, Now, Renderer, Settings, View};
use engine::scene::assets::Assets;
use engine::scene::{Feature, Forced, Scene, world_from_local};
use engine::transport::Transport;
use glam::Vec3;

/// Held by the one test that draws.
static TURN: Mutex<()> = Mutex::new(());

thread_local! {
    static MINE: RefCell<Option<MutexGuard<'static, ()>>> = const { RefCell::new(None) };
}

/// `None`, said in one line, where the machine has no GPU adapter at all. Tests draw one after the other: a driver
/// was seen to hang when sixteen of them made devices at once. The turn ends with the test's thread.
pub fn gpu() -> Option<Gpu> {
    MINE.with_borrow_mut(|mine| {
        mine.get_or_insert_with(|| TURN.lock().unwrap_or_else(PoisonError::into_inner));
    });
    match Gpu::headless() {
        Ok(gpu) => Some(gpu),
        Err(engine::gpu::GpuError::NoAdapter) => {
            println!("not run: no GPU adapter");
            None
        }
        Err(error) => panic!("{error}"),
    }
}

/// A renderer, and what it draws into.
pub struct Studio {
    pub renderer: Renderer,
    pub display: wgpu::Texture,
    pub eye: Eye,
    pub assets: Assets,
}

impl Studio {
    /// One sample a pixel, so that radiance can be read; pictures repeat.
    pub fn new(gpu: Gpu, transport: Transport, eye: Eye, size: [u32; 2]) -> Self {
        Self::with(gpu, transport, eye, size, Settings { samples: Some(1), ..Settings::default() })
    }

    pub fn with(gpu: Gpu, transport: Transport, eye: Eye, size: [u32; 2], settings: Settings) -> Self {
        Self::asked(gpu, transport, eye, size, settings, &[])
    }

    /// Where the author has spoken of features.
    pub fn asked(
        gpu: Gpu,
        transport: Transport,
        eye: Eye,
        size: [u32; 2],
        settings: Settings,
        said: &[(Feature, Forced)],
    ) -> Self {
        Self::heeding(gpu, transport, eye, size, settings, Asked::new(&said.iter().copied().collect()))
    }

    /// Where he has also made promises.
    pub fn heeding(
        gpu: Gpu,
        transport: Transport,
        eye: Eye,
        size: [u32; 2],
        settings: Settings,
        asked: Asked,
    ) -> Self {
        let gpu = Arc::new(gpu);
        let display = texture::target(&gpu, "display", size, 1, wgpu::TextureFormat::Rgba8UnormSrgb);
        let assets = Assets::default();
        let settings = Settings { wait: true, ..settings };
        let renderer = Renderer::asked(gpu, Arc::new(transport), &assets, settings, asked).unwrap();
        Self { renderer, display, eye, assets }
    }

    /// Bytes on the GPU of a kind.
    pub fn bytes(&self, kind: &str) -> u64 {
        let found = self.renderer.bytes().into_iter().find(|(name, _)| *name == kind);
        found.unwrap_or_else(|| panic!("no {kind}")).1
    }

    pub fn draw(&mut self, scene: &Scene, view: View) -> Drawn {
        self.draw_at(scene, view, 0.0)
    }

    pub fn draw_at(&mut self, scene: &Scene, view: View, time: f64) -> Drawn {
        let world = world_from_local(scene);
        let now = Now { scene, assets: &self.assets, world_from_local: &world, time, eye: self.eye, view };
        self.renderer.draw(&now, &self.display).unwrap()
    }

    /// Until the light is solved.
    pub fn settle(&mut self, scene: &Scene, view: View) -> Drawn {
        for _ in 0..200 {
            let drawn = self.draw(scene, view);
            if drawn.transport_dispatches == 0 {
                return drawn;
            }
        }
        panic!("the light does not settle: {:?}", self.draw(scene, view));
    }

    /// Radiance before the tonemap, rows from the top.
    pub fn radiance(&self) -> Vec<Vec3> {
        radiance_of(&self.renderer)
    }

    pub fn radiance_at(&self, x: u32, y: u32) -> Vec3 {
        self.radiance()[(y * self.display.width() + x) as usize]
    }

    /// 8 bits RGBA.
    pub fn pixels(&self) -> Vec<u8> {
        texture::read(self.renderer.gpu(), &self.display, 4).unwrap()
    }

    pub fn save(&self, path: &std::path::Path) {
        let (width, height) = (self.display.width(), self.display.height());
        image::save_buffer(path, &self.pixels(), width, height, image::ExtendedColorType::Rgba8).unwrap();
    }
}

/// Radiance of the last frame before the tonemap, rows from the top.
pub fn radiance_of(renderer: &Renderer) -> Vec<Vec3> {
    let targets = renderer.targets().expect("a frame was drawn");
    let bytes = texture::read(renderer.gpu(), &targets.radiance, 8).unwrap();
    let halves = bytes.chunks_exact(2).map(|pair| texture::single(u16::from_le_bytes([pair[0], pair[1]])));
    let pre_exposure = renderer.exposed().unwrap().pre_exposure;
    let values: Vec<f32> = halves.map(|half| half / pre_exposure).collect();
    values.chunks_exact(4).map(|texel| Vec3::new(texel[0], texel[1], texel[2])).collect()
}
