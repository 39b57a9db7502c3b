//! A camera looks along its entity's -Z, with +Y up.

use serde::{Deserialize, Serialize};

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    pub projection: Projection,
    /// Metres.
    pub near: f32,
    /// Metres; `None`: no far plane.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub far: Option<f32>,
    /// Display = 2^exposure * radiance, before the tonemap.
    #[serde(default)]
    pub exposure: f32,
    /// Instead of `exposure`, from what the picture shows. `None`: `exposure` holds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub auto_exposure: Option<AutoExposure>,
    #[serde(default, skip_serializing_if = "ToneCurve::is_neutral")]
    pub tonemap: ToneCurve,
}

/// Exposure that follows the picture: the mean of log2 luminance, without its darkest half and its brightest
/// twentieth, becomes middle grey, 0.18 (after Reinhard et al., "Photographic tone reproduction", 2002).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AutoExposure {
    /// Stops on top.
    pub compensation: f32,
    /// The exposure stays between these, in stops.
    pub least: f32,
    pub most: f32,
    /// 1/s: after a second, what is left of a change is e^-speed. Infinite: no adaptation, each picture by itself.
    pub speed: f32,
}

impl Default for AutoExposure {
    fn default() -> Self {
        Self { compensation: 0.0, least: -32.0, most: 32.0, speed: 2.0 }
    }
}

/// How exposed radiance becomes a display's colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ToneCurve {
    /// Linear up to 0.8, then bent towards white: colours are as measured.
    #[default]
    Neutral,
    /// As film: a soft toe and a long shoulder.
    Agx,
}

impl ToneCurve {
    fn is_neutral(&self) -> bool {
        *self == Self::Neutral
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Projection {
    /// Vertical field of view, radians.
    Perspective { fov_y: f32 },
    /// Half the height that is seen, metres.
    Orthographic { half_height: f32 },
}

impl Default for Camera {
    fn default() -> Self {
        Self {
            projection: Projection::Perspective { fov_y: 0.9 },
            near: 0.05,
            far: None,
            exposure: 0.0,
            auto_exposure: None,
            tonemap: ToneCurve::default(),
        }
    }
}

impl Camera {
    /// It sees something: an opening between nothing and a half turn, planes in their order.
    pub fn validate(&self) -> Result<(), String> {
        let (is_open, least_near) = match self.projection {
            Projection::Perspective { fov_y } => {
                (fov_y > 0.0 && fov_y < std::f32::consts::PI, f32::MIN_POSITIVE)
            }
            Projection::Orthographic { half_height } => (half_height > 0.0 && half_height.is_finite(), 0.0),
        };
        if !is_open {
            return Err(
                "the camera's field of view has to be larger than 0, and smaller than a half turn".to_owned()
            );
        }
        let has_depth =
            self.near >= least_near && self.near.is_finite() && self.far.is_none_or(|far| far > self.near);
        if !has_depth {
            return Err(
                "the camera's near plane has to lie before it, and its far plane beyond that".to_owned()
            );
        }
        if !self.exposure.is_finite() {
            return Err("the camera's exposure is not finite".to_owned());
        }
        self.auto_exposure.as_ref().map_or(Ok(()), AutoExposure::validate)
    }
}

impl AutoExposure {
    fn validate(&self) -> Result<(), String> {
        let is_finite = [self.compensation, self.least, self.most].into_iter().all(f32::is_finite);
        if !is_finite || self.least > self.most {
            return Err("the camera's automatic exposure needs finite stops, `least` up to `most`".to_owned());
        }
        if self.speed >= 0.0 {
            return Ok(());
        }
        Err("the camera's automatic exposure has a speed that is negative or no number".to_owned())
    }
}
