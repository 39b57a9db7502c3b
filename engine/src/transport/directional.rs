//! Directional terms: what a normal map makes of irradiance that is known for the surface's own normal alone.
//!
//! A bump tilts the normal n to m, by an angle t. It sees what its surface sees, and under the surface's horizon the
//! slopes beside it, which are taken to be as bright as the mean of what arrives, E/pi:
//! ```text
//! E(m) = Int L(w) (m.w)+ dw  +  h E          over the half space of n;   h = (1 - cos t) / 2
//! ```
//! so that light that is the same from everywhere is the same for every tilt. Besides E three numbers a channel are
//! known, an axis each,
//! ```text
//! V = Int L(w) f(w) dw        f(w) = w - (n.w) n + (1 - 2 n.w) n                             [W/m2]
//! ```
//! along the surface the irradiance vector, across it how much more light is low than high. All of V is 0 where light is
//! the same from everywhere. E and V say which radiance l0 + l.w arrives, the one that is linear in the direction, and of
//! that the integral is in closed form (over a lune, whose parts are sin t - t cos t and t sin t):
//! ```text
//! E(m) = E + (1 - t/pi) V.s + (1 - cos t - 2/pi (sin t - t cos t)) V.n        s = m - cos t n
//! ```
//! Where light comes from a narrow cone that is too much: what the tilt then hides is told by F = (V along the surface) +
//! E n, the irradiance vector, alone. The integral without what is hidden,
//! ```text
//! E(m) >= max((1 - h) E + V.s, h E)
//! ```
//! is a bound that always holds, and exact for a small lamp. Between the two goes k = 3 (1 - |F|/Z), clamped to 0..1, with
//! Z = 2 E + V.n the light from everywhere: a radiance l0 + l.w >= 0 has |F|/Z <= 2/3, a small lamp has 1. At m = n both
//! are E itself. What is emitted and what bounced are tilted each by itself, and a lamp stays one in a bright room.
//!
//! V is a row of B as E is. Why not its likes, in the error of irradiance over tilts up to 45 degrees in a box lit by a
//! lamp in a wall: E alone 16 %, with the irradiance vector 4.7 %, with V 2.6 %, with three numbers weighted by the cosine,
//! as a histogram of E's own rays gives them, 7.8 %: what is low counts most, and the cosine has next to nothing of it.
//!
//! (Irradiance vector: Arvo 1994. Terms along the surface for normal maps: McTaggart 2004; of the hemisphere: Habel and
//! Wimmer 2010. Both take fixed directions; here the linear radiance is the basis, so that n itself is exact.)

use std::f64::consts::PI;

use glam::{DVec3, Vec3};

use super::{Batch, Transport};
use crate::scene::{Entity, MaterialId, Scene};

/// Rows a receiver: V along x, y and z of the scene.
pub const AXES: usize = 3;
/// No light of radiosity at most 1 gives more along any axis: (1/pi) Int |a.f| <= (1/pi) sqrt(2 pi * 2 pi/3).
pub const MOST: f64 = 1.154_700_538_379_251_5;

/// Is there a static surface whose normals are tilted by a map?
pub fn any_directional(scene: &Scene) -> bool {
    let is_static = |entity: &&Entity| entity.is_static && !scene.is_hidden(entity);
    let materials = |entity: &Entity| entity.mesh.as_ref().map(|renderer| renderer.materials.clone());
    let mut used = scene.entities.iter().filter(is_static).filter_map(materials).flatten();
    used.any(|material| is_bumped(scene, material))
}

pub fn is_bumped(scene: &Scene, material: MaterialId) -> bool {
    scene.material(material).is_some_and(|material| material.normal_texture.is_some())
}

/// f(w) of light that comes from a direction.
pub fn weight(direction: Vec3, normal: Vec3) -> Vec3 {
    direction + normal * (1.0 - 3.0 * normal.dot(direction))
}

