//! What lies under the mouse, or inside a rectangle that it drew: icons first, then surfaces as the GPU sees them.
//!
//! The GPU is asked in one picture of the editor and its answer taken in a later one: nobody waits for it. So a question is
//! data, with all that it is about as it was when the mouse asked: where from, with which keys.

use eframe::egui;
use egui::{Modifiers, Pos2, Rect};
use engine::render::Eye;
use engine::render::picking::Pixels;
use engine::scene::EntityId;

use super::hand::Hand;
use crate::selection::Selection;
use crate::viewport::marks::{self, Mark};
use crate::viewport::{Picture, Stage};

/// A question of the mouse.
#[derive(Clone, Debug, PartialEq)]
pub struct Pick {
    pub what: What,
    pub modifiers: Modifiers,
    pub eye: Eye,
    /// Pixels of the picture, and those that are asked about.
    pub size: [u32; 2],
    pub pixels: Pixels,
    /// Icons that are met, the nearest first.
    pub icons: Vec<EntityId>,
}

/// What the answer is for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum What {
    /// The first there is selected; of clicks at the same place each goes through to what lies beneath.
    Click(Pos2),
    /// All of them, one beneath the other, are listed there.
    List(Pos2),
    /// All that is seen is selected.
    Area,
}

impl Pick {
    pub(super) fn under(hand: &Hand<'_>, at: Pos2, marks: &[Mark], stage: &Stage, what: What) -> Self {
        let [x, y] = pixel_of(hand, at);
        let pixels = Pixels { low: [x, y], high: [x + 1, y + 1] };
        Self::of(hand, pixels, marks::under(marks, at), stage, what)
    }

    pub(super) fn inside(hand: &Hand<'_>, area: Rect, marks: &[Mark], stage: &Stage) -> Self {
        let pixels = Pixels { low: pixel_of(hand, area.min), high: pixel_of(hand, area.max) };
        let icons = marks.iter().filter(|mark| area.contains(mark.at)).map(|mark| mark.entity);
        Self::of(hand, pixels, icons.collect(), stage, What::Area)
    }

    fn of(hand: &Hand<'_>, pixels: Pixels, icons: Vec<EntityId>, stage: &Stage, what: What) -> Self {
        let (rect, scale) = (hand.lens.rect, hand.ui.ctx().pixels_per_point());
        let size = Picture::pixels(stage.gpu(), rect.size(), scale);
        Self { what, modifiers: hand.modifiers, eye: hand.lens.eye, size, pixels, icons }
    }

    /// The first icon beneath those that it went through.
    pub fn icon(&self, through: &[EntityId]) -> Option<EntityId> {
        self.icons.iter().find(|icon| self.what != What::Area && !through.contains(icon)).copied()
    }
}

/// Shift adds, Ctrl takes away what is selected and adds what is not.
pub fn joined(selection: &Selection, found: Vec<EntityId>, modifiers: Modifiers) -> Vec<EntityId> {
    if !modifiers.shift && !modifiers.command {
        return found;
    }
    let mut ids: Vec<EntityId> = selection.ids().to_vec();
    for id in found {
        let was = ids.contains(&id);
        ids.retain(|other| *other != id);
        if !(was && modifiers.command) {
            ids.push(id);
        }
    }
    ids
}

fn pixel_of(hand: &Hand<'_>, at: Pos2) -> [u32; 2] {
    let off = (at - hand.lens.rect.min) * hand.ui.ctx().pixels_per_point();
    [off.x.max(0.0) as u32, off.y.max(0.0) as u32]
}
