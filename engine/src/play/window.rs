//! The window: its events, and the loop that draws.

use std::time::{Duration, Instant};

use glam::DVec2;
use winit::application::ApplicationHandler;
use winit::event::{
    DeviceEvent, DeviceId, ElementState, KeyEvent, MouseButton, MouseScrollDelta, WindowEvent,
};
use winit::event_loop::{ActiveEventLoop, EventLoop};
use winit::keyboard::{KeyCode, PhysicalKey};
use winit::window::WindowId;

use super::show::{KEYS, Show};
use super::stage::Stage;
use super::statistics::Statistics;
use super::{Options, PlayError, World};
use crate::gpu::GpuError;
use crate::render::{Drawn, RenderError};

pub fn run(options: &Options, world: World) -> Result<(), PlayError> {
    let no_window = |error: winit::error::EventLoopError| PlayError::Window(error.to_string());
    let event_loop = EventLoop::new().map_err(no_window)?;
    let mut player = Player {
        show: Show::new(options, world),
        options: options.clone(),
        stage: None,
        failed: None,
        titled: Instant::now(),
        frames: 0,
        statistics: Statistics::default(),
    };
    eprintln!("{KEYS}");
    event_loop.run_app(&mut player).map_err(no_window)?;
    match (player.failed, &options.stats, &player.stage) {
        (Some(error), _, _) => Err(error),
        (None, Some(path), Some(stage)) => player.statistics.write(path, &stage.renderer, stage.size()),
        (None, _, _) => Ok(()),
    }
}

struct Player {
    options: Options,
    show: Show,
    /// Gone and made anew when the device is lost.
    stage: Option<Stage>,
    failed: Option<PlayError>,
    titled: Instant,
    frames: u64,
    statistics: Statistics,
}

impl Player {
    fn frame(&mut self, event_loop: &ActiveEventLoop) -> Result<(), PlayError> {
        self.show.advance();
        let Some(stage) = &mut self.stage else { return Ok(()) };
        let since = Instant::now();
        let world_from_local = self.show.placed();
        let drawn = match stage.draw(&self.show.now(&world_from_local)) {
            Err(PlayError::Render(RenderError::Gpu(GpuError::Lost(why)))) => {
                eprintln!("the GPU device was lost ({why}); making another");
                self.stage = None;
                self.stage = Some(Stage::new(event_loop, &self.options, &self.show.world)?);
                return Ok(());
            }
            drawn => drawn?,
        };
        if let Some(path) = self.show.screenshot_due() {
            stage.photograph(&self.show.now(&world_from_local), &path)?;
            eprintln!("{}", path.display());
        }
        // Nothing is drawn while the window is hidden.
        let Some(drawn) = drawn else { return Ok(()) };
        self.title(&drawn, since.elapsed());
        self.statistics.add(drawn, since.elapsed());
        self.frames += 1;
        if self.options.frames.is_some_and(|frames| self.frames >= frames) {
            event_loop.exit();
        }
        Ok(())
    }

    /// A few times a second.
    fn title(&mut self, drawn: &Drawn, took: Duration) {
        if self.titled.elapsed() < Duration::from_millis(300) {
            return;
        }
        self.titled = Instant::now();
        let bound = drawn.bound.map_or("-".to_owned(), |bound| format!("{:.2} %", bound * 100.0));
        let text = format!(
            "{} - {:.1} ms - light within {bound} - {} dispatches",
            self.show.title(),
            took.as_secs_f64() * 1e3,
            drawn.transport_dispatches
        );
        if let Some(stage) = &self.stage {
            stage.window.set_title(&text);
        }
    }

    fn key(&mut self, event_loop: &ActiveEventLoop, event: &KeyEvent) {
        let PhysicalKey::Code(key) = event.physical_key else { return };
        let down = event.state == ElementState::Pressed;
        self.show.fly.key(key, down);
        if !down || event.repeat {
            return;
        }
        match key {
            KeyCode::Escape => event_loop.exit(),
            _ => self.show.key(key),
        }
    }

    fn mouse(&mut self, button: MouseButton, state: ElementState) {
        if button == MouseButton::Right {
            self.show.fly.looking = state == ElementState::Pressed;
            if let Some(stage) = &self.stage {
                stage.hold_cursor(self.show.fly.looking);
            }
        }
    }

    /// Ends the loop with an error.
    fn check(&mut self, event_loop: &ActiveEventLoop, result: Result<(), PlayError>) {
        if let Err(error) = result {
            self.failed = Some(error);
            event_loop.exit();
        }
    }
}

impl ApplicationHandler for Player {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.stage.is_some() {
            return;
        }
        match Stage::new(event_loop, &self.options, &self.show.world) {
            Ok(stage) => {
                eprintln!("{}", stage.renderer.gpu().name());
                self.stage = Some(stage);
            }
            Err(error) => self.check(event_loop, Err(error)),
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        match event {
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::Resized(size) => {
                if let Some(stage) = &mut self.stage {
                    stage.resize(size.width, size.height);
                }
            }
            WindowEvent::Focused(false) => {
                self.show.fly.release();
                if let Some(stage) = &self.stage {
                    stage.hold_cursor(false);
                }
            }
            WindowEvent::KeyboardInput { event, .. } => self.key(event_loop, &event),
            WindowEvent::MouseInput { button, state, .. } => self.mouse(button, state),
            WindowEvent::MouseWheel { delta, .. } => self.show.fly.wheel(match delta {
                MouseScrollDelta::LineDelta(_, lines) => f64::from(lines),
                MouseScrollDelta::PixelDelta(pixels) => pixels.y / 40.0,
            }),
            WindowEvent::RedrawRequested => {
                let result = self.frame(event_loop);
                self.check(event_loop, result);
            }
            _ => {}
        }
    }

    fn device_event(&mut self, _: &ActiveEventLoop, _: DeviceId, event: DeviceEvent) {
        if let DeviceEvent::MouseMotion { delta: (x, y) } = event {
            let seen = self.show.scene_eye();
            self.show.fly.turn(DVec2::new(x, y), seen);
        }
    }

    fn about_to_wait(&mut self, _: &ActiveEventLoop) {
        if let Some(stage) = &self.stage {
            stage.window.request_redraw();
        }
    }
}
