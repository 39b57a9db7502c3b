//! Emitters that paths are joined to: a triangle by its power, a point on it by area.
//!
//! ```text
//! density per solid angle = share(triangle) / area * r^2 / cos(emitter)
//! weight                  = p^2 / (p^2 + q^2)                        power heuristic (Veach 1995)
//! ```
//! for p the density with which a light's point is drawn here and q that with which a surface's own direction would
//! have found it: the two weights of a way sum to 1, and neither way is ever far noisier than the better one.

use engine::transport::materials::points_in_triangles;
use glam::{DVec3, Vec3};

use super::world::World;
use crate::directions::in_triangle;

#[derive(Default)]
pub struct Sources {
    triangles: Vec<u32>,
    /// Running shares, to 1.
    sums: Vec<f64>,
    /// By triangle of the world: chance per area, 0 where it is no emitter [1/m2].
    density: Vec<f64>,
}

/// A way to a point of an emitter that faces it.
pub struct Towards {
    pub direction: DVec3,
    pub position: Vec3,
    /// Of the emitter, on the side that is seen.
    pub facing: Vec3,
    /// Times the share of the point that is there [W/m2/sr].
    pub radiance: DVec3,
    /// Per solid angle.
    pub density: f64,
}

impl Sources {
    pub fn new(world: &World) -> Self {
        let powers: Vec<f64> = (0..world.triangles.len() as u32).map(|t| power(world, t)).collect();
        let total: f64 = powers.iter().sum();
        let mut sources = Self { density: vec![0.0; powers.len()], ..Self::default() };
        let mut sum = 0.0;
        for (t, power) in powers.into_iter().enumerate().filter(|(_, power)| *power > 0.0) {
            sum += power / total;
            sources.triangles.push(t as u32);
            sources.sums.push(sum);
            sources.density[t] = power / total / world.area(t as u32);
        }
        sources
    }

    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// Towards a point of an emitter; none where it looks away or gives off nothing.
    pub fn towards(&self, world: &World, from: Vec3, [u, v, choice, _]: [f32; 4]) -> Option<Towards> {
        let choice = self.sums.partition_point(|&sum| sum <= f64::from(choice));
        let triangle = *self.triangles.get(choice).or(self.triangles.last())?;
        let (p, q) = in_triangle(u, v);
        let position = world.position(triangle, [p, q]);
        let way = (position - from).as_dvec3();
        let distance = way.length();
        let direction = way / distance;
        let density = self.density(world, triangle, direction, distance);
        let normal = world.normal(triangle);
        let facing = if normal.as_dvec3().dot(direction) > 0.0 { -normal } else { normal };
        let radiance = world.emission(triangle, [p, q]) * f64::from(world.coverage(triangle, [p, q]));
        (density.is_finite() && density > 0.0 && radiance.max_element() > 0.0).then_some(Towards {
            direction,
            position,
            facing,
            radiance,
            density,
        })
    }

    /// With which a point of a triangle is drawn, per solid angle; 0 from behind an emitter of one side.
    pub fn density(&self, world: &World, triangle: u32, direction: DVec3, distance: f64) -> f64 {
        let by_area = self.density[triangle as usize];
        if by_area == 0.0 {
            return 0.0;
        }
        let cosine = -world.normal(triangle).as_dvec3().dot(direction);
        let cosine = if world.is_double_sided(triangle) { cosine.abs() } else { cosine };
        if cosine > 0.0 { by_area * distance * distance / cosine } else { 0.0 }
    }
}

/// In proportion to what a triangle gives off, all channels alike.
fn power(world: &World, triangle: u32) -> f64 {
    if world.material(triangle).emission.radiance() == Vec3::ZERO {
        return 0.0;
    }
    let points = points_in_triangles(4);
    let mean = points.iter().map(|&at| world.emission(triangle, at).element_sum()).sum::<f64>();
    mean * world.area(triangle) * if world.is_double_sided(triangle) { 2.0 } else { 1.0 }
}

/// The power heuristic.
pub fn weight(own: f64, other: f64) -> f64 {
    if own.is_infinite() { 1.0 } else { own * own / (own * own + other * other) }
}
