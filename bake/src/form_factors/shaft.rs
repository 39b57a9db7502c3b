//! What could stand between two things: everything that touches the convex hull of both.
//!
//! A thing is out of the way where a plane parts it from the hull. For boxes the planes are those that lean on an
//! edge of each (Haines and Wallace 1994); for flat patches their own planes, that of the thing in question, and
//! the planes through an edge of one and a corner of the other. To miss a parting plane is to call a free way
//! unclear, never the reverse.

use glam::{DVec2, DVec3};

use super::facet::{Facet, Flat};
use super::polygon::{clip, edges_of};

/// Axis-parallel.
#[derive(Clone, Copy, Debug)]
pub struct Box3 {
    pub low: DVec3,
    pub high: DVec3,
}

impl Box3 {
    pub fn of(facet: &Facet) -> Self {
        Self { low: facet.low, high: facet.high }
    }

    pub fn union(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    pub fn distance(&self, other: &Self) -> f64 {
        (self.low - other.high).max(other.low - self.high).max(DVec3::ZERO).length()
    }

    /// The corner that lies farthest in a direction's signs.
    fn corner(&self, up: glam::BVec3) -> DVec3 {
        DVec3::select(up, self.high, self.low)
    }
}

/// A plane along an axis: the other two axes, outward normal in their plane, how far out the hull reaches.
type Side = ([usize; 2], DVec2, f64);

/// The hull of two boxes.
pub struct BoxShaft {
    whole: Box3,
    sides: [Side; 6],
    count: usize,
    boxes: [Box3; 2],
    slack: f64,
}

impl BoxShaft {
    pub fn new(a: Box3, b: Box3, slack: f64) -> Self {
        let mut sides = [([0, 1], DVec2::ZERO, 0.0); 6];
        let mut count = 0;
        for axes in [[0, 1], [1, 2], [2, 0]] {
            for signs in [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]].map(DVec2::from_array) {
                let corner = |of: &Box3| {
                    let pick = |k: usize| {
                        let axis = axes[k];
                        if signs[k] > 0.0 { of.high[axis] } else { of.low[axis] }
                    };
                    DVec2::new(pick(0), pick(1))
                };
                let (from, to) = (corner(&a), corner(&b));
                let across = (to - from).perp();
                let normal = if across.dot(signs) < 0.0 { -across } else { across };
                // At most two an axis: opposite corners cannot both lean.
                if (normal * signs).min_element() > 0.0 && count < sides.len() {
                    let normal = normal.normalize();
                    sides[count] = (axes, normal, normal.dot(from).max(normal.dot(to)));
                    count += 1;
                }
            }
        }
        Self { whole: a.union(b), sides, count, boxes: [a, b], slack }
    }

    /// Surely not in the way?
    pub fn is_beside(&self, thing: &Facet) -> bool {
        let (low, high, slack) = (thing.low, thing.high, self.slack);
        if (low + slack).cmpge(self.whole.high).any() || (high - slack).cmple(self.whole.low).any() {
            return true;
        }
        let is_out = |(axes, normal, reach): &Side| {
            let nearest = |k: usize| if normal[k] > 0.0 { low[axes[k]] } else { high[axes[k]] };
            normal.dot(DVec2::new(nearest(0), nearest(1))) >= reach - slack
        };
        self.sides[..self.count].iter().any(is_out)
            || thing.flat.as_ref().is_some_and(|flat| self.is_on_one_side(flat))
    }

    /// Nothing that lies on one side of a plane is parted by what lies in it.
    fn is_on_one_side(&self, flat: &Flat) -> bool {
        let up = flat.normal.cmpgt(DVec3::ZERO);
        let highest = |of: &Box3| flat.height(of.corner(up));
        let lowest = |of: &Box3| flat.height(of.corner(!up));
        self.boxes.iter().all(|of| highest(of) <= self.slack)
            || self.boxes.iter().all(|of| lowest(of) >= -self.slack)
    }
}

