//! Lines on the ground of the scene view, a metre apart or ten times more or less, as the camera's distance asks for. They
//! fade out with distance, and lie in the picture: surfaces hide them.

use engine::render::lines::Line;
use glam::{DVec3, Vec3, Vec4};

use crate::camera::ViewCamera;

/// Lines on each side of the middle.
const LINES: i32 = 40;
const FAINT: f32 = 0.13;
const STRONG: f32 = 0.3;

/// Relative to `origin`.
pub fn lines(camera: &ViewCamera, origin: DVec3) -> Vec<Line> {
    let step = 10f64.powf((camera.distance / 6.0).log10().floor()).clamp(1e-3, 1e5);
    let middle = (camera.pivot / step).round() * step;
    let mut lines = Vec::new();
    for number in -LINES..=LINES {
        let off = f64::from(number) * step;
        for axis in [0, 2] {
            let at = middle[axis] + off;
            let share = 1.0 - (f64::from(number.abs()) / f64::from(LINES)) as f32;
            let tenth = (at / step).round() as i64 % 10 == 0;
            let color = color(axis, at.abs() < step * 0.5, if tenth { STRONG } else { FAINT });
            along(&mut lines, axis, at, middle, step, color * Vec4::new(1.0, 1.0, 1.0, share), origin);
        }
    }
    lines
}

/// The lines through the world's middle are x, red, and z, blue.
fn color(across: usize, is_axis: bool, strength: f32) -> Vec4 {
    match (is_axis, across) {
        (true, 0) => Vec4::new(0.1, 0.28, 0.85, 0.7),
        (true, _) => Vec4::new(0.78, 0.1, 0.08, 0.7),
        _ => Vec4::new(0.45, 0.45, 0.48, strength),
    }
}

/// In two halves of four pieces each, fainter outwards.
fn along(lines: &mut Vec<Line>, axis: usize, at: f64, middle: DVec3, step: f64, color: Vec4, origin: DVec3) {
    const PIECES: i32 = 4;
    let other = 2 - axis;
    let length = f64::from(LINES) * step;
    let point = |share: f64| -> Vec3 {
        let mut point = DVec3::ZERO;
        point[axis] = at;
        point[other] = middle[other] + share * length;
        (point - origin).as_vec3()
    };
    for piece in -PIECES..PIECES {
        let share = |piece: i32| f64::from(piece) / f64::from(PIECES);
        let (from, to) = (share(piece), share(piece + 1));
        let fade = 1.0 - ((from + to) * 0.5).abs() as f32;
        lines.push(Line { ends: [point(from), point(to)], color: color * Vec4::new(1.0, 1.0, 1.0, fade) });
    }
}
