//! How much of each reflection probe a point reads.
//!
//! A probe's weight is 1 in its box, on the box's faces too (which are a room's walls and floor), and falls smoothly
//! to 0 over the blend distance beyond them. A surface is looked up from as far in front of it: what faces away from
//! a room does not read its probe through the wall.
//!
//! Probes of higher importance take first, smaller boxes before larger ones; what they leave goes to the next, and
//! what all leave to the sky:
//! ```text
//! w_k = left * raw_k / max(1, sum of raw in the group)      left <- left * (1 - min(1, sum of raw))
//! ```
//! where a group is boxes of one importance and of about one size. The weights and the sky's sum to 1, and all are
//! continuous along any line.

use glam::{DAffine3, DVec3, Mat3, Vec3};

use crate::scene::ReflectionProbe;

/// Boxes up to this many times as large as the smallest of a group share the group's light.
const ONE_SIZE: f32 = 2.0;
/// The least share of half the box over which a probe fades: nothing pops.
const LEAST_FADE: f32 = 0.02;

/// A box in which a probe is read, relative to the transport's origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Influence {
    /// Maps the box to -1 .. 1: `box_from_world * position + shift`.
    pub box_from_world: Mat3,
    pub shift: Vec3,
    /// Half the box along its own axes, metres.
    pub half: Vec3,
    /// Metres beyond the box over which it fades.
    pub fade: f32,
    /// Where the cubemap was taken.
    pub position: Vec3,
    pub importance: i32,
}

impl Influence {
    /// `None`: the box is flat or not finite, so that nothing is in it.
    pub fn new(probe: &ReflectionProbe, world_from_local: &DAffine3, origin: DVec3) -> Option<Self> {
        let m = world_from_local.matrix3;
        let half_axes = glam::DMat3::from_cols(
            m.x_axis * f64::from(probe.half_size.x),
            m.y_axis * f64::from(probe.half_size.y),
            m.z_axis * f64::from(probe.half_size.z),
        );
        let lengths = [half_axes.x_axis, half_axes.y_axis, half_axes.z_axis].map(DVec3::length);
        let inverse = half_axes.inverse();
        let centre = world_from_local.transform_point3(probe.offset.as_dvec3()) - origin;
        let shift = -(inverse * centre);
        if !(lengths.iter().all(|length| *length > 0.0) && inverse.is_finite() && shift.is_finite()) {
            return None;
        }
        let half = Vec3::from(lengths.map(|length| length as f32));
        let position = (world_from_local.translation - origin).as_vec3();
        let (box_from_world, shift) = (inverse.as_mat3(), shift.as_vec3());
        let is_one = half.is_finite() && position.is_finite() && half.min_element() > 0.0;
        if !(is_one && box_from_world.is_finite() && shift.is_finite()) {
            return None; // in single precision
        }
        let fade = probe.blend_distance.max(LEAST_FADE * half.min_element());
        Some(Self { box_from_world, shift, half, fade, position, importance: probe.importance })
    }

    /// Cubic metres, over 8.
    pub fn volume(&self) -> f32 {
        self.half.element_product()
    }

    /// How far a point is inside the box, metres; negative outside.
    pub fn depth(&self, position: Vec3) -> f32 {
        let inside = (Vec3::ONE - (self.box_from_world * position + self.shift).abs()) * self.half;
        // What is nowhere, or beyond all floats, is as far outside as can be.
        if inside.is_finite() { inside.min_element() } else { f32::MIN }
    }

    /// Its weight where no other probe is: 1 in the box, 0 farther away than the blend distance.
    pub fn raw(&self, position: Vec3) -> f32 {
        let t = (1.0 + self.depth(position) / self.fade.min(f32::MAX)).clamp(0.0, 1.0);
        t * t * (3.0 - 2.0 * t)
    }

    /// Whether any surface in a sphere reads the probe.
    pub fn touches(&self, centre: Vec3, radius: f32) -> bool {
        self.depth(centre) > -radius - 2.0 * self.fade
    }

