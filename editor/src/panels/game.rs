//! The game view: the scene through its own camera, as the player shows it.

use eframe::egui;
use egui::{Align2, Color32, FontId, Rect, Role, Sense, Ui, WidgetInfo, pos2};
use engine::render::View;
use engine::render::outline::Marks;

use crate::scenery::Scenery;
use crate::theme;
use crate::viewport::{Picture, Stage};

pub struct GameView {
    pub picture: Picture,
}

impl Default for GameView {
    fn default() -> Self {
        Self { picture: Picture::numbered(1) }
    }
}

impl GameView {
    pub fn show(&mut self, ui: &mut Ui, stage: &mut Stage, scenery: &Scenery<'_>) {
        let rect = ui.available_rect_before_wrap();
        let response = ui.allocate_rect(rect, Sense::click());
        response.widget_info(|| WidgetInfo::labeled(Role::Image, true, "Game view"));
        let Some(eye) = scenery.camera() else {
            let told = "This scene has no camera: create one to see through it.";
            let color = theme::weak(ui.visuals());
            ui.painter().text(rect.center(), Align2::CENTER_CENTER, told, FontId::proportional(13.0), color);
            return;
        };
        let size = Picture::pixels(stage.gpu(), rect.size(), ui.ctx().pixels_per_point());
        let marks = Marks { displaced: scenery.displaced.clone(), ..Marks::default() };
        let now = scenery.now(eye, View::Composite);
        if let Some(texture) = self.picture.show(stage, &now, scenery.revision, &marks, size) {
            let uv = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            ui.painter().image(texture, rect, uv, Color32::WHITE);
        }
        if !self.picture.is_settled() {
            ui.ctx().request_repaint();
        }
    }
}
