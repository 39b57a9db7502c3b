//! How far light probes see, kept for those beside a wall, so that the light of one room stays out of the next.
//!
//! A probe keeps one number a direction, its *nearness*: 1 / |hit - probe|_1, in the norm |x| + |y| + |z|, at the nodes
//! of an octahedral map (Meyer et al. 2010; the map is linear in that norm). A wall n.x = d, seen in direction v with
//! |v|_1 = 1, has the nearness n.v / d: linear in v. So the map, read piecewise linearly in triangles that no edge of
//! the octahedron cuts, gives every plane exactly (and rounds corners between planes off), and
//! ```text
//! x = nearness(v) * |p - probe|_1
//! ```
//! is 1 where p lies on the wall, and (d + behind) / d behind it. Mean and variance of the distance (Donnelly and
//! Lauritzen 2006) would be as small, but in slanting directions they vary so much within a texel that what is
//! hidden cannot be told from what is seen.
//!
//! The share that p sees falls smoothly from 1 at x = 1 to 0 at x = [`HIDDEN`]: it is continuous in p.

use glam::{Vec2, Vec3};

/// Steps along a side of the map; even, so that the octahedron's edges run through nodes.
const STEPS: usize = 32;
const SIDE: usize = STEPS + 1;
/// Nodes of a map.
pub const NODES: usize = SIDE * SIDE;
/// What lies this much further away than the wall in front of it is not seen at all.
const HIDDEN: f32 = 1.15;

#[derive(Clone, Debug, Default, PartialEq)]
pub struct Depths {
    /// Which probes have a map, ascending.
    pub probes: Vec<u32>,
    /// [`NODES`] a map [1/m]; 0 where nothing is met.
    pub nearness: Vec<f32>,
}

impl Depths {
    pub fn validate(&self, probes: usize) -> Result<(), String> {
        if self.nearness.len() != self.probes.len() * NODES {
            return Err(format!("{} probes have {} depths", self.probes.len(), self.nearness.len()));
        }
        if self.probes.windows(2).any(|pair| pair[0] >= pair[1])
            || self.probes.last().is_some_and(|&last| last as usize >= probes)
        {
            return Err("depths name probes out of order or that do not exist".to_owned());
        }
        let sound = |nearness: &f32| nearness.is_finite() && *nearness >= 0.0;
        if self.nearness.iter().all(sound) { Ok(()) } else { Err("a depth is no distance".to_owned()) }
    }

    /// Share that the probe of this map sees of a point at this way from it, 0 to 1.
    pub fn seen(&self, map: usize, way: Vec3) -> f32 {
        let distance = way.abs().element_sum().min(f32::MAX);
        if !way.is_finite() || distance <= 0.0 {
            return 1.0;
        }
        let nearness = read(&self.nearness[map * NODES..][..NODES], way / distance);
        let t = ((nearness * distance - 1.0) / (HIDDEN - 1.0)).clamp(0.0, 1.0);
        1.0 - t * t * (3.0 - 2.0 * t)
    }
}

/// The direction of a node, |v|_1 = 1. Nodes of the map's rim that are one direction give the same.
pub fn direction(node: usize) -> Vec3 {
    let along = |k: usize| k as f32 * (2.0 / STEPS as f32) - 1.0;
    unfolded(Vec2::new(along(node % SIDE), along(node / SIDE)))
}

fn unfolded(at: Vec2) -> Vec3 {
    let z = 1.0 - at.x.abs() - at.y.abs();
    if z >= 0.0 { at.extend(z) } else { mirrored(at).extend(z) }
}

/// The corner of the square beyond an edge of the octahedron is folded behind it, and back.
fn mirrored(at: Vec2) -> Vec2 {
    // Adding 0 turns -0 into 0, so that the rim's two ends of a fold agree.
    let sign = at.map(|x| if x < 0.0 { -1.0 } else { 1.0 });
    Vec2::new(1.0 - at.y.abs(), 1.0 - at.x.abs()) * sign + 0.0
}

