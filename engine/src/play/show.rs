//! What is shown: time, camera, view and lights as the keys have set them.

use std::path::PathBuf;
use std::time::Instant;

use glam::DAffine3;
use winit::keyboard::KeyCode;

use super::clock::Clock;
use super::fly::Fly;
use super::{Options, World};
use crate::render::{Eye, Now, View};

pub struct Show {
    pub world: World,
    pub fly: Fly,
    pub vsync: bool,
    /// Over the picture: how it came about; the keys.
    pub overlay: bool,
    pub help: bool,
    view: View,
    /// Instead of the camera's.
    exposure: Option<f32>,
    /// Stops on top of an automatic exposure.
    compensation: f32,
    out: PathBuf,
    clock: Clock,
    last: Instant,
    screenshot: bool,
    screenshots: u32,
}

impl Show {
    pub fn new(options: &Options, world: World) -> Self {
        Self {
            fly: Fly::new(world.size),
            vsync: options.vsync,
            overlay: options.overlay,
            help: false,
            view: options.view,
            exposure: options.exposure,
            compensation: 0.0,
            out: options.out.clone().unwrap_or_else(|| PathBuf::from(".")),
            world,
            clock: Clock::new(options.fixed_dt),
            last: Instant::now(),
            screenshot: false,
            screenshots: 0,
        }
    }

    /// Time, lights and camera go on to now.
    pub fn advance(&mut self) {
        let passed = self.clock.advance(self.last.elapsed().as_secs_f64());
        self.last = Instant::now();
        self.world.follow(self.clock.time());
        let seen = self.scene_eye();
        self.fly.advance(passed, seen);
    }

    pub fn placed(&self) -> Vec<DAffine3> {
        self.world.placed_at(self.clock.time())
    }

    pub fn scene_eye(&self) -> Eye {
        self.world.eye(&self.placed())
    }

    pub fn now<'a>(&'a self, world_from_local: &'a [DAffine3]) -> Now<'a> {
        let scene_eye = self.world.eye(world_from_local);
        let mut eye = self.fly.eye.unwrap_or(scene_eye);
        eye.exposure = scene_eye.exposure;
        eye.auto_exposure = scene_eye.auto_exposure.map(|mut auto| {
            auto.compensation += self.compensation;
            auto
        });
        Now {
            scene: &self.world.scene,
            assets: &self.world.assets,
            world_from_local,
            time: self.clock.time(),
            eye: eye.exposed(self.exposure),
            view: self.view,
        }
    }

    pub fn key(&mut self, key: KeyCode) {
        match key {
            KeyCode::KeyP | KeyCode::Space => self.clock.paused = !self.clock.paused,
            KeyCode::KeyN => self.clock.step(),
            KeyCode::KeyV => self.view = self.view.next(),
            KeyCode::KeyC => self.fly.eye = None,
            KeyCode::Equal | KeyCode::NumpadAdd => self.expose(0.5),
            KeyCode::Minus | KeyCode::NumpadSubtract => self.expose(-0.5),
            KeyCode::F1 | KeyCode::Tab => self.overlay = !self.overlay,
            KeyCode::KeyH => self.help = !self.help,
            KeyCode::F2 => self.vsync = !self.vsync,
            KeyCode::F12 => self.screenshot = true,
            _ => self.switch(key),
        }
    }

    fn expose(&mut self, stops: f32) {
        let scene = self.scene_eye();
        if scene.auto_exposure.is_some() && self.exposure.is_none() {
            self.compensation += stops;
        } else {
            self.exposure = Some(self.exposure.unwrap_or(scene.exposure) + stops);
        }
    }

    fn switch(&mut self, key: KeyCode) {
        let Some(number) = NUMBERS.iter().position(|&number| number == key) else { return };
        if let Some(said) = self.world.switch(number) {
            eprintln!("{said}");
        }
    }

    /// Where the picture that was asked for goes.
    pub fn screenshot_due(&mut self) -> Option<PathBuf> {
        if !std::mem::take(&mut self.screenshot) {
            return None;
        }
        self.screenshots += 1;
        Some(self.out.join(format!("{}_{:03}.png", self.world.name, self.screenshots)))
    }

    pub fn title(&self) -> String {
        let paused = if self.clock.paused { " - paused" } else { "" };
        format!("{} - {}{paused}", self.world.name, self.view.name())
    }

    pub fn time(&self) -> f64 {
        self.clock.time()
    }
}

const NUMBERS: [KeyCode; 9] = [
    KeyCode::Digit1,
    KeyCode::Digit2,
    KeyCode::Digit3,
    KeyCode::Digit4,
    KeyCode::Digit5,
    KeyCode::Digit6,
    KeyCode::Digit7,
    KeyCode::Digit8,
    KeyCode::Digit9,
];
