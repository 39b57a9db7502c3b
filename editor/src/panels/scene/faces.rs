//! The box of a selected reflection probe, and handles in the middle of its faces: a pull moves that face alone, with Alt
//! the one opposite too.

use eframe::egui;
use egui::{Color32, Pos2, Stroke};
use engine::scene::{EntityId, ReflectionProbe};
use glam::{DAffine3, DVec3};

use super::Handling;
use super::hand::Hand;
use super::handles::tell_beside_mouse;
use crate::ask::Asks;
use crate::edit::{Edit, Field};
use crate::intents::Intent;
use crate::theme;

/// Points.
const HIT: f32 = 9.0;
/// Half a box, metres in its own space.
const THINNEST: f32 = 0.01;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Face {
    axis: usize,
    ahead: bool,
}

const FACES: [Face; 6] = [
    Face { axis: 0, ahead: false },
    Face { axis: 0, ahead: true },
    Face { axis: 1, ahead: false },
    Face { axis: 1, ahead: true },
    Face { axis: 2, ahead: false },
    Face { axis: 2, ahead: true },
];

#[derive(Default)]
pub(super) struct Faces {
    pull: Option<Pull>,
}

struct Pull {
    entity: EntityId,
    probe: ReflectionProbe,
    world: DAffine3,
    face: Face,
    /// Where the mouse met the face's axis, metres from the face.
    met: f64,
    told: String,
}

impl Face {
    fn sign(self) -> f32 {
        if self.ahead { 1.0 } else { -1.0 }
    }

    fn middle(self, probe: &ReflectionProbe, world: &DAffine3) -> DVec3 {
        let mut middle = probe.offset;
        middle[self.axis] += probe.half_size[self.axis] * self.sign();
        world.transform_point3(middle.as_dvec3())
    }

    /// Outwards, unit; `None`: the box is flat.
    fn way(self, world: &DAffine3) -> Option<DVec3> {
        (world.matrix3.col(self.axis) * f64::from(self.sign())).try_normalize()
    }
}

impl Faces {
    pub fn is_pulled(&self) -> bool {
        self.pull.is_some()
    }

    /// Returns whether the mouse is theirs.
    pub fn handle(&mut self, hand: &Hand<'_>, handling: &Handling, asks: &mut Asks) -> bool {
        if hand.pressed && self.pull.is_none() {
            self.pull = grasped(hand);
        }
        let Some(pull) = &mut self.pull else { return false };
        if hand.ends(asks) {
            self.pull = None;
            return true;
        }
        if let Some(along) = hand.at.and_then(|at| along(hand, at, pull.face, &pull.probe, &pull.world)) {
            let steps = (handling.snap != hand.modifiers.command).then_some(handling.steps.metres);
            let metres = along - pull.met;
            let metres = steps.map_or(metres, |step| (metres / step).round() * step);
            let probe = pulled(&pull.probe, &pull.world, pull.face, metres, hand.modifiers.alt);
            let size = probe.half_size * 2.0;
            pull.told = format!("{:.2} \u{d7} {:.2} \u{d7} {:.2} m", size.x, size.y, size.z);
            let field = Field::ReflectionProbe(Some(Box::new(probe)));
            asks.push(Intent::Preview(Edit::set(pull.entity, field)));
        }
        true
    }

    pub fn paint(&self, hand: &Hand<'_>) {
        let Some((_, probe, world)) = chosen(hand) else { return };
        let hot = match &self.pull {
            Some(pull) => Some(pull.face),
            None => hand.at.filter(|_| hand.over).and_then(|at| under(hand, at, &probe, &world)),
        };
        let painter = hand.painter();
        for face in FACES {
            let Some((place, _)) = hand.lens.project(face.middle(&probe, &world)) else { continue };
            let is_hot = hot == Some(face);
            let color = if is_hot { theme::GRASPED } else { theme::AXES[face.axis] };
            let radius = if is_hot { 6.5 } else { 5.0 };
            painter.circle(place, radius, color, Stroke::new(1.5, Color32::from_black_alpha(170)));
        }
        if let Some(pull) = &self.pull {
            tell_beside_mouse(hand, &pull.told);
        }
    }
}

/// The active entity, where it is a reflection probe.
fn chosen(hand: &Hand<'_>) -> Option<(EntityId, ReflectionProbe, DAffine3)> {
    let entity = hand.seen.document.entity(hand.seen.selection.active()?)?;
    let probe = entity.reflection_probe.clone()?;
    Some((entity.id, probe, hand.seen.document.world_from_local(entity.id)))
}

fn under(hand: &Hand<'_>, at: Pos2, probe: &ReflectionProbe, world: &DAffine3) -> Option<Face> {
    let near = FACES.into_iter().filter_map(|face| {
        let (place, depth) = hand.lens.project(face.middle(probe, world))?;
        (place.distance(at) <= HIT).then_some((face, depth))
    });
    near.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(face, _)| face)
}

fn grasped(hand: &Hand<'_>) -> Option<Pull> {
    let (at, (entity, probe, world)) = (hand.at?, chosen(hand)?);
    let face = under(hand, at, &probe, &world)?;
    let met = along(hand, at, face, &probe, &world)?;
    Some(Pull { entity, probe, world, face, met, told: String::new() })
}

/// Metres from the face to where the mouse meets its axis.
fn along(hand: &Hand<'_>, at: Pos2, face: Face, probe: &ReflectionProbe, world: &DAffine3) -> Option<f64> {
    hand.lens.ray(at).nearest_on(face.middle(probe, world), face.way(world)?)
}

/// `both`: the opposite face too, so that the middle stays.
fn pulled(probe: &ReflectionProbe, world: &DAffine3, face: Face, metres: f64, both: bool) -> ReflectionProbe {
    let mut new = probe.clone();
    let axis = face.axis;
    let own = (metres / world.matrix3.col(axis).length().max(1e-9)) as f32;
    let grown = if both { own } else { own * 0.5 };
    new.half_size[axis] = (probe.half_size[axis] + grown).max(THINNEST);
    if !both {
        new.offset[axis] += (new.half_size[axis] - probe.half_size[axis]) * face.sign();
    }
    if new.half_size.is_finite() && new.offset.is_finite() { new } else { probe.clone() }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    const RIGHT: Face = Face { axis: 0, ahead: true };

    #[test]
    fn one_face_moves_and_the_opposite_one_stays() {
        let probe = ReflectionProbe { half_size: Vec3::splat(2.0), ..ReflectionProbe::default() };
        let world = DAffine3::from_scale(DVec3::new(2.0, 1.0, 1.0));
        let new = pulled(&probe, &world, RIGHT, 1.0, false);
        let left = Face { ahead: false, ..RIGHT };
        assert!(left.middle(&new, &world).abs_diff_eq(left.middle(&probe, &world), 1e-6));
        let way = RIGHT.middle(&new, &world) - RIGHT.middle(&probe, &world);
        assert!(way.abs_diff_eq(DVec3::X, 1e-6), "{way}");
        let both = pulled(&probe, &world, RIGHT, 1.0, true);
        assert_eq!((both.offset, both.half_size.x), (Vec3::ZERO, 2.5));
    }

    #[test]
    fn a_box_is_never_turned_inside_out() {
        let probe = ReflectionProbe::default();
        let new = pulled(&probe, &DAffine3::IDENTITY, RIGHT, -100.0, false);
        assert_eq!(new.half_size.x, THINNEST);
        let flat = DAffine3::from_scale(DVec3::new(0.0, 1.0, 1.0));
        assert_eq!(RIGHT.way(&flat), None);
    }
}
