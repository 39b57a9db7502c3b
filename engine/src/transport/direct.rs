//! Direct light from punctual lights, at points: KHR_lights_punctual's formulas, in the transport's space.
//!
//! ```text
//! sun          H = E cos                                     E irradiance on a facing surface [W/m2]
//! point, spot  H = I cos / d^2 * window(d) * cone(angle)      I radiant intensity [W/sr]
//! ```
//! A light nearer to a patch than twice its size uses the patch's solid angle, H = I Omega / A, so that the
//! patch never receives more than the light gives ([`super::solid_angle`]).

use std::f32::consts::TAU;

use glam::{DAffine3, DVec3, Vec3};
use rayon::prelude::*;

use super::solid_angle::{cone_in_triangle, solid_angle};
use super::{Patch, Sample, Transport};
use crate::scene::{EntityId, Light, LightKind, Scene};

/// A light is never nearer to a point than this [m], and never gives more than this [W/m2]: of what validation lets
/// through (1e26 W/sr) sums over lights and samples are floats.
const NEAREST: f32 = 1e-6;
const BRIGHTEST: f32 = 1e34;

/// A light in the transport's space (metres from its origin).
#[derive(Clone, Debug)]
pub struct PlacedLight {
    pub entity: EntityId,
    pub light: Light,
    pub position: Vec3,
    /// Unit, the way its light goes (its entity's -Z).
    pub direction: Vec3,
}

/// Is the way from a point, moved off its surface along the normal, to another free?
pub type Visible<'a> = dyn Fn(Vec3, Vec3, Vec3) -> bool + Sync + 'a;

/// All lights of visible entities; those that are off have no power.
pub fn placed_lights(scene: &Scene, world_from_local: &[DAffine3], origin: DVec3) -> Vec<PlacedLight> {
    let placed = scene.entities.iter().zip(world_from_local).filter(|(entity, _)| !entity.hidden);
    placed
        .filter_map(|(entity, world)| {
            let light = entity.light.clone()?;
            let direction = world.transform_vector3(DVec3::NEG_Z).normalize_or(DVec3::NEG_Y).as_vec3();
            let position = (world.translation - origin).as_vec3();
            position.is_finite().then_some(PlacedLight { entity: entity.id, light, position, direction })
        })
        .collect()
}

impl PlacedLight {
    /// The unit direction to the light and how far it is.
    pub fn towards(&self, position: Vec3) -> (Vec3, f32) {
        match self.light.kind {
            LightKind::Sun => (-self.direction, f32::INFINITY),
            _ => {
                let way = self.position - position;
                let distance = way.length();
                (if distance > 0.0 { way / distance } else { Vec3::ZERO }, distance)
            }
        }
    }

    /// Where the shadow ray from a point ends. A sun's lies beyond the scene, whose extent is given.
    pub fn end(&self, position: Vec3, extent: f32) -> Vec3 {
        match self.light.kind {
            LightKind::Sun => position - self.direction * (4.0 * extent),
            _ => self.position,
        }
    }

    /// What the light's range and cone leave of it, 0..1.
    pub fn share(&self, to_light: Vec3, distance: f32) -> f32 {
        match self.light.kind {
            LightKind::Sun => 1.0,
            LightKind::Point => self.light.window(distance),
            LightKind::Spot { .. } => {
                let (scale, offset) = self.light.cone();
                let cone = (scale * self.direction.dot(-to_light) + offset).clamp(0.0, 1.0);
                self.light.window(distance) * cone * cone
            }
        }
    }

    /// Int of the cone over all directions: flux = I * this [sr].
    fn solid_angle(&self) -> f32 {
        let (scale, offset) = self.light.cone();
        match self.light.kind {
            LightKind::Spot { .. } => TAU * (1.0 - (1.0 - offset) / scale + 1.0 / (3.0 * scale)),
            _ => 2.0 * TAU,
        }
    }

    /// Unshadowed irradiance at a point with a unit normal [W/m2]; `disc`: what is added to the squared distance,
    /// 0 at a point.
    pub fn irradiance(&self, position: Vec3, normal: Vec3, disc: f32) -> Vec3 {
        let (to_light, distance) = self.towards(position);
        let cosine = normal.dot(to_light).max(0.0);
        let fall_off = match self.light.kind {
            LightKind::Sun => 1.0,
            _ => 1.0 / (distance.max(NEAREST).powi(2) + disc),
        };
        let most = if disc > 0.0 { self.solid_angle() / (disc * TAU) } else { f32::INFINITY };
        let arrives = self.light.power() * (cosine * fall_off * self.share(to_light, distance)).min(most);
        arrives.min(Vec3::splat(BRIGHTEST))
    }
}

