//! Handles on the screen: how they look, and which of them lies under the mouse. Their size does not change with
//! distance.

use std::f64::consts::TAU;

use eframe::egui;
use egui::{Color32, Painter, Pos2, Shape, Stroke, Vec2};
use glam::DVec3;

use super::{Handle, Stand, Tool, handles};
use crate::lens::Lens;
use crate::theme;

/// Points that an axis is long.
pub const REACH: f32 = 84.0;
const RING_SCREEN: f64 = 1.18;
/// Share of the reach where planes begin and end.
const PLANE: [f64; 2] = [0.22, 0.42];
const NEAR: f32 = 7.0;
const SEGMENTS: usize = 72;

/// The handle under the mouse.
pub fn under(lens: &Lens, stand: &Stand, tool: Tool, at: Pos2) -> Option<Handle> {
    let apart = |handle: &Handle| distance(lens, stand, *handle, at).filter(|apart| *apart <= NEAR);
    let near = handles(tool).iter().filter_map(|handle| Some((*handle, apart(handle)?)));
    near.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(handle, _)| handle)
}

/// Points from the mouse; `None`: the handle is not seen.
fn distance(lens: &Lens, stand: &Stand, handle: Handle, at: Pos2) -> Option<f32> {
    match handle {
        Handle::MoveAxis(axis) | Handle::ScaleAxis(axis) => {
            let [from, to] = shaft(lens, stand, axis)?;
            let start = from + (to - from) * 0.2;
            Some(to_segment(at, start, to).min((at.distance(to) - 3.0).max(0.0)))
        }
        Handle::MovePlane(axis) => {
            let corners = plane(lens, stand, axis)?;
            inside(&corners, at).then_some(2.0)
        }
        Handle::MoveScreen | Handle::ScaleAll => {
            let (middle, _) = lens.project(stand.origin)?;
            (at.distance(middle) <= 9.0).then_some(0.0)
        }
        Handle::Ring(axis) => {
            let front = ring(lens, stand, stand.axis(axis), 1.0);
            let near = front.windows(2).filter(|pair| pair[0].1 && pair[1].1);
            near.map(|pair| to_segment(at, pair[0].0, pair[1].0)).min_by(f32::total_cmp)
        }
        Handle::RingScreen => {
            let (middle, _) = lens.project(stand.origin)?;
            Some((at.distance(middle) - REACH * RING_SCREEN as f32).abs() + 0.5)
        }
    }
}

fn reach(lens: &Lens, stand: &Stand) -> f64 {
    lens.metres_per_point(stand.origin) * f64::from(REACH)
}

/// From the middle to the tip. `None`: it points at the eye and has no length to pull along.
fn shaft(lens: &Lens, stand: &Stand, axis: usize) -> Option<[Pos2; 2]> {
    let way = stand.axis(axis);
    if way.dot(lens.to_eye(stand.origin)).abs() > 0.985 {
        return None;
    }
    let (from, _) = lens.project(stand.origin)?;
    let (to, _) = lens.project(stand.origin + way * reach(lens, stand))?;
    Some([from, to])
}

/// On the side that the eye is on. `None`: it is seen from its edge.
fn plane(lens: &Lens, stand: &Stand, axis: usize) -> Option<[Pos2; 4]> {
    let sight = lens.to_eye(stand.origin);
    if stand.axis(axis).dot(sight).abs() < 0.15 {
        return None;
    }
    let [a, b] = [(axis + 1) % 3, (axis + 2) % 3].map(|other| stand.axis(other) * reach(lens, stand));
    let corner = |u: f64, v: f64| Some(lens.project(stand.origin + a * u + b * v)?.0);
    let [low, high] = PLANE;
    Some([corner(low, low)?, corner(high, low)?, corner(high, high)?, corner(low, high)?])
}

/// Points of a circle, and whether they are on the side of the eye.
fn ring(lens: &Lens, stand: &Stand, axis: DVec3, radius: f64) -> Vec<(Pos2, bool)> {
    let (u, v) = axis.any_orthonormal_pair();
    let radius = reach(lens, stand) * radius;
    let sight = lens.to_eye(stand.origin);
    let point = |index: usize| {
        let (sin, cos) = (TAU * index as f64 / SEGMENTS as f64).sin_cos();
        let off = u * cos + v * sin;
        // A little more than half, so that rings seen from above are whole.
        Some((lens.project(stand.origin + off * radius)?.0, off.dot(sight) > -0.08))
    };
    (0..=SEGMENTS).filter_map(point).collect()
}

