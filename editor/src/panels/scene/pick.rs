//! What lies under the mouse, or inside a rectangle that it drew: icons first, then surfaces as the GPU sees them.

use std::collections::HashSet;

use eframe::egui;
use egui::{Pos2, Rect, Ui};
use engine::render::View;
use engine::render::picking::Pixels;
use engine::scene::EntityId;

use super::Seen;
use crate::lens::Lens;
use crate::selection::Selection;
use crate::viewport::marks::{self, Mark};
use crate::viewport::{Picture, Stage};

/// Shift adds, Ctrl takes away what is selected and adds what is not.
pub(super) fn joined(
    selection: &Selection,
    found: Vec<EntityId>,
    modifiers: egui::Modifiers,
) -> Vec<EntityId> {
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

fn pixel_of(ui: &Ui, lens: &Lens, at: Pos2) -> [u32; 2] {
    let off = (at - lens.rect.min) * ui.ctx().pixels_per_point();
    [off.x.max(0.0) as u32, off.y.max(0.0) as u32]
}

/// The first under the mouse: an icon, or else a surface.
pub(super) fn under(
    ui: &Ui,
    lens: &Lens,
    at: Pos2,
    marks: &[Mark],
    stage: &mut Stage,
    seen: &Seen<'_>,
    without: &HashSet<EntityId>,
) -> Option<EntityId> {
    let left: Vec<Mark> = marks.iter().copied().filter(|mark| !without.contains(&mark.entity)).collect();
    if let Some(id) = marks::under(&left, at) {
        return Some(id);
    }
    let [x, y] = pixel_of(ui, lens, at);
    let pixels = Pixels { low: [x, y], high: [x + 1, y + 1] };
    seen_in(ui, lens, pixels, stage, seen, without).first().copied()
}

pub(super) fn all_under(
    ui: &Ui,
    lens: &Lens,
    at: Pos2,
    marks: &[Mark],
    stage: &mut Stage,
    seen: &Seen<'_>,
) -> Vec<EntityId> {
    const MOST: usize = 24;
    let mut found = Vec::new();
    let mut without = HashSet::new();
    while let Some(id) = under(ui, lens, at, marks, stage, seen, &without).filter(|_| found.len() < MOST) {
        found.push(id);
        without.insert(id);
    }
    found
}

pub(super) fn in_area(
    ui: &Ui,
    lens: &Lens,
    area: Rect,
    marks: &[Mark],
    stage: &mut Stage,
    seen: &Seen<'_>,
) -> Vec<EntityId> {
    let pixels = Pixels { low: pixel_of(ui, lens, area.min), high: pixel_of(ui, lens, area.max) };
    let mut found = seen_in(ui, lens, pixels, stage, seen, &HashSet::new());
    found.extend(marks.iter().filter(|mark| area.contains(mark.at)).map(|mark| mark.entity));
    found
}

fn seen_in(
    ui: &Ui,
    lens: &Lens,
    pixels: Pixels,
    stage: &mut Stage,
    seen: &Seen<'_>,
    without: &HashSet<EntityId>,
) -> Vec<EntityId> {
    let size = Picture::pixels(stage.gpu(), lens.rect.size(), ui.ctx().pixels_per_point());
    let now = seen.scenery.now(lens.eye, View::Composite);
    let locked =
        seen.scenery.scene.entities.iter().map(|entity| entity.id).filter(|id| seen.document.is_locked(*id));
    let without = without.iter().copied().chain(locked).collect();
    let found = stage.renderer.seen_in(&now, size, pixels, &without).unwrap_or_default();
    found.into_iter().filter_map(|at| Some(seen.scenery.scene.entities.get(at)?.id)).collect()
}
