//! Direct light from punctual lights, at points: KHR_lights_punctual's formulas, in the transport's space.
//!
//! ```text
//! sun          H = E cos                                     E irradiance on a facing surface [W/m2]
//! point, spot  H = I cos / d^2 * window(d) * cone(angle)      I radiant intensity [W/sr]
//! ```
//! A light nearer to a patch than twice its size uses the patch's solid angle, H = I Omega / A, so that the
//! patch never receives more than the light gives.

use glam::{DAffine3, DVec3, Vec3};
use rayon::prelude::*;

use super::Transport;
use crate::scene::{EntityId, Light, LightKind, Scene};

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

    /// Unshadowed irradiance at a point with a unit normal [W/m2].
    pub fn irradiance(&self, position: Vec3, normal: Vec3) -> Vec3 {
        let (to_light, distance) = self.towards(position);
        let cosine = normal.dot(to_light).max(0.0);
        let fall_off = match self.light.kind {
            LightKind::Sun => 1.0,
            _ if distance > 0.0 => 1.0 / (distance * distance),
            _ => 0.0,
        };
        self.light.power() * (cosine * fall_off * self.share(to_light, distance))
    }
}

/// Irradiance from punctual lights at each patch, the mean over its samples [W/m2].
pub fn irradiance_of_patches(transport: &Transport, lights: &[PlacedLight], visible: &Visible) -> Vec<Vec3> {
    let extent = extent(transport);
    let lights: Vec<&PlacedLight> = lights.iter().filter(|light| light.light.power() != Vec3::ZERO).collect();
    transport
        .patches
        .par_iter()
        .map(|patch| {
            let samples = &transport.samples[patch.first_sample as usize..][..patch.sample_count as usize];
            let of_light = |light: &&PlacedLight| {
                let mut sum = Vec3::ZERO;
                let (mut seen, mut all) = (0.0, 0.0);
                for sample in samples {
                    let irradiance = light.irradiance(sample.position, sample.normal);
                    let amount = irradiance.element_sum();
                    if amount <= 0.0 {
                        continue;
                    }
                    all += amount;
                    let end = light.end(sample.position, extent);
                    if !light.light.casts_shadows || visible(sample.position, sample.normal, end) {
                        sum += irradiance;
                        seen += amount;
                    }
                }
                let near = matches!(light.light.kind, LightKind::Point)
                    && samples.iter().any(|s| s.position.distance_squared(light.position) < 4.0 * patch.area);
                if near && seen > 0.0 {
                    near_irradiance(transport, patch, light) * (seen / all)
                } else {
                    sum / samples.len().max(1) as f32
                }
            };
            lights.iter().map(of_light).sum()
        })
        .collect()
}

/// H = I Omega / A: the patch's solid angle seen from a light that is near it.
fn near_irradiance(transport: &Transport, patch: &super::Patch, light: &PlacedLight) -> Vec3 {
    let range = patch.first_triangle as usize..(patch.first_triangle + patch.triangle_count) as usize;
    let mut flux = 0.0;
    for t in range {
        let corners = transport.surface.positions(t).map(|corner| corner - light.position);
        let omega = solid_angle(corners) * if patch.back == 1 { 1.0 } else { -1.0 };
        let middle = (corners[0] + corners[1] + corners[2]).length() / 3.0;
        flux += omega.max(0.0) * light.light.window(middle);
    }
    light.light.power() * (flux / patch.area)
}

/// Signed solid angle of a triangle seen from the origin (Van Oosterom and Strackee 1983); negative when its
/// corners run counter-clockwise as seen from there.
fn solid_angle([a, b, c]: [Vec3; 3]) -> f32 {
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let numerator = a.dot(b.cross(c));
    let denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    2.0 * numerator.atan2(denominator)
}

/// A length no point of the scene is farther from its origin than.
pub fn extent(transport: &Transport) -> f32 {
    let far =
        transport.surface.vertices.iter().fold(0.0_f32, |far, vertex| far.max(vertex.position.length()));
    far.max(1e-3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_facing_triangle_has_a_negative_solid_angle_of_the_right_size() {
        // An octant of directions.
        let omega = solid_angle([Vec3::X, Vec3::Y, Vec3::Z]);
        assert!((omega.abs() - std::f32::consts::FRAC_PI_2).abs() < 1e-6, "{omega}");
        // Seen from the origin, x, y, z run counter-clockwise when looked at from outside, so the face looks
        // away from the origin: a front face towards the origin is the other way round.
        let [a, b, c] = [Vec3::X, Vec3::Y, Vec3::Z];
        let looks_at_origin = (b - a).cross(c - a).dot(-a) > 0.0;
        assert_eq!(looks_at_origin, omega < 0.0);
    }
}