/// Piecewise linear: each square between nodes is cut in two along the edges of the octahedron.
fn read(map: &[f32], v: Vec3) -> f32 {
    let at = if v.z >= 0.0 { v.truncate() } else { mirrored(v.truncate()) };
    let half = STEPS / 2;
    let from_middle = at.abs().min(Vec2::ONE) * half as f32;
    let cell = from_middle.floor().min(Vec2::splat(half as f32 - 1.0));
    let Vec2 { x: f, y: g } = from_middle - cell;
    let node = |i: usize, j: usize| {
        let place = |k: usize, negative: bool| if negative { half - k } else { half + k };
        map[place(cell.y as usize + j, at.y < 0.0) * SIDE + place(cell.x as usize + i, at.x < 0.0)]
    };
    let (across, along) = (node(1, 0), node(0, 1));
    if f + g <= 1.0 {
        let corner = node(0, 0);
        corner + f * (across - corner) + g * (along - corner)
    } else {
        let corner = node(1, 1);
        corner + (1.0 - f) * (along - corner) + (1.0 - g) * (across - corner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The inside of a box, by the planes that the way meets first.
    fn room(low: Vec3, high: Vec3) -> Depths {
        let nearness = |v: Vec3| {
            let planes = (0..3).map(|axis| (v[axis] / high[axis]).max(v[axis] / low[axis]));
            planes.fold(0.0, f32::max)
        };
        Depths { probes: vec![0], nearness: (0..NODES).map(|node| nearness(direction(node))).collect() }
    }

    fn directions() -> impl Iterator<Item = Vec3> {
        let golden = std::f32::consts::PI * (3.0 - 5.0_f32.sqrt());
        (0..5000).map(move |k| {
            let z = 1.0 - (2 * k + 1) as f32 / 5000.0;
            let r = (1.0 - z * z).sqrt();
            Vec3::new(r * (golden * k as f32).cos(), r * (golden * k as f32).sin(), z)
        })
    }

    #[test]
    fn a_map_gives_a_plane_exactly() {
        let wall = Vec3::new(0.5, -0.3, 0.8);
        let nearness = |v: Vec3| wall.dot(v);
        let map: Vec<f32> = (0..NODES).map(|node| nearness(direction(node))).collect();
        for v in directions().map(|v| v / v.abs().element_sum()) {
            assert!((read(&map, v) - nearness(v)).abs() < 1e-5, "{v}");
        }
    }

    #[test]
    fn a_probe_sees_its_room_and_nothing_behind_the_walls() {
        let depths = room(Vec3::new(-2.0, -1.0, -1.5), Vec3::new(0.7, 1.5, 1.0));
        depths.validate(1).unwrap();
        for v in directions() {
            let mut hit = f32::INFINITY;
            for axis in 0..3 {
                let wall = if v[axis] > 0.0 { [0.7, 1.5, 1.0][axis] } else { [2.0, 1.0, 1.5][axis] };
                hit = hit.min(wall / v[axis].abs());
            }
            assert!(depths.seen(0, v * hit * 0.9) > 0.99, "{v}");
            // Between walls, where the map rounds the corner off, it may see a little further.
            assert!(depths.seen(0, v * hit * 1.35) < 0.01, "{v}: {}", depths.seen(0, v * hit * 1.35));
        }
        assert_eq!(depths.seen(0, Vec3::ZERO), 1.0);
    }

    #[test]
    fn what_is_seen_has_no_seams() {
        let mut depths = room(Vec3::new(-2.0, -1.0, -1.5), Vec3::new(0.7, 1.5, 1.0));
        // As rough as a map can be.
        for (node, nearness) in depths.nearness.iter_mut().enumerate() {
            let v = direction(node);
            *nearness *= 1.0 + 0.5 * (17.0 * v.x + 31.0 * v.y + 23.0 * v.z).sin();
        }
        let (a, b) = (Vec3::new(0.31, -0.2, 0.4), Vec3::new(-0.37, 0.25, -0.21));
        for way in [a.cross(b).normalize(), a, b] {
            let around = way.any_orthonormal_vector();
            let at = |k: u32| {
                let angle = k as f32 * (std::f32::consts::TAU / 100_000.0);
                depths.seen(0, glam::Quat::from_axis_angle(way.normalize(), angle) * around * 1.1)
            };
            assert!((0..100_000).all(|k| (at(k) - at(k + 1)).abs() < 0.01));
        }
    }
}
