//! Snapping vertex to vertex: while V is held (or after it was tapped) a vertex of the selection is grasped and goes to
//! the vertex under the mouse, with all that is selected.

use std::collections::HashSet;

use eframe::egui;
use egui::{Color32, Key, Pos2, Rect, Stroke, StrokeKind, Vec2};
use engine::scene::EntityId;
use glam::{DQuat, DVec3};

use super::hand::Hand;
use super::handles::tell_beside_mouse;
use crate::ask::Asks;
use crate::gizmo::{Change, Stand};
use crate::intents::Intent;
use crate::theme;
use crate::tools::hit::Caster;
use crate::tools::transform;

/// Points within which a vertex is grasped, and snapped to.
const GRASP: f32 = 40.0;
const SNAP: f32 = 26.0;
/// Seconds; a key that was down no longer was tapped.
const TAP: f64 = 0.35;

#[derive(Default)]
pub(super) struct VertexSnapping {
    pull: Option<Pull>,
    /// Since when the key is down, and whether something was pulled meanwhile.
    held: Option<(f64, bool)>,
}

struct Pull {
    from: DVec3,
    starts: Vec<transform::Start>,
    moving: HashSet<EntityId>,
    told: String,
    target: Option<DVec3>,
}

impl VertexSnapping {
    pub fn is_pulled(&self) -> bool {
        self.pull.is_some()
    }

    /// A key that was held, or pulled with, ends with its release; one that was tapped stays.
    pub fn watch(&mut self, hand: &Hand<'_>, is_on: &mut bool) {
        let (down, now) = hand.ui.input(|input| (input.key_down(Key::V), input.time));
        match (down, self.held) {
            (true, None) => self.held = Some((now, false)),
            (false, Some((since, pulled))) => {
                self.held = None;
                *is_on &= !(pulled || now - since > TAP);
            }
            _ => {}
        }
    }

    /// Returns whether the mouse is its.
    pub fn handle(&mut self, hand: &Hand<'_>, caster: &mut Caster, asks: &mut Asks) -> bool {
        let Hand { lens, seen, .. } = *hand;
        let Some(at) = hand.at else { return self.is_pulled() };
        if hand.pressed && self.pull.is_none() {
            let indexed = seen.document.indexed();
            let moving: HashSet<EntityId> =
                seen.selection.ids().iter().flat_map(|id| indexed.subtree(*id)).collect();
            let own = caster.vertex(&seen.scenery, lens, at, GRASP, |entity| moving.contains(&entity.id));
            let starts = transform::starts(seen.document, seen.selection.ids());
            self.pull = own.map(|from| Pull { from, starts, moving, told: String::new(), target: None });
        }
        let Some(pull) = &mut self.pull else { return false };
        if let Some((_, pulled)) = &mut self.held {
            *pulled = true;
        }
        if hand.ends(asks) {
            self.pull = None;
            return true;
        }
        let others = |entity: &engine::scene::Entity| !pull.moving.contains(&entity.id);
        pull.target = caster.vertex(&seen.scenery, lens, at, SNAP, others);
        let free = || lens.ray(at).meets(pull.from, lens.to_eye(pull.from));
        if let Some(to) = pull.target.or_else(free) {
            let (way, stand) = (to - pull.from, Stand { origin: pull.from, axes: DQuat::IDENTITY });
            asks.push(Intent::Preview(transform::edit(&pull.starts, &stand, &Change::Move(way), false)));
            pull.told = format!("{:.3}  {:.3}  {:.3} m", way.x, way.y, way.z);
        }
        true
    }

    pub fn paint(&self, hand: &Hand<'_>, caster: &mut Caster) {
        let Hand { lens, seen, .. } = *hand;
        if let Some(pull) = &self.pull {
            if let Some((place, _)) = pull.target.and_then(|target| lens.project(target)) {
                mark(hand, place, theme::GRASPED);
            }
            return tell_beside_mouse(hand, &pull.told);
        }
        let Some(at) = hand.at.filter(|_| hand.over) else { return };
        let indexed = seen.document.indexed();
        let own: HashSet<EntityId> =
            seen.selection.ids().iter().flat_map(|id| indexed.subtree(*id)).collect();
        let near = caster.vertex(&seen.scenery, lens, at, GRASP, |entity| own.contains(&entity.id));
        if let Some((place, _)) = near.and_then(|near| lens.project(near)) {
            mark(hand, place, Color32::WHITE);
        }
    }
}

fn mark(hand: &Hand<'_>, place: Pos2, color: Color32) {
    let square = Rect::from_center_size(place, Vec2::splat(10.0));
    let painter = hand.painter();
    painter.rect_stroke(square, 1.0, Stroke::new(3.5, Color32::from_black_alpha(150)), StrokeKind::Middle);
    painter.rect_stroke(square, 1.0, Stroke::new(2.0, color), StrokeKind::Middle);
}
