//! The scene view: the scene as its author moves through it, with what is selected, and handles to move it.

mod dropped;
mod pick;

use std::collections::HashSet;

use eframe::egui;
use egui::{
    Align2, Color32, FontId, Key, PointerButton, Pos2, Rect, Response, Role, Sense, Ui, WidgetInfo, pos2,
    vec2,
};
use engine::render::outline::Marks;
use engine::render::{Eye, View};
use engine::scene::EntityId;
use glam::DQuat;

use crate::ask::Asks;
use crate::camera::ViewCamera;
use crate::document::Document;
use crate::gizmo::{self, Change, Grasp, Stand, Steps, Tool};
use crate::icons::{self, Icon};
use crate::intents::Intent;
use crate::lens::Lens;
use crate::scenery::Scenery;
use crate::selection::Selection;
use crate::theme;
use crate::tools::{navigate, transform};
use crate::viewport::marks::{self, Mark};
use crate::viewport::{Picture, Stage, cube, grid};
use pick::{all_under, in_area, joined, under};

/// How handles stand and pull.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Handling {
    pub tool: Tool,
    /// Along the axes of the active entity, not the world's.
    pub local: bool,
    /// In the middle of all that is selected, not at the active entity's origin.
    pub centre: bool,
    pub snap: bool,
    pub steps: Steps,
}

#[derive(Default)]
pub struct SceneView {
    pub camera: ViewCamera,
    pub view: View,
    pub handling: Handling,
    pub hide_grid: bool,
    pub picture: Picture,
    /// Of the last picture of the editor, where the panel is shown.
    pub lens: Option<Lens>,
    grasp: Option<(Grasp, Vec<transform::Start>)>,
    /// What the pull has come to, beside the mouse.
    told: Option<String>,
    boxed: Option<Pos2>,
    /// The last click, and what it went through.
    cycle: Option<(Pos2, Vec<EntityId>)>,
    /// The list of what lies under the mouse.
    list: Option<(Pos2, Vec<EntityId>)>,
    flew: bool,
}

/// What the panel is drawn of.
pub struct Seen<'a> {
    pub document: &'a Document,
    pub scenery: Scenery<'a>,
    pub selection: &'a Selection,
}

impl SceneView {
    pub fn show(&mut self, ui: &mut Ui, stage: &mut Stage, seen: &Seen<'_>, asks: &mut Asks) {
        let rect = ui.available_rect_before_wrap();
        let response = ui.allocate_rect(rect, Sense::click_and_drag());
        response.widget_info(|| WidgetInfo::labeled(Role::Image, true, "Scene view"));
        let busy = self.grasp.is_some() || self.boxed.is_some();
        let navigates = !busy && navigate::navigate(ui, &response, &mut self.camera);
        self.flew |= response.dragged_by(PointerButton::Secondary);

        let exposed_as = seen.scenery.camera().unwrap_or(Eye::looking(glam::DVec3::Z, glam::DVec3::ZERO));
        let lens = Lens { eye: self.camera.eye(&exposed_as), rect };
        self.lens = Some(lens);
        self.picture(ui, stage, seen, &lens);
        let painter = ui.painter_at(rect);
        let open =
            seen.scenery.placed().filter(|(entity, _)| !entity.hidden && !seen.document.is_locked(entity.id));
        let marks = marks::marks(&lens, open);
        for (entity, world) in seen.scenery.placed().filter(|(entity, _)| seen.selection.contains(entity.id))
        {
            marks::paint_reach(&painter, &lens, entity, world, 16.0 / 9.0);
        }
        marks::paint(&painter, &marks, |id| seen.selection.contains(id));

        let on_cube = self.controls(ui, rect);
        if !navigates && !on_cube {
            self.handle(ui, &response, &lens, seen, asks);
            self.select(ui, &response, &lens, &marks, stage, seen, asks);
        }
        self.paint_handles(ui, &lens, seen);
        self.list_under_mouse(ui, seen, asks);
        dropped::show(ui, &response, &lens, seen, self.camera.pivot, asks);
    }

    fn picture(&mut self, ui: &Ui, stage: &mut Stage, seen: &Seen<'_>, lens: &Lens) {
        let size = Picture::pixels(stage.gpu(), lens.rect.size(), ui.ctx().pixels_per_point());
        let lines = if self.hide_grid { Vec::new() } else { grid::lines(&self.camera, stage.origin()) };
        let outlined = seen.selection.ids().iter().copied().collect();
        let marks = Marks { lines, outlined, displaced: seen.scenery.displaced.clone() };
        let now = seen.scenery.now(lens.eye, self.view);
        let shown = self.picture.show(stage, &now, seen.scenery.revision, &marks, size);
        if let Some(texture) = shown {
            let uv = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            ui.painter().image(texture, lens.rect, uv, Color32::WHITE);
        }
        if let Some(error) = &self.picture.error {
            let font = FontId::proportional(13.0);
            ui.painter().text(
                lens.rect.center(),
                Align2::CENTER_CENTER,
                error,
                font,
                ui.visuals().error_fg_color,
            );
        }
        if !self.picture.is_settled() {
            ui.ctx().request_repaint();
        }
    }