/// Irradiance from punctual lights at each patch [W/m2].
pub fn irradiance_of_patches(transport: &Transport, lights: &[PlacedLight], visible: &Visible) -> Vec<Vec3> {
    let extent = extent(transport);
    let lights: Vec<&PlacedLight> = lights.iter().filter(|light| light.light.power() != Vec3::ZERO).collect();
    let of_patch = |patch: &Patch| {
        lights.iter().map(|light| irradiance_of_patch(transport, patch, light, extent, visible)).sum()
    };
    transport.patches.par_iter().map(of_patch).collect()
}

fn irradiance_of_patch(
    transport: &Transport,
    patch: &Patch,
    light: &PlacedLight,
    extent: f32,
    visible: &Visible,
) -> Vec3 {
    let samples = &transport.samples[patch.first_sample as usize..][..patch.sample_count as usize];
    let nearness = nearness(patch, light);
    let disc = disc(patch);
    let (mut sum, mut seen, mut all) = (Vec3::ZERO, 0.0, 0.0);
    for sample in samples {
        let irradiance = light.irradiance(sample.position, sample.normal, disc);
        let near_weight = if nearness > 0.0 { near_weight(sample, light) } else { 0.0 };
        if irradiance.max_element() <= 0.0 && near_weight <= 0.0 {
            continue;
        }
        all += near_weight;
        let end = light.end(sample.position, extent);
        if !light.light.casts_shadows || visible(sample.position, sample.normal, end) {
            sum += irradiance;
            seen += near_weight;
        }
    }
    let mean = sum / samples.len().max(1) as f32;
    if seen <= 0.0 {
        return mean * (1.0 - nearness);
    }
    mean * (1.0 - nearness) + near_irradiance(transport, patch, light) * (nearness * seen / all)
}

/// Triangles that cover less of the sphere around a spot [sr] are taken at their middle, where there are more than
/// these: others are given their exact part of the cone.
const SMALL: f32 = 0.01;
const FEW: u32 = 32;
/// Patches of more triangles than this (clusters: a part of a statue) are not summed over; see [`disc`].
const MANY: u32 = 1024;

/// 1 for a light nearer to a patch than 2.5 times its size, whose share is taken from the patch's solid angle; 0 beyond
/// 3.5 times, where the samples' mean is within half a percent; between them it goes from one to the other.
fn nearness(patch: &Patch, light: &PlacedLight) -> f32 {
    if matches!(light.light.kind, LightKind::Sun) || patch.triangle_count > MANY {
        return 0.0;
    }
    let sizes = light.position.distance(patch.centre) / patch.area.sqrt();
    (3.5 - sizes).clamp(0.0, 1.0)
}

/// What is added to squared distances [m2]. A sample of a cluster stands for a disc of the area a = A / samples,
/// whose solid angle a cos / (d^2 + a / 2 pi) is right far away (a point), over its middle (2 pi at no distance) and
/// within 15 % between; no sample takes more than 2 pi I, or than a spot has. A light over a ball gives it up to a fifth
/// of its light too much.
fn disc(patch: &Patch) -> f32 {
    if patch.triangle_count <= MANY { 0.0 } else { patch.area / (patch.sample_count.max(1) as f32 * TAU) }
}

/// How much a sample says of what is seen of a near patch: its part of the patch's solid angle.
fn near_weight(sample: &Sample, light: &PlacedLight) -> f32 {
    let way = light.position - sample.position;
    let squared = way.length_squared();
    sample.normal.dot(way).max(0.0) / (squared * squared.sqrt()).max(1e-18)
}

/// H = I Omega / A: what a light that is near gives a patch. Exact where the patch does not hide itself, which flat and
/// convex ones do not; of others the share of samples that are seen counts.
fn near_irradiance(transport: &Transport, patch: &Patch, light: &PlacedLight) -> Vec3 {
    let range = patch.first_triangle as usize..(patch.first_triangle + patch.triangle_count) as usize;
    let (scale, offset) = light.light.cone();
    let mut flux = 0.0;
    for t in range {
        let [a, b, c] = transport.surface.positions(t).map(|corner| corner - light.position);
        // Clockwise as seen from the light, where the side that counts faces it.
        let corners = if patch.back == 1 { [a, b, c] } else { [a, c, b] };
        let omega = solid_angle(corners);
        if omega <= 0.0 {
            continue;
        }
        let in_cone = match light.light.kind {
            LightKind::Spot { .. } if patch.triangle_count <= FEW || omega > SMALL => {
                cone_in_triangle(corners, light.direction, [scale, offset])
            }
            _ => {
                let cosine = light.direction.dot((a + b + c).normalize_or_zero());
                let cone = (scale * cosine + offset).clamp(0.0, 1.0);
                omega * cone * cone
            }
        };
        flux += in_cone * light.light.window((a + b + c).length() / 3.0);
    }
    (light.light.power() * (flux / patch.area)).min(Vec3::splat(BRIGHTEST))
}

/// A length no point of the scene is farther from its origin than.
pub fn extent(transport: &Transport) -> f32 {
    let far =
        transport.surface.vertices.iter().fold(0.0_f32, |far, vertex| far.max(vertex.position.length()));
    far.max(1e-3)
}
