//! Edits of the probes of one light probe group. Places are the world's, groups hold their own space.

use std::collections::BTreeSet;

use engine::scene::{EntityId, LightProbeGroup};
use glam::{DAffine3, DVec3, Vec3};

use crate::edit::{Edit, Field};

/// By their places in the group.
pub type Chosen = BTreeSet<usize>;

/// A box is not filled with more.
pub const MOST: usize = 20_000;

/// The group's probes are these from now on.
pub fn edit(id: EntityId, name: &str, group: LightProbeGroup) -> Edit {
    Edit::several(name, [Edit::set(id, Field::LightProbes(Some(Box::new(group))))])
}

/// The chosen go this way (metres, world).
pub fn moved(group: &LightProbeGroup, world: &DAffine3, chosen: &Chosen, way: DVec3) -> LightProbeGroup {
    let mut group = group.clone();
    let local = world.inverse();
    for &probe in chosen {
        if let Some(position) = group.positions.get_mut(probe) {
            let place = world.transform_point3(position.as_dvec3()) + way;
            let new = local.transform_point3(place).as_vec3();
            *position = if new.is_finite() { new } else { *position };
        }
    }
    group
}

/// The chosen once more, in the same places; and those that are new.
pub fn duplicated(group: &LightProbeGroup, chosen: &Chosen) -> (LightProbeGroup, Chosen) {
    let mut group = group.clone();
    let first = group.positions.len();
    let copies: Vec<Vec3> = chosen.iter().filter_map(|probe| group.positions.get(*probe).copied()).collect();
    group.positions.extend(copies);
    let new = (first..group.positions.len()).collect();
    (group, new)
}

pub fn removed(group: &LightProbeGroup, chosen: &Chosen) -> LightProbeGroup {
    let left = group.positions.iter().enumerate().filter(|(at, _)| !chosen.contains(at));
    LightProbeGroup { positions: left.map(|(_, position)| *position).collect() }
}

/// One more, at a place of the world; `None`: the group's space does not reach there.
pub fn added(group: &LightProbeGroup, world: &DAffine3, place: DVec3) -> Option<(LightProbeGroup, Chosen)> {
    let mut group = group.clone();
    let position = world.inverse().transform_point3(place).as_vec3();
    group.positions.push(position);
    let new = Chosen::from([group.positions.len() - 1]);
    position.is_finite().then_some((group, new))
}

/// The box about the chosen, or about all where fewer than two are; in the group's space.
pub fn extent(group: &LightProbeGroup, chosen: &Chosen) -> Option<[Vec3; 2]> {
    let all = chosen.len() < 2;
    let inside = group.positions.iter().enumerate().filter(|(at, _)| all || chosen.contains(at));
    inside.map(|(_, position)| [*position; 2]).reduce(|[low, high], [a, b]| [low.min(a), high.max(b)])
}

/// How many probes stand along each side of a box, no farther apart than `spacing` (metres, world).
pub fn counts([low, high]: [Vec3; 2], world: &DAffine3, spacing: f64) -> [usize; 3] {
    [0, 1, 2].map(|axis| {
        let length = f64::from(high[axis] - low[axis]) * world.matrix3.col(axis).length();
        let steps = (length / spacing.max(1e-3) - 1e-6).ceil().max(0.0);
        // What has no length has one layer.
        1 + (steps as usize).min(MOST)
    })
}

/// A grid of probes from one corner of a box to the other, instead of those that were in it.
pub fn filled(
    group: &LightProbeGroup,
    [low, high]: [Vec3; 2],
    counts: [usize; 3],
) -> (LightProbeGroup, Chosen) {
    let is_inside = |position: &Vec3| position.cmpge(low - 1e-4).all() && position.cmple(high + 1e-4).all();
    let mut positions: Vec<Vec3> = group.positions.iter().filter(|p| !is_inside(p)).copied().collect();
    let first = positions.len();
    let share = |at: usize, count: usize| if count > 1 { at as f32 / (count - 1) as f32 } else { 0.5 };
    for z in 0..counts[2] {
        for y in 0..counts[1] {
            let row = (0..counts[0])
                .map(|x| Vec3::new(share(x, counts[0]), share(y, counts[1]), share(z, counts[2])));
            positions.extend(row.map(|share| low + (high - low) * share));
        }
    }
    let new = (first..positions.len()).collect();
    (LightProbeGroup { positions }, new)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn group() -> LightProbeGroup {
        LightProbeGroup { positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(2.0, 1.0, 0.0)] }
    }

    #[test]
    fn probes_are_moved_the_worlds_way_whatever_the_groups_space_is() {
        let turn = glam::DQuat::from_rotation_y(0.7);
        let world = DAffine3::from_scale_rotation_translation(DVec3::splat(2.0), turn, DVec3::Y);
        let moved = moved(&group(), &world, &Chosen::from([1, 9]), DVec3::Y * 3.0);
        let place = |position: Vec3| world.transform_point3(position.as_dvec3());
        let expected = place(Vec3::X) + DVec3::Y * 3.0;
        assert!(place(moved.positions[1]).abs_diff_eq(expected, 1e-5));
        assert_eq!(moved.positions[0], Vec3::ZERO);
    }

    #[test]
    fn probes_are_copied_taken_away_and_added() {
        let (copied, new) = duplicated(&group(), &Chosen::from([0, 2]));
        assert_eq!((copied.positions.len(), new), (5, Chosen::from([3, 4])));
        assert_eq!(removed(&copied, &Chosen::from([0, 4])).positions.len(), 3);
        let (added, new) = added(&group(), &DAffine3::from_translation(DVec3::Z), DVec3::ZERO).unwrap();
        assert_eq!((added.positions[3], new), (Vec3::NEG_Z, Chosen::from([3])));
        let flat = DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0));
        assert!(super::added(&group(), &flat, DVec3::Y).is_none());
    }

    #[test]
    fn a_box_is_filled_with_a_grid_no_wider_than_asked() {
        let all = Chosen::new();
        let reach = extent(&group(), &all).unwrap();
        let counts = counts(reach, &DAffine3::IDENTITY, 0.5);
        assert_eq!(counts, [5, 3, 1]);
        let (filled, new) = filled(&group(), reach, counts);
        assert_eq!((filled.positions.len(), new.len()), (15, 15), "those that were there are gone");
        assert!(filled.positions.contains(&Vec3::new(2.0, 1.0, 0.0)));
        assert_eq!(extent(&LightProbeGroup::default(), &all), None);
        assert_eq!(super::counts([Vec3::ZERO, Vec3::splat(1e9)], &DAffine3::IDENTITY, 0.1), [MOST + 1; 3]);
    }
}