    /// Over the picture: what it shows, and from where. Returns whether the mouse is on them.
    fn controls(&mut self, ui: &mut Ui, rect: Rect) -> bool {
        let corner = Rect::from_min_size(rect.min + vec2(8.0, 8.0), vec2(240.0, 24.0));
        let mut over = false;
        ui.scope_builder(egui::UiBuilder::new().max_rect(corner), |ui| {
            let frame = egui::Frame::new().fill(ui.visuals().panel_fill.gamma_multiply(0.88));
            let frame = frame.corner_radius(4).inner_margin(egui::Margin::symmetric(3, 1));
            let inner = frame.show(ui, |ui| {
                ui.horizontal(|ui| {
                    ui.spacing_mut().item_spacing.x = 2.0;
                    self.choose_view(ui);
                    if icons::button(ui, Icon::Grid, "Grid", "Lines on the ground", !self.hide_grid).clicked()
                    {
                        self.hide_grid ^= true;
                    }
                });
            });
            over |= inner.response.contains_pointer();
        });
        let middle = pos2(rect.right() - cube::SIZE * 0.5 - 8.0, rect.top() + cube::SIZE * 0.5 + 8.0);
        let cube_rect = Rect::from_center_size(middle, vec2(cube::SIZE, cube::SIZE));
        if rect.width() > 260.0 && rect.height() > 160.0 {
            cube::show(ui, cube_rect, &mut self.camera);
            let pointer = ui.input(|input| input.pointer.hover_pos());
            over |= pointer.is_some_and(|at| at.distance(middle) < cube::SIZE * 0.5);
        }
        over
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

    /// Where the handles stand.
    fn stand(&self, seen: &Seen<'_>) -> Option<Stand> {
        let active = seen.document.entity(seen.selection.active()?)?;
        let world = seen.document.world_from_local(active.id);
        // Scales go along the axes of what is scaled: anything else would shear it.
        let local = self.handling.local || self.handling.tool == Tool::Scale;
        let axes = if local { transform::rotation_of(&world) } else { DQuat::IDENTITY };
        let origin = if self.handling.centre {
            let extent = seen.scenery.extent(|entity| seen.selection.contains(entity.id));
            extent.map_or(world.translation, |(low, high)| (low + high) * 0.5)
        } else {
            world.translation
        };
        Some(Stand { origin, axes })
    }

    fn handle(&mut self, ui: &Ui, response: &Response, lens: &Lens, seen: &Seen<'_>, asks: &mut Asks) {
        if seen.scenery.is_playing {
            return;
        }
        let (pressed, down, at, ctrl) = ui.input(|input| {
            let pointer = &input.pointer;
            (pointer.primary_pressed(), pointer.primary_down(), pointer.latest_pos(), input.modifiers.command)
        });
        let Some(at) = at else { return };
        if pressed && response.contains_pointer() && self.grasp.is_none() {
            let grasped = self.stand(seen).and_then(|stand| {
                let handle = gizmo::under(lens, &stand, self.handling.tool, at)?;
                Some(Grasp::new(handle, stand, lens, at))
            });
            self.grasp = grasped.map(|grasp| (grasp, transform::starts(seen.document, seen.selection.ids())));
        }
        let Some((grasp, starts)) = &mut self.grasp else { return };
        if ui.input(|input| input.key_pressed(Key::Escape)) {
            asks.push(Intent::Cancel);
            (self.grasp, self.told) = (None, None);
            return;
        }
        if down {
            let steps = (self.handling.snap != ctrl).then_some(&self.handling.steps);
            if let Some(change) = grasp.change(lens, at, steps) {
                let own = !self.handling.centre && starts.len() > 1 && !matches!(change, Change::Move(_));
                asks.push(Intent::Preview(transform::edit(starts, &grasp.stand, &change, own)));
                self.told = Some(told(&change));
            }
        } else {
            asks.push(Intent::End);
            (self.grasp, self.told) = (None, None);
        }
    }

    fn paint_handles(&self, ui: &Ui, lens: &Lens, seen: &Seen<'_>) {
        if seen.scenery.is_playing {
            return;
        }
        let painter = ui.painter_at(lens.rect);
        let at = ui.input(|input| input.pointer.latest_pos());
        let Some(mut stand) = self.stand(seen) else { return };
        let hot = match &self.grasp {
            Some((grasp, _)) => {
                if self.handling.tool != Tool::Move {
                    stand = grasp.stand;
                }
                Some(grasp.handle)
            }
            None => at.and_then(|at| gizmo::under(lens, &stand, self.handling.tool, at)),
        };
        gizmo::paint(&painter, lens, &stand, self.handling.tool, hot);
        if let (Some(told), Some(at)) = (&self.told, at) {
            let font = FontId::proportional(13.0);
            let place = at + vec2(18.0, 10.0);
            let galley = painter.layout_no_wrap(told.clone(), font, Color32::WHITE);
            let back = Rect::from_min_size(place, galley.size()).expand2(vec2(6.0, 3.0));
            painter.rect_filled(back, 4.0, Color32::from_black_alpha(190));
            painter.galley(place, galley, Color32::WHITE);
        }
    }

    #[allow(clippy::too_many_arguments)]
    fn select(
        &mut self,
        ui: &Ui,
        response: &Response,
        lens: &Lens,
        marks: &[Mark],
        stage: &mut Stage,
        seen: &Seen<'_>,
        asks: &mut Asks,
    ) {
        if self.grasp.is_some() {
            return;
        }
        let modifiers = ui.input(|input| input.modifiers);
        if response.drag_started_by(PointerButton::Primary) && !modifiers.alt {
            self.boxed = ui.input(|input| input.pointer.press_origin());
        }
        if let (Some(from), Some(to)) = (self.boxed, ui.input(|input| input.pointer.latest_pos())) {
            let area = Rect::from_two_pos(from, to).intersect(lens.rect);
            let accent = theme::accent(ui.visuals());
            ui.painter_at(lens.rect).rect(
                area,
                0.0,
                accent.gamma_multiply(0.15),
                egui::Stroke::new(1.0, accent),
                egui::StrokeKind::Inside,
            );
            if response.drag_stopped_by(PointerButton::Primary) {
                self.boxed = None;
                let found = in_area(ui, lens, area, marks, stage, seen);
                asks.push(Intent::Select(joined(seen.selection, found, modifiers)));
            }
            return;
        }
        let Some(at) = response.interact_pointer_pos() else { return };
        if response.clicked() {
            let found = self.next_under(ui, lens, at, marks, stage, seen, modifiers.any());
            asks.push(Intent::Select(joined(seen.selection, found.into_iter().collect(), modifiers)));
        }
        if response.secondary_clicked() && !std::mem::take(&mut self.flew) {
            let found = all_under(ui, lens, at, marks, stage, seen);
            self.list = (!found.is_empty()).then_some((at, found));
        }
    }

    /// A click at the same place goes through to what lies beneath.
    #[allow(clippy::too_many_arguments)]
    fn next_under(
        &mut self,
        ui: &Ui,
        lens: &Lens,
        at: Pos2,
        marks: &[Mark],
        stage: &mut Stage,
        seen: &Seen<'_>,
        afresh: bool,
    ) -> Option<EntityId> {
        let again = self.cycle.take().filter(|(last, _)| !afresh && last.distance(at) < 3.0);
        let mut gone_through = again.map_or(Vec::new(), |(_, through)| through);
        let mut without: HashSet<EntityId> = gone_through.iter().copied().collect();
        let mut found = under(ui, lens, at, marks, stage, seen, &without);
        if found.is_none() {
            gone_through.clear();
            without.clear();
            found = under(ui, lens, at, marks, stage, seen, &without);
        }
        gone_through.extend(found);
        self.cycle = Some((at, gone_through));
        found
    }

    fn list_under_mouse(&mut self, ui: &Ui, seen: &Seen<'_>, asks: &mut Asks) {
        let Some((at, found)) = self.list.take() else { return };
        let mut open = true;
        let popup = egui::Popup::new(ui.scope_id().with("under mouse"), ui.ctx().clone(), at, ui.layer_id())
            .kind(egui::PopupKind::Menu)
            .close_behavior(egui::PopupCloseBehavior::CloseOnClick)
            .open_bool(&mut open);
        popup.show(|ui| {
            ui.weak("Under the mouse");
            for entity in found.iter().filter_map(|id| seen.document.entity(*id)) {
                if ui.selectable_label(seen.selection.contains(entity.id), &entity.name).clicked() {
                    asks.push(Intent::Select(vec![entity.id]));
                }
            }
        });
        if open {
            self.list = Some((at, found));
        }
    }
}

/// What a pull came to.
fn told(change: &Change) -> String {
    match change {
        Change::Move(way) => format!("{:.3}  {:.3}  {:.3} m", way.x, way.y, way.z),
        Change::Turn { angle, .. } => format!("{:.1}\u{b0}", angle.to_degrees()),
        Change::Scale(scale) => {
            let [x, y, z] = scale.to_array();
            if x == y && y == z { format!("\u{d7} {x:.2}") } else { format!("\u{d7} {x:.2}  {y:.2}  {z:.2}") }
        }
    }
}
