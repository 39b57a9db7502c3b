//! The density brush: paints how finely a surface is divided, vertex by vertex. Each dab moves the density of the
//! vertices under the brush towards its target, most at the middle:
//!
//! ```text
//! d' = d (target / d)^(strength w)      w = (1 - (r / radius)^2)^2
//! ```
//! with r the distance from the brush's middle in the world [m]. Densities are factors, so that the way from 1/4 to 4
//! leads through 1: it is their logarithm that moves.
//!
//! Where the brush lies between vertices, inside one large triangle, it pulls at the triangle's corners, each by its
//! barycentric share at the brush's middle: the density there is made of theirs. Smoothing goes towards the mean of the
//! neighbours. Vertices in one place (seams of normals and textures) are one.

use std::collections::HashMap;

use engine::scene::density::RANGE;
use engine::scene::{Density, Mesh};
use glam::{DAffine3, DVec3, Vec3};

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

    /// The density after a dab that reaches no vertex: inside a triangle, at these shares of its corners.
    pub fn dab_between(
        &self,
        density: &Density,
        mesh: &Mesh,
        corners: [u32; 3],
        shares: [f64; 3],
    ) -> Option<Density> {
        let target = f64::from(self.target).clamp(f64::from(*RANGE.start()), f64::from(*RANGE.end()));
        let places = corners.map(|corner| mesh.positions.get(corner as usize).copied());
        let vertices = vertices(mesh);
        let mut painted = full(density, vertices);
        let mut reached = false;
        for (vertex, position) in mesh.positions[..vertices].iter().enumerate() {
            let share =
                places.iter().position(|place| *place == Some(*position)).map(|corner| shares[corner]);
            let weight = self.strength.clamp(0.0, 1.0) * share.unwrap_or(0.0).clamp(0.0, 1.0);
            if weight > 0.0 && self.radius > 0.0 {
                painted[vertex] = towards(painted[vertex], target, weight);
                reached = true;
            }
        }
        reached.then_some(Density { scale: density.scale, painted })
    }

    /// The density after a dab that smooths: each vertex under the brush goes towards the mean of its neighbours.
    pub fn smooth(
        &self,
        density: &Density,
        mesh: &Mesh,
        world_from_local: &DAffine3,
        at: DVec3,
    ) -> Option<Density> {
        let vertices = vertices(mesh);
        let before = full(density, vertices);
        let means = neighbours(mesh, &before);
        let mut painted: Option<Vec<f32>> = None;
        for (vertex, position) in mesh.positions[..vertices].iter().enumerate() {
            let weight = self.weight(world_from_local.transform_point3(position.as_dvec3()).distance(at));
            let mean = means.get(&key(*position)).filter(|_| weight > 0.0);
            if let Some([sum, count]) = mean {
                let painted = painted.get_or_insert_with(|| before.clone());
                painted[vertex] = towards(before[vertex], (sum / count).exp(), weight);
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

fn key(position: Vec3) -> [u32; 3] {
    position.to_array().map(f32::to_bits)
}

/// By place: the sum of the logarithms of its neighbours' densities, and how many there are.
fn neighbours(mesh: &Mesh, painted: &[f32]) -> HashMap<[u32; 3], [f64; 2]> {
    let mut means: HashMap<[u32; 3], [f64; 2]> = HashMap::new();
    for corners in mesh.triangles() {
        for k in 0..3 {
            let ends = [corners[k], corners[(k + 1) % 3]].map(|corner| mesh.original(corner as usize));
            for [to, from] in [ends, [ends[1], ends[0]]] {
                let mean = means.entry(key(mesh.positions[to])).or_default();
                mean[0] += positive(painted[from]).ln();
                mean[1] += 1.0;
            }
        }
    }
    means
}

/// What is no density counts as 1.
fn positive(density: f32) -> f64 {
    if density.is_finite() && density > 0.0 { f64::from(density) } else { 1.0 }
}

fn towards(density: f32, target: f64, weight: f64) -> f32 {
    let density = positive(density);
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

    #[test]
    fn between_vertices_the_corners_are_pulled_by_their_shares() {
        let plane = mesh(Shape::Plane);
        let [a, b, c] = plane.triangles().next().unwrap();
        let small = Brush { radius: 0.01, ..BRUSH };
        let middle = (plane.positions[a as usize] + plane.positions[b as usize]).as_dvec3() * 0.5;
        assert_eq!(small.dab(&Density::default(), &plane, &DAffine3::IDENTITY, middle), None);
        let painted = small.dab_between(&Density::default(), &plane, [a, b, c], [0.5, 0.5, 0.0]).unwrap();
        let at = |corner: u32| painted.painted[corner as usize];
        assert_eq!((at(a), at(b), at(c)), (2.0, 2.0, 1.0), "half the way from 1 to 4");
        assert_eq!(small.dab_between(&painted, &plane, [900, 901, 902], [1.0, 0.0, 0.0]), None);
    }

    #[test]
    fn smoothing_goes_to_the_mean_of_the_neighbours_and_leaves_what_is_even() {
        let plane = mesh(Shape::Plane);
        let whole = Brush { radius: 1e6, ..BRUSH };
        let even = Density { scale: 1.0, painted: vec![2.0; 4] };
        let smoothed = whole.smooth(&even, &plane, &DAffine3::IDENTITY, DVec3::ZERO).unwrap();
        assert!(smoothed.painted.iter().all(|density| (density - 2.0).abs() < 1e-6));
        let mut rough = even.clone();
        rough.painted[0] = 16.0;
        let smoothed = whole.smooth(&rough, &plane, &DAffine3::IDENTITY, DVec3::ZERO).unwrap();
        assert!((smoothed.painted[0] - 2.0).abs() < 1e-4, "{smoothed:?}: its neighbours are all 2");
        assert!(smoothed.painted[1..].iter().any(|density| *density > 2.0));
    }
}
