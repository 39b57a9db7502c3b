//! Patches as polygons: what a closed form and a line of sight ask of them.

use std::collections::HashMap;

use glam::{DVec2, DVec3, Vec3};

use super::polygon::{self, Edge, clip, edges_of};
use crate::layout::RayScene;

/// A patch's shape, scaled units.
pub struct Facet {
    /// Of its convex hull, counter-clockwise from its front; of one that is not flat, all its corners.
    pub hull: Vec<DVec3>,
    pub low: DVec3,
    pub high: DVec3,
    /// Unless it is bent or has holes.
    pub flat: Option<Flat>,
}

pub struct Flat {
    pub normal: DVec3,
    /// The plane: normal . x = offset.
    pub offset: f64,
    pub centre: DVec3,
    /// No corner is farther from the centre.
    pub radius: f64,
    area: f64,
    /// Its boundary, counter-clockwise.
    outline: Vec<Edge>,
    /// Convex parts.
    pieces: Vec<Vec<DVec3>>,
    /// Four points of equal weight with its area's centre and second moments.
    points: [DVec3; 4],
}

/// How far corners may be off a plane, in shares of a patch's size.
const BENT: f64 = 1e-4;
/// Beyond this many radii of both, four points say all (to 1e-3 of the factor).
const FAR: f64 = 3.0;

/// `is_whole`: by patch, has it no holes?
pub fn facets(scene: &RayScene, is_whole: impl Fn(usize) -> bool) -> Vec<Facet> {
    (0..scene.patch_areas.len())
        .map(|i| {
            let triangles = &scene.triangles[scene.patch_triangles[i].clone()];
            Facet::new(triangles, scene.patch_back[i], is_whole(i))
        })
        .collect()
}

impl Facet {
    fn new(triangles: &[[Vec3; 3]], back: bool, is_whole: bool) -> Self {
        let turned = |t: &[Vec3; 3]| {
            let [a, b, c] = t.map(|corner| corner.as_dvec3());
            if back { [a, c, b] } else { [a, b, c] }
        };
        let triangles: Vec<[DVec3; 3]> = triangles.iter().map(turned).collect();
        let corners: Vec<DVec3> = triangles.iter().flatten().copied().collect();
        let low = corners.iter().fold(DVec3::INFINITY, |low, &p| low.min(p));
        let high = corners.iter().fold(DVec3::NEG_INFINITY, |high, &p| high.max(p));
        match Flat::new(&triangles).filter(|_| is_whole) {
            Some((flat, hull)) => Self { hull, low, high, flat: Some(flat) },
            None => Self { hull: corners, low, high, flat: None },
        }
    }
}

impl Flat {
    fn new(triangles: &[[DVec3; 3]]) -> Option<(Self, Vec<DVec3>)> {
        let crosses: Vec<DVec3> = triangles.iter().map(|[a, b, c]| (*b - *a).cross(*c - *a) * 0.5).collect();
        let whole: DVec3 = crosses.iter().sum();
        let area = whole.length();
        let normal = whole.try_normalize()?;
        let middle = |t: &[DVec3; 3]| (t[0] + t[1] + t[2]) / 3.0;
        let centre =
            triangles.iter().zip(&crosses).map(|(t, cross)| middle(t) * cross.length()).sum::<DVec3>()
                / crosses.iter().map(|cross| cross.length()).sum::<f64>();
        let offset = normal.dot(centre);
        let corners = triangles.iter().flatten();
        let bent = corners.clone().map(|p| (normal.dot(*p) - offset).abs()).fold(0.0, f64::max);
        if bent > BENT * area.sqrt() || crosses.iter().any(|cross| cross.dot(normal) <= 0.0) {
            return None;
        }
        let frame = Frame::new(normal, centre);
        let hull = hull(corners.clone().map(|&p| frame.flattened(p)).collect());
        let covered =
            0.5 * (0..hull.len()).map(|k| hull[k].perp_dot(hull[(k + 1) % hull.len()])).sum::<f64>();
        let hull: Vec<DVec3> = hull.into_iter().map(|p| frame.raised(p)).collect();
        // Folded over itself.
        if covered < area * (1.0 - 1e-5) {
            return None;
        }
        let pieces = if covered <= area * (1.0 + 1e-5) {
            vec![hull.clone()]
        } else {
            triangles.iter().map(|t| t.to_vec()).collect()
        };
        let radius = hull.iter().map(|p| p.distance(centre)).fold(0.0, f64::max);
        let points = frame.points(triangles, area);
        let outline = outline(&pieces);
        Some((Self { normal, offset, centre, radius, area, outline, pieces, points }, hull))
    }

