//! Light that was solved at the bake, where nothing but brightness may change afterwards.
//!
//! The system is linear in its sources, so that the light of all of them is the sum of what each comes to:
//! ```text
//! B = B_never + Sum_s i_s B_s        H, L likewise
//! ```
//! B_never is the light of all that never changes, as authored; B_s is the *response* to source s at intensity 1, and
//! i_s its intensity now: a light's own and 0 while it is off, an emission's strength, a sky's brightness. No row is
//! needed for that, and no product: the player's file has the responses in place of the matrix.
//!
//! Numbers are single floats, as the GPU's are: half floats would show as bands of 1/2048 in a dim gradient.

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::Transport;
use super::directional::AXES;
use super::sh::COEFFICIENTS;
use crate::scene::{EntityId, MaterialId, Scene, Sky, SkyKind};

/// No sum of responses is above [W/m2]: sums over it are floats.
const BRIGHTEST: f32 = 1e34;

/// What shines.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// All that never changes: lights, surfaces and sky.
    Never,
    /// A punctual light, by its entity.
    Light(EntityId),
    /// All surfaces of a material.
    Emission(MaterialId),
    Sky,
}

/// Light on all spaces. What is empty is dark.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Spread {
    /// B by patch [W/m2].
    pub radiosity: Vec<Vec3>,
    /// By receiver: irradiance from what surfaces and sky emit, and from what bounced [W/m2]. What comes straight
    /// from punctual lights is in neither.
    pub receivers: [Vec<Vec3>; 2],
    /// Nine coefficients a probe, likewise [W/m2/sr].
    pub probes: [Vec<Vec3>; 2],
    /// Three directional terms for each of the first receivers, likewise [W/m2].
    pub directional: [Vec<Vec3>; 2],
}

/// What a source comes to at intensity 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Response {
    pub source: Source,
    pub spread: Spread,
}

#[derive(Clone, Debug, Default, PartialEq)]
pub struct Solved {
    /// No source twice.
    pub responses: Vec<Response>,
}

impl Solved {
    /// By response: the intensity of its source in the scene as it is now.
    pub fn scale(&self, scene: &Scene) -> Vec<f32> {
        self.responses.iter().map(|response| response.source.intensity(scene)).collect()
    }

    /// The sum of all responses, each times its scale.
    pub fn combine(&self, scale: &[f32]) -> Spread {
        let mut sum = Spread::default();
        for (response, &scale) in self.responses.iter().zip(scale).filter(|(_, scale)| **scale != 0.0) {
            for (into, from) in sum.arrays_mut().into_iter().zip(response.spread.arrays()) {
                add(into, from, scale);
            }
        }
        sum
    }

    /// Every array has one vector for each place, or none; all are light.
    pub(super) fn validate(&self, transport: &Transport) -> Result<(), String> {
        for (index, response) in self.responses.iter().enumerate() {
            if self.responses[..index].iter().any(|before| before.source == response.source) {
                return Err(format!("two responses to {:?}", response.source));
            }
            for (values, count) in response.spread.arrays().into_iter().zip(Spread::lengths(transport)) {
                let is_whole = values.is_empty() || values.len() == count;
                if !is_whole || values.iter().any(|value| !value.is_finite()) {
                    return Err(format!("the response to {:?} is not of these spaces", response.source));
                }
            }
        }
        Ok(())
    }
}

impl Spread {
    /// Radiosity, receivers, probes, directional terms: in the order of [`Self::NAMES`].
    pub fn arrays(&self) -> [&Vec<Vec3>; 7] {
        let ([a, b], [c, d], [e, f]) = (&self.receivers, &self.probes, &self.directional);
        [&self.radiosity, a, b, c, d, e, f]
    }

    pub fn arrays_mut(&mut self) -> [&mut Vec<Vec3>; 7] {
        let ([a, b], [c, d], [e, f]) = (&mut self.receivers, &mut self.probes, &mut self.directional);
        [&mut self.radiosity, a, b, c, d, e, f]
    }

    pub const NAMES: [&str; 7] = [
        "radiosity",
        "receivers.emitted",
        "receivers.bounced",
        "probes.emitted",
        "probes.bounced",
        "directional.emitted",
        "directional.bounced",
    ];

    /// Of the arrays, where they are not empty.
    pub fn lengths(transport: &Transport) -> [usize; 7] {
        let (receivers, probes) = (transport.receivers.len(), transport.probes.len() * COEFFICIENTS);
        let terms = transport.directional_receivers() * AXES;
        [transport.patches.len(), receivers, receivers, probes, probes, terms, terms]
    }
}

