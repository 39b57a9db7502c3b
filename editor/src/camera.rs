//! The camera of the scene view. It turns about a point some way in front of it; whatever moves it keeps that point in
//! the middle of the picture.

use glam::{DQuat, DVec2, DVec3};

use engine::render::Eye;
use engine::scene::{Camera, Projection};

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewCamera {
    /// In the middle of the picture.
    pub pivot: DVec3,
    /// Metres from the eye to it.
    pub distance: f64,
    /// Radians about Y, then about the camera's X.
    yaw: f64,
    pitch: f64,
    pub orthographic: bool,
    /// Metres a second that it flies.
    pub speed: f64,
}

/// Radians, vertical.
const FOV: f64 = 0.9;
/// Radians a point of the mouse's way.
const TURN: f64 = 0.005;
const NEAREST: f64 = 1e-3;
const FARTHEST: f64 = 1e6;
/// How much nearer a notch of the wheel brings.
const NOTCH: f64 = 1.15;
/// Steepest view, so that the picture never turns over.
const STEEPEST: f64 = std::f64::consts::FRAC_PI_2;

impl Default for ViewCamera {
    fn default() -> Self {
        Self { pivot: DVec3::ZERO, distance: 8.0, yaw: 0.6, pitch: -0.45, orthographic: false, speed: 3.0 }
    }
}

impl ViewCamera {
    /// All of a box is in the picture.
    pub fn framing(low: DVec3, high: DVec3) -> Self {
        let mut camera = Self::default();
        camera.frame(low, high);
        camera.speed = ((high - low).length() / 4.0).clamp(0.05, 1e4);
        camera
    }

    /// As somebody else looks at a point's depth: a scene's camera.
    pub fn as_eye(eye: &Eye, about: DVec3) -> Self {
        let mut camera = Self::default();
        camera.look_along(eye.rotation * DVec3::NEG_Z);
        camera.distance = (about - eye.position).dot(camera.forward()).clamp(0.1, FARTHEST);
        camera.pivot = eye.position + camera.forward() * camera.distance;
        camera
    }

    pub fn rotation(&self) -> DQuat {
        DQuat::from_rotation_y(self.yaw) * DQuat::from_rotation_x(self.pitch)
    }

    pub fn forward(&self) -> DVec3 {
        self.rotation() * DVec3::NEG_Z
    }

    pub fn position(&self) -> DVec3 {
        self.pivot - self.forward() * self.distance
    }

    /// As the renderer wants it; exposure and tone curve are the scene camera's.
    pub fn eye(&self, exposed_as: &Eye) -> Eye {
        let mut eye = Eye::looking(DVec3::Z, DVec3::ZERO);
        eye.rotation = self.rotation();
        if self.orthographic {
            // Parallel rays start behind everything that could be in the picture.
            let back = (self.distance * 50.0).max(100.0);
            eye.position = self.pivot - self.forward() * back;
            eye.near = 0.0;
            eye.far = Some((back * 4.0) as f32);
            eye.projection =
                Projection::Orthographic { half_height: (self.distance * (FOV * 0.5).tan()) as f32 };
        } else {
            eye.position = self.position();
            eye.near = (self.distance * 0.005).clamp(1e-4, 0.1) as f32;
            eye.far = None;
            eye.projection = Projection::Perspective { fov_y: FOV as f32 };
        }
        eye.exposure = exposed_as.exposure;
        eye.auto_exposure = exposed_as.auto_exposure;
        eye.tonemap = exposed_as.tonemap;
        eye
    }

    /// About the pivot.
    pub fn orbit(&mut self, points: DVec2) {
        self.yaw = (self.yaw - points.x * TURN).rem_euclid(std::f64::consts::TAU);
        self.pitch = (self.pitch - points.y * TURN).clamp(-STEEPEST, STEEPEST);
    }

    /// About itself.
    pub fn turn(&mut self, points: DVec2) {
        let position = self.position();
        self.orbit(points);
        self.pivot = position + self.forward() * self.distance;
    }

    /// What is at the pivot's depth stays under the mouse; `height` of the picture in points.
    pub fn pan(&mut self, points: DVec2, height: f64) {
        let metres_per_point = self.height_at_pivot() / height.max(1.0);
        let way = DVec3::new(-points.x, points.y, 0.0) * metres_per_point;
        self.pivot += self.rotation() * way;
    }

