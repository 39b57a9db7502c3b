//! The view cube: the world's axes as the camera sees them, in a corner of the scene view. A click on one looks along it,
//! a click on the middle changes between perspective and parallel rays.

use eframe::egui;
use egui::{Align2, Color32, FontId, Pos2, Rect, Role, Sense, Stroke, Ui, Vec2, WidgetInfo, vec2};
use glam::DVec3;

use crate::camera::ViewCamera;
use crate::theme;

/// Points that it is wide.
pub const SIZE: f32 = 84.0;
const REACH: f32 = 30.0;
const BALL: f32 = 8.5;
const NAMES: [(&str, &str); 3] = [("X", "x"), ("Y", "y"), ("Z", "z")];

/// Returns whether the camera changed.
pub fn show(ui: &mut Ui, rect: Rect, camera: &mut ViewCamera) -> bool {
    let before = *camera;
    let middle = rect.center();
    ui.painter().circle_filled(middle, SIZE * 0.5, Color32::from_black_alpha(70));
    let turn = camera.rotation().inverse();
    let mut ends: Vec<(usize, bool, DVec3)> = (0..3)
        .flat_map(|axis| [(axis, true), (axis, false)])
        .map(|(axis, ahead)| (axis, ahead, turn * DVec3::AXES[axis] * if ahead { 1.0 } else { -1.0 }))
        .collect();
    ends.sort_by(|a, b| a.2.z.total_cmp(&b.2.z));
    for (axis, ahead, seen) in ends {
        let at = middle + vec2(seen.x as f32, -seen.y as f32) * REACH;
        if end(ui, middle, at, axis, ahead, seen.z as f32) {
            camera.look_along(DVec3::AXES[axis] * if ahead { -1.0 } else { 1.0 });
        }
    }
    let hub = Rect::from_center_size(middle, Vec2::splat(13.0));
    let name = if camera.orthographic { "Parallel projection" } else { "Perspective" };
    let response = ui.interact(hub, ui.scope_id().with("projection"), Sense::click());
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, "Perspective or parallel projection"));
    let color = if response.hovered() { theme::GRASPED } else { Color32::from_gray(200) };
    let shape = Rect::from_center_size(middle, Vec2::splat(8.0));
    if camera.orthographic {
        ui.painter().rect_filled(shape, 1.0, color);
    } else {
        ui.painter().circle_filled(middle, 4.5, color);
    }
    if response.on_hover_text(format!("{name}: click to change")).clicked() {
        camera.orthographic ^= true;
    }
    *camera != before
}

/// One end of an axis. Returns whether it was clicked.
fn end(ui: &mut Ui, middle: Pos2, at: Pos2, axis: usize, ahead: bool, depth: f32) -> bool {
    let name = format!("Look along {}{}", if ahead { "-" } else { "+" }, NAMES[axis].0);
    let rect = Rect::from_center_size(at, Vec2::splat(BALL * 2.0));
    let response = ui.interact(rect, ui.scope_id().with(("axis", axis, ahead)), Sense::click());
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, &name));
    let nearness = 0.65 + 0.35 * depth;
    let color = if response.hovered() { theme::GRASPED } else { theme::AXES[axis].gamma_multiply(nearness) };
    if ahead {
        ui.painter().line_segment([middle, at], Stroke::new(2.0, color));
        ui.painter().circle_filled(at, BALL, color);
        let font = FontId::proportional(11.0);
        ui.painter().text(at, Align2::CENTER_CENTER, NAMES[axis].0, font, Color32::from_gray(20));
    } else {
        ui.painter().circle(at, BALL - 2.5, Color32::from_black_alpha(110), Stroke::new(1.5, color));
    }
    response.on_hover_text(name).clicked()
}
