//! The density brush: paints how finely a surface is divided, vertex by vertex. Each dab moves the density of the
//! vertices under the brush towards its target, most at the middle:
//!
//! ```text
//! d' = d (target / d)^(strength w)      w = (1 - (r / radius)^2)^2
//! ```
//! with r the distance from the brush's middle in the world [m]. Densities are factors, so that the way from 1/4 to 4
//! leads through 1: it is their logarithm that moves.

use engine::scene::density::RANGE;
use engine::scene::{Density, Mesh};
use glam::{DAffine3, DVec3};

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brush {
    /// Metres, in the world.
    pub radius: f64,
    /// Of one dab: 0 nothing, 1 all the way at the middle.
    pub strength: f64,
    /// Density that it paints; 1 takes paint away.
    pub target: f32,
}

impl Brush {
    /// The density after a dab at a point of the world. `None`: no vertex lies under the brush.
    pub fn dab(
        &self,
        density: &Density,
        mesh: &Mesh,
        world_from_local: &DAffine3,
        at: DVec3,
    ) -> Option<Density> {
        let target = f64::from(self.target).clamp(f64::from(*RANGE.start()), f64::from(*RANGE.end()));
        let vertices = vertices(mesh);
        let mut painted: Option<Vec<f32>> = None;
        for (vertex, position) in mesh.positions[..vertices].iter().enumerate() {
            let weight = self.weight(world_from_local.transform_point3(position.as_dvec3()).distance(at));
            if weight > 0.0 {
                let painted = painted.get_or_insert_with(|| full(density, vertices));
                painted[vertex] = towards(painted[vertex], target, weight);
            }
        }
        Some(Density { scale: density.scale, painted: painted? })
    }

    fn weight(&self, distance: f64) -> f64 {
        let part = distance / self.radius;
        if part < 1.0 { self.strength.clamp(0.0, 1.0) * (1.0 - part * part).powi(2) } else { 0.0 }
    }
}

/// What was in the file: copies that tangents asked for follow behind and are painted with their originals.
fn vertices(mesh: &Mesh) -> usize {
    mesh.positions.len().saturating_sub(mesh.copies.len())
}

/// Where nothing was painted yet it is 1.
fn full(density: &Density, vertices: usize) -> Vec<f32> {
    let mut painted = density.painted.clone();
    painted.resize(vertices, 1.0);
    painted
}

fn towards(density: f32, target: f64, weight: f64) -> f32 {
    let is_one = density.is_finite() && density > 0.0;
    let density = if is_one { f64::from(density) } else { 1.0 };
    (density * (target / density).powf(weight)) as f32
}

#[cfg(test)]
mod tests {
    use engine::scene::shape::{Shape, mesh};

    use super::*;

    const BRUSH: Brush = Brush { radius: 0.4, strength: 1.0, target: 4.0 };

    #[test]
    fn a_dab_reaches_what_lies_under_the_brush_and_nothing_else() {
        let plane = mesh(Shape::Plane);
        let world =
            DAffine3::from_scale_rotation_translation(DVec3::splat(10.0), Default::default(), DVec3::X);
        let corner = world.transform_point3(plane.positions[2].as_dvec3());
        let painted = BRUSH.dab(&Density::default(), &plane, &world, corner).unwrap();
        assert_eq!(painted.painted, [1.0, 1.0, 4.0, 1.0]);
        assert_eq!(BRUSH.dab(&Density::default(), &plane, &world, DVec3::X), None);
    }

    #[test]
    fn dabs_add_up_to_the_target_and_one_takes_them_away() {
        let plane = mesh(Shape::Plane);
        let at = plane.positions[0].as_dvec3() + DVec3::X * 0.2;
        let soft = Brush { strength: 0.3, ..BRUSH };
        let mut density = Density { scale: 3.0, painted: Vec::new() };
        let mut last = 1.0;
        for _ in 0..60 {
            density = soft.dab(&density, &plane, &DAffine3::IDENTITY, at).unwrap();
            assert!(density.painted[0] >= last && density.painted[0] <= 4.0);
            last = density.painted[0];
        }
        assert!(last > 3.9 && density.scale == 3.0);
        let eraser = Brush { target: 1.0, ..BRUSH };
        let erased =
            eraser.dab(&density, &plane, &DAffine3::IDENTITY, plane.positions[0].as_dvec3()).unwrap();
        assert_eq!(erased.painted[0], 1.0);
    }

    #[test]
    fn nonsense_paint_becomes_a_density_again() {
        let plane = mesh(Shape::Plane);
        let broken = Density { scale: 1.0, painted: vec![f32::NAN, -1.0, 0.0] };
        let whole = Brush { radius: 10.0, ..BRUSH };
        let painted = whole.dab(&broken, &plane, &DAffine3::IDENTITY, DVec3::ZERO).unwrap().painted;
        assert!(
            painted.len() == 4 && painted.iter().all(|density| (1.0..=4.0).contains(density)),
            "{painted:?}"
        );
        let none = Brush { radius: 0.0, ..BRUSH };
        assert_eq!(none.dab(&broken, &plane, &DAffine3::IDENTITY, DVec3::ZERO), None);
    }
}