/// Draws the handles; `hot` is grasped, or lies under the mouse.
pub fn paint(painter: &Painter, lens: &Lens, stand: &Stand, tool: Tool, hot: Option<Handle>) {
    // Far ones first.
    let depth = |handle: &Handle| match handle {
        Handle::MoveAxis(axis) | Handle::ScaleAxis(axis) => stand.axis(*axis).dot(lens.to_eye(stand.origin)),
        Handle::MovePlane(_) | Handle::Ring(_) => -2.0,
        Handle::RingScreen => -3.0,
        Handle::MoveScreen | Handle::ScaleAll => 2.0,
    };
    let mut order: Vec<Handle> = handles(tool).to_vec();
    order.sort_by(|a, b| depth(a).total_cmp(&depth(b)));
    for handle in order {
        let is_hot = hot == Some(handle);
        paint_handle(painter, lens, stand, handle, is_hot);
    }
}

fn color_of(axis: usize, hot: bool) -> Color32 {
    if hot { theme::GRASPED } else { theme::AXES[axis] }
}

fn paint_handle(painter: &Painter, lens: &Lens, stand: &Stand, handle: Handle, hot: bool) {
    let width = if hot { 3.0 } else { 2.0 };
    match handle {
        Handle::MoveAxis(axis) => {
            let Some([from, to]) = shaft(lens, stand, axis) else { return };
            painter.line_segment([from, to], Stroke::new(width, color_of(axis, hot)));
            arrow_head(painter, from, to, color_of(axis, hot));
        }
        Handle::ScaleAxis(axis) => {
            let Some([from, to]) = shaft(lens, stand, axis) else { return };
            painter.line_segment([from, to], Stroke::new(width, color_of(axis, hot)));
            painter.rect_filled(egui::Rect::from_center_size(to, Vec2::splat(9.0)), 1.0, color_of(axis, hot));
        }
        Handle::MovePlane(axis) => {
            let Some(corners) = plane(lens, stand, axis) else { return };
            let color = color_of(axis, hot);
            let stroke = Stroke::new(1.0, color);
            painter.add(Shape::convex_polygon(corners.to_vec(), color.gamma_multiply(0.35), stroke));
        }
        Handle::Ring(axis) => {
            let points = ring(lens, stand, stand.axis(axis), 1.0);
            paint_ring(painter, &points, color_of(axis, hot), width);
        }
        Handle::RingScreen => {
            let Some((middle, _)) = lens.project(stand.origin) else { return };
            let color = if hot { theme::GRASPED } else { Color32::from_gray(190) };
            painter.circle_stroke(middle, REACH * RING_SCREEN as f32, Stroke::new(width * 0.75, color));
        }
        Handle::MoveScreen | Handle::ScaleAll => {
            let Some((middle, _)) = lens.project(stand.origin) else { return };
            let color = if hot { theme::GRASPED } else { Color32::from_gray(225) };
            let square = egui::Rect::from_center_size(middle, Vec2::splat(11.0));
            painter.rect(
                square,
                1.0,
                color.gamma_multiply(0.5),
                Stroke::new(1.0, color),
                egui::StrokeKind::Inside,
            );
        }
    }
}

fn paint_ring(painter: &Painter, points: &[(Pos2, bool)], color: Color32, width: f32) {
    for pair in points.windows(2) {
        let front = pair[0].1 && pair[1].1;
        let stroke =
            if front { Stroke::new(width, color) } else { Stroke::new(1.0, color.gamma_multiply(0.25)) };
        painter.line_segment([pair[0].0, pair[1].0], stroke);
    }
}

fn arrow_head(painter: &Painter, from: Pos2, to: Pos2, color: Color32) {
    let way = (to - from).normalized();
    let side = way.rot90() * 5.0;
    let head = vec![to + way * 12.0, to + side, to - side];
    painter.add(Shape::convex_polygon(head, color, Stroke::NONE));
}

pub fn to_segment(at: Pos2, from: Pos2, to: Pos2) -> f32 {
    let way = to - from;
    let along =
        if way.length_sq() > 0.0 { ((at - from).dot(way) / way.length_sq()).clamp(0.0, 1.0) } else { 0.0 };
    at.distance(from + way * along)
}

fn inside(corners: &[Pos2; 4], at: Pos2) -> bool {
    let side = |i: usize| {
        let (from, to) = (corners[i], corners[(i + 1) % 4]);
        (to - from).x * (at - from).y - (to - from).y * (at - from).x
    };
    let sides = [0, 1, 2, 3].map(side);
    sides.iter().all(|side| *side >= 0.0) || sides.iter().all(|side| *side <= 0.0)
}
