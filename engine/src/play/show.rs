//! What is shown: time, camera, view and lights as the keys have set them.

use std::path::PathBuf;
use std::time::Instant;

use glam::DAffine3;
use winit::keyboard::KeyCode;

use super::fly::Fly;
use super::{Options, World};
use crate::render::{Eye, Now, View};
use crate::scene::{Changes, Entity};

pub const KEYS: &str = "\
keys: W A S D Q E fly, Shift fast, the right mouse button looks, the wheel sets the speed, C the scene's camera
      P or Space pause, N single step, 1..9 switch lights, V next view, + - exposure
      F12 screenshot, H these keys, Esc quits";

/// Motion goes in steps of this many seconds.
const STEP: f64 = 1.0 / 240.0;
const SINGLE_STEP: f64 = 1.0 / 60.0;

pub struct Show {
    pub world: World,
    pub fly: Fly,
    view: View,
    /// Instead of the camera's.
    exposure: Option<f32>,
    fixed_dt: Option<f64>,
    out: PathBuf,
    /// Of the scene, seconds; and what is left of a step.
    time: f64,
    left: f64,
    paused: bool,
    /// One step is due though it is paused.
    step: bool,
    last: Instant,
    screenshot: bool,
    screenshots: u32,
}

impl Show {
    pub fn new(options: &Options, world: World) -> Self {
        Self {
            fly: Fly::new(world.size),
            view: options.view,
            exposure: options.exposure,
            fixed_dt: options.fixed_dt,
            out: options.out.clone().unwrap_or_else(|| PathBuf::from(".")),
            world,
            time: 0.0,
            left: 0.0,
            paused: false,
            step: false,
            last: Instant::now(),
            screenshot: false,
            screenshots: 0,
        }
    }

    /// Time and camera go on to now.
    pub fn advance(&mut self) {
        // A window that was hidden for long does not jump.
        let passed = self.last.elapsed().as_secs_f64().min(0.25);
        self.last = Instant::now();
        if self.step {
            self.time += self.fixed_dt.unwrap_or(SINGLE_STEP);
        } else if !self.paused {
            self.time += self.fixed_dt.unwrap_or_else(|| whole_steps(&mut self.left, passed));
        }
        self.step = false;
        let seen = self.scene_eye();
        self.fly.advance(passed, seen);
    }

    pub fn placed(&self) -> Vec<DAffine3> {
        self.world.placed_at(self.time)
    }

    pub fn scene_eye(&self) -> Eye {
        self.world.eye(&self.placed())
    }

    pub fn now<'a>(&'a self, world_from_local: &'a [DAffine3]) -> Now<'a> {
        let scene_eye = self.world.eye(world_from_local);
        let mut eye = self.fly.eye.unwrap_or(scene_eye);
        eye.exposure = self.exposure.unwrap_or(scene_eye.exposure);
        Now {
            scene: &self.world.scene,
            assets: &self.world.assets,
            world_from_local,
            time: self.time,
            eye,
            view: self.view,
        }
    }

    pub fn key(&mut self, key: KeyCode) {
        match key {
            KeyCode::KeyP | KeyCode::Space => self.paused = !self.paused,
            KeyCode::KeyN => (self.paused, self.step) = (true, true),
            KeyCode::KeyV => self.view = self.view.next(),
            KeyCode::KeyC => self.fly.eye = None,
            KeyCode::Equal | KeyCode::NumpadAdd => self.expose(0.5),
            KeyCode::Minus | KeyCode::NumpadSubtract => self.expose(-0.5),
            KeyCode::F12 => self.screenshot = true,
            KeyCode::KeyH => eprintln!("{KEYS}"),
            _ => self.switch(key),
        }
    }

    fn expose(&mut self, stops: f32) {
        self.exposure = Some(self.exposure.unwrap_or(self.scene_eye().exposure) + stops);
    }

    /// Lights by number, in the order of the hierarchy.
    fn switch(&mut self, key: KeyCode) {
        let Some(number) = NUMBERS.iter().position(|&number| number == key) else { return };
        let mut lights = self.world.scene.entities.iter_mut().filter(|entity| entity.light.is_some());
        let Some(entity) = lights.nth(number) else { return };
        switch(entity);
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
        let paused = if self.paused { " - paused" } else { "" };
        format!("{} - {}{paused}", self.world.name, self.view.name())
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

fn switch(entity: &mut Entity) {
    let Some(light) = &mut entity.light else { return };
    if light.changes == Changes::Never {
        eprintln!("light `{}` never changes, as the scene says", entity.name);
        return;
    }
    light.on = !light.on;
    eprintln!("light `{}` is {}", entity.name, if light.on { "on" } else { "off" });
}

/// As much of the time that has passed as makes whole steps; what is left counts the next time.
fn whole_steps(left: &mut f64, passed: f64) -> f64 {
    let steps = ((*left + passed) / STEP).floor();
    *left += passed - steps * STEP;
    steps * STEP
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Light;

    #[test]
    fn time_goes_in_whole_steps_and_loses_none() {
        let mut left = 0.0;
        let sum: f64 = (0..1000).map(|_| whole_steps(&mut left, 0.0061)).sum();
        assert!((sum + left - 6.1).abs() < 1e-9);
        assert!((sum / STEP - (sum / STEP).round()).abs() < 1e-6);
    }

    #[test]
    fn a_light_that_never_changes_is_not_switched() {
        let light =
            |changes| Entity { light: Some(Light { changes, ..Light::default() }), ..Entity::default() };
        let (mut free, mut fixed) = (light(Changes::Anything), light(Changes::Never));
        switch(&mut free);
        switch(&mut fixed);
        assert!(!free.light.unwrap().on);
        assert!(fixed.light.unwrap().on);
    }
}
