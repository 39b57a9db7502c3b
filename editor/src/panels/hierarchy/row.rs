//! One row: fold, icon, name, and whether it is shown.

use eframe::egui;
use egui::{
    Align2, EventFilter, FontId, Key, Rect, Response, Role, Sense, Stroke, Ui, Vec2, WidgetInfo, pos2, vec2,
};
use engine::scene::Entity;

use super::super::menu;
use super::{Dragged, Hierarchy, Row, Tree, icon, small_icon};
use crate::ask::{Ask, Asks};
use crate::icons::Icon;
use crate::intents::Intent;
use crate::selection::Click;
use crate::theme;

const INDENT: f32 = 14.0;

impl Hierarchy {
    pub(super) fn row(&mut self, ui: &mut Ui, row: Row, entity: &Entity, tree: &Tree<'_>, asks: &mut Asks) {
        let Tree { document, selection, .. } = *tree;
        let size = vec2(ui.available_width(), theme::ROW - 2.0);
        let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
        let id = ui.scope_id().with(("row", entity.id.0));
        let response = ui.interact(rect, id, Sense::click_and_drag());
        let selected = selection.contains(entity.id);
        response.widget_info(|| WidgetInfo::selected(Role::TreeItem, true, selected, &entity.name));
        let is_hidden = entity.hidden || document.indexed().ancestors(entity.id).any(|above| above.hidden);
        paint_back(ui, rect, &response, selected);
        let left = rect.left() + 4.0 + f32::from(row.depth) * INDENT;
        if row.has_children {
            self.fold_button(ui, Rect::from_min_size(pos2(left, rect.top()), vec2(INDENT, size.y)), entity);
        }
        let color = color(ui, selected, is_hidden);
        let place = Rect::from_center_size(pos2(left + INDENT + 7.0, rect.center().y), Vec2::splat(14.0));
        small_icon(ui, place, icon(entity), color);
        let text = Rect::from_min_max(pos2(left + INDENT + 19.0, rect.top()), rect.max - vec2(26.0, 0.0));
        if self.renaming.as_ref().is_some_and(|(renamed, _)| *renamed == entity.id) {
            self.name_field(ui, text, entity, asks);
        } else {
            let painter = ui.painter().with_clip_rect(text.intersect(ui.clip_rect()));
            let font = FontId::proportional(13.0);
            painter.text(pos2(text.left(), text.center().y), Align2::LEFT_CENTER, &entity.name, font, color);
        }
        if document.is_locked(entity.id) {
            let lock = Rect::from_center_size(pos2(rect.right() - 32.0, rect.center().y), Vec2::splat(18.0));
            unlock_button(ui, lock, entity, asks);
        }
        if response.hovered() || entity.hidden {
            let eye = Rect::from_center_size(pos2(rect.right() - 14.0, rect.center().y), Vec2::splat(18.0));
            eye_button(ui, eye, entity, asks);
        }
        if response.clicked() {
            self.click(ui, entity.id, asks);
        }
        if response.clicked() || self.focus == Some(entity.id) {
            self.focus = None;
            response.request_focus();
        }
        if response.has_focus() && self.renaming.is_none() {
            self.keyboard(ui, row, &response, tree, asks);
        }
        if response.double_clicked() {
            asks.push(Ask::Frame(vec![entity.id]));
        }
        if response.secondary_clicked() && !selected {
            asks.push(Intent::Select(vec![entity.id]));
        }
        self.drag(ui, rect, &response, entity, tree, asks);
        response.context_menu(|ui| menu::context(ui, &tree.state, tree.bindings, asks));
    }

