//! Selecting in the scene view: by clicks, by a rectangle, and from a list of what lies under the mouse.

use eframe::egui;
use egui::{PointerButton, Pos2, Rect, Ui};
use engine::scene::EntityId;

use super::Seen;
use super::hand::Hand;
use super::pick::{Pick, What};
use crate::ask::Asks;
use crate::intents::Intent;
use crate::theme;
use crate::viewport::Stage;
use crate::viewport::marks::Mark;

#[derive(Default)]
pub struct Choosing {
    boxed: Option<Pos2>,
    /// The last click, and what it went through.
    cycle: Option<(Pos2, Vec<EntityId>)>,
    /// The list of what lies under the mouse.
    list: Option<(Pos2, Vec<EntityId>)>,
    /// The right button was held to fly, and is no click.
    flew: bool,
}

impl Choosing {
    pub(super) fn is_boxing(&self) -> bool {
        self.boxed.is_some()
    }

    /// To be called with every picture, whatever the mouse does.
    pub(super) fn watch(&mut self, hand: &Hand<'_>) {
        let pressed = hand.ui.input(|input| input.pointer.secondary_pressed());
        self.flew = hand.response.dragged_by(PointerButton::Secondary) || self.flew && !pressed;
    }

    pub(super) fn handle(&mut self, hand: &Hand<'_>, marks: &[Mark], stage: &Stage, asks: &mut Asks) {
        let Hand { ui, response, lens, modifiers, .. } = *hand;
        if response.drag_started_by(PointerButton::Primary) && !modifiers.alt {
            self.boxed = ui.input(|input| input.pointer.press_origin());
        }
        if let (Some(from), Some(to)) = (self.boxed, hand.at) {
            let area = Rect::from_two_pos(from, to).intersect(lens.rect);
            paint_box(hand, area);
            if response.drag_stopped_by(PointerButton::Primary) {
                self.boxed = None;
                asks.push(Pick::inside(hand, area, marks, stage));
            }
            return;
        }
        let Some(at) = response.interact_pointer_pos() else { return };
        if response.clicked() {
            asks.push(Pick::under(hand, at, marks, stage, What::Click(at)));
        }
        if response.secondary_clicked() && !self.flew {
            asks.push(Pick::under(hand, at, marks, stage, What::List(at)));
        }
    }

    /// A click at the same place goes through what the ones before it found, to what lies beneath.
    pub fn through(&mut self, pick: &Pick) -> Vec<EntityId> {
        let What::Click(at) = pick.what else { return Vec::new() };
        let afresh = pick.modifiers.any();
        let again = self.cycle.take().filter(|(last, _)| !afresh && last.distance(at) < 3.0);
        again.map_or(Vec::new(), |(_, through)| through)
    }

    /// What a click found, after what it went through.
    pub fn went_through(&mut self, at: Pos2, through: Vec<EntityId>) {
        self.cycle = Some((at, through));
    }

    /// The list as far as it is known. Returns whether it is still looked at.
    pub fn list(&mut self, at: Pos2, found: &[EntityId]) -> bool {
        let is_open = found.len() == 1 || self.list.as_ref().is_some_and(|(of, _)| *of == at);
        if is_open {
            self.list = Some((at, found.to_vec()));
        }
        is_open
    }

    pub(super) fn list_under_mouse(&mut self, ui: &Ui, seen: &Seen<'_>, asks: &mut Asks) {
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

/// The rectangle that the mouse draws.
pub(super) fn paint_box(hand: &Hand<'_>, area: Rect) {
    let accent = theme::accent(hand.ui.visuals());
    let stroke = egui::Stroke::new(1.0, accent);
    hand.painter().rect(area, 0.0, accent.gamma_multiply(0.15), stroke, egui::StrokeKind::Inside);
}
