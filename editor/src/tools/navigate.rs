//! The mouse and the keys that move the scene view's camera.
//!
//! Right button: look about, and fly with W A S D Q E, the wheel sets the speed, Shift flies faster. Alt and left button:
//! orbit. Middle button: pan. Alt and right button, or the wheel: nearer and farther.

use eframe::egui;
use egui::{Key, PointerButton, Response, Ui, Vec2};
use glam::{DVec2, DVec3};

use crate::camera::ViewCamera;

const KEYS: [(Key, DVec3); 6] = [
    (Key::W, DVec3::NEG_Z),
    (Key::S, DVec3::Z),
    (Key::A, DVec3::NEG_X),
    (Key::D, DVec3::X),
    (Key::Q, DVec3::NEG_Y),
    (Key::E, DVec3::Y),
];
/// Points of the wheel's way that are a notch.
const NOTCH: f32 = 50.0;
/// A picture that took long does not make it jump.
const LONGEST: f32 = 0.1;

/// Returns whether the camera has the mouse, so that nothing else should take it.
pub fn navigate(ui: &Ui, response: &Response, camera: &mut ViewCamera) -> bool {
    let (alt, shift) = ui.input(|input| (input.modifiers.alt, input.modifiers.shift));
    let points = response.drag_delta();
    let way = DVec2::new(points.x.into(), points.y.into());
    let held = |button| response.dragged_by(button);
    if held(PointerButton::Secondary) && alt {
        camera.zoom((way.x - way.y) / 40.0);
    } else if held(PointerButton::Secondary) {
        camera.turn(way);
        fly(ui, camera, shift);
    } else if held(PointerButton::Middle) {
        camera.pan(way, f64::from(response.rect.height()));
    } else if held(PointerButton::Primary) && alt {
        camera.orbit(way);
    }
    if response.contains_pointer() {
        wheel(ui, camera, held(PointerButton::Secondary));
    }
    held(PointerButton::Secondary) || held(PointerButton::Middle) || alt
}

fn fly(ui: &Ui, camera: &mut ViewCamera, fast: bool) {
    let (way, seconds) = ui.input(|input| {
        let pressed = KEYS.iter().filter(|(key, _)| input.key_down(*key));
        (pressed.map(|(_, way)| *way).sum::<DVec3>(), input.stable_dt.min(LONGEST))
    });
    if way != DVec3::ZERO {
        camera.fly(way, f64::from(seconds), fast);
        ui.ctx().request_repaint();
    }
}

fn wheel(ui: &Ui, camera: &mut ViewCamera, flies: bool) {
    let turned: Vec2 = ui.input(|input| input.smooth_scroll_delta());
    if turned.y == 0.0 {
        return;
    }
    let notches = f64::from(turned.y / NOTCH);
    if flies { camera.speed_up(notches) } else { camera.zoom(notches) }
}