    pub fn zoom(&mut self, notches: f64) {
        self.distance = (self.distance / NOTCH.powf(notches.clamp(-20.0, 20.0))).clamp(NEAREST, FARTHEST);
    }

    pub fn speed_up(&mut self, notches: f64) {
        self.speed = (self.speed * 1.2_f64.powf(notches.clamp(-20.0, 20.0))).clamp(1e-3, 1e5);
    }

    /// `way` along its own axes.
    pub fn fly(&mut self, way: DVec3, seconds: f64, fast: bool) {
        let metres = self.speed * seconds * if fast { 5.0 } else { 1.0 };
        self.pivot += self.rotation() * way.normalize_or_zero() * metres;
    }

    /// A box fills the picture.
    pub fn frame(&mut self, low: DVec3, high: DVec3) {
        let radius = ((high - low).length() * 0.5).max(1e-3);
        self.pivot = (low + high) * 0.5;
        self.distance = (radius / (FOV * 0.5).sin() * 1.1).clamp(NEAREST, FARTHEST);
    }

    /// Looks along a direction, at what it looks at now.
    pub fn look_along(&mut self, forward: DVec3) {
        let forward = forward.normalize_or(DVec3::NEG_Z);
        if forward.y.abs() < 0.999 {
            self.yaw = (-forward.x).atan2(-forward.z);
        }
        self.pitch = forward.y.clamp(-1.0, 1.0).asin();
    }

    /// Metres that the picture shows there, from its foot to its head.
    pub fn height_at_pivot(&self) -> f64 {
        2.0 * self.distance * (FOV * 0.5).tan()
    }

    /// How large something new is that is to be seen whole: 1, or where the picture shows less than 4 m at the pivot no
    /// more than a quarter of its height, as a round number.
    pub fn size_of_new(&self) -> f64 {
        let quarter = self.height_at_pivot() / 4.0;
        let decades = -quarter.log10().floor();
        let round = [5.0, 2.0, 1.0].map(|digit| digit / 10.0_f64.powf(decades));
        round.into_iter().find(|size| *size <= quarter).unwrap_or(round[2]).min(1.0)
    }

    /// The scene camera that sees the same picture.
    pub fn as_camera(&self) -> Camera {
        Camera { projection: Projection::Perspective { fov_y: FOV as f32 }, ..Camera::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orbiting_keeps_the_pivot_and_turning_keeps_the_eye() {
        let mut camera = ViewCamera::framing(DVec3::ZERO, DVec3::splat(2.0));
        let (pivot, distance) = (camera.pivot, camera.distance);
        camera.orbit(DVec2::new(120.0, -40.0));
        assert_eq!(camera.pivot, pivot);
        assert!(camera.position().distance(pivot) - distance < 1e-9);
        let eye = camera.position();
        camera.turn(DVec2::new(-33.0, 12.0));
        assert!(camera.position().abs_diff_eq(eye, 1e-9) && camera.pivot != pivot);
    }

    #[test]
    fn looking_along_an_axis_and_over_the_top_stays_upright() {
        let mut camera = ViewCamera::default();
        for way in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z] {
            camera.look_along(way);
            assert!(camera.forward().abs_diff_eq(way, 1e-6), "{way}");
        }
        camera.orbit(DVec2::new(0.0, 1e6));
        assert!((camera.rotation() * DVec3::Y).y >= -1e-9);
    }

    #[test]
    fn something_new_is_a_metre_large_and_smaller_where_a_metre_would_hide_everything() {
        let size = |distance| ViewCamera { distance, ..ViewCamera::default() }.size_of_new();
        assert_eq!((size(8.0), size(1e5)), (1.0, 1.0));
        assert_eq!([2.5, 1.08, 0.2, 1e-3].map(size), [0.5, 0.2, 0.02, 0.0002]);
    }

    #[test]
    fn panning_moves_what_is_under_the_mouse_with_it() {
        let mut camera = ViewCamera::default();
        camera.look_along(DVec3::NEG_Z);
        let height = 600.0;
        camera.pan(DVec2::new(height, 0.0), height);
        let visible = 2.0 * camera.distance * (FOV * 0.5).tan();
        assert!(camera.pivot.abs_diff_eq(DVec3::X * -visible, 1e-9));
    }
}
