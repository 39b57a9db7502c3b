//! The window: its events, and the loop that draws.

use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::DVec2;
use winit::application::ApplicationHandler;
use winit::event::{
    DeviceEvent, DeviceId, ElementState, KeyEvent, MouseButton, MouseScrollDelta, WindowEvent,
};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop};
use winit::keyboard::{KeyCode, PhysicalKey};
use winit::window::{Window, WindowId};

use super::light;
use super::lose::LoseDevice;
use super::overlay::{self, KEYS, Took};
use super::show::Show;
use super::stage::{self, Stage};
use super::statistics::Statistics;
use super::{Options, PlayError, World};
use crate::render::{Drawn, Eye};

pub fn run(options: &Options, world: World) -> Result<(), PlayError> {
    let no_window = |error: winit::error::EventLoopError| PlayError::Window(error.to_string());
    let event_loop = EventLoop::new().map_err(no_window)?;
    let mut player = Player {
        show: Show::new(options, world),
        options,
        window: None,
        stage: None,
        ended: Ok(()),
        told: None,
        began: Instant::now(),
        hidden: false,
        unshown: false,
        lost: 0,
        lose: LoseDevice::from_environment(),
        frames: 0,
        statistics: Statistics::new(options.stats.as_deref()),
    };
    eprintln!("keys: {}", KEYS.join("\n      "));
    event_loop.run_app(&mut player).map_err(no_window)?;
    let Player { show, stage, ended, statistics, .. } = player;
    let renderer = stage.as_ref().map(|stage| &stage.renderer);
    let size = stage.as_ref().map_or(options.size, Stage::size);
    let ended = ended.and_then(|()| match renderer {
        Some(renderer) => light::write(options.light.as_deref(), renderer),
        None => Ok(()),
    });
    statistics.finish(ended, renderer, &show.world, size)
}

/// How often text is renewed, and how often a hidden window looks whether it is seen again.
const NOW_AND_THEN: Duration = Duration::from_millis(250);
/// Devices lost one after the other, without a picture between them, before the player gives up.
const MOST_LOST: u32 = 3;

struct Player<'a> {
    options: &'a Options,
    show: Show,
    /// Stays when the device is lost.
    window: Option<Arc<Window>>,
    /// Gone and made anew when the device is lost.
    stage: Option<Stage>,
    ended: Result<(), PlayError>,
    /// When title and overlay were renewed.
    told: Option<Instant>,
    /// When the last picture was begun.
    began: Instant,
    /// Other windows hide it, as the system says: nothing is drawn until it says otherwise.
    hidden: bool,
    /// The last picture could not be shown: the next one waits a little.
    unshown: bool,
    lost: u32,
    lose: LoseDevice,
    frames: u64,
    statistics: Statistics<'a>,
}

impl Player<'_> {
    /// Makes what is not there: window, device, renderer.
    fn open(&mut self, event_loop: &ActiveEventLoop) -> Result<(), PlayError> {
        let window = match &self.window {
            Some(window) => window.clone(),
            None => stage::window(event_loop, self.options, &self.show.world.name)?,
        };
        self.window = Some(window.clone());
        let stage = Stage::new(event_loop, window, self.options, &self.show.world, self.show.vsync)?;
        eprintln!("{}", stage.renderer.gpu().name());
        self.stage = Some(stage);
        (self.told, self.began) = (None, Instant::now());
        Ok(())
    }

    /// A picture; where the device is lost, another device, on which the scene goes on as it was.
    fn frame(&mut self, event_loop: &ActiveEventLoop) -> Result<(), PlayError> {
        match self.picture(event_loop) {
            Err(error) if stage::is_lost(&error) && self.lost < MOST_LOST => {
                eprintln!("{error}; making another");
                self.lost += 1;
                self.stage = None;
                self.open(event_loop)
            }
            drawn => drawn,
        }
    }

    fn picture(&mut self, event_loop: &ActiveEventLoop) -> Result<(), PlayError> {
        let Some(stage) = &mut self.stage else { return Ok(()) };
        self.show.advance();
        let frame = self.began.elapsed();
        self.began = Instant::now();
        stage.set_vsync(self.show.vsync);
        self.lose.at(self.frames, stage.renderer.gpu());
        let world_from_local = self.show.placed();
        let now = self.show.now(&world_from_local);
        let eye = now.eye;
        let drawn = stage.draw(&now)?;
        self.unshown = drawn.is_none();
        let Some((drawn, cpu)) = drawn else { return Ok(()) };
        if self.frames == 0 {
            self.show.world.tell_misplaced(&stage.renderer);
        }
        if let Some(path) = self.show.screenshot_due() {
            stage.photograph(&self.show.now(&world_from_local), &path)?;
            eprintln!("{}", path.display());
        }
        let took = Took { frame, cpu: Some(cpu) };
        self.tell(&drawn, &eye, took);
        self.statistics.add(&drawn, took);
        (self.lost, self.frames) = (0, self.frames + 1);
        if self.options.frames.is_some_and(|frames| self.frames >= frames) {
            event_loop.exit();
        }
        Ok(())
    }

    /// A few times a second: the title, and what is written over the picture.
    fn tell(&mut self, drawn: &Drawn, eye: &Eye, took: Took) {
        if self.told.is_some_and(|told| told.elapsed() < NOW_AND_THEN) {
            return;
        }
        self.told = Some(Instant::now());
        let Some(stage) = &mut self.stage else { return };
        let title = self.show.title();
        stage.window.set_title(&title);
        let mut lines = Vec::new();
        if self.show.help {
            lines.extend(KEYS.map(str::to_owned));
        } else if self.show.overlay {
            let title = format!("{title} - {:.1} s", self.show.time());
            lines = overlay::told(&title, took, drawn, eye, &stage.renderer, &self.show.world);
            lines.push(format!("vsync {} - H lists the keys", if self.show.vsync { "on" } else { "off" }));
        }
        let scale = stage.window.scale_factor().round().max(1.0) as u32;
        stage.renderer.overlay.show(lines, scale);
    }

    fn key(&mut self, event_loop: &ActiveEventLoop, event: &KeyEvent) {
        let PhysicalKey::Code(key) = event.physical_key else { return };
        let down = event.state == ElementState::Pressed;
        self.show.fly.key(key, down);
        if !down || event.repeat {
            return;
        }
        self.told = None;
        match (key, &self.stage) {
            (KeyCode::Escape, _) => event_loop.exit(),
            (KeyCode::F9, Some(stage)) => stage.lose_device(),
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
        if result.is_err() {
            self.ended = result;
            event_loop.exit();
        }
    }
}

impl ApplicationHandler for Player<'_> {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.stage.is_none() {
            let opened = self.open(event_loop);
            self.check(event_loop, opened);
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        match event {
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::Occluded(hidden) => self.hidden = hidden,
            WindowEvent::Resized(size) => {
                self.unshown = false;
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

    /// The next picture at once where it is seen; a hidden window sleeps, and looks now and then.
    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        let Some(stage) = &self.stage else { return };
        let waits = self.unshown && self.began.elapsed() < NOW_AND_THEN;
        if stage.is_seen() && !self.hidden && !waits {
            event_loop.set_control_flow(ControlFlow::Wait);
            stage.window.request_redraw();
        } else {
            event_loop.set_control_flow(ControlFlow::WaitUntil(Instant::now() + NOW_AND_THEN));
        }
    }
}
