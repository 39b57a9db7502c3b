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
    points: [(DVec3, f64); 4],
    /// Three for each of its parts, with their areas.
    many_points: Vec<(DVec3, f64)>,
}

/// Beyond this many radii of both, four points say all: to 1e-4 of a factor that is small by then.
const FAR: f64 = 7.0;
/// Beyond this many, three points for each of at least [`PARTS`] parts do.
const APART: f64 = 2.5;
const PARTS: usize = 4;

/// `slack`: how far corners may be off their plane; `is_whole`: by patch, has it no holes?
pub fn facets(scene: &RayScene, slack: f64, is_whole: impl Fn(usize) -> bool) -> Vec<Facet> {
    (0..scene.patch_areas.len())
        .map(|i| {
            let triangles = &scene.triangles[scene.patch_triangles[i].clone()];
            Facet::new(triangles, scene.patch_back[i], slack, is_whole(i))
        })
        .collect()
}

impl Facet {
    fn new(triangles: &[[Vec3; 3]], back: bool, slack: f64, is_whole: bool) -> Self {
        let turned = |t: &[Vec3; 3]| {
            let [a, b, c] = t.map(|corner| corner.as_dvec3());
            if back { [a, c, b] } else { [a, b, c] }
        };
        let triangles: Vec<[DVec3; 3]> = triangles.iter().map(turned).collect();
        let corners: Vec<DVec3> = triangles.iter().flatten().copied().collect();
        let low = corners.iter().fold(DVec3::INFINITY, |low, &p| low.min(p));
        let high = corners.iter().fold(DVec3::NEG_INFINITY, |high, &p| high.max(p));
        match Flat::new(&triangles, slack).filter(|_| is_whole) {
            Some((flat, hull)) => Self { hull, low, high, flat: Some(flat) },
            None => Self { hull: corners, low, high, flat: None },
        }
    }
}

impl Flat {
    fn new(triangles: &[[DVec3; 3]], slack: f64) -> Option<(Self, Vec<DVec3>)> {
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
        if bent > slack || crosses.iter().any(|cross| cross.dot(normal) <= 0.0) {
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
        let points = frame.points(triangles, area).map(|p| (p, 0.25 * area));
        let many_points = points_of_parts(triangles.to_vec());
        let outline = outline(&pieces);
        Some((Self { normal, offset, centre, radius, area, outline, pieces, points, many_points }, hull))
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
    let (distance, radii) = (a.centre.distance(b.centre), a.radius + b.radius);
    let normals = [a.normal, b.normal];
    match distance / radii {
        apart if apart > FAR => polygon::exchange_by_points(&a.points, &b.points, normals),
        apart if apart > APART => polygon::exchange_by_points(&a.many_points, &b.many_points, normals),
        _ => polygon::exchange(&a.outline, &b.outline),
    }
}

/// Exact for squares on each part (Strang and Fix 1973).
fn points_of_parts(mut parts: Vec<[DVec3; 3]>) -> Vec<(DVec3, f64)> {
    while parts.len() < PARTS {
        let quarters = |[a, b, c]: [DVec3; 3]| {
            let (ab, bc, ca) = (a.midpoint(b), b.midpoint(c), c.midpoint(a));
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        parts = parts.into_iter().flat_map(quarters).collect();
    }
    let points = |[a, b, c]: [DVec3; 3]| {
        let share = (b - a).cross(c - a).length() / 6.0;
        let middle = (a + b + c) / 6.0;
        [a, b, c].map(|corner| (middle + 0.5 * corner, share))
    };
    parts.into_iter().flat_map(points).collect()
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
        Facet::new(triangles, false, 1e-6, true)
    }

    fn square(corner: Vec3, first: Vec3, second: Vec3) -> [[Vec3; 3]; 2] {
        let (a, b, c, d) = (corner, corner + first, corner + first + second, corner + second);
        [[a, b, c], [a, c, d]]
    }

    /// The largest error, relative to the closed form, between triangles so many radii apart.
    fn worst(apart: f64) -> f64 {
        let a = facet(&[[Vec3::ZERO, Vec3::X, Vec3::new(0.3, 0.9, 0.0)]]);
        let mut worst = 0.0_f64;
        for k in 0..60 {
            let number =
                |i: u32| crate::directions::unit(crate::directions::hash(u64::from(16 * k + i)) as u32) - 0.5;
            let turn = glam::Quat::from_rotation_x(std::f32::consts::PI + 1.6 * number(0))
                * glam::Quat::from_rotation_z(k as f32);
            let shape = [Vec3::ZERO, Vec3::X, Vec3::new(-0.2, 1.1, 0.0)]
                .map(|p| turn * (p - Vec3::new(0.27, 0.37, 0.0)));
            let radii = a.flat.as_ref().unwrap().radius + facet(&[shape]).flat.unwrap().radius;
            let at = Vec3::new(number(1), number(2), 0.7).normalize() * (apart * radii * 1.001) as f32;
            let b = facet(&[shape.map(|p| p + at + Vec3::new(0.433, 0.3, 0.0))]);
            let [flat_a, flat_b] = [&a, &b].map(|facet| facet.flat.as_ref().unwrap());
            if b.hull.iter().any(|&p| flat_a.height(p) < 0.0)
                || a.hull.iter().any(|&p| flat_b.height(p) < 0.0)
            {
                continue;
            }
            let exact = polygon::exchange(&flat_a.outline, &flat_b.outline);
            worst = worst.max((exchange(&a, &b, 1e-9) / exact - 1.0).abs());
        }
        worst
    }

    #[test]
    fn points_say_what_outlines_say_from_afar() {
        let (many, four) = (worst(APART), worst(FAR));
        println!("worst {many:.1e} from afar, {four:.1e} from farther");
        assert!(many > 0.0 && four > 0.0 && many < 1e-4 && four < 3e-4);
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
