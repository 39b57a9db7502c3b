//! What a ray meets. `obvhs` finds the candidates; the triangle test here is watertight (Woop, Benthin and Wald
//! 2013): a ray towards an edge that two triangles share hits one of them, never neither.

use std::time::Duration;

use engine::transport::NONE;
use glam::{Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh_from_tris;
use obvhs::ray::{Ray, RayHit};
use obvhs::triangle::Triangle;

/// A triangle of the scene by its number, and the share of the ray's way.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    pub triangle: u32,
    pub t: f32,
    /// Weights of the second and third corner.
    pub barycentric: [f32; 2],
    pub back: bool,
}

/// May a ray pass through this triangle here? Barycentric weights of the second and third corner, and the
/// ray's own random number in 0..1.
pub trait Holes: Sync {
    fn passes(&self, triangle: u32, barycentric: [f32; 2], chance: f32) -> bool;
}

pub struct Bvh {
    tree: CwBvh,
    /// In the tree's order.
    corners: Vec<[Vec3; 3]>,
    triangle_of: Vec<u32>,
    /// By triangle: may it have holes?
    holed: Vec<bool>,
    /// How far from its surface a ray starts.
    pub offset: f32,
}

impl Bvh {
    /// `holed`: one a triangle, or empty where none has holes.
    pub fn new(triangles: &[[Vec3; 3]], holed: Vec<bool>) -> Self {
        let soup: Vec<Triangle> = triangles
            .iter()
            .map(|t| Triangle { v0: t[0].into(), v1: t[1].into(), v2: t[2].into() })
            .collect();
        let params = BvhBuildParams { pre_split: false, ..BvhBuildParams::medium_build() };
        let tree = if soup.is_empty() {
            CwBvh::default()
        } else {
            build_cwbvh_from_tris(&soup, params, &mut Duration::default())
        };
        let triangle_of = tree.primitive_indices.clone();
        let corners = triangle_of.iter().map(|&t| triangles[t as usize]).collect();
        let extent = triangles.iter().flatten().fold(Vec3::ZERO, |max, p| max.max(p.abs())).max_element();
        Self { tree, corners, triangle_of, holed, offset: 16.0 * f32::EPSILON * extent }
    }

    /// The nearest thing from `origin`, which is moved off its surface along the unit `normal`.
    pub fn closest(
        &self,
        origin: Vec3,
        normal: Vec3,
        direction: Vec3,
        chance: f32,
        holes: &dyn Holes,
    ) -> Option<Hit> {
        if self.corners.is_empty() {
            return None;
        }
        let origin = origin + normal * self.offset;
        let shear = Shear::new(direction);
        let mut best: Option<Hit> = None;
        let ray = Ray::new(Vec3A::from(origin), Vec3A::from(direction), 0.0, f32::INFINITY);
        self.tree.ray_traverse(ray, &mut RayHit::none(), |_, i| {
            let Some((t, barycentric, back)) = shear.meet(origin, &self.corners[i]) else {
                return f32::INFINITY;
            };
            // A back face gives way to a front face in the same place: two rooms may share a wall without
            // thickness. Equal front faces go to the lower number, whatever order the tree has.
            let t = if back { t * (1.0 + 4.0 * f32::EPSILON) + self.offset } else { t };
            let triangle = self.triangle_of[i];
            if best.is_some_and(|best| (best.t, best.triangle) <= (t, triangle))
                || self.open(triangle, barycentric, chance, holes)
            {
                return f32::INFINITY;
            }
            best = Some(Hit { triangle, t, barycentric, back });
            // Nodes at the same distance must still be looked at.
            t * (1.0 + f32::EPSILON)
        });
        best
    }

    /// Is the way from `from` (moved off its surface) to `to` free, but for the triangles that `to` lies on?
    pub fn visible(&self, from: Vec3, normal: Vec3, to: Vec3, chance: f32, holes: &dyn Holes) -> bool {
        if self.corners.is_empty() {
            return true;
        }
        let origin = from + normal * self.offset;
        let direction = to - origin;
        let length = direction.length();
        if length <= 4.0 * self.offset {
            return true;
        }
        let end = 1.0 - 4.0 * self.offset / length;
        self.free(origin, direction, end, chance, holes)
    }

    /// Does a ray leave the scene?
    pub fn escapes(
        &self,
        origin: Vec3,
        normal: Vec3,
        direction: Vec3,
        chance: f32,
        holes: &dyn Holes,
    ) -> bool {
        self.corners.is_empty()
            || self.free(origin + normal * self.offset, direction, f32::MAX, chance, holes)
    }

    fn free(&self, origin: Vec3, direction: Vec3, end: f32, chance: f32, holes: &dyn Holes) -> bool {
        let shear = Shear::new(direction);
        let ray = Ray::new(Vec3A::from(origin), Vec3A::from(direction), 0.0, end);
        self.tree.ray_traverse_miss(ray, |_, i| match shear.meet(origin, &self.corners[i]) {
            Some((t, barycentric, _))
                if t < end && !self.open(self.triangle_of[i], barycentric, chance, holes) =>
            {
                t
            }
            _ => f32::INFINITY,
        })
    }

