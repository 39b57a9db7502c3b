//! Window, surface, device and renderer.

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use winit::dpi::PhysicalSize;
use winit::event_loop::ActiveEventLoop;
use winit::window::{CursorGrabMode, Window};

use super::headless::save;
use super::{Options, PlayError, World};
use crate::gpu::{Gpu, GpuError, texture};
use crate::render::{Drawn, Now, Renderer, Settings};

pub struct Stage {
    pub window: Arc<Window>,
    instance: wgpu::Instance,
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    gpu: Arc<Gpu>,
    pub renderer: Renderer,
}

/// The window is to be opened.
pub fn window(
    event_loop: &ActiveEventLoop,
    options: &Options,
    title: &str,
) -> Result<Arc<Window>, PlayError> {
    let [width, height] = options.size;
    let size = PhysicalSize::new(width, height);
    let attributes = Window::default_attributes().with_title(title).with_inner_size(size);
    let window = event_loop.create_window(attributes);
    Ok(Arc::new(window.map_err(|error| PlayError::Window(error.to_string()))?))
}

impl Stage {
    /// A device and all that lives on it, for a window that is there.
    pub fn new(
        event_loop: &ActiveEventLoop,
        window: Arc<Window>,
        options: &Options,
        world: &World,
        vsync: bool,
    ) -> Result<Self, PlayError> {
        let no_window = |error: String| PlayError::Window(error);
        let display = Box::new(event_loop.owned_display_handle());
        let descriptor = wgpu::InstanceDescriptor::new_with_display_handle(display).with_env();
        let instance = wgpu::Instance::new(descriptor);
        let surface =
            instance.create_surface(window.clone()).map_err(|error| no_window(error.to_string()))?;
        let gpu = Arc::new(Gpu::open(&instance, Some(&surface))?);
        let size = window.inner_size();
        let mut config = surface
            .get_default_config(&gpu.adapter, size.width.max(1), size.height.max(1))
            .ok_or_else(|| no_window(format!("{} shows no pictures in this window", gpu.name())))?;
        let formats = surface.get_capabilities(&gpu.adapter).formats;
        config.format = formats.into_iter().find(|format| format.is_srgb()).unwrap_or(config.format);
        config.present_mode = present_mode(vsync);
        surface.configure(&gpu.device, &config);
        let settings = Settings {
            wait: options.fixed_dt.is_some(),
            unlimited_gain: world.unlimited_gain,
            products: options.products,
            ..Settings::default()
        };
        world.cubemaps.prepare(&gpu, world, settings)?;
        let mut renderer = world.renderer(&gpu, settings)?;
        renderer.give_cubemaps(world.cubemaps.load(&world.scene));
        Ok(Self { window, instance, surface, config, gpu, renderer })
    }

    pub fn size(&self) -> [u32; 2] {
        [self.config.width, self.config.height]
    }

    /// A window that is minimised has no size; its surface keeps the last one.
    pub fn resize(&mut self, width: u32, height: u32) {
        if width > 0 && height > 0 {
            (self.config.width, self.config.height) = (width, height);
            self.surface.configure(&self.gpu.device, &self.config);
        }
    }

    pub fn set_vsync(&mut self, vsync: bool) {
        if self.config.present_mode != present_mode(vsync) {
            self.config.present_mode = present_mode(vsync);
            self.surface.configure(&self.gpu.device, &self.config);
        }
    }

    /// Whether somebody could see a picture. Not every system knows.
    pub fn is_seen(&self) -> bool {
        let size = self.window.inner_size();
        let has_size = size.width > 0 && size.height > 0;
        has_size && self.window.is_minimized() != Some(true) && self.window.is_visible() != Some(false)
    }

    /// What the picture came to, and how long it took without the wait for the display. `None`: the window shows
    /// nothing now.
    pub fn draw(&mut self, now: &Now<'_>) -> Result<Option<(Drawn, Duration)>, PlayError> {
        let Some(picture) = self.next_picture()? else { return Ok(None) };
        let since = Instant::now();
        let drawn = self.renderer.draw(now, &picture.texture)?;
        let took = since.elapsed();
        self.window.pre_present_notify();
        self.gpu.queue.present(picture);
        Ok(Some((drawn, took)))
    }

    /// To draw into. A window that changed gets new ones, once.
    fn next_picture(&mut self) -> Result<Option<wgpu::SurfaceTexture>, PlayError> {
        use wgpu::CurrentSurfaceTexture as Current;
        for _ in 0..2 {
            match self.surface.get_current_texture() {
                Current::Success(picture) | Current::Suboptimal(picture) => return Ok(Some(picture)),
                Current::Timeout | Current::Occluded => return Ok(None),
                Current::Outdated => {
                    self.gpu.check()?;
                    self.surface.configure(&self.gpu.device, &self.config);
                }
                Current::Validation | Current::Lost => {
                    // Only now does a device that is lost say so.
                    self.gpu.wait()?;
                    self.renew_surface()?;
                }
            }
        }
        Ok(None)
    }

    /// The device is well, but the window's pictures are lost.
    fn renew_surface(&mut self) -> Result<(), PlayError> {
        let renewed = self.instance.create_surface(self.window.clone());
        self.surface = renewed.map_err(|error| PlayError::Window(error.to_string()))?;
        self.surface.configure(&self.gpu.device, &self.config);
        Ok(())
    }

    /// As when the driver is reset.
    pub fn lose_device(&self) {
        self.gpu.device.destroy();
    }

    /// The same once more, into a file.
    pub fn photograph(&mut self, now: &Now<'_>, path: &Path) -> Result<(), PlayError> {
        let format = wgpu::TextureFormat::Rgba8UnormSrgb;
        let display = texture::target(&self.gpu, "screenshot", self.size(), 1, format);
        self.renderer.draw(now, &display)?;
        save(&self.gpu, &display, path)
    }

    /// Keeps the cursor in its place while it turns the camera; where the system cannot, it roams.
    pub fn hold_cursor(&self, hold: bool) {
        let modes: &[CursorGrabMode] =
            if hold { &[CursorGrabMode::Locked, CursorGrabMode::Confined] } else { &[CursorGrabMode::None] };
        let _ = modes.iter().any(|&mode| self.window.set_cursor_grab(mode).is_ok());
        self.window.set_cursor_visible(!hold);
    }
}

/// Whether the error is one that a new device gets over.
pub fn is_lost(error: &PlayError) -> bool {
    matches!(error, PlayError::Render(crate::render::RenderError::Gpu(GpuError::Lost(_))))
}

fn present_mode(vsync: bool) -> wgpu::PresentMode {
    if vsync { wgpu::PresentMode::AutoVsync } else { wgpu::PresentMode::AutoNoVsync }
}
