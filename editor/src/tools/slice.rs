//! A plane through the tetrahedra between light probes: what an object that moves in it would read.
//!
//! The plane cuts each tetrahedron in a triangle or a quadrilateral, whose corners lie on edges between two probes. Light
//! is linear inside a tetrahedron, and so it is in the section: any triangulation that keeps the sections' sides shows it
//! exactly. A constrained Delaunay triangulation (`spade`) of all cut points is one.

use std::collections::HashMap;

use glam::{DVec2, DVec3};
use spade::{ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation};

use super::web::Web;

/// Where the plane is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Of the world: across it.
    pub axis: usize,
    /// Along the axis, metres.
    pub offset: f64,
}

/// A point in the plane, between two probes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut {
    pub at: DVec3,
    pub probes: [usize; 2],
    /// Of the second.
    pub share: f64,
}

#[derive(Clone, Debug, Default)]
pub struct Slice {
    pub cuts: Vec<Cut>,
    pub triangles: Vec<[usize; 3]>,
    /// How many tetrahedra are cut.
    pub sections: usize,
    /// Sides of sections, each once.
    pub sides: Vec<[usize; 2]>,
}

/// Coordinates are rounded to this share of the slice's size: cuts in one place become one.
const ROUNDED: f64 = 1.0 / (1 << 20) as f64;

struct Corner {
    at: Point2<f64>,
    cut: usize,
}

impl HasPosition for Corner {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.at
    }
}

impl Plane {
    fn height(&self, place: DVec3) -> f64 {
        place[self.axis] - self.offset
    }

    fn flat(&self, place: DVec3) -> DVec2 {
        DVec2::new(place[(self.axis + 1) % 3], place[(self.axis + 2) % 3])
    }
}

pub fn slice(web: &Web, plane: &Plane) -> Slice {
    let mut cutting = Cutting::new(web, *plane);
    let sections: Vec<Vec<usize>> = web.cells.iter().map(|cell| cutting.section(*cell)).collect();
    triangulated(cutting, &sections)
}

/// Cut points as they are found, each once.
struct Cutting<'a> {
    web: &'a Web,
    plane: Plane,
    step: f64,
    known: HashMap<[i64; 2], usize>,
    cuts: Vec<Cut>,
}

impl<'a> Cutting<'a> {
    fn new(web: &'a Web, plane: Plane) -> Self {
        let fold = |with: fn(DVec3, DVec3) -> DVec3| web.positions.iter().copied().reduce(with);
        let extent = fold(DVec3::max).unwrap_or_default() - fold(DVec3::min).unwrap_or_default();
        let step = (extent.max_element() * ROUNDED).max(1e-9);
        Self { web, plane, step, known: HashMap::new(), cuts: Vec::new() }
    }

    /// The corners of a cell's section, around it; fewer than three: the plane does not cut it. A probe in the plane
    /// counts as above it, so that no section is found twice.
    fn section(&mut self, cell: [usize; 4]) -> Vec<usize> {
        let heights = cell.map(|probe| self.plane.height(self.web.positions[probe]));
        let mut corners = Vec::new();
        for i in 0..4 {
            for j in i + 1..4 {
                if (heights[i] >= 0.0) != (heights[j] >= 0.0) {
                    let share = heights[i] / (heights[i] - heights[j]);
                    corners.push(self.cut([cell[i], cell[j]], share));
                }
            }
        }
        corners.sort_unstable();
        corners.dedup();
        let flat = |cut: usize| self.plane.flat(self.cuts[cut].at);
        let middle = corners.iter().map(|cut| flat(*cut)).sum::<DVec2>() / corners.len().max(1) as f64;
        corners.sort_by(|a, b| angle(flat(*a) - middle).total_cmp(&angle(flat(*b) - middle)));
        corners
    }

    fn cut(&mut self, probes: [usize; 2], share: f64) -> usize {
        let [from, to] = probes.map(|probe| self.web.positions[probe]);
        let at = from.lerp(to, share);
        let key = (self.plane.flat(at) / self.step).to_array().map(|x| x.round() as i64);
        *self.known.entry(key).or_insert_with(|| {
            self.cuts.push(Cut { at, probes, share });
            self.cuts.len() - 1
        })
    }
}