    /// Where a ray from inside the box meets it, seen from where the cubemap was taken. A point outside counts as
    /// the nearest one of the box: the result stays continuous across its faces.
    pub fn projected(&self, position: Vec3, direction: Vec3) -> Vec3 {
        let from = (self.box_from_world * position + self.shift).clamp(Vec3::NEG_ONE, Vec3::ONE);
        let way = self.box_from_world * direction;
        let mut distance = f32::INFINITY;
        for axis in 0..3 {
            if way[axis] != 0.0 {
                distance = distance.min((way[axis].signum() - from[axis]) / way[axis]);
            }
        }
        if !distance.is_finite() {
            return direction;
        }
        let inside =
            position + self.world_from_box() * (from - (self.box_from_world * position + self.shift));
        let seen = inside + direction * distance - self.position;
        seen.normalize_or(direction)
    }

    fn world_from_box(&self) -> Mat3 {
        self.box_from_world.inverse()
    }
}

/// The order in which probes take, and the group of each, numbered upwards in that order.
pub fn ranked(probes: &[Influence]) -> Vec<(usize, u32)> {
    let mut order: Vec<usize> = (0..probes.len()).collect();
    let key = |index: &usize| (-i64::from(probes[*index].importance), probes[*index].volume());
    order.sort_by(|a, b| {
        let ((importance_a, volume_a), (importance_b, volume_b)) = (key(a), key(b));
        importance_a.cmp(&importance_b).then(volume_a.total_cmp(&volume_b)).then(a.cmp(b))
    });
    let mut group = 0;
    let mut first: Option<usize> = None;
    let number = |index: usize| {
        let probe = &probes[index];
        let same = first.is_some_and(|first: usize| {
            probes[first].importance == probe.importance
                && probe.volume() <= ONE_SIZE * probes[first].volume()
        });
        if !same {
            group += u32::from(first.is_some());
            first = Some(index);
        }
        (index, group)
    };
    order.into_iter().map(number).collect()
}