/// E(m) by channel, from E and V (a vector of channels for each axis).
pub fn tilted(irradiance: DVec3, terms: [DVec3; AXES], normal: DVec3, tilted: DVec3) -> DVec3 {
    let cosine = normal.dot(tilted).clamp(-1.0, 1.0);
    let aside = tilted - normal * cosine;
    let (sine, angle) = (aside.length(), aside.length().atan2(cosine));
    let along = |axis: DVec3| terms[0] * axis.x + terms[1] * axis.y + terms[2] * axis.z;
    let (tilts, across) = (along(aside), along(normal));
    let hidden = 0.5 * (1.0 - cosine);
    let linear = irradiance
        + tilts * (1.0 - angle / PI)
        + across * (1.0 - cosine - 2.0 / PI * (sine - angle * cosine));
    let least = (irradiance * (1.0 - hidden) + tilts).max(irradiance * hidden);
    let squared: DVec3 = terms.into_iter().map(|term| term * term).sum();
    let vector = (squared - across * across + irradiance * irradiance).max(DVec3::ZERO);
    let everywhere = (2.0 * irradiance + across).max(DVec3::splat(f64::MIN_POSITIVE));
    let share = (3.0 - 3.0 * vector.map(f64::sqrt) / everywhere).clamp(DVec3::ZERO, DVec3::ONE);
    least + share * (linear - least).max(DVec3::ZERO)
}

impl Transport {
    /// How many receivers have directional terms: the first ones.
    pub fn directional_receivers(&self) -> usize {
        self.directional_terms() / AXES
    }

    /// Rows of directional terms, or what light that was solved at the bake has in their place.
    pub fn directional_terms(&self) -> usize {
        let responses = self.solved.iter().flat_map(|solved| &solved.responses);
        let solved = responses.flat_map(|response| &response.spread.directional).map(Vec::len).max();
        self.directional_from_patch.len().max(solved.unwrap_or(0))
    }

