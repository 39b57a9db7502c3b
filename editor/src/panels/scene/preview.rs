//! What a selected camera sees, in a corner of the scene view.

use eframe::egui;
use egui::{
    Align2, Color32, CornerRadius, FontId, Rect, Role, Sense, Stroke, StrokeKind, Ui, WidgetInfo, pos2, vec2,
};
use engine::render::outline::Marks;
use engine::render::{Eye, View};

use super::Seen;
use crate::viewport::{Picture, Stage};

/// Of the scene view's width, and points at most.
const SHARE: f32 = 0.3;
const WIDEST: f32 = 340.0;

pub(super) struct Preview {
    picture: Picture,
}

impl Default for Preview {
    fn default() -> Self {
        Self { picture: Picture::numbered(2) }
    }
}

impl Preview {
    pub fn forget(&mut self) {
        self.picture.forget();
    }

    /// Returns where it is drawn.
    pub fn show(&mut self, ui: &mut Ui, rect: Rect, stage: &mut Stage, seen: &Seen<'_>) -> Option<Rect> {
        let active = seen.selection.active()?;
        let (entity, world) = seen.scenery.placed().find(|(entity, _)| entity.id == active)?;
        let eye = Eye::of_camera(entity.camera.as_ref()?, world);
        let width = (rect.width() * SHARE).min(WIDEST).round();
        if width < 120.0 {
            return None;
        }
        let size = vec2(width, (width * 9.0 / 16.0).round());
        let place = Rect::from_min_size(rect.max - size - vec2(10.0, 10.0), size);
        let pixels = Picture::pixels(stage.gpu(), size, ui.ctx().pixels_per_point());
        let marks = Marks { displaced: seen.scenery.displaced.clone(), ..Marks::default() };
        let now = seen.scenery.now(eye, View::Composite);
        let texture = self.picture.show(stage, &now, seen.scenery.revision, &marks, pixels)?;
        if !self.picture.is_settled() {
            ui.ctx().request_repaint();
        }
        let response = ui.interact(place, ui.scope_id().with("camera preview"), Sense::hover());
        response.widget_info(|| WidgetInfo::labeled(Role::Image, true, "Camera preview"));
        let uv = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        ui.painter().rect_filled(place.expand(2.0), CornerRadius::same(3), Color32::from_gray(20));
        ui.painter().image(texture, place, uv, Color32::WHITE);
        ui.painter().rect_stroke(
            place.expand(1.0),
            CornerRadius::same(2),
            Stroke::new(1.0, Color32::from_gray(150)),
            StrokeKind::Outside,
        );
        let font = FontId::proportional(12.0);
        let galley = ui.painter().layout_no_wrap(entity.name.clone(), font, Color32::WHITE);
        let label = Rect::from_min_size(place.min + vec2(5.0, 4.0), galley.size()).expand2(vec2(4.0, 1.0));
        ui.painter().rect_filled(label, 3.0, Color32::from_black_alpha(150));
        ui.painter().galley(
            Align2::LEFT_TOP.anchor_rect(label.shrink2(vec2(4.0, 1.0))).min,
            galley,
            Color32::WHITE,
        );
        Some(place)
    }
}
