//! The handles of what is selected, and pulls at them.

use eframe::egui;
use egui::{Color32, FontId, Key, Rect, vec2};
use glam::DQuat;

use super::hand::Hand;
use super::{Handling, Seen};
use crate::ask::Asks;
use crate::gizmo::typed::Typed;
use crate::gizmo::{self, Change, Grasp, Stand, Tool};
use crate::intents::Intent;
use crate::tools::transform;

#[derive(Default)]
pub(super) struct Handles {
    pull: Option<Pull>,
}

struct Pull {
    grasp: Grasp,
    starts: Vec<transform::Start>,
    typed: Typed,
    /// What it has come to, beside the mouse.
    told: String,
}

/// Where the handles stand.
pub(super) fn stand(handling: &Handling, seen: &Seen<'_>) -> Option<Stand> {
    let active = seen.document.entity(seen.selection.active()?)?;
    let world = seen.document.world_from_local(active.id);
    // Scales go along the axes of what is scaled: anything else would shear it.
    let local = handling.local || handling.tool == Tool::Scale;
    let axes = if local { transform::rotation_of(&world) } else { DQuat::IDENTITY };
    let origin = if handling.centre {
        let extent = seen.scenery.extent(|entity| seen.selection.contains(entity.id));
        extent.map_or(world.translation, |(low, high)| (low + high) * 0.5)
    } else {
        world.translation
    };
    Some(Stand { origin, axes })
}

impl Handles {
    pub fn is_pulled(&self) -> bool {
        self.pull.is_some()
    }

    /// Returns whether the mouse is theirs.
    pub fn handle(&mut self, hand: &Hand<'_>, handling: &Handling, asks: &mut Asks) -> bool {
        if hand.pressed && self.pull.is_none() {
            self.grasp(hand, handling);
        }
        let Some(pull) = &mut self.pull else { return false };
        if hand.ui.input(|input| input.key_pressed(Key::Escape)) {
            asks.push(Intent::Cancel);
            self.pull = None;
            return true;
        }
        let entered = hand.ui.input(|input| pull.typed.take(input));
        if let Some(change) = pull.change(hand, handling).filter(|_| hand.down || entered) {
            let own = !handling.centre && pull.starts.len() > 1 && !matches!(change, Change::Move(_));
            asks.push(Intent::Preview(transform::edit(&pull.starts, &pull.grasp.stand, &change, own)));
            pull.told = told(&change, &pull.typed);
        }
        if entered || !hand.down {
            asks.push(Intent::End);
            self.pull = None;
        }
        true
    }

    fn grasp(&mut self, hand: &Hand<'_>, handling: &Handling) -> Option<()> {
        let (at, stand) = (hand.at?, stand(handling, hand.seen)?);
        let handle = gizmo::under(hand.lens, &stand, handling.tool, at)?;
        self.pull = Some(Pull {
            grasp: Grasp::new(handle, stand, hand.lens, at),
            starts: transform::starts(hand.seen.document, hand.seen.selection.ids()),
            typed: Typed::default(),
            told: String::new(),
        });
        None
    }

    pub fn paint(&self, hand: &Hand<'_>, handling: &Handling) {
        let Some(mut stand) = stand(handling, hand.seen) else { return };
        let hot = match &self.pull {
            Some(pull) => {
                if handling.tool != Tool::Move {
                    stand = pull.grasp.stand;
                }
                Some(pull.grasp.handle)
            }
            None => {
                let at = hand.at.filter(|_| hand.over);
                at.and_then(|at| gizmo::under(hand.lens, &stand, handling.tool, at))
            }
        };
        gizmo::paint(&hand.painter(), hand.lens, &stand, handling.tool, hot);
        if let Some(pull) = &self.pull {
            tell_beside_mouse(hand, &pull.told);
        }
    }
}

impl Pull {
    /// What is typed counts, else where the mouse is.
    fn change(&mut self, hand: &Hand<'_>, handling: &Handling) -> Option<Change> {
        let Grasp { handle, stand, .. } = self.grasp;
        if !self.typed.is_empty() {
            return self.typed.change(handle, &stand, hand.lens.to_eye(stand.origin));
        }
        let steps = (handling.snap != hand.modifiers.command).then_some(&handling.steps);
        self.grasp.change(hand.lens, hand.at?, steps)
    }
}

/// What a pull came to; a caret behind what is typed.
fn told(change: &Change, typed: &Typed) -> String {
    let told = match change {
        Change::Move(way) => format!("{:.3}  {:.3}  {:.3} m", way.x, way.y, way.z),
        Change::Turn { angle, .. } => format!("{:.1}\u{b0}", angle.to_degrees()),
        Change::Scale(scale) => {
            let [x, y, z] = scale.to_array();
            if x == y && y == z { format!("\u{d7} {x:.2}") } else { format!("\u{d7} {x:.2}  {y:.2}  {z:.2}") }
        }
    };
    if typed.is_empty() { told } else { format!("{}|   {told}", typed.text) }
}

pub(super) fn tell_beside_mouse(hand: &Hand<'_>, told: &str) {
    let Some(at) = hand.at.filter(|_| !told.is_empty()) else { return };
    let painter = hand.painter();
    let galley = painter.layout_no_wrap(told.to_owned(), FontId::proportional(13.0), Color32::WHITE);
    // Inside the picture, wherever the mouse is.
    let room = hand.lens.rect.shrink(10.0);
    let place = (at + vec2(18.0, 10.0)).min(room.max - galley.size()).max(room.min);
    let back = Rect::from_min_size(place, galley.size()).expand2(vec2(6.0, 3.0));
    painter.rect_filled(back, 4.0, Color32::from_black_alpha(190));
    painter.galley(place, galley, Color32::WHITE);
}