/// The hull of two flat patches, of which only what is in front of both matters.
pub struct Shaft<'a> {
    pair: [&'a Facet; 2],
    flats: [&'a Flat; 2],
    /// Outward normals and offsets; made when first asked for.
    sides: Option<Vec<(DVec3, f64)>>,
    slack: f64,
}

impl<'a> Shaft<'a> {
    pub fn new(pair: [&'a Facet; 2], flats: [&'a Flat; 2], slack: f64) -> Self {
        Self { pair, flats, sides: None, slack }
    }

    /// Surely not in the way?
    pub fn is_beside(&mut self, thing: &Facet) -> bool {
        let slack = self.slack;
        if self.flats.iter().any(|flat| thing.hull.iter().all(|&p| flat.height(p) <= slack)) {
            return true;
        }
        if let Some(flat) = &thing.flat {
            let mut heights = self.pair.iter().flat_map(|facet| &facet.hull).map(|&p| flat.height(p));
            if heights.clone().all(|h| h <= slack) || heights.all(|h| h >= -slack) {
                return true;
            }
        }
        let pair = self.pair;
        let sides = self.sides.get_or_insert_with(|| sides(pair, slack));
        let is_out =
            |(normal, reach): &(DVec3, f64)| thing.hull.iter().all(|p| normal.dot(*p) >= reach - slack);
        sides.iter().any(is_out)
    }
}

/// Planes through an edge of one and a corner of the other that have both on one side.
fn sides([a, b]: [&Facet; 2], slack: f64) -> Vec<(DVec3, f64)> {
    let mut sides = Vec::new();
    for (of, with) in [(a, b), (b, a)] {
        let Some(flat) = &of.flat else { continue };
        // What lies behind a patch's plane sees nothing of it.
        let with = clip(&with.hull, flat.normal, flat.offset);
        for [from, to] in edges_of(&of.hull) {
            // Seen along the edge: how far outward and how far up corners lie.
            let out = (to - from).cross(flat.normal).normalize_or_zero();
            let seen = |p: &DVec3| DVec2::new((*p - from).dot(out), flat.height(*p).max(0.0));
            let corners = with.iter().map(seen).filter(|p| p.length() > slack);
            // The one most outward: all others lie on the inner side of the way to it.
            let Some(widest) = corners.reduce(|a, b| if a.perp_dot(b) < 0.0 { b } else { a }) else {
                continue;
            };
            let outward = (out * widest.y - flat.normal * widest.x).normalize();
            sides.push((outward, outward.dot(from)));
        }
    }
    sides
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::form_factors::facet::facets;
    use crate::layout::RayScene;
    use glam::Vec3;

    fn of(triangles: &[[Vec3; 3]]) -> Vec<Facet> {
        let scene = RayScene {
            triangles: triangles.to_vec(),
            patch_triangles: (0..triangles.len()).map(|i| i..i + 1).collect(),
            patch_back: vec![false; triangles.len()],
            patch_areas: vec![1.0; triangles.len()],
            ..RayScene::default()
        };
        facets(&scene, 1e-6, |_| true)
    }

    fn triangle(at: Vec3, turn: glam::Quat, size: f32) -> [Vec3; 3] {
        [Vec3::ZERO, Vec3::X, Vec3::new(0.2, 0.9, 0.0)].map(|p| at + turn * (p - Vec3::splat(0.3)) * size)
    }

    #[test]
    fn what_a_line_of_sight_crosses_is_never_called_beside() {
        let sobol = crate::directions::Sobol::new(4096);
        let number = |k: u32, seed: u64| sobol.point(k, seed).map(|x| x - 0.5);
        let (mut crossed, mut cleared) = (0, 0);
        for k in 0..4000 {
            let make = |seed: u64, size: f32| {
                let ([x, y, z, _], [a, b, c, d]) = (number(k, seed), number(k, seed + 1));
                triangle(Vec3::new(x, y, z), glam::Quat::from_xyzw(a, b, c, d).normalize(), size)
            };
            let triangles = [make(1, 0.5), make(3, 0.7), make(5, 1.0)];
            let facets = of(&triangles);
            let [a, b, thing] = [0, 1, 2].map(|i| &facets[i]);
            let boxes = BoxShaft::new(Box3::of(a), Box3::of(b), 1e-6);
            let flats = [a, b].map(|facet| facet.flat.as_ref().unwrap());
            let is_beside = boxes.is_beside(thing) || Shaft::new([a, b], flats, 1e-6).is_beside(thing);
            let mut is_crossed = false;
            for step in 0..64 {
                let [u, v, s, t] = sobol.point(step, u64::from(k)).map(f64::from);
                let (from, to) = (inside(&triangles[0], u, v), inside(&triangles[1], s, t));
                let faces = flats[0].height(to) > 0.0 && flats[1].height(from) > 0.0;
                is_crossed |= faces && crosses(&triangles[2], from, to);
            }
            assert!(!(is_crossed && is_beside), "{k}: {triangles:?}");
            crossed += usize::from(is_crossed);
            cleared += usize::from(is_beside);
        }
        println!("{crossed} crossed, {cleared} beside");
        assert!(crossed > 100 && cleared > 1000);
    }

    fn inside(t: &[Vec3; 3], u: f64, v: f64) -> DVec3 {
        let [a, b, c] = t.map(|p| p.as_dvec3());
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        a + (b - a) * u + (c - a) * v
    }

    fn crosses(t: &[Vec3; 3], from: DVec3, to: DVec3) -> bool {
        let [a, b, c] = t.map(|p| p.as_dvec3() - from);
        let way = to - from;
        let volumes = [way.dot(b.cross(c)), way.dot(c.cross(a)), way.dot(a.cross(b))];
        let normal = (b - a).cross(c - a);
        let share = normal.dot(a) / normal.dot(way);
        (volumes.iter().all(|v| *v > 1e-9) || volumes.iter().all(|v| *v < -1e-9))
            && share > 1e-6
            && share < 1.0 - 1e-6
    }

    #[test]
    fn a_wall_between_is_in_the_way_and_a_wall_behind_is_not() {
        let square = |x: f32| [Vec3::new(x, -1.0, -1.0), Vec3::new(x, 1.0, -1.0), Vec3::new(x, 0.0, 1.0)];
        let mut facing = square(1.0);
        facing.swap(1, 2);
        let facets = of(&[square(-1.0), facing, square(0.0), square(2.0), square(-1.0)]);
        let flats = [0, 1].map(|i| facets[i].flat.as_ref().unwrap());
        let mut shaft = Shaft::new([&facets[0], &facets[1]], flats, 1e-6);
        assert_eq!([2, 3, 4].map(|i| shaft.is_beside(&facets[i])), [false, true, true]);
    }
}