    /// Whether normal maps tilt the light of a batch: all that its vertices blend has directional terms.
    pub fn is_directional(&self, batch: &Batch) -> bool {
        let known = self.directional_receivers();
        let triangles = batch.first as usize..(batch.first + batch.count) as usize;
        let knows = |vertex: u32| {
            let blends =
                [self.surface.blends.get(vertex as usize), self.surface.back_blends.get(vertex as usize)];
            let mut used =
                blends.into_iter().flatten().flat_map(|blend| blend.receivers.into_iter().zip(blend.weights));
            used.all(|(receiver, weight)| weight == 0.0 || (receiver as usize) < known)
        };
        known > 0 && self.surface.triangles[triangles].iter().flatten().all(|&vertex| knows(vertex))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// E and V of a radiance, by a fine grid of directions; and E(m) likewise.
    fn of(radiance: impl Fn(DVec3) -> f64, normal: DVec3, m: DVec3) -> (f64, [DVec3; 3], f64) {
        let (x, y) = (normal.any_orthonormal_vector(), normal.cross(normal.any_orthonormal_vector()));
        let (mut e, mut v, mut truth) = (0.0, DVec3::ZERO, 0.0);
        let (rings, steps) = (400, 400);
        for i in 0..rings {
            let z = (f64::from(i) + 0.5) / f64::from(rings);
            for k in 0..steps {
                let turn = (f64::from(k) + 0.5) / f64::from(steps) * 2.0 * PI;
                let around = (1.0 - z * z).sqrt();
                let w = x * (around * turn.cos()) + y * (around * turn.sin()) + normal * z;
                let light = radiance(w) * 2.0 * PI / f64::from(rings * steps);
                e += light * z;
                v += weight(w.as_vec3(), normal.as_vec3()).as_dvec3() * light;
                truth += light * m.dot(w).max(0.0);
            }
        }
        (e, [v.x, v.y, v.z].map(DVec3::splat), truth + 0.5 * (1.0 - normal.dot(m)) * e)
    }

    fn tilt(normal: DVec3, angle: f64, turn: f64) -> DVec3 {
        let x = normal.any_orthonormal_vector();
        let y = normal.cross(x);
        (x * turn.cos() + y * turn.sin()) * angle.sin() + normal * angle.cos()
    }

    const NORMAL: DVec3 = DVec3::new(0.48, 0.64, 0.6);

    #[test]
    fn even_light_is_the_same_for_every_tilt() {
        for angle in [0.0, 0.1, 0.7, 1.2, 1.5] {
            let (e, v, truth) = of(|_| 2.0, NORMAL, tilt(NORMAL, angle, 1.0));
            assert!(v.iter().all(|v| v.x.abs() < 1e-4), "{v:?}");
            let told = tilted(DVec3::splat(e), v, NORMAL, tilt(NORMAL, angle, 1.0)).x;
            assert!((told / e - 1.0).abs() < 1e-4 && (truth / e - 1.0).abs() < 1e-3, "{told} {truth} {e}");
        }
    }

    #[test]
    fn light_that_is_linear_in_the_direction_is_exact() {
        let radiance = |w: DVec3| 3.0 + DVec3::new(0.9, -1.4, 0.8).dot(w);
        for (angle, turn) in [(0.2, 0.3), (0.5, 2.0), (0.785, 4.0), (1.3, 5.5), (1.57, 1.1)] {
            let m = tilt(NORMAL, angle, turn);
            let (e, v, truth) = of(radiance, NORMAL, m);
            let told = tilted(DVec3::splat(e), v, NORMAL, m).x;
            assert!((told - truth).abs() < 2e-4 * truth, "{angle} {turn}: {told} {truth}");
        }
    }

    #[test]
    fn the_normal_itself_keeps_its_irradiance_whatever_the_terms() {
        let e = DVec3::new(3.0, 0.1, 7.0);
        let terms = [DVec3::new(2.0, -9.0, 1.0), DVec3::splat(-4.0), DVec3::new(0.0, 5.0, 2.0)];
        let normal = NORMAL.normalize();
        assert!(tilted(e, terms, normal, normal).abs_diff_eq(e, 1e-12));
    }

    #[test]
    fn a_small_lamp_that_the_tilt_sees_is_never_missed() {
        // All light from within a degree of one direction.
        for height in [0.2, 0.6, 1.0, 1.4_f64] {
            let at = tilt(NORMAL, PI / 2.0 - height, 0.4);
            let lamp = |w: DVec3| if w.dot(at) > 0.999 { 100.0 } else { 0.0 };
            for (angle, turn) in [(0.3, 0.4), (0.7, 0.4), (0.7, 2.0), (0.7, 3.5)] {
                let m = tilt(NORMAL, angle, turn);
                let (e, v, truth) = of(lamp, NORMAL, m);
                let told = tilted(DVec3::splat(e), v, NORMAL, m).x;
                let sees = m.dot(at) > 0.1;
                assert!(told >= 0.0);
                assert!(!sees || told > 0.999 * truth, "{height} {angle} {turn}: {told} {truth}");
            }
        }
    }

    #[test]
    fn no_axis_of_even_light_weighs_more_than_the_bound() {
        let mut most = 0.0_f64;
        for axis in [DVec3::X, DVec3::Y, DVec3::Z, NORMAL, NORMAL.any_orthonormal_vector()] {
            let (mut sum, n) = (0.0, 300);
            for i in 0..n {
                let z = (f64::from(i) + 0.5) / f64::from(n);
                for k in 0..n {
                    let w = tilt(NORMAL, z.acos(), 2.0 * PI * f64::from(k) / f64::from(n));
                    sum += weight(w.as_vec3(), NORMAL.as_vec3()).as_dvec3().dot(axis).abs() * 2.0
                        / f64::from(n * n);
                }
            }
            most = most.max(sum);
        }
        assert!((0.9..=MOST).contains(&most), "{most}");
    }

    #[test]
    fn only_static_surfaces_that_are_drawn_count() {
        use crate::scene::{EntityId, ImageSource, Material, Texture};
        let texture = Texture::new(ImageSource { file: "bumps.png".to_owned(), image: None });
        let mut scene = Scene {
            materials: vec![Material { normal_texture: Some(texture), ..Material::default() }],
            entities: vec![Entity { id: EntityId(1), is_static: true, ..Entity::default() }],
            ..Scene::default()
        };
        assert!(!any_directional(&scene), "nothing is drawn");
        scene.entities[0].mesh = Some(crate::scene::MeshRenderer {
            mesh: crate::scene::MeshSource::Shape(crate::scene::shape::Shape::Quad),
            materials: vec![scene.materials[0].id],
            casts_shadows: true,
            density: Default::default(),
            reflection: Default::default(),
        });
        assert!(any_directional(&scene));
        scene.entities[0].is_static = false;
        assert!(!any_directional(&scene), "what moves reads probes");
        scene.entities[0].is_static = true;
        scene.entities[0].hidden = true;
        assert!(!any_directional(&scene));
    }
}