/// Weights at a point of probes that are [`ranked`], in that order; what they lack of 1 is the sky's.
pub fn weights(probes: &[Influence], ranked: &[(usize, u32)], position: Vec3) -> Vec<f32> {
    let raw: Vec<f32> = ranked.iter().map(|&(index, _)| probes[index].raw(position)).collect();
    let mut left = 1.0;
    let mut weights = Vec::with_capacity(raw.len());
    for group in ranked.chunk_by(|a, b| a.1 == b.1) {
        let raw = &raw[weights.len()..][..group.len()];
        let sum: f32 = raw.iter().sum();
        weights.extend(raw.iter().map(|raw| left * raw / sum.max(1.0)));
        left *= 1.0 - sum.min(1.0);
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    fn probe(centre: Vec3, half: Vec3, importance: i32) -> Influence {
        let settings = ReflectionProbe {
            half_size: half,
            blend_distance: 0.5,
            importance,
            ..ReflectionProbe::default()
        };
        let world = DAffine3::from_translation(centre.as_dvec3());
        Influence::new(&settings, &world, DVec3::ZERO).expect("a box")
    }

    /// A house: two rooms that overlap at the door, a niche in one, and something important in the other.
    fn probes() -> Vec<Influence> {
        vec![
            probe(Vec3::new(-2.0, 0.0, 0.0), Vec3::new(1.9, 1.5, 2.0), 0),
            probe(Vec3::new(2.0, 0.0, 0.0), Vec3::new(1.9, 1.5, 2.0), 0),
            probe(Vec3::new(-3.0, 0.0, 0.0), Vec3::new(0.8, 0.8, 0.8), 0),
            probe(Vec3::new(2.5, 0.2, 0.3), Vec3::new(1.0, 1.0, 1.0), 5),
            probe(Vec3::ZERO, Vec3::new(6.0, 3.0, 3.0), -1),
        ]
    }

    #[test]
    fn weights_sum_to_at_most_1_and_are_continuous_along_any_line() {
        let probes = probes();
        let ranked = ranked(&probes);
        let lines = [
            (Vec3::new(-7.0, 0.1, 0.2), Vec3::new(7.0, 0.3, 0.1)),
            (Vec3::new(2.6, -4.0, 0.3), Vec3::new(2.4, 4.0, 0.2)),
            (Vec3::new(-3.5, 1.0, -4.0), Vec3::new(3.0, -1.0, 4.0)),
        ];
        for (from, to) in lines {
            let steps = 20_000;
            let mut last: Option<Vec<f32>> = None;
            for step in 0..=steps {
                let at = from.lerp(to, step as f32 / steps as f32);
                let now = weights(&probes, &ranked, at);
                let sum: f32 = now.iter().sum();
                assert!(now.iter().all(|weight| *weight >= 0.0) && sum <= 1.0 + 1e-6, "{now:?} at {at}");
                if let Some(last) = &last {
                    // At most 1.5 / fade a metre each, times the way of a step, with room for groups.
                    let apart = now.iter().zip(last).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                    assert!(apart < 12.0 * (to - from).length() / steps as f32, "{apart} at {at}");
                }
                last = Some(now);
            }
        }
    }

    #[test]
    fn the_important_and_the_small_take_first() {
        let probes = probes();
        let ranked = ranked(&probes);
        let at = |position| {
            let weights = weights(&probes, &ranked, position);
            let mut by_probe = [0.0; 5];
            for (&(index, _), weight) in ranked.iter().zip(&weights) {
                by_probe[index] = *weight;
            }
            by_probe
        };
        assert_eq!(at(Vec3::new(-3.0, 0.0, 0.0)), [0.0, 0.0, 1.0, 0.0, 0.0]);
        assert_eq!(at(Vec3::new(2.5, 0.2, 0.3)), [0.0, 0.0, 0.0, 1.0, 0.0]);
        let door = at(Vec3::ZERO);
        assert!((door[0] - door[1]).abs() < 1e-6 && (door[0] + door[1] - 1.0).abs() < 1e-6, "{door:?}");
        assert_eq!(at(Vec3::new(0.0, 10.0, 0.0)), [0.0; 5]);
    }

    #[test]
    fn a_mirror_in_the_box_sees_the_walls_where_they_are() {
        let probe = probe(Vec3::new(1.0, 0.0, 0.0), Vec3::new(2.0, 1.0, 3.0), 0);
        // From the middle nothing is moved.
        let direction = Vec3::new(0.3, 0.5, -0.8).normalize();
        assert!(probe.projected(probe.position, direction).abs_diff_eq(direction, 1e-6));
        // Straight up from a corner meets the ceiling above that corner.
        let seen = probe.projected(Vec3::new(2.5, 0.0, 2.0), Vec3::Y);
        assert!(seen.abs_diff_eq(Vec3::new(1.5, 1.0, 2.0).normalize(), 1e-6), "{seen}");
        // Directions along an axis have zeros that nothing is divided by.
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            assert!(probe.projected(Vec3::new(1.7, 0.4, -1.0), axis).is_finite());
        }
        // From outside: as from the nearest point of the box.
        let outside = probe.projected(Vec3::new(1.0, 0.0, 9.0), Vec3::Y);
        assert!(outside.abs_diff_eq(probe.projected(Vec3::new(1.0, 0.0, 3.0), Vec3::Y), 1e-5));
    }

    #[test]
    fn a_turned_and_stretched_box_is_the_box_that_is_drawn() {
        let settings = ReflectionProbe { half_size: Vec3::new(1.0, 1.0, 1.0), ..ReflectionProbe::default() };
        let world = DAffine3::from_scale_rotation_translation(
            DVec3::new(3.0, 1.0, 1.0),
            glam::DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2),
            DVec3::new(10.0, 0.0, 0.0),
        );
        let probe = Influence::new(&settings, &world, DVec3::new(10.0, 0.0, 0.0)).expect("a box");
        assert!((probe.depth(Vec3::ZERO) - 1.0).abs() < 1e-6);
        assert!((probe.depth(Vec3::new(0.0, 0.0, 2.75)) - 0.25).abs() < 1e-5);
        assert!(probe.depth(Vec3::new(1.1, 0.0, 0.0)) < 0.0);
        let flat = ReflectionProbe { half_size: Vec3::new(1.0, 0.0, 1.0), ..ReflectionProbe::default() };
        assert_eq!(Influence::new(&flat, &world, DVec3::ZERO), None);
    }
}
