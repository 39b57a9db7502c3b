//! Selecting in the scene view: by clicks, by a rectangle, and from a list of what lies under the mouse.

use std::collections::HashSet;

use eframe::egui;
use egui::{PointerButton, Pos2, Rect, Ui};
use engine::scene::EntityId;

use super::Seen;
use super::hand::Hand;
use super::pick::{all_under, in_area, joined, under};
use crate::ask::Asks;
use crate::intents::Intent;
use crate::theme;
use crate::viewport::Stage;
use crate::viewport::marks::Mark;

#[derive(Default)]
pub(super) struct Choosing {
    boxed: Option<Pos2>,
    /// The last click, and what it went through.
    cycle: Option<(Pos2, Vec<EntityId>)>,
    /// The list of what lies under the mouse.
    list: Option<(Pos2, Vec<EntityId>)>,
    /// The right button was held to fly, and is no click.
    flew: bool,
}

impl Choosing {
    pub fn is_boxing(&self) -> bool {
        self.boxed.is_some()
    }

    /// To be called with every picture, whatever the mouse does.
    pub fn watch(&mut self, hand: &Hand<'_>) {
        let pressed = hand.ui.input(|input| input.pointer.secondary_pressed());
        self.flew = hand.response.dragged_by(PointerButton::Secondary) || self.flew && !pressed;
    }

    pub fn handle(&mut self, hand: &Hand<'_>, marks: &[Mark], stage: &mut Stage, asks: &mut Asks) {
        let Hand { ui, response, lens, seen, modifiers, .. } = *hand;
        if response.drag_started_by(PointerButton::Primary) && !modifiers.alt {
            self.boxed = ui.input(|input| input.pointer.press_origin());
        }
        if let (Some(from), Some(to)) = (self.boxed, hand.at) {
            let area = Rect::from_two_pos(from, to).intersect(lens.rect);
            paint_box(hand, area);
            if response.drag_stopped_by(PointerButton::Primary) {
                self.boxed = None;
                let found = in_area(ui, lens, area, marks, stage, seen);
                asks.push(Intent::Select(joined(seen.selection, found, modifiers)));
            }
            return;
        }
        let Some(at) = response.interact_pointer_pos() else { return };
        if response.clicked() {
            let found = self.next_under(hand, at, marks, stage);
            asks.push(Intent::Select(joined(seen.selection, found.into_iter().collect(), modifiers)));
        }
        if response.secondary_clicked() && !self.flew {
            let found = all_under(ui, lens, at, marks, stage, seen);
            self.list = (!found.is_empty()).then_some((at, found));
        }
    }

    /// A click at the same place goes through to what lies beneath.
    fn next_under(
        &mut self,
        hand: &Hand<'_>,
        at: Pos2,
        marks: &[Mark],
        stage: &mut Stage,
    ) -> Option<EntityId> {
        let Hand { ui, lens, seen, .. } = *hand;
        let afresh = hand.modifiers.any();
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

    pub fn list_under_mouse(&mut self, ui: &Ui, seen: &Seen<'_>, asks: &mut Asks) {
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
