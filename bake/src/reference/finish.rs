//! How a surface reflects at a point: Lambert's law, and the player's gloss on top.
//!
//! ```text
//! F0 = mix(0.04 (1 - r^4), albedo, metallic)      edge = mix(1 - r^4, 1, metallic)         r: perceptual roughness
//! once = F0 x + edge y                            x, y: split sum (Karis 2013)
//! mirrored = once * more                          more = 1 + F0 (1 / (x + y) - 1)          (Fdez-Aguera 2019)
//! f = albedo (1 - metallic) (1 - max mirrored) / pi + more (F0 + (edge - F0) (1 - vh)^5) D G2 / (4 nl nv)
//! ```
//! so that under uniform light a surface mirrors what the player's does, `mirrored`, and no more than it gets.

use std::f64::consts::{FRAC_1_PI, PI};

use engine::scene::Material;
use engine::transport::materials::SurfacePoint;
use glam::{DMat3, DVec3, Vec3};

use super::Surfaces;
use super::ggx::{self, SplitSum};
use super::world::World;
use crate::directions::{cosine_direction, frame};

/// Punctual lights have no size: no lobe is narrower than this perceptual roughness makes it, as the player has it.
const LEAST_ROUGHNESS: f64 = 0.045;

/// What reflects, seen from one direction.
pub struct Finish {
    /// Lambert's, after what is mirrored.
    diffuse: DVec3,
    gloss: Option<Gloss>,
    /// World from local, +Z the normal that shades.
    world_from_local: DMat3,
    /// The face's own, on the side that is seen.
    face: DVec3,
}

struct Gloss {
    facing: DVec3,
    edge: f64,
    more: DVec3,
    alpha: f64,
    /// How often a direction is drawn from the lobe.
    share: f64,
    /// To the viewer, local.
    view: DVec3,
}

/// A direction that a path goes on in.
pub struct Drawn {
    pub direction: DVec3,
    /// f cos / density.
    pub weight: DVec3,
    /// Per solid angle.
    pub density: f64,
}

/// Where a path arrives.
pub struct Arrival {
    pub triangle: u32,
    pub barycentric: [f32; 2],
    pub back: bool,
    pub to_viewer: DVec3,
}

impl Finish {
    /// What counts the light that arrives: f = 1 in all directions.
    pub fn meter(normal: Vec3) -> Self {
        Self {
            diffuse: DVec3::splat(PI),
            gloss: None,
            world_from_local: local(normal),
            face: normal.as_dvec3(),
        }
    }

    pub fn at(world: &World, arrival: &Arrival, surfaces: Surfaces, split: &SplitSum) -> Self {
        let material = world.material(arrival.triangle);
        let at = world.point(arrival.triangle, arrival.barycentric);
        let base = base_color(world, material, &at);
        let metals = world.data(&material.metallic_roughness_texture, &at);
        let metallic = f64::from((material.metallic * metals.z).clamp(0.0, 1.0));
        let side = if arrival.back { -1.0 } else { 1.0 };
        let face = world.normal(arrival.triangle) * side;
        let mut finish = Self {
            diffuse: base * (1.0 - metallic),
            gloss: None,
            world_from_local: local(face),
            face: face.as_dvec3(),
        };
        if material.unlit {
            finish.diffuse = DVec3::ZERO;
        } else if surfaces == Surfaces::Shiny {
            let smooth = world.shading_normal(arrival.triangle, arrival.barycentric, arrival.back);
            if smooth.as_dvec3().dot(arrival.to_viewer) > 1e-3 {
                finish.world_from_local = local(smooth);
            }
            let roughness = f64::from((material.roughness * metals.y).clamp(0.0, 1.0));
            finish.polish(base, metallic, roughness, arrival.to_viewer, split);
        }
        finish
    }