    pub fn height(&self, p: DVec3) -> f64 {
        self.normal.dot(p) - self.offset
    }

    pub fn area(&self) -> f64 {
        self.area
    }

    /// Outlines of what lies in front of the other.
    fn clipped(&self, other: &Self) -> Vec<Edge> {
        let parts = self.pieces.iter().map(|piece| clip(piece, other.normal, other.offset));
        parts.flat_map(|part| edges_of(&part).collect::<Vec<_>>()).collect()
    }
}

/// A_i F_ij of patches with nothing between them, heights under `slack` of a plane counted as on it.
pub fn exchange(of: &Facet, with: &Facet, slack: f64) -> f64 {
    let (Some(a), Some(b)) = (&of.flat, &with.flat) else { return 0.0 };
    let heights = |flat: &Flat, hull: &[DVec3]| {
        let heights = hull.iter().map(|&p| flat.height(p));
        heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], h| [low.min(h), high.max(h)])
    };
    let ([low_a, high_a], [low_b, high_b]) = (heights(b, &of.hull), heights(a, &with.hull));
    if high_a <= slack || high_b <= slack {
        return 0.0;
    }
    let whole = low_a >= -slack && low_b >= -slack;
    if !whole {
        return polygon::exchange(&a.clipped(b), &b.clipped(a));
    }
    if a.centre.distance(b.centre) > FAR * (a.radius + b.radius) {
        return polygon::exchange_by_points(&a.points, &b.points, [a.normal, b.normal], [a.area, b.area]);
    }
    polygon::exchange(&a.outline, &b.outline)
}

/// A plane with two axes.
struct Frame {
    x: DVec3,
    y: DVec3,
    centre: DVec3,
}

impl Frame {
    fn new(normal: DVec3, centre: DVec3) -> Self {
        let (x, y) = normal.any_orthonormal_pair();
        Self { x, y, centre }
    }

    fn flattened(&self, p: DVec3) -> DVec2 {
        DVec2::new(self.x.dot(p - self.centre), self.y.dot(p - self.centre))
    }

    fn raised(&self, p: DVec2) -> DVec3 {
        self.centre + self.x * p.x + self.y * p.y
    }

    /// centre +- e_k sqrt(2 v_k), where v_k and e_k are the principal variances of the area.
    fn points(&self, triangles: &[[DVec3; 3]], area: f64) -> [DVec3; 4] {
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for corners in triangles {
            let corners = corners.map(|p| self.flattened(p));
            let [a, b, c] = corners;
            let share = 0.5 * (b - a).perp_dot(c - a).abs() / (12.0 * area);
            for p in [a, b, c, a + b + c] {
                xx += share * p.x * p.x;
                xy += share * p.x * p.y;
                yy += share * p.y * p.y;
            }
        }
        let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
        let (mean, spread) = (0.5 * (xx + yy), (0.25 * (xx - yy).powi(2) + xy * xy).sqrt());
        let major = DVec2::from_angle(angle) * (2.0 * (mean + spread)).sqrt();
        let minor = DVec2::from_angle(angle).perp() * (2.0 * (mean - spread).max(0.0)).sqrt();
        [major, -major, minor, -minor].map(|p| self.raised(p))
    }
}

