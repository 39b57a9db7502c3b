//! What a ray meets. `obvhs` finds the candidates; the triangle test here decides on which side of each edge the
//! ray goes by the volume of (direction, corner, corner), as Pluecker coordinates do. For the two triangles that
//! share an edge that number is the same but for its sign, to the last bit, so that a ray towards the edge hits
//! one of them, never neither.

use std::time::Duration;

use glam::{Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh;
use obvhs::ray::{Ray, RayHit};

use super::NONE;

/// A triangle of the scene by its number, and the share of the ray's way.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    pub triangle: u32,
    /// For comparisons; in the tree's space.
    t: f32,
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
    corners: Vec<[Vec3A; 3]>,
    triangle_of: Vec<u32>,
    /// By triangle: may it have holes?
    holed: Vec<bool>,
    /// From the callers' space to the tree's: a power of two. `obvhs` lets no box be nearer than 1e-4, so that the
    /// scene must be large there.
    scale: f32,
    /// How far from its surface a ray starts, in the tree's space.
    offset: f32,
}

/// The scene's extent in the tree's space.
const EXTENT: f32 = 65536.0;

impl Bvh {
    /// `holed`: one a triangle, or empty where none has holes.
    pub fn new(triangles: &[[Vec3; 3]], holed: Vec<bool>) -> Self {
        let extent = triangles.iter().flatten().fold(Vec3::ZERO, |max, p| max.max(p.abs())).max_element();
        let scale = (EXTENT / extent.max(1e-30)).log2().floor().exp2();
        let offset = 16.0 * f32::EPSILON * extent * scale;
        let scaled = |corners: &[Vec3; 3]| corners.map(|corner| Vec3A::from(corner * scale));
        // A box without thickness cannot be quantised, and a ray along its face may miss it.
        let margin = Vec3A::splat(0.5 * offset);
        let mut boxes: Vec<Aabb> = triangles
            .iter()
            .map(|corners| {
                let mut aabb = Aabb::from_points(&scaled(corners));
                aabb.min -= margin;
                aabb.max += margin;
                aabb
            })
            .collect();
        if let [only] = boxes[..] {
            boxes.push(only); // a root that is a leaf is never looked at
        }
        let tree = if boxes.is_empty() {
            CwBvh::default()
        } else {
            build_cwbvh(
                &boxes,
                BvhBuildParams { pre_split: false, ..BvhBuildParams::medium_build() },
                &mut Duration::default(),
            )
        };
        let last = (triangles.len() as u32).saturating_sub(1);
        let triangle_of: Vec<u32> = tree.primitive_indices.iter().map(|&t| t.min(last)).collect();
        let corners = triangle_of.iter().map(|&t| scaled(&triangles[t as usize])).collect();
        Self { tree, corners, triangle_of, holed, scale, offset }
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
        let (origin, direction) =
            (Vec3A::from(origin * self.scale + normal * self.offset), unsigned(direction));
        let mut best: Option<Hit> = None;
        let mut best_corners = &self.corners[0];
        let ray = Ray::new(origin, direction, 0.0, f32::INFINITY);
        self.tree.ray_traverse(ray, &mut RayHit::none(), |_, i| {
            let Some((t, barycentric, back)) = meet(origin, direction, &self.corners[i]) else {
                return f32::INFINITY;
            };
            // In the same place, which rounding parts, lie triangles that are parallel too: a wall beside the foot of
            // another parts rooms. There a back face gives way to a front face, as two rooms may share a wall without
            // thickness, and of equals the one of the lower number is met, whatever order the tree has.
            let triangle = self.triangle_of[i];
            let in_one_place = |best: &Hit| {
                (best.t - t).abs() <= self.offset + 4.0 * f32::EPSILON * t
                    && is_parallel(best_corners, &self.corners[i], best.back == back)
            };
            let is_before = |best: Hit| match in_one_place(&best) {
                true => (best.back, best.triangle) <= (back, triangle),
                false => (best.t, best.triangle) <= (t, triangle),
            };
            if best.is_some_and(is_before) || self.open(triangle, barycentric, chance, holes) {
                return f32::INFINITY;
            }
            best = Some(Hit { triangle, t, barycentric, back });
            best_corners = &self.corners[i];
            // Nodes in the same place must still be looked at.
            t * (1.0 + 4.0 * f32::EPSILON) + self.offset
        });
        best
    }

