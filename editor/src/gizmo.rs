//! Handles that move, turn and scale what is selected. This file knows what they are and what a pull at one of them means;
//! [`paint`] draws them.
//!
//! A pull is measured from where it began, never from picture to picture, so that nothing drifts: along an axis by the
//! point of it that is nearest to the ray under the mouse, in a plane by where that ray meets it, about an axis by the
//! angle there.

mod paint;
pub mod typed;

use eframe::egui;
use egui::Pos2;
use glam::{DQuat, DVec3};

use crate::lens::{Lens, Ray};
pub use paint::{paint, to_segment, under};

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tool {
    /// Nothing but looking and selecting.
    View,
    #[default]
    Move,
    Rotate,
    Scale,
    /// Paints how finely surfaces are divided.
    Density,
    /// Chooses and moves light probes of a group.
    Probes,
}

impl Tool {
    /// Clicks belong to it, not to selecting.
    pub fn is_light(self) -> bool {
        matches!(self, Self::Density | Self::Probes)
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Handle {
    MoveAxis(usize),
    /// Across this axis.
    MovePlane(usize),
    /// In the plane of the picture.
    MoveScreen,
    Ring(usize),
    /// About the line of sight.
    RingScreen,
    ScaleAxis(usize),
    ScaleAll,
}

/// Where the handles stand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stand {
    pub origin: DVec3,
    pub axes: DQuat,
}

impl Stand {
    pub fn axis(&self, axis: usize) -> DVec3 {
        self.axes * DVec3::AXES[axis]
    }
}

/// What was pulled, in all, since the handle was grasped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// Metres, world.
    Move(DVec3),
    /// Radians about a line through the stand.
    Turn { axis: DVec3, angle: f64 },
    /// Along the stand's axes.
    Scale(DVec3),
}

/// Steps that a pull goes in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steps {
    pub metres: f64,
    pub degrees: f64,
    pub scale: f64,
}

impl Default for Steps {
    fn default() -> Self {
        Self { metres: 0.25, degrees: 15.0, scale: 0.1 }
    }
}

impl Steps {
    /// Within what makes sense.
    pub fn times(self, factor: f64) -> Self {
        Self {
            metres: (self.metres * factor).clamp(1e-3, 100.0),
            degrees: (self.degrees * factor).clamp(0.1, 90.0),
            scale: (self.scale * factor).clamp(1e-3, 10.0),
        }
    }
}

pub fn handles(tool: Tool) -> &'static [Handle] {
    match tool {
        Tool::View | Tool::Density | Tool::Probes => &[],
        Tool::Move => &[
            Handle::MoveScreen,
            Handle::MoveAxis(0),
            Handle::MoveAxis(1),
            Handle::MoveAxis(2),
            Handle::MovePlane(0),
            Handle::MovePlane(1),
            Handle::MovePlane(2),
        ],
        Tool::Rotate => &[Handle::Ring(0), Handle::Ring(1), Handle::Ring(2), Handle::RingScreen],
        Tool::Scale => &[Handle::ScaleAll, Handle::ScaleAxis(0), Handle::ScaleAxis(1), Handle::ScaleAxis(2)],
    }
}

/// A handle that is being pulled.
#[derive(Clone, Debug)]
pub struct Grasp {
    pub handle: Handle,
    pub stand: Stand,
    /// Points.
    from: Pos2,
    /// Where the ray met the handle's line or plane.
    met: Option<DVec3>,
    /// Of a ring: what was turned so far, and the direction of the mouse then.
    turned: f64,
    last: Option<DVec3>,
    /// Metres that the handles are long.
    reach: f64,
}

impl Grasp {
    pub fn new(handle: Handle, stand: Stand, lens: &Lens, at: Pos2) -> Self {
        let mut grasp = Self {
            handle,
            stand,
            from: at,
            met: None,
            turned: 0.0,
            last: None,
            reach: lens.metres_per_point(stand.origin) * f64::from(paint::REACH),
        };
        grasp.met = grasp.meets(lens, at);
        grasp.last = grasp.met.map(|met| met - stand.origin);
        grasp
    }

    fn normal(&self, lens: &Lens) -> DVec3 {
        match self.handle {
            Handle::MovePlane(axis) | Handle::Ring(axis) => self.stand.axis(axis),
            _ => lens.to_eye(self.stand.origin),
        }
    }

    fn meets(&self, lens: &Lens, at: Pos2) -> Option<DVec3> {
        let ray = lens.ray(at);
        match self.handle {
            Handle::MoveAxis(axis) | Handle::ScaleAxis(axis) => {
                let way = self.stand.axis(axis);
                Some(self.stand.origin + way * ray.nearest_on(self.stand.origin, way)?)
            }
            _ => self.meets_plane(&ray, lens),
        }
    }

    /// A plane that is seen from its edge is turned to the eye: a ring then follows the mouse along the picture.
    fn meets_plane(&self, ray: &Ray, lens: &Lens) -> Option<DVec3> {
        let normal = self.normal(lens);
        let sight = lens.to_eye(self.stand.origin);
        let is_edge = normal.dot(sight).abs() < 0.1 && matches!(self.handle, Handle::Ring(_));
        ray.meets(self.stand.origin, if is_edge { sight } else { normal })
    }

