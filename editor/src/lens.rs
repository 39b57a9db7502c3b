//! Between points on the screen and the world, for everything that is drawn or grasped over a picture.

use eframe::egui;
use egui::{Pos2, Rect, pos2};
use engine::render::Eye;
use engine::scene::Projection;
use glam::DVec3;

/// A picture at its place on the screen, and from where it is taken.
#[derive(Clone, Copy, Debug)]
pub struct Lens {
    pub eye: Eye,
    pub rect: Rect,
}

/// Half a line through the world; `direction` has length 1.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    pub origin: DVec3,
    pub direction: DVec3,
}

impl Ray {
    /// Where it meets a plane. `None`: it runs along it, or away.
    pub fn meets(&self, point: DVec3, normal: DVec3) -> Option<DVec3> {
        let slope = self.direction.dot(normal);
        let along = (point - self.origin).dot(normal) / slope;
        (slope.abs() > 1e-6 && along > 0.0).then(|| self.origin + self.direction * along)
    }

    /// How far along a line (metres from `point`, `way` has length 1) it comes nearest. `None`: both run alike.
    pub fn nearest_on(&self, point: DVec3, way: DVec3) -> Option<f64> {
        let cosine = self.direction.dot(way);
        let apart = 1.0 - cosine * cosine;
        let between = point - self.origin;
        (apart > 1e-4).then(|| (cosine * between.dot(self.direction) - between.dot(way)) / apart)
    }
}

impl Lens {
    fn half(&self) -> [f64; 2] {
        self.eye.half(self.rect.width() / self.rect.height().max(1.0)).map(f64::from)
    }

    fn is_parallel(&self) -> bool {
        matches!(self.eye.projection, Projection::Orthographic { .. })
    }

    pub fn forward(&self) -> DVec3 {
        self.eye.rotation * DVec3::NEG_Z
    }

    /// Towards the eye from a point.
    pub fn to_eye(&self, point: DVec3) -> DVec3 {
        if self.is_parallel() { -self.forward() } else { (self.eye.position - point).normalize_or(DVec3::Z) }
    }

    /// Where a point is seen, and how far away it is; `None`: behind the eye.
    pub fn project(&self, point: DVec3) -> Option<(Pos2, f64)> {
        let at = self.eye.rotation.inverse() * (point - self.eye.position);
        let depth = -at.z;
        if depth < f64::from(self.eye.near).max(1e-9) && !self.is_parallel() {
            return None;
        }
        let [x, y] = self.half();
        let scale = if self.is_parallel() { 1.0 } else { depth };
        let share = [at.x / (x * scale), at.y / (y * scale)];
        let middle = self.rect.center();
        let seen = pos2(
            middle.x + (share[0] * f64::from(self.rect.width()) * 0.5) as f32,
            middle.y - (share[1] * f64::from(self.rect.height()) * 0.5) as f32,
        );
        seen.is_finite().then_some((seen, depth))
    }

    pub fn ray(&self, at: Pos2) -> Ray {
        let [x, y] = self.half();
        let middle = self.rect.center();
        let share = [
            f64::from(at.x - middle.x) / f64::from(self.rect.width().max(1.0)) * 2.0,
            f64::from(middle.y - at.y) / f64::from(self.rect.height().max(1.0)) * 2.0,
        ];
        let off = DVec3::new(share[0] * x, share[1] * y, 0.0);
        if self.is_parallel() {
            return Ray { origin: self.eye.position + self.eye.rotation * off, direction: self.forward() };
        }
        let direction = self.eye.rotation * (off + DVec3::NEG_Z).normalize();
        Ray { origin: self.eye.position, direction }
    }

    /// How many metres a point of the screen is, where something stands.
    pub fn metres_per_point(&self, at: DVec3) -> f64 {
        let depth = (at - self.eye.position).dot(self.forward()).abs().max(1e-6);
        let scale = if self.is_parallel() { 1.0 } else { depth };
        2.0 * self.half()[1] * scale / f64::from(self.rect.height().max(1.0))
    }

    /// A line between two points of the world, cut off where it goes behind the eye.
    pub fn segment(&self, from: DVec3, to: DVec3) -> Option<[Pos2; 2]> {
        if let (Some((a, _)), Some((b, _))) = (self.project(from), self.project(to)) {
            return Some([a, b]);
        }
        let forward = self.forward();
        let depth =
            |point: DVec3| (point - self.eye.position).dot(forward) - f64::from(self.eye.near) * 1.01 - 1e-6;
        let (a, b) = (depth(from), depth(to));
        if a <= 0.0 && b <= 0.0 {
            return None;
        }
        let cut = from.lerp(to, a / (a - b));
        let (seen, other) = if a > 0.0 { (from, cut) } else { (cut, to) };
        Some([self.project(seen)?.0, self.project(other)?.0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::ViewCamera;

    #[test]
    fn what_is_projected_lies_on_the_ray_back() {
        for orthographic in [false, true] {
            let mut camera = ViewCamera::default();
            camera.orthographic = orthographic;
            let plain = Eye::looking(DVec3::Z, DVec3::ZERO);
            let rect = Rect::from_min_size(pos2(30.0, 50.0), egui::vec2(640.0, 360.0));
            let lens = Lens { eye: camera.eye(&plain), rect };
            for point in [DVec3::ZERO, DVec3::new(1.0, 0.5, -0.7), DVec3::new(-2.0, 1.0, 0.3)] {
                let (seen, _) = lens.project(point).unwrap();
                let ray = lens.ray(seen);
                let along = (point - ray.origin).dot(ray.direction);
                let apart = (ray.origin + ray.direction * along).distance(point);
                assert!(apart < 1e-2, "{orthographic} {point} {apart}");
            }
        }
    }

    #[test]
    fn a_ray_meets_planes_and_comes_nearest_to_lines() {
        let ray = Ray { origin: DVec3::new(0.0, 2.0, 0.0), direction: DVec3::NEG_Y };
        assert_eq!(ray.meets(DVec3::ZERO, DVec3::Y), Some(DVec3::ZERO));
        assert_eq!(ray.meets(DVec3::ZERO, DVec3::X), None);
        assert_eq!(ray.meets(DVec3::Y * 3.0, DVec3::Y), None, "behind");
        let near = ray.nearest_on(DVec3::new(-3.0, 0.0, 0.0), DVec3::X).unwrap();
        assert!((near - 3.0).abs() < 1e-12);
        assert_eq!(ray.nearest_on(DVec3::ZERO, DVec3::Y), None);
    }
}