fn angle(way: DVec2) -> f64 {
    way.y.atan2(way.x)
}

fn triangulated(cutting: Cutting<'_>, sections: &[Vec<usize>]) -> Slice {
    let Cutting { plane, step, cuts, .. } = cutting;
    let mut slice = Slice { cuts, ..Slice::default() };
    let mut net = ConstrainedDelaunayTriangulation::<Corner>::new();
    let place = |(cut, at): (usize, &Cut)| {
        let [x, y] = (plane.flat(at.at) / step).to_array().map(f64::round);
        net.insert(Corner { at: Point2::new(x, y), cut }).ok()
    };
    let handles: Vec<_> = slice.cuts.iter().enumerate().map(place).collect();
    for section in sections.iter().filter(|section| section.len() >= 3) {
        slice.sections += 1;
        for (k, &from) in section.iter().enumerate() {
            let to = section[(k + 1) % section.len()];
            let side = [from.min(to), from.max(to)];
            if let (Some(a), Some(b)) = (handles[from], handles[to])
                && a != b
                && net.can_add_constraint(a, b)
            {
                net.add_constraint(a, b);
            }
            slice.sides.push(side);
        }
    }
    slice.sides.sort_unstable();
    slice.sides.dedup();
    slice.triangles = net.inner_faces().map(|face| face.vertices().map(|corner| corner.data().cut)).collect();
    slice
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(counts: [i32; 3]) -> Web {
        let mut positions = Vec::new();
        for z in 0..counts[2] {
            for y in 0..counts[1] {
                positions.extend((0..counts[0]).map(|x| DVec3::new(x.into(), y.into(), z.into())));
            }
        }
        Web::between(positions)
    }

    fn area(slice: &Slice, plane: &Plane) -> f64 {
        let triangle = |corners: &[usize; 3]| {
            let [a, b, c] = corners.map(|cut| plane.flat(slice.cuts[cut].at));
            (b - a).perp_dot(c - a).abs() * 0.5
        };
        slice.triangles.iter().map(triangle).sum()
    }

    #[test]
    fn sections_fill_what_the_plane_cuts_of_the_hull() {
        let web = grid([4, 3, 3]);
        for (axis, offset, wide) in [(0, 1.4, 4.0), (1, 0.5, 6.0), (2, 1.999, 6.0), (1, 1.0, 6.0)] {
            let plane = Plane { axis, offset };
            let slice = slice(&web, &plane);
            assert!((area(&slice, &plane) - wide).abs() < 1e-3, "{plane:?}: {}", area(&slice, &plane));
            assert!(slice.sections > 8 && slice.sides.len() > slice.sections);
        }
        let beside = slice(&web, &Plane { axis: 0, offset: 9.0 });
        assert!(beside.cuts.is_empty() && beside.triangles.is_empty());
    }

    #[test]
    fn a_cut_is_the_mean_of_its_two_probes() {
        let web = grid([3, 3, 3]);
        let plane = Plane { axis: 2, offset: 0.3 };
        for cut in slice(&web, &plane).cuts {
            let [from, to] = cut.probes.map(|probe| web.positions[probe]);
            assert!(cut.at.abs_diff_eq(from.lerp(to, cut.share), 1e-12) && (cut.at.z - 0.3).abs() < 1e-9);
        }
    }

    /// Each triangle lies in one section: its middle is blended of no more than four probes, those of one cell.
    #[test]
    fn no_triangle_crosses_the_side_of_a_section() {
        let web = grid([3, 3, 3]);
        let slice = slice(&web, &Plane { axis: 1, offset: 0.6 });
        for corners in &slice.triangles {
            let mut probes: Vec<usize> = corners.iter().flat_map(|cut| slice.cuts[*cut].probes).collect();
            probes.sort_unstable();
            probes.dedup();
            let is_of_one = web.cells.iter().any(|cell| probes.iter().all(|probe| cell.contains(probe)));
            assert!(is_of_one, "{probes:?}");
        }
    }
}