    /// Nodes of 80 bytes (`Node` in `transport/rays.wgsl`); none where there are no triangles.
    pub fn nodes(&self) -> &[[u32; 20]] {
        bytemuck::cast_slice(&self.tree.nodes)
    }

    /// The triangles in the order in which the nodes name them.
    pub fn order(&self) -> &[u32] {
        &self.triangle_of
    }

    /// From the callers' space to that of the nodes, a power of two.
    pub fn scale(&self) -> f32 {
        self.scale
    }

    /// How far from its surface a ray starts, in the callers' space.
    pub fn offset(&self) -> f32 {
        self.offset / self.scale
    }

    /// Metres from the (moved) origin to a hit.
    pub fn distance(&self, hit: &Hit) -> f32 {
        hit.t / self.scale
    }

    /// Is the way between points of two surfaces free, each moved off its own along a unit normal (zero: in free
    /// space)? Whatever stands between them hides the one from the other, however near to either it is.
    pub fn free_between(
        &self,
        [from, normal]: [Vec3; 2],
        [to, facing]: [Vec3; 2],
        chance: f32,
        holes: &dyn Holes,
    ) -> bool {
        let [origin, end] = [(from, normal), (to, facing)].map(|(p, n)| p * self.scale + n * self.offset);
        let way = end - origin;
        let length = way.length();
        length == 0.0 || self.free(origin, way / length, length, chance, holes)
    }

    /// Is the way from `from` (moved off its surface) to `to` free, but for the triangles that `to` lies on? Where it is
    /// known what that is, [`Bvh::free_between`] overlooks nothing beside it.
    pub fn visible(&self, from: Vec3, normal: Vec3, to: Vec3, chance: f32, holes: &dyn Holes) -> bool {
        if self.corners.is_empty() {
            return true;
        }
        let origin = from * self.scale + normal * self.offset;
        let direction = to * self.scale - origin;
        let length = direction.length();
        if length <= 4.0 * self.offset {
            return true;
        }
        // Of unit length: in shares of the way to a far light, the boxes that are too near would reach far.
        self.free(origin, direction / length, length - 4.0 * self.offset, chance, holes)
    }