    fn polish(&mut self, base: DVec3, metallic: f64, roughness: f64, to_viewer: DVec3, split: &SplitSum) {
        let mut view = self.world_from_local.transpose() * to_viewer;
        view.z = view.z.max(1e-4);
        let view = view.normalize();
        let fade = 1.0 - roughness.powi(4);
        let facing = DVec3::splat(0.04 * fade).lerp(base, metallic);
        let edge = fade + (1.0 - fade) * metallic;
        let [x, y] = split.at(view.z, roughness);
        let more = DVec3::ONE + facing * (1.0 / (x + y).max(1e-3) - 1.0);
        let mirrored = (facing * x + DVec3::splat(edge * y)) * more;
        self.diffuse *= 1.0 - mirrored.max_element().min(1.0);
        let (shiny, rough) = (mirrored.max_element(), self.diffuse.max_element());
        if shiny > 0.0 {
            let alpha = roughness.max(LEAST_ROUGHNESS).powi(2);
            let share = if rough > 0.0 { (shiny / (shiny + rough)).clamp(0.1, 0.9) } else { 1.0 };
            self.gloss = Some(Gloss { facing, edge, more, alpha, share, view });
        }
    }

    /// Nothing leaves, whatever arrives.
    pub fn is_black(&self) -> bool {
        self.diffuse == DVec3::ZERO && self.gloss.is_none()
    }

    /// f cos for light from a unit direction.
    pub fn reflected(&self, from: DVec3) -> DVec3 {
        let light = self.world_from_local.transpose() * from;
        if light.z <= 0.0 || self.face.dot(from) <= 0.0 {
            return DVec3::ZERO;
        }
        let mut sum = self.diffuse * FRAC_1_PI;
        if let Some(gloss) = &self.gloss {
            sum += gloss.reflected(light);
        }
        sum * light.z
    }

    /// With which [`Finish::draw`] finds a unit direction, per solid angle.
    pub fn density(&self, from: DVec3) -> f64 {
        let light = self.world_from_local.transpose() * from;
        let by_cosine = light.z.max(0.0) * FRAC_1_PI;
        match &self.gloss {
            None => by_cosine,
            Some(_) if light.z <= 0.0 => 0.0,
            Some(gloss) => {
                let by_lobe = ggx::density(gloss.view, light, gloss.alpha);
                by_lobe * gloss.share + by_cosine * (1.0 - gloss.share)
            }
        }
    }

    /// A direction about as often as light leaves from it.
    pub fn draw(&self, [u, v, choice, _]: [f32; 4]) -> Option<Drawn> {
        let gloss = self.gloss.as_ref().filter(|gloss| f64::from(choice) < gloss.share);
        let local = match gloss {
            Some(gloss) => ggx::draw(gloss.view, gloss.alpha, f64::from(u), f64::from(v)),
            None => cosine_direction(u, v).as_dvec3(),
        };
        let direction = (self.world_from_local * local).normalize();
        let density = self.density(direction);
        let weight = match self.gloss {
            None => self.diffuse, // the cosine and its density cancel
            Some(_) => self.reflected(direction) / density,
        };
        (density > 0.0 && weight.is_finite() && weight != DVec3::ZERO).then_some(Drawn {
            direction,
            weight,
            density,
        })
    }
}

impl Gloss {
    fn reflected(&self, light: DVec3) -> DVec3 {
        let half = (self.view + light).normalize_or_zero();
        let fresnel = (1.0 - self.view.dot(half).clamp(0.0, 1.0)).powi(5);
        let once = self.facing + (DVec3::splat(self.edge) - self.facing) * fresnel;
        once * self.more * ggx::lobe(self.view, light, self.alpha)
    }
}

fn local(normal: Vec3) -> DMat3 {
    let (x, y) = frame(normal);
    DMat3::from_cols(x.as_dvec3(), y.as_dvec3(), normal.as_dvec3())
}

/// 0..1; NaN counts as 0.5, as in the bake.
fn base_color(world: &World, material: &Material, at: &SurfacePoint) -> DVec3 {
    let base =
        material.albedo.color * world.color(&material.albedo.texture, at).truncate() * at.color.truncate();
    base.map(|x| if x.is_nan() { 0.5 } else { x.clamp(0.0, 1.0) }).as_dvec3()
}
