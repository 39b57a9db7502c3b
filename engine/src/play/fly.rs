//! A camera that flies: W A S D along its own axes, Q down and E up, the mouse turns it while its right button
//! is down, the wheel sets the speed, Shift flies five times as fast.

use glam::{DQuat, DVec2, DVec3};
use winit::keyboard::KeyCode;

use crate::render::Eye;

pub struct Fly {
    /// Where it is, once it was moved; until then the scene's camera is looked through.
    pub eye: Option<Eye>,
    /// Metres a second.
    speed: f64,
    pressed: Vec<KeyCode>,
    pub looking: bool,
}

/// Radians a pixel.
const TURN: f64 = 0.003;
const KEYS: [(KeyCode, DVec3); 6] = [
    (KeyCode::KeyW, DVec3::NEG_Z),
    (KeyCode::KeyS, DVec3::Z),
    (KeyCode::KeyA, DVec3::NEG_X),
    (KeyCode::KeyD, DVec3::X),
    (KeyCode::KeyQ, DVec3::NEG_Y),
    (KeyCode::KeyE, DVec3::Y),
];
const FAST: [KeyCode; 2] = [KeyCode::ShiftLeft, KeyCode::ShiftRight];

impl Fly {
    /// Crosses a scene of this size (metres) in about six seconds.
    pub fn new(size: f64) -> Self {
        Self { eye: None, speed: (size / 6.0).clamp(0.05, 1e4), pressed: Vec::new(), looking: false }
    }

    pub fn key(&mut self, key: KeyCode, down: bool) {
        self.pressed.retain(|&pressed| pressed != key);
        if down {
            self.pressed.push(key);
        }
    }

    /// All keys are up: the window has lost them.
    pub fn release(&mut self) {
        self.pressed.clear();
        self.looking = false;
    }

    pub fn wheel(&mut self, notches: f64) {
        self.speed = (self.speed * 1.2_f64.powf(notches.clamp(-20.0, 20.0))).clamp(1e-3, 1e5);
    }

    /// The mouse has moved so many pixels.
    pub fn turn(&mut self, pixels: DVec2, seen: Eye) {
        if !self.looking {
            return;
        }
        let mut eye = self.eye.unwrap_or(seen);
        let forward = eye.rotation * DVec3::NEG_Z;
        let yaw = (-forward.x).atan2(-forward.z) - pixels.x * TURN;
        let pitch = (forward.y.clamp(-1.0, 1.0).asin() - pixels.y * TURN).clamp(-1.55, 1.55);
        eye.rotation = DQuat::from_rotation_y(yaw) * DQuat::from_rotation_x(pitch);
        self.eye = Some(eye);
    }

    /// Flies on for so many seconds.
    pub fn advance(&mut self, seconds: f64, seen: Eye) {
        let way: DVec3 = KEYS.iter().filter(|(key, _)| self.pressed.contains(key)).map(|(_, way)| *way).sum();
        if way == DVec3::ZERO {
            return;
        }
        let fast = if FAST.iter().any(|key| self.pressed.contains(key)) { 5.0 } else { 1.0 };
        let mut eye = self.eye.unwrap_or(seen);
        eye.position += eye.rotation * way.normalize() * (self.speed * fast * seconds);
        self.eye = Some(eye);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen() -> Eye {
        Eye::looking(DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO)
    }

    #[test]
    fn w_flies_to_where_it_looks_and_shift_is_faster() {
        let mut fly = Fly::new(6.0);
        fly.advance(1.0, seen());
        assert_eq!(fly.eye, None);
        fly.key(KeyCode::KeyW, true);
        fly.advance(1.0, seen());
        assert!(fly.eye.unwrap().position.abs_diff_eq(DVec3::new(0.0, 0.0, 4.0), 1e-9));
        fly.key(KeyCode::ShiftLeft, true);
        fly.advance(1.0, seen());
        assert!(fly.eye.unwrap().position.abs_diff_eq(DVec3::new(0.0, 0.0, -1.0), 1e-9));
    }

    #[test]
    fn the_mouse_turns_only_while_its_button_is_down_and_never_over_the_top() {
        let mut fly = Fly::new(6.0);
        fly.turn(DVec2::new(100.0, 0.0), seen());
        assert_eq!(fly.eye, None);
        fly.looking = true;
        fly.turn(DVec2::new(100.0, 0.0), seen());
        let forward = fly.eye.unwrap().rotation * DVec3::NEG_Z;
        assert!(forward.x > 0.29 && forward.z < 0.0);
        fly.turn(DVec2::new(0.0, -1e6), seen());
        let forward = fly.eye.unwrap().rotation * DVec3::NEG_Z;
        assert!(forward.y > 0.99 && forward.is_finite());
    }
}
