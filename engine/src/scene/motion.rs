//! How an entity moves while the scene plays, as a function of time alone.

use std::f64::consts::TAU;

use glam::{DMat3, DQuat, DVec3};
use serde::{Deserialize, Serialize};

use super::Transform;
use super::assets::Clip;
use super::entity::is_false;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Motion {
    /// Turns about an axis through its own origin, in its parent's space.
    Spin { axis: DVec3, radians_per_second: f64 },
    /// Goes along the points (in its parent's space) and back, there and back in `seconds`, slowing at the
    /// ends. `look`: its -Z faces along the path, +Y up, on the way back too, as a camera on rails.
    PingPong {
        points: Vec<DVec3>,
        seconds: f64,
        #[serde(default, skip_serializing_if = "is_false")]
        look: bool,
    },
    /// A node's animation out of an imported glTF file, repeated for ever.
    Clip { file: String, animation: u32, node: u32, speed: f64 },
}

/// Where the entity is after so many seconds. `clip` is what a [`Motion::Clip`] names, if it was loaded.
/// Where the motion makes no sense (no axis, no points, a time that is not finite), it is as authored.
pub fn moved(motion: &Motion, authored: &Transform, clip: Option<&Clip>, seconds: f64) -> Transform {
    let moved = match motion {
        Motion::Spin { axis, radians_per_second } => spun(authored, *axis, radians_per_second * seconds),
        Motion::PingPong { points, seconds: period, look } => {
            let share = there_and_back(seconds / period);
            let rotation = if *look { facing(points, share) } else { None }.unwrap_or(authored.rotation);
            along(points, share).map(|translation| Transform { translation, rotation, ..*authored })
        }
        Motion::Clip { speed, .. } => clip.map(|clip| clip.sample(speed * seconds, authored)),
    };
    moved.filter(Transform::is_finite).unwrap_or(*authored)
}

fn spun(authored: &Transform, axis: DVec3, angle: f64) -> Option<Transform> {
    let turn = DQuat::from_axis_angle(axis.try_normalize()?, angle % TAU);
    Some(Transform { rotation: (turn * authored.rotation).normalize(), ..*authored })
}

/// 0 at the start, 1 half a period later, with no speed at either: (1 - cos 2 pi t) / 2.
fn there_and_back(periods: f64) -> f64 {
    if periods.is_finite() { 0.5 - 0.5 * (TAU * periods.fract()).cos() } else { 0.0 }
}

/// The point at this share of the path's length.
fn along(points: &[DVec3], share: f64) -> Option<DVec3> {
    let lengths = points.windows(2).map(|side| side[0].distance(side[1]));
    let mut left = share * lengths.clone().sum::<f64>();
    for (side, length) in points.windows(2).zip(lengths) {
        if left <= length && length > 0.0 {
            return Some(side[0].lerp(side[1], left / length));
        }
        left -= length;
    }
    points.last().copied()
}

/// Looks from a tenth of the path behind to a tenth ahead, so that corners are turned and not jumped. `None`:
/// straight up or down, or nowhere.
fn facing(points: &[DVec3], share: f64) -> Option<DQuat> {
    let way = along(points, (share + 0.1).min(1.0))? - along(points, (share - 0.1).max(0.0))?;
    let back = -way.try_normalize()?;
    let right = DVec3::Y.cross(back).try_normalize()?;
    Some(DQuat::from_mat3(&DMat3::from_cols(right, back.cross(right), back)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(motion: &Motion, seconds: f64) -> Transform {
        moved(motion, &Transform::default(), None, seconds)
    }

    #[test]
    fn spin_turns_about_the_axis_of_the_parent() {
        let motion = Motion::Spin { axis: DVec3::Y * 7.0, radians_per_second: TAU / 4.0 };
        assert!((at(&motion, 1.0).rotation * DVec3::X).abs_diff_eq(DVec3::NEG_Z, 1e-12));
        assert!((at(&motion, -1.0).rotation * DVec3::X).abs_diff_eq(DVec3::Z, 1e-12));
        let tilted = Transform { rotation: DQuat::from_rotation_x(1.0), ..Transform::default() };
        let turned = moved(&motion, &tilted, None, 2.0).rotation;
        assert!(turned.angle_between(DQuat::from_rotation_y(TAU / 2.0) * tilted.rotation) < 1e-6);
    }

    #[test]
    fn ping_pong_goes_there_and_back_by_length() {
        let points = vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 3.0, 0.0)];
        let motion = Motion::PingPong { points, seconds: 6.0, look: false };
        for (seconds, expected) in [
            (0.0, DVec3::ZERO),
            (1.0, DVec3::X), // (1 - cos 60 deg) / 2 = a quarter of 4 m
            (3.0, DVec3::new(1.0, 3.0, 0.0)),
            (5.0, DVec3::X),
            (6.0, DVec3::ZERO),
            (-1.0, DVec3::X),
        ] {
            assert!(at(&motion, seconds).translation.abs_diff_eq(expected, 1e-12), "{seconds}");
        }
    }

    #[test]
    fn what_looks_along_its_path_turns_smoothly_and_never_about() {
        let points = vec![DVec3::ZERO, DVec3::X * 4.0, DVec3::new(4.0, 0.0, -4.0)];
        let motion = Motion::PingPong { points, seconds: 8.0, look: true };
        let forward = |seconds| at(&motion, seconds).rotation * DVec3::NEG_Z;
        assert!(forward(0.0).abs_diff_eq(DVec3::X, 1e-9));
        assert!(forward(4.0).abs_diff_eq(DVec3::NEG_Z, 1e-9), "at the turn");
        assert!(forward(8.0).abs_diff_eq(DVec3::X, 1e-9), "back, facing on");
        for step in 0..800 {
            let (now, next) = (forward(f64::from(step) * 0.01), forward(f64::from(step + 1) * 0.01));
            assert!(now.angle_between(next) < 0.05 && now.y.abs() < 1e-9, "{step}");
        }
        let lift = Motion::PingPong { points: vec![DVec3::ZERO, DVec3::Y], seconds: 1.0, look: true };
        assert_eq!(at(&lift, 0.3).rotation, DQuat::IDENTITY, "straight up: as authored");
    }

    #[test]
    fn any_motion_is_finite_at_any_time() {
        let far = DVec3::splat(f64::MAX);
        let path =
            |points: &[DVec3], seconds| Motion::PingPong { points: points.to_vec(), seconds, look: true };
        let motions = [
            Motion::Spin { axis: DVec3::ZERO, radians_per_second: 1.0 },
            Motion::Spin { axis: DVec3::X, radians_per_second: f64::MAX },
            Motion::Spin { axis: DVec3::NAN, radians_per_second: f64::NAN },
            path(&[], 1.0),
            path(&[DVec3::ONE], 0.0),
            path(&[DVec3::ONE, DVec3::ONE], -1.0),
            path(&[far, -far], 1.0),
            path(&[DVec3::NAN, DVec3::ONE], f64::NAN),
            Motion::Clip { file: String::new(), animation: 0, node: 0, speed: f64::INFINITY },
        ];
        for motion in &motions {
            for seconds in [0.0, 1.0, -1.0, 1e-300, 1e300, f64::NAN, f64::INFINITY] {
                assert!(at(motion, seconds).is_finite(), "{motion:?} {seconds}");
            }
        }
        assert_eq!(at(&motions[3], 1.0), Transform::default());
        assert_eq!(at(&motions[4], 1.0).translation, DVec3::ONE);
    }
}