    /// What the mouse at this place has pulled in all.
    pub fn change(&mut self, lens: &Lens, at: Pos2, steps: Option<&Steps>) -> Option<Change> {
        match self.handle {
            Handle::MoveAxis(_) | Handle::MovePlane(_) | Handle::MoveScreen => self.moved(lens, at, steps),
            Handle::Ring(axis) => self.turned(lens, at, self.stand.axis(axis), steps),
            Handle::RingScreen => self.turned(lens, at, lens.to_eye(self.stand.origin), steps),
            Handle::ScaleAxis(axis) => self.scaled(lens, at, axis, steps),
            Handle::ScaleAll => {
                let way = f64::from((at.x - self.from.x) + (self.from.y - at.y));
                let factor = (way / f64::from(paint::REACH)).exp2();
                Some(Change::Scale(DVec3::splat(snapped(factor, steps.map(|steps| steps.scale)))))
            }
        }
    }

    fn moved(&self, lens: &Lens, at: Pos2, steps: Option<&Steps>) -> Option<Change> {
        let way = self.meets(lens, at)? - self.met?;
        let Some(steps) = steps else { return Some(Change::Move(way)) };
        let local = self.stand.axes.inverse() * way;
        let local = local.to_array().map(|metres| snapped(metres, Some(steps.metres)));
        Some(Change::Move(self.stand.axes * DVec3::from(local)))
    }

    fn turned(&mut self, lens: &Lens, at: Pos2, axis: DVec3, steps: Option<&Steps>) -> Option<Change> {
        let now = self.meets(lens, at)? - self.stand.origin;
        let last = self.last.replace(now)?;
        self.turned += last.cross(now).dot(axis).atan2(last.dot(now) - last.dot(axis) * now.dot(axis));
        let step = steps.map(|steps| steps.degrees.to_radians());
        Some(Change::Turn { axis, angle: snapped(self.turned, step) })
    }

    fn scaled(&self, lens: &Lens, at: Pos2, axis: usize, steps: Option<&Steps>) -> Option<Change> {
        let way = self.stand.axis(axis);
        let along = |point: DVec3| (point - self.stand.origin).dot(way);
        let (from, now) = (along(self.met?), along(self.meets(lens, at)?));
        // Grasped at its foot, a handle is pulled against its whole length.
        let length = if from.abs() < self.reach * 0.1 { self.reach } else { from };
        let factor = snapped(1.0 + (now - from) / length, steps.map(|steps| steps.scale));
        let mut scale = DVec3::ONE;
        scale[axis] = factor;
        Some(Change::Scale(scale))
    }
}

fn snapped(value: f64, step: Option<f64>) -> f64 {
    match step.filter(|step| *step > 0.0) {
        Some(step) => (value / step).round() * step,
        None => value,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::ViewCamera;
    use egui::{Rect, pos2, vec2};
    use engine::render::Eye;

    fn lens() -> Lens {
        let mut camera = ViewCamera::default();
        camera.look_along(DVec3::new(-0.4, -0.5, -0.8));
        let rect = Rect::from_min_size(pos2(0.0, 0.0), vec2(800.0, 600.0));
        Lens { eye: camera.eye(&Eye::looking(DVec3::Z, DVec3::ZERO)), rect }
    }

    const STAND: Stand = Stand { origin: DVec3::ZERO, axes: DQuat::IDENTITY };

    /// From one place of the world to another, by their places on the screen.
    fn pulled(handle: Handle, from: DVec3, to: DVec3, steps: Option<&Steps>) -> Change {
        let lens = lens();
        let at = |point| lens.project(point).unwrap().0;
        let mut grasp = Grasp::new(handle, STAND, &lens, at(from));
        for share in 1..8 {
            grasp.change(&lens, at(from.lerp(to, f64::from(share) / 8.0)), steps);
        }
        grasp.change(&lens, at(to), steps).unwrap()
    }

    #[test]
    fn a_pull_along_an_axis_moves_by_what_the_mouse_passes_on_it() {
        let Change::Move(way) = pulled(Handle::MoveAxis(0), DVec3::X, DVec3::X * 2.5, None) else { panic!() };
        assert!(way.abs_diff_eq(DVec3::X * 1.5, 1e-3), "{way}");
        let Change::Move(way) =
            pulled(Handle::MoveAxis(0), DVec3::X, DVec3::X * 2.4, Some(&Steps::default()))
        else {
            panic!()
        };
        assert!(way.abs_diff_eq(DVec3::X * 1.5, 1e-9), "{way}");
    }

    #[test]
    fn a_pull_in_a_plane_stays_in_it() {
        let to = DVec3::new(0.7, 0.0, -0.3);
        let Change::Move(way) = pulled(Handle::MovePlane(1), DVec3::ZERO, to, None) else { panic!() };
        assert!(way.abs_diff_eq(to, 1e-3), "{way}");
    }

    #[test]
    fn a_ring_turns_by_the_angle_that_the_mouse_goes_around_it() {
        let on_ring = |degrees: f64| DQuat::from_rotation_y(degrees.to_radians()) * DVec3::X;
        let Change::Turn { axis, angle } = pulled(Handle::Ring(1), on_ring(0.0), on_ring(40.0), None) else {
            panic!()
        };
        assert!(axis.abs_diff_eq(DVec3::Y, 1e-9) && (angle.to_degrees() - 40.0).abs() < 0.1, "{angle}");
        let Change::Turn { angle, .. } =
            pulled(Handle::Ring(1), on_ring(0.0), on_ring(40.0), Some(&Steps::default()))
        else {
            panic!()
        };
        assert!((angle.to_degrees() - 45.0).abs() < 1e-9);
    }

    #[test]
    fn a_pull_at_a_scale_handle_scales_by_the_share_of_its_length() {
        let Change::Scale(scale) = pulled(Handle::ScaleAxis(2), DVec3::Z, DVec3::Z * 2.0, None) else {
            panic!()
        };
        assert!(scale.abs_diff_eq(DVec3::new(1.0, 1.0, 2.0), 1e-3), "{scale}");
    }
}