    fn open(&self, triangle: u32, barycentric: [f32; 2], chance: f32, holes: &dyn Holes) -> bool {
        !self.holed.is_empty() && self.holed[triangle as usize] && holes.passes(triangle, barycentric, chance)
    }
}

/// Nothing has holes.
pub struct Solid;

impl Holes for Solid {
    fn passes(&self, _: u32, _: [f32; 2], _: f32) -> bool {
        false
    }
}

/// The patch that a hit lies on; `None`: the light is lost (a back face).
pub fn patch_of(hit: &Hit, patches: &[[u32; 2]]) -> Option<u32> {
    let patch = patches[hit.triangle as usize][usize::from(hit.back)];
    (patch != NONE).then_some(patch)
}

/// The ray's own frame: its longest axis is z, and x and y are sheared so that it points along z.
struct Shear {
    axes: [usize; 3],
    by: Vec3,
}

impl Shear {
    fn new(direction: Vec3) -> Self {
        let z = direction.abs().max_position();
        let (mut x, mut y) = ((z + 1) % 3, (z + 2) % 3);
        if direction[z] < 0.0 {
            std::mem::swap(&mut x, &mut y);
        }
        let by = Vec3::new(direction[x] / direction[z], direction[y] / direction[z], 1.0 / direction[z]);
        Self { axes: [x, y, z], by }
    }

    /// (t > 0, weights of the second and third corner, seen from behind).
    fn meet(&self, origin: Vec3, corners: &[Vec3; 3]) -> Option<(f32, [f32; 2], bool)> {
        let [x, y, z] = self.axes;
        let local = corners.map(|corner| {
            let p = corner - origin;
            (p[x] - self.by.x * p[z], p[y] - self.by.y * p[z], p[z])
        });
        let [a, b, c] = local;
        let mut u = c.0 * b.1 - c.1 * b.0;
        let mut v = a.0 * c.1 - a.1 * c.0;
        let mut w = b.0 * a.1 - b.1 * a.0;
        if u == 0.0 || v == 0.0 || w == 0.0 {
            let cross = |p: (f32, f32, f32), q: (f32, f32, f32)| {
                (f64::from(p.0) * f64::from(q.1) - f64::from(p.1) * f64::from(q.0)) as f32
            };
            (u, v, w) = (cross(c, b), cross(a, c), cross(b, a));
        }
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let det = u + v + w;
        if det == 0.0 {
            return None;
        }
        let t = (u * a.2 + v * b.2 + w * c.2) * self.by.z / det;
        // With this order of products a front face (counter-clockwise from the origin) has det < 0 or > 0 by
        // the handedness of the frame, which the swap of x and y keeps.
        (t > 0.0).then(|| (t, [v / det, w / det], det < 0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube() -> Vec<[Vec3; 3]> {
        // Fronts face inwards.
        let p = |i: usize| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) - 0.5;
        let quads = [[0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [2, 3, 7, 6], [0, 1, 3, 2], [4, 6, 7, 5]];
        quads
            .iter()
            .flat_map(|q: &[usize; 4]| [[p(q[0]), p(q[1]), p(q[2])], [p(q[0]), p(q[2]), p(q[3])]])
            .collect()
    }

    #[test]
    fn rays_at_edges_and_corners_never_slip_through() {
        let cube = cube();
        let bvh = Bvh::new(&cube, Vec::new());
        for corners in &cube {
            for step in 0..2000 {
                let t = step as f32 / 1999.0;
                for (a, b) in [(0, 1), (1, 2), (2, 0)] {
                    let direction = corners[a].lerp(corners[b], t) - Vec3::new(0.013, 0.021, -0.017);
                    let hit =
                        bvh.closest(Vec3::new(0.013, 0.021, -0.017), Vec3::ZERO, direction, 0.0, &Solid);
                    assert!(hit.is_some_and(|hit| !hit.back), "{direction}: {hit:?}");
                }
            }
        }
    }

    #[test]
    fn fronts_are_fronts_from_every_side() {
        for axis in [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z] {
            let (u, v) = crate::directions::frame(axis);
            // Counter-clockwise seen from the origin means: its normal points back to the origin.
            let at = |x: f32, y: f32| -axis * 2.0 + u * x + v * y;
            let triangle = [at(-1.0, -1.0), at(1.0, -1.0), at(0.0, 1.0)];
            let bvh = Bvh::new(&[triangle], Vec::new());
            let hit = bvh.closest(Vec3::ZERO, Vec3::ZERO, -axis, 0.0, &Solid).unwrap();
            assert!(!hit.back && (hit.t - 2.0).abs() < 1e-6, "{axis}: {hit:?}");
            let hit = bvh.closest(-axis * 4.0, Vec3::ZERO, axis, 0.0, &Solid).unwrap();
            assert!(hit.back, "{axis}: {hit:?}");
        }
    }
}