    /// Arrows go through the rows, fold and unfold.
    fn keyboard(&mut self, ui: &Ui, row: Row, response: &Response, tree: &Tree<'_>, asks: &mut Asks) {
        let arrows = EventFilter { horizontal_arrows: true, vertical_arrows: true, ..EventFilter::default() };
        ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, arrows));
        let (pressed, shift) = ui.input(|input| {
            let keys = [Key::ArrowUp, Key::ArrowDown, Key::ArrowLeft, Key::ArrowRight];
            (keys.into_iter().find(|key| input.key_pressed(*key)), input.modifiers.shift)
        });
        let Some(key) = pressed else { return };
        let is_open = row.has_children && !self.collapsed.contains(&row.id);
        let at = self.rows.iter().position(|other| other.id == row.id).unwrap_or(0);
        let to = match key {
            Key::ArrowUp => at.checked_sub(1),
            Key::ArrowDown => Some(at + 1),
            Key::ArrowLeft if is_open => return self.fold(row.id),
            Key::ArrowLeft => {
                let parent = tree.document.entity(row.id).and_then(|entity| entity.parent);
                self.rows.iter().position(|other| Some(other.id) == parent)
            }
            _ if is_open => Some(at + 1),
            _ if row.has_children => return self.fold(row.id),
            _ => None,
        };
        let Some(id) = to.and_then(|to| self.rows.get(to)).map(|row| row.id) else { return };
        self.focus = Some(id);
        self.reveal = Some(id);
        let how = if shift { Click::Range } else { Click::Replace };
        asks.push(Intent::Click { id, how, shown: self.shown() });
    }

    /// What is dragged is dropped before a row at its upper edge, behind it at its lower edge, and into it between.
    fn drag(
        &self,
        ui: &Ui,
        rect: Rect,
        response: &Response,
        entity: &Entity,
        tree: &Tree<'_>,
        asks: &mut Asks,
    ) {
        if response.drag_started() {
            let is_one_of_many = tree.selection.contains(entity.id);
            let ids = if is_one_of_many { tree.selection.ids().to_vec() } else { vec![entity.id] };
            response.dnd_set_drag_payload(Dragged(ids));
        }
        let Some(at) = ui.input(|input| input.pointer.hover_pos()) else { return };
        if response.dnd_hover_payload::<Dragged>().is_none() {
            return;
        }
        let share = (at.y - rect.top()) / rect.height();
        let accent = Stroke::new(2.0, theme::accent(ui.visuals()));
        match share {
            ..0.25 => drop(ui.painter().hline(rect.x_range(), rect.top(), accent)),
            0.75.. => drop(ui.painter().hline(rect.x_range(), rect.bottom(), accent)),
            _ => drop(ui.painter().rect_stroke(rect, 3.0, accent, egui::StrokeKind::Inside)),
        }
        let Some(dropped) = response.dnd_release_payload::<Dragged>() else { return };
        let siblings = tree.document.children(entity.parent);
        let next =
            siblings.iter().position(|id| *id == entity.id).and_then(|own| siblings.get(own + 1)).copied();
        let (parent, before) = match share {
            ..0.25 => (entity.parent, Some(entity.id)),
            0.75.. => (entity.parent, next),
            _ => (Some(entity.id), None),
        };
        asks.push(Intent::Reparent { ids: dropped.0.clone(), parent, before });
    }

    fn fold_button(&mut self, ui: &Ui, rect: Rect, entity: &Entity) {
        let open = !self.collapsed.contains(&entity.id);
        let response = ui.interact(rect, ui.scope_id().with(("fold", entity.id.0)), Sense::click());
        let name = format!("{} {}", if open { "Fold" } else { "Unfold" }, entity.name);
        response.widget_info(|| WidgetInfo::labeled(Role::Button, true, &name));
        let color =
            if response.hovered() { ui.visuals().strong_text_color() } else { theme::weak(ui.visuals()) };
        let c = rect.center();
        let points = match open {
            true => vec![c + vec2(-4.0, -2.0), c + vec2(4.0, -2.0), c + vec2(0.0, 3.0)],
            false => vec![c + vec2(-2.0, -4.0), c + vec2(3.0, 0.0), c + vec2(-2.0, 4.0)],
        };
        ui.painter().add(egui::Shape::convex_polygon(points, color, egui::Stroke::NONE));
        if response.clicked() {
            self.fold(entity.id);
        }
    }

    fn name_field(&mut self, ui: &mut Ui, rect: Rect, entity: &Entity, asks: &mut Asks) {
        let Some((_, name)) = &mut self.renaming else { return };
        let field = egui::TextEdit::singleline(name).margin(egui::Margin::symmetric(2, 1));
        let response = ui.put(rect, field);
        response.ctx.accesskit_node_builder(response.id, |node| node.set_label("Name"));
        if ui.input(|input| input.key_pressed(Key::Escape)) {
            self.renaming = None;
        } else if response.lost_focus() {
            let name = name.trim().to_owned();
            if !name.is_empty() && name != entity.name {
                asks.push(Intent::Rename { id: entity.id, name });
            }
            self.renaming = None;
        } else {
            response.request_focus();
        }
    }
}

fn paint_back(ui: &Ui, rect: Rect, response: &Response, selected: bool) {
    let visuals = ui.visuals();
    let fill = match (selected, response.hovered()) {
        (true, _) => visuals.selection.bg_fill,
        (false, true) => visuals.widgets.inactive.bg_fill.gamma_multiply(0.6),
        (false, false) => return,
    };
    ui.painter().rect_filled(rect, 3.0, fill);
}

fn color(ui: &Ui, selected: bool, hidden: bool) -> egui::Color32 {
    let visuals = ui.visuals();
    match (selected, hidden) {
        (true, _) => visuals.selection.stroke.color,
        (_, true) => theme::weak(visuals).gamma_multiply(0.6),
        _ => visuals.text_color(),
    }
}

/// Only what is locked has one: clicks in the scene view go through it.
fn unlock_button(ui: &Ui, rect: Rect, entity: &Entity, asks: &mut Asks) {
    let response = ui.interact(rect, ui.scope_id().with(("lock", entity.id.0)), Sense::click());
    let name = format!("Unlock {}", entity.name);
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, &name));
    let color = if response.hovered() { ui.visuals().strong_text_color() } else { theme::weak(ui.visuals()) };
    small_icon(ui, rect, Icon::Lock, color);
    if response.on_hover_text(name).clicked() {
        asks.push(Intent::Lock { ids: vec![entity.id], locked: false });
    }
}

fn eye_button(ui: &Ui, rect: Rect, entity: &Entity, asks: &mut Asks) {
    let response = ui.interact(rect, ui.scope_id().with(("eye", entity.id.0)), Sense::click());
    let name = format!("{} {}", if entity.hidden { "Show" } else { "Hide" }, entity.name);
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, &name));
    let color = if response.hovered() { ui.visuals().strong_text_color() } else { theme::weak(ui.visuals()) };
    small_icon(ui, rect, if entity.hidden { Icon::EyeShut } else { Icon::Eye }, color);
    if response.on_hover_text(name).clicked() {
        asks.push(Intent::Hide { ids: vec![entity.id], hidden: !entity.hidden });
    }
}
