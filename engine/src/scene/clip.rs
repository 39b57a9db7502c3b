//! Key frames in time (glTF 2.0, appendix C: step, linear with slerp, cubic Hermite splines).

use glam::{DQuat, DVec4, Vec3, Vec4};

use super::Transform;
use super::assets::{Channel, Clip, Interpolation};

impl Clip {
    /// The node's transform after so many seconds; the clip starts over when it ends. What has no channel,
    /// and what would not be finite, stays as authored.
    pub fn sample(&self, seconds: f64, authored: &Transform) -> Transform {
        let length = f64::from(self.seconds);
        let at = if length > 0.0 && seconds.is_finite() { seconds.rem_euclid(length) } else { 0.0 };
        let point = |channel: &Option<Channel<Vec3>>| {
            let value = value_at(channel.as_ref()?, at, |v| v.as_dvec3().extend(0.0), DVec4::lerp)?;
            Some(value.truncate())
        };
        let turn = |channel: &Option<Channel<Vec4>>| {
            let value = value_at(channel.as_ref()?, at, |v| v.as_dvec4(), slerp)?;
            value.try_normalize().map(DQuat::from_vec4)
        };
        Transform {
            translation: point(&self.translation).unwrap_or(authored.translation),
            rotation: turn(&self.rotation).unwrap_or(authored.rotation),
            scale: point(&self.scale).unwrap_or(authored.scale),
        }
    }
}

/// Outside its keys a channel keeps its first or last value. `None`: no keys, or nothing finite.
fn value_at<T: Copy>(
    channel: &Channel<T>,
    seconds: f64,
    wide: impl Fn(T) -> DVec4,
    mix: impl Fn(DVec4, DVec4, f64) -> DVec4,
) -> Option<DVec4> {
    let is_spline = channel.interpolation == Interpolation::CubicSpline;
    let row = |key: usize, part: usize| {
        let at = if is_spline { 3 * key + part } else { key };
        channel.values.get(at).map(|&value| wide(value))
    };
    let value = |key: usize| row(key, 1);
    let time = |key: usize| channel.times.get(key).map(|&time| f64::from(time));
    let after = channel.times.partition_point(|&time| f64::from(time) <= seconds);
    let found = if after == 0 {
        value(0)?
    } else if after == channel.times.len() || channel.interpolation == Interpolation::Step {
        value(after - 1)?
    } else {
        let (from, to) = (time(after - 1)?, time(after)?);
        let t = ((seconds - from) / (to - from)).clamp(0.0, 1.0);
        let (a, b) = (value(after - 1)?, value(after)?);
        if is_spline {
            let (leaving, arriving) = (row(after - 1, 2)?, row(after, 0)?);
            hermite(a, leaving * (to - from), b, arriving * (to - from), t)
        } else {
            mix(a, b, t)
        }
    };
    found.is_finite().then_some(found)
}

fn slerp(a: DVec4, b: DVec4, t: f64) -> DVec4 {
    let unit = |q: DVec4| DQuat::from_vec4(q.try_normalize().unwrap_or(DVec4::W));
    DVec4::from(unit(a).slerp(unit(b), t))
}

fn hermite(a: DVec4, leaving: DVec4, b: DVec4, arriving: DVec4, t: f64) -> DVec4 {
    let (t2, t3) = (t * t, t * t * t);
    (2.0 * t3 - 3.0 * t2 + 1.0) * a
        + (t3 - 2.0 * t2 + t) * leaving
        + (3.0 * t2 - 2.0 * t3) * b
        + (t3 - t2) * arriving
}

#[cfg(test)]
mod tests {
    use std::f32::consts::FRAC_1_SQRT_2;

    use glam::DVec3;

    use super::*;

    fn sliding(interpolation: Interpolation, values: Vec<Vec3>) -> Clip {
        let times = vec![0.0, 1.0, 3.0];
        Clip { seconds: 4.0, translation: Some(Channel { times, values, interpolation }), ..Clip::default() }
    }

    fn x_at(clip: &Clip, seconds: f64) -> f64 {
        clip.sample(seconds, &Transform::default()).translation.x
    }

    #[test]
    fn keys_are_held_joined_or_curved() {
        let values = [1.0, 2.0, 6.0].map(|x| Vec3::X * x).to_vec();
        let step = sliding(Interpolation::Step, values.clone());
        let linear = sliding(Interpolation::Linear, values);
        for (seconds, stepped, straight) in [
            (0.0, 1.0, 1.0),
            (0.5, 1.0, 1.5),
            (2.0, 2.0, 4.0),
            (3.5, 6.0, 6.0),
            (4.5, 1.0, 1.5),
            (-1.0, 6.0, 6.0),
        ] {
            assert_eq!((x_at(&step, seconds), x_at(&linear, seconds)), (stepped, straight), "{seconds}");
        }
        // x = t^2 has the tangent 2 t; a cubic Hermite spline keeps it exactly.
        let parabola = [0.0, 1.0, 3.0f32].iter().flat_map(|t| [2.0 * t, t * t, 2.0 * t]);
        let curved = sliding(Interpolation::CubicSpline, parabola.map(|x| Vec3::X * x).collect());
        for seconds in [0.0, 0.3, 1.0, 1.7, 2.9] {
            assert!((x_at(&curved, seconds) - seconds * seconds).abs() < 1e-12);
        }
    }

    #[test]
    fn rotations_go_the_short_way_at_even_speed() {
        let values = vec![Vec4::W, Vec4::new(0.0, -FRAC_1_SQRT_2, 0.0, -FRAC_1_SQRT_2)]; // a quarter about +Y
        let rotation = Some(Channel { times: vec![0.0, 1.0], values, interpolation: Interpolation::Linear });
        let clip = Clip { seconds: 2.0, rotation, ..Clip::default() };
        let turned = clip.sample(1.0 / 3.0, &Transform::default()).rotation;
        let expected = DQuat::from_rotation_y(std::f64::consts::FRAC_PI_6);
        assert!(turned.angle_between(expected) < 1e-6, "{turned}");
    }

    #[test]
    fn broken_clips_leave_what_was_authored() {
        let authored = Transform::at(DVec3::new(1.0, 2.0, 3.0));
        let nothing = Channel { times: vec![], values: vec![], interpolation: Interpolation::CubicSpline };
        let short = Channel {
            times: vec![0.0, 1.0, 2.0],
            values: vec![Vec3::NAN],
            interpolation: Interpolation::Linear,
        };
        for channel in [nothing, short] {
            let clip = Clip { seconds: f32::NAN, translation: Some(channel.clone()), ..Clip::default() };
            for seconds in [0.0, -3.0, 1.5, 1e300, f64::NAN, f64::INFINITY] {
                assert_eq!(clip.sample(seconds, &authored), authored);
                let endless = Clip { seconds: 2.0, ..clip.clone() };
                assert_eq!(endless.sample(seconds, &authored), authored);
            }
        }
        let one = Channel { times: vec![5.0], values: vec![Vec3::ONE], interpolation: Interpolation::Linear };
        let clip = Clip { seconds: 5.0, translation: Some(one), ..Clip::default() };
        assert_eq!(clip.sample(7.0, &authored).translation, DVec3::ONE);
    }
}
