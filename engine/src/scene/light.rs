//! Punctual lights, as KHR_lights_punctual defines them. A light shines along its entity's -Z.

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::Changes;
use super::entity::yes;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Light {
    pub kind: LightKind,
    pub color: Vec3,
    /// Sun: irradiance on a facing surface [W/m2]. Point and spot: radiant intensity [W/sr].
    pub intensity: f32,
    /// Point and spot: the light is windowed to nothing at this distance [m]. `None`: it reaches all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<f32>,
    #[serde(default = "yes")]
    pub casts_shadows: bool,
    #[serde(default = "yes")]
    pub on: bool,
    #[serde(default)]
    pub changes: Changes,
    /// While the scene plays, and while it is on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub switching: Option<Switching>,
}

/// On and off by the clock, as a function of time alone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Switching {
    /// Seconds from one start to the next.
    pub period: f64,
    /// Of each period, from its start: 0..1.
    pub on_share: f64,
    /// Seconds by which it is ahead.
    #[serde(default)]
    pub offset: f64,
}

impl Switching {
    pub fn is_on(&self, seconds: f64) -> bool {
        ((seconds + self.offset) / self.period).rem_euclid(1.0) < self.on_share
    }

    /// It has a period, and a share of it.
    pub fn validate(&self) -> Result<(), String> {
        let is_one = self.period > 0.0
            && self.period.is_finite()
            && (0.0..=1.0).contains(&self.on_share)
            && self.offset.is_finite();
        let message = "its light switches with a period that is not larger than 0, a share outside 0..1 or an \
                       offset that is not finite";
        if is_one { Ok(()) } else { Err(message.to_owned()) }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LightKind {
    Sun,
    Point,
    /// Half angles in radians: full inside `inner`, nothing outside `outer`.
    Spot {
        inner: f32,
        outer: f32,
    },
}

impl Default for Light {
    fn default() -> Self {
        Self {
            kind: LightKind::Point,
            color: Vec3::ONE,
            intensity: 1.0,
            range: None,
            casts_shadows: true,
            on: true,
            changes: Changes::Anything,
            switching: None,
        }
    }
}

impl Light {
    /// The spot's scale and offset: share = saturate(scale * cos(angle) + offset)^2 (KHR_lights_punctual).
    /// Point and sun: (0, 1).
    pub fn cone(&self) -> (f32, f32) {
        match self.kind {
            LightKind::Spot { inner, outer } => {
                let scale = 1.0 / (inner.cos() - outer.cos()).max(1e-4);
                (scale, -outer.cos() * scale)
            }
            _ => (0.0, 1.0),
        }
    }

    /// What the range leaves of the light at this distance: saturate(1 - (d/range)^4), 1 without a range.
    pub fn window(&self, distance: f32) -> f32 {
        let part = |range: f32| if range == f32::INFINITY { 0.0 } else { distance / range };
        self.range.map_or(1.0, |range| (1.0 - part(range).powi(4)).clamp(0.0, 1.0))
    }

    /// Its spectrum: colour times intensity where it is on.
    pub fn power(&self) -> Vec3 {
        if self.on { self.color * self.intensity } else { Vec3::ZERO }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn switching_is_a_function_of_time() {
        let switching = Switching { period: 4.0, on_share: 0.25, offset: 1.0 };
        let on: Vec<f64> = (-4..8).map(f64::from).filter(|&at| switching.is_on(at)).collect();
        assert_eq!(on, [-1.0, 3.0, 7.0]);
        assert!(Switching { on_share: 1.0, ..switching }.is_on(1e9));
        assert!(!Switching { on_share: 0.0, ..switching }.is_on(3.0));
        for broken in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(Switching { period: broken, ..switching }.validate().is_err());
        }
        assert!(Switching { on_share: 1.1, ..switching }.validate().is_err());
        assert!(switching.validate().is_ok());
    }
}
