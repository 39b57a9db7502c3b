//! Bars over the picture: what it shows, and what the tool at hand can do.

use eframe::egui;
use egui::{Pos2, Rect, Response, Ui, vec2};
use engine::render::View;

use super::SceneView;
use crate::icons::{self, Icon};
use crate::theme;
use crate::viewport::cube;

/// A bar with its upper left corner there. Returns where it is.
pub(super) fn bar(ui: &mut Ui, corner: Pos2, width: f32, content: impl FnOnce(&mut Ui)) -> Rect {
    let room = Rect::from_min_size(corner, vec2(width, 26.0));
    let mut place = Rect::NOTHING;
    ui.scope_builder(egui::UiBuilder::new().max_rect(room), |ui| {
        let frame = egui::Frame::new().fill(ui.visuals().panel_fill.gamma_multiply(0.9));
        let frame = frame.corner_radius(4).inner_margin(egui::Margin::symmetric(4, 2));
        let inner = frame.show(ui, |ui| {
            ui.horizontal_wrapped(|ui| {
                ui.spacing_mut().item_spacing = vec2(4.0, 3.0);
                content(ui);
            });
        });
        place = inner.response.rect;
    });
    place
}

/// What a bar says, never broken in two.
pub(super) fn told(ui: &mut Ui, words: &str) -> Response {
    let color = theme::weak(ui.visuals());
    ui.add(egui::Label::new(egui::RichText::new(words).color(color)).extend())
}

/// A number in a bar, with its name before it.
pub(super) fn number(
    ui: &mut Ui,
    (name, short, tooltip): (&str, &str, &str),
    value: &mut f64,
    range: std::ops::RangeInclusive<f64>,
    suffix: &str,
) -> Response {
    ui.label(short).on_hover_text(tooltip);
    let speed = (value.abs() * 0.01).max(0.002);
    let field = egui::DragValue::new(value).speed(speed).range(range).max_decimals(3).suffix(suffix);
    let response = ui.add(field).on_hover_text(tooltip);
    response.ctx.accesskit_node_builder(response.id, |node| node.set_label(name));
    response
}

impl SceneView {
    /// What the picture shows, and from where.
    pub(super) fn controls(&mut self, ui: &mut Ui, rect: Rect) {
        let corner = rect.min + vec2(8.0, 8.0);
        let place = bar(ui, corner, 290.0, |ui| {
            ui.spacing_mut().item_spacing.x = 2.0;
            self.choose_view(ui);
            self.headlight(ui);
            let lines = "Lines on the ground (G)";
            if icons::button(ui, Icon::Grid, "Grid", lines, !self.hide_grid).clicked() {
                self.hide_grid ^= true;
            }
            let edges = "Edges of all meshes over the picture (Alt+W)";
            if icons::button(ui, Icon::Mesh, "Wireframe", edges, self.wireframe).clicked() {
                self.wireframe ^= true;
            }
            let icons = "Icons, handles and what they reach";
            if icons::button(ui, Icon::Lamp, "Gizmos and icons", icons, !self.hide_gizmos).clicked() {
                self.hide_gizmos ^= true;
            }
            let net = "The tetrahedra between light probes (T)";
            if icons::button(ui, Icon::LightProbes, "Tetrahedra", net, self.net.tetrahedra).clicked() {
                self.net.tetrahedra ^= true;
            }
        });
        self.covered.push(place);
        let middle = Pos2::new(rect.right() - cube::SIZE * 0.5 - 8.0, rect.top() + cube::SIZE * 0.5 + 8.0);
        let cube_rect = Rect::from_center_size(middle, vec2(cube::SIZE, cube::SIZE));
        if rect.width() > 260.0 && rect.height() > 160.0 {
            cube::show(ui, cube_rect, &mut self.camera);
            self.covered.push(cube_rect.shrink(6.0));
        }
    }

    /// A scene that has no light yet is black in its own.
    fn headlight(&mut self, ui: &mut Ui) {
        let is_on = self.view == View::Headlight;
        let tooltip = "A light at the eye instead of the scene's, which may be dark (Alt+9)";
        if icons::button(ui, Icon::Sun, "Headlight", tooltip, is_on).clicked() {
            self.view = if is_on { View::Composite } else { View::Headlight };
        }
    }

    fn choose_view(&mut self, ui: &mut Ui) {
        let name = |view: View| {
            let name = view.name();
            name[..1].to_uppercase() + &name[1..]
        };
        let chosen = egui::ComboBox::from_id_salt("view")
            .selected_text(name(self.view))
            .width(104.0)
            .height(400.0)
            .show_ui(ui, |ui| {
                for (number, view) in View::ALL.into_iter().enumerate() {
                    // As many as the table of commands has.
                    let shortcut = if number < 9 { format!("Alt+{}", number + 1) } else { String::new() };
                    let button =
                        egui::Button::selectable(self.view == view, name(view)).shortcut_text(shortcut);
                    if ui.add(button).clicked() {
                        self.view = view;
                    }
                }
            });
        let response = chosen.response.on_hover_text("What of the light the picture shows");
        response.ctx.accesskit_node_builder(response.id, |node| node.set_label("Draw mode"));
    }
}