/// Counter-clockwise, without corners on its sides (Andrew's monotone chain).
fn hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    let half = |points: &mut dyn Iterator<Item = DVec2>| {
        let mut chain: Vec<DVec2> = Vec::new();
        for p in points {
            while let [.., a, b] = chain[..] {
                if (b - a).perp_dot(p - b) > 1e-9 * (b - a).length() * (p - b).length() {
                    break;
                }
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut hull = half(&mut points.iter().copied());
    hull.extend(half(&mut points.iter().rev().copied()));
    hull
}

/// The edges that no neighbour has in the other direction.
fn outline(pieces: &[Vec<DVec3>]) -> Vec<Edge> {
    let bits = |p: DVec3| p.to_array().map(f64::to_bits);
    let edges: Vec<Edge> = pieces.iter().flat_map(|piece| edges_of(piece)).collect();
    let mut counts: HashMap<_, i32> = HashMap::new();
    edges.iter().for_each(|[a, b]| *counts.entry((bits(*a), bits(*b))).or_default() += 1);
    let is_alone = |[a, b]: &Edge| !counts.contains_key(&(bits(*b), bits(*a)));
    edges.iter().copied().filter(is_alone).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn facet(triangles: &[[Vec3; 3]]) -> Facet {
        Facet::new(triangles, false, true)
    }

    fn square(corner: Vec3, first: Vec3, second: Vec3) -> [[Vec3; 3]; 2] {
        let (a, b, c, d) = (corner, corner + first, corner + first + second, corner + second);
        [[a, b, c], [a, c, d]]
    }

    #[test]
    fn four_points_say_what_outlines_say_from_afar() {
        let a = facet(&[[Vec3::ZERO, Vec3::X, Vec3::new(0.3, 0.9, 0.0)]]);
        let mut worst = 0.0_f64;
        for k in 0..40 {
            let turn =
                glam::Quat::from_rotation_x(3.1416 + 0.02 * k as f32) * glam::Quat::from_rotation_z(k as f32);
            let at = Vec3::new((k as f32).sin() * 2.0, 0.4, 3.6);
            let b = facet(&[[Vec3::ZERO, Vec3::X, Vec3::new(-0.2, 1.1, 0.0)].map(|p| turn * p + at)]);
            let (flat_a, flat_b) = (a.flat.as_ref().unwrap(), b.flat.as_ref().unwrap());
            assert!(flat_a.centre.distance(flat_b.centre) > FAR);
            let exact = polygon::exchange(&flat_a.outline, &flat_b.outline);
            let normals = [flat_a.normal, flat_b.normal];
            let found = polygon::exchange_by_points(
                &flat_a.points,
                &flat_b.points,
                normals,
                [flat_a.area, flat_b.area],
            );
            worst = worst.max((found / exact - 1.0).abs());
        }
        println!("worst {worst:.1e}");
        assert!(worst < 1e-2, "{worst}");
    }

    #[test]
    fn what_lies_behind_a_plane_is_cut_off() {
        // A unit square half of which is under the floor sees as much as its upper half.
        let floor = facet(&square(Vec3::ZERO, Vec3::Z, Vec3::X));
        let sunk = facet(&square(Vec3::new(-0.5, -1.0, 0.0), Vec3::Y * 2.0, Vec3::Z));
        let standing = facet(&square(Vec3::new(-0.5, 0.0, 0.0), Vec3::Y, Vec3::Z));
        let (whole, half) = (exchange(&floor, &standing, 1e-9), exchange(&floor, &sunk, 1e-9));
        assert!((whole - half).abs() < 1e-9 && whole > 0.01, "{whole} {half}");
        assert_eq!(exchange(&floor, &floor, 1e-9), 0.0);
    }

    #[test]
    fn a_bent_patch_is_not_flat_and_a_concave_one_keeps_its_area() {
        let [a, b] = square(Vec3::ZERO, Vec3::Z, Vec3::X);
        let bent = [a, b.map(|p| if p == Vec3::X { Vec3::new(1.0, 0.1, 0.0) } else { p })];
        assert!(facet(&bent).flat.is_none());
        let concave = [a, b, square(Vec3::X, Vec3::Z, Vec3::X)[0]];
        let ceiling = facet(&square(Vec3::Y, Vec3::X, Vec3::Z));
        let apart: f64 = concave.iter().map(|&t| exchange(&facet(&[t]), &ceiling, 1e-9)).sum();
        let together = exchange(&facet(&concave), &ceiling, 1e-9);
        assert!((apart - together).abs() < 1e-8 && together > 0.2, "{apart} {together}");
    }
}