fn add(into: &mut Vec<Vec3>, from: &[Vec3], scale: f32) {
    into.resize(into.len().max(from.len()), Vec3::ZERO);
    for (into, from) in into.iter_mut().zip(from) {
        *into = (*into + *from * scale).clamp(Vec3::splat(-BRIGHTEST), Vec3::splat(BRIGHTEST));
    }
}

impl Source {
    /// What its response is multiplied by.
    pub fn intensity(self, scene: &Scene) -> f32 {
        match self {
            Self::Never => 1.0,
            Self::Light(id) => {
                let entity = scene.entity(id).filter(|entity| !entity.hidden);
                let light = entity.and_then(|entity| entity.light.as_ref()).filter(|light| light.on);
                light.map_or(0.0, |light| light.intensity)
            }
            Self::Emission(id) => scene.material(id).map_or(0.0, |material| material.emission.strength),
            Self::Sky => brightness(&scene.sky),
        }
    }
}

/// Of a sky: what its colours are multiplied by. A picture's strength, else the largest channel of all.
pub fn brightness(sky: &Sky) -> f32 {
    match &sky.kind {
        SkyKind::None => 0.0,
        SkyKind::Constant { radiance } => radiance.max_element(),
        SkyKind::Gradient { zenith, horizon, ground, .. } => zenith.max(*horizon).max(*ground).max_element(),
        SkyKind::Picture { strength, .. } => *strength,
    }
}

/// The same sky at brightness 1; a black one stays black.
pub fn at_brightness_one(sky: &Sky) -> Sky {
    let share = 1.0 / brightness(sky);
    let mut sky = sky.clone();
    match &mut sky.kind {
        SkyKind::Picture { strength, .. } => *strength = 1.0,
        _ if !share.is_finite() => {}
        SkyKind::None => {}
        SkyKind::Constant { radiance } => *radiance *= share,
        SkyKind::Gradient { zenith, horizon, ground, .. } => {
            [zenith, horizon, ground].into_iter().for_each(|color| *color *= share);
        }
    }
    sky
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Entity, Light};

    fn response(source: Source, bounced: f32) -> Response {
        let receivers = [Vec::new(), vec![Vec3::splat(bounced); 2]];
        Response { source, spread: Spread { receivers, ..Spread::default() } }
    }

    #[test]
    fn responses_add_up_each_times_the_intensity_of_its_source() {
        let lamp = Entity { id: EntityId(7), light: Some(Light::default()), ..Entity::default() };
        let mut scene = Scene { entities: vec![lamp], ..Scene::default() };
        let solved = Solved {
            responses: vec![response(Source::Never, 1.0), response(Source::Light(EntityId(7)), 2.0)],
        };
        let light = |scene: &Scene| solved.combine(&solved.scale(scene)).receivers[1][1].x;
        assert_eq!(light(&scene), 3.0);
        let lamp = |scene: &mut Scene, on, intensity| {
            *scene.entities[0].light.as_mut().unwrap() = Light { on, intensity, ..Light::default() };
        };
        lamp(&mut scene, true, 0.5);
        assert_eq!(light(&scene), 2.0);
        lamp(&mut scene, false, 0.5);
        assert_eq!(light(&scene), 1.0);
        lamp(&mut scene, true, f32::MAX);
        assert!(light(&scene).is_finite());
        assert!(solved.combine(&solved.scale(&scene)).radiosity.is_empty());
    }

    #[test]
    fn a_sky_is_its_brightness_times_the_same_sky_at_one() {
        let constant = SkyKind::Constant { radiance: Vec3::new(1.0, 2.0, 4.0) };
        let sky = Sky { kind: constant, ..Sky::default() };
        assert_eq!((brightness(&sky), brightness(&at_brightness_one(&sky))), (4.0, 1.0));
        let black = Sky { kind: SkyKind::Constant { radiance: Vec3::ZERO }, ..Sky::default() };
        assert_eq!(at_brightness_one(&black), black);
    }

    #[test]
    fn responses_of_other_spaces_are_refused() {
        let transport = Transport { receivers: vec![Default::default(); 2], ..Transport::default() };
        let with = |responses| Solved { responses }.validate(&transport);
        assert!(with(vec![response(Source::Sky, 1.0)]).is_ok());
        assert!(with(vec![response(Source::Sky, 1.0), response(Source::Sky, 1.0)]).is_err());
        assert!(with(vec![response(Source::Never, f32::NAN)]).is_err());
        let mut longer = response(Source::Never, 1.0);
        longer.spread.receivers[1].push(Vec3::ZERO);
        assert!(with(vec![longer]).is_err());
    }
}
