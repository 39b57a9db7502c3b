//! Evaluation points: where all bakes, methods and references are compared.
//!
//! Even by area over the front faces of all that is baked, one in each of n strata of equal area, wherever in it chance
//! (seeded) puts it: edges and corners get their share. Areas being even, every point has the same weight. Points
//! inside solids, where a quarter of what is seen are back faces, light nothing that anybody sees and are left out.

use engine::transport::bvh::{Bvh, Holes};
use glam::{DVec3, Vec3};

use crate::directions::{Sobol, cosine_direction, frame, hash, in_triangle, unit};
use crate::pipeline::INSIDE;
use crate::surface::{Surface, Triangle};
use crate::{Opened, Point};

/// Of all points.
pub const SEED: u64 = 0x9e01_77a5;
/// Rays that look about from a point.
const LOOKS: u32 = 64;

/// Points, and how many more were inside solids.
pub struct Points {
    pub points: Vec<Point>,
    pub inside: usize,
}

/// At most `count` points.
pub fn choose(opened: &Opened, count: usize) -> Points {
    let surface = &opened.surface;
    let drawn = draw(surface, count);
    let corners: Vec<[Vec3; 3]> =
        surface.triangles.iter().map(|triangle| triangle.positions().map(|p| p.as_vec3())).collect();
    let looker = Looker { surface, bvh: Bvh::new(&corners, Vec::new()), sobol: Sobol::new(LOOKS) };
    let n = drawn.len();
    let seen = drawn.into_iter().enumerate().filter(|(k, drawn)| !looker.is_inside(*k as u64, drawn));
    let world = |position: DVec3| surface.origin + position * surface.unit;
    let points: Vec<Point> =
        seen.map(|(_, (position, normal))| Point { position: world(position), normal }).collect();
    Points { inside: n - points.len(), points }
}

/// Positions in scaled space, with their faces' normals.
fn draw(surface: &Surface, count: usize) -> Vec<(DVec3, DVec3)> {
    let mut area = 0.0;
    let sums: Vec<f64> = surface
        .triangles
        .iter()
        .map(|triangle| {
            area += triangle.cross().length();
            area
        })
        .collect();
    if area <= 0.0 || !area.is_finite() {
        return Vec::new();
    }
    let chance = |k: usize, dimension: u64| unit(hash(hash(SEED ^ k as u64) ^ dimension) as u32);
    let one = |k: usize| {
        let target = (k as f64 + f64::from(chance(k, 0))) / count as f64 * area;
        let t = sums.partition_point(|&sum| sum <= target).min(sums.len() - 1);
        at(&surface.triangles[t], chance(k, 1), chance(k, 2))
    };
    (0..count).map(one).collect()
}

fn at(triangle: &Triangle, u: f32, v: f32) -> (DVec3, DVec3) {
    let [a, b, c] = triangle.positions();
    let (p, q) = in_triangle(u, v);
    (a + (b - a) * f64::from(p) + (c - a) * f64::from(q), triangle.cross().normalize_or(DVec3::Y))
}

/// Sees back faces.
struct Looker<'a> {
    surface: &'a Surface,
    bvh: Bvh,
    sobol: Sobol,
}

struct Solid;

impl Holes for Solid {
    fn passes(&self, _triangle: u32, _barycentric: [f32; 2], _chance: f32) -> bool {
        false
    }
}

impl Looker<'_> {
    fn is_inside(&self, key: u64, (position, normal): &(DVec3, DVec3)) -> bool {
        let (position, normal) = (position.as_vec3(), normal.as_vec3());
        let (x, y) = frame(normal);
        let meets_back = |ray: u32| {
            let [a, b, ..] = self.sobol.point(ray, hash(SEED ^ key));
            let local = cosine_direction(a, b);
            let direction = x * local.x + y * local.y + normal * local.z;
            let hit = self.bvh.closest(position, normal, direction, 0.5, &Solid);
            hit.is_some_and(|hit| hit.back && !self.is_double_sided(hit.triangle))
        };
        let back = (0..LOOKS).filter(|&ray| meets_back(ray)).count();
        back as f64 > INSIDE * f64::from(LOOKS)
    }

    fn is_double_sided(&self, triangle: u32) -> bool {
        let batch = self.surface.triangles[triangle as usize].batch;
        self.surface.batches[batch as usize].double_sided != 0
    }
}