    fn free(&self, origin: Vec3, direction: Vec3, end: f32, chance: f32, holes: &dyn Holes) -> bool {
        let (origin, direction) = (Vec3A::from(origin), unsigned(direction));
        let ray = Ray::new(origin, direction, 0.0, end);
        self.tree.ray_traverse_miss(ray, |_, i| match meet(origin, direction, &self.corners[i]) {
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

/// The patch that a hit lies on; `None`: the light is lost (a back face).
pub fn patch_of(hit: &Hit, patches: &[[u32; 2]]) -> Option<u32> {
    let patch = patches[hit.triangle as usize][usize::from(hit.back)];
    (patch != NONE).then_some(patch)
}

/// Without -0, which the tree takes for the wrong octant.
fn unsigned(direction: Vec3) -> Vec3A {
    Vec3A::from(direction) + Vec3A::ZERO
}

/// Do two triangles face the same way, or opposite ways?
fn is_parallel(a: &[Vec3A; 3], b: &[Vec3A; 3], same: bool) -> bool {
    let [a, b] = [a, b].map(|corners| (corners[1] - corners[0]).cross(corners[2] - corners[0]));
    let cosine = if same { a.dot(b) } else { -a.dot(b) };
    cosine > 0.999 * (a.length_squared() * b.length_squared()).sqrt()
}

/// (t > 0, weights of the second and third corner, seen from behind).
#[inline(always)]
fn meet(origin: Vec3A, direction: Vec3A, corners: &[Vec3A; 3]) -> Option<(f32, [f32; 2], bool)> {
    let [a, b, c] = [corners[0] - origin, corners[1] - origin, corners[2] - origin];
    let u = direction.dot(c.cross(b));
    let v = direction.dot(a.cross(c));
    let w = direction.dot(b.cross(a));
    if u.min(v).min(w) < 0.0 && u.max(v).max(w) > 0.0 {
        return None;
    }
    let volume = u + v + w;
    if volume == 0.0 {
        return None;
    }
    let share = volume.recip();
    let [u, v, w] = [u * share, v * share, w * share];
    let t = (a * u + b * v + c * w).dot(direction) / direction.length_squared();
    (t > 0.0).then_some((t, [v, w], volume < 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Solid;

    impl Holes for Solid {
        fn passes(&self, _: u32, _: [f32; 2], _: f32) -> bool {
            false
        }
    }

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
        // From a hair above one wall beside another.
        for k in 1..2000 {
            let near = Vec3::new(-0.5, -0.5 + 1e-7 * k as f32, 0.013 * (k % 31) as f32 - 0.2);
            let hit = bvh.closest(near, Vec3::X, Vec3::new(0.6, -0.7, 0.39), 0.0, &Solid);
            assert!(hit.is_some_and(|hit| !hit.back), "{near}: {hit:?}");
        }
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
    fn what_is_close_hides_what_is_far() {
        let wall = [Vec3::new(0.0, -1.0, -1.0), Vec3::new(0.0, 1.0, -1.0), Vec3::new(0.0, 0.0, 1.0)];
        let bvh = Bvh::new(&[wall], Vec::new());
        for distance in [1e-5, 1e-4, 1e-3, 0.1] {
            for far in [1.0, 100.0] {
                let (from, to) = (Vec3::X * distance, Vec3::NEG_X * far);
                assert!(!bvh.visible(from, Vec3::ZERO, to, 0.0, &Solid), "{distance} {far}");
                assert!(bvh.visible(from, Vec3::ZERO, -to, 0.0, &Solid), "{distance} {far}");
            }
        }
    }

    #[test]
    fn a_sheet_hides_what_lies_behind_it_however_near() {
        let rectangle = |a: Vec3, u: Vec3, v: Vec3| [[a, a + u, a + u + v], [a, a + u + v, a + v]];
        let floor = rectangle(Vec3::ZERO, Vec3::Z, Vec3::X * 2.0);
        let wall = rectangle(Vec3::ZERO, Vec3::Y, Vec3::Z);
        let sheet = rectangle(Vec3::X, Vec3::Y, Vec3::Z);
        let bvh = Bvh::new(&[floor, wall, sheet].concat(), Vec::new());
        let wall = [Vec3::new(0.0, 0.5, 0.5), Vec3::X];
        // What rounding of a point's own place leaves open.
        for ulps in 8..1000_u32 {
            let beside = |x: u32| [Vec3::new(f32::from_bits(x), 0.0, 0.4), Vec3::Y];
            let one = 1.0_f32.to_bits();
            let [before, behind] = [beside(one - ulps), beside(one + ulps)];
            assert!(bvh.free_between(wall, before, 0.0, &Solid), "{before:?}");
            assert!(bvh.free_between(before, wall, 0.0, &Solid), "{before:?}");
            assert!(!bvh.free_between(wall, behind, 0.0, &Solid), "{behind:?}");
            assert!(!bvh.free_between(behind, wall, 0.0, &Solid), "{behind:?}");
            assert!(!bvh.free_between(behind, before, 0.0, &Solid), "{behind:?}");
            let way = (behind[0] - wall[0]).normalize();
            let met = bvh.closest(wall[0], wall[1], way, 0.0, &Solid).expect("a closed way");
            assert!(met.triangle >= 4, "the sheet, not the floor behind it: {met:?}");
        }
    }

    #[test]
    fn fronts_are_fronts_from_every_side() {
        for axis in [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z] {
            let (u, v) = axis.any_orthonormal_pair();
            // Counter-clockwise seen from the origin means: its normal points back to the origin.
            let at = |x: f32, y: f32| -axis * 2.0 + u * x + v * y;
            let triangle = [at(-1.0, -1.0), at(1.0, -1.0), at(0.0, 1.0)];
            let bvh = Bvh::new(&[triangle], Vec::new());
            let hit = bvh.closest(Vec3::ZERO, Vec3::ZERO, -axis, 0.0, &Solid).unwrap();
            assert!(!hit.back && (bvh.distance(&hit) - 2.0).abs() < 1e-5, "{axis}: {hit:?}");
            let hit = bvh.closest(-axis * 4.0, Vec3::ZERO, axis, 0.0, &Solid).unwrap();
            assert!(hit.back, "{axis}: {hit:?}");
        }
    }
}
