//! Probes in space: the tetrahedron that holds the place, or the nearest point of the hull.
//!
//! Rounding leaves faces of a hull that should be flat a little hollow, with probes just below them. So that those count
//! out there too, the hull is first made a little smaller about its middle: its nearest point is one all the same.
//!
//! The nearest point is looked for on faces that are seen from the place, from the one that the walk left through to
//! the nearest of those about its corners, and on. Seen faces of a convex hull hang together, and the distance has no
//! other least value among them.

use glam::DVec3;

use super::{Blend, HOLLOW};
use crate::transport::tetrahedra::Tetrahedra;

#[derive(Clone, Debug)]
pub struct Space {
    pub tetrahedra: Tetrahedra,
    /// Ghosts about point i of the hull: `ghosts[starts[i]..starts[i + 1]]`.
    starts: Vec<u32>,
    ghosts: Vec<u32>,
    pub(super) middle: DVec3,
    /// What is left of the hull's size.
    pub(super) size: f64,
}

impl Space {
    pub fn new(tetrahedra: Tetrahedra) -> Self {
        let mut about: Vec<(u32, u32)> = (tetrahedra.solid as u32..)
            .zip(tetrahedra.hull())
            .flat_map(|(ghost, face)| face.map(|corner| (corner, ghost)))
            .collect();
        about.sort_unstable();
        let starts = (0..=tetrahedra.points.len() as u32)
            .map(|point| about.partition_point(|&(corner, _)| corner < point) as u32)
            .collect();
        let ghosts = about.into_iter().map(|(_, ghost)| ghost).collect();
        let middle = tetrahedra.points.iter().sum::<DVec3>() / tetrahedra.points.len() as f64;
        let depths = tetrahedra.hull().map(|face| depth(middle, face.map(|k| tetrahedra.points[k as usize])));
        let size = 1.0 - (HOLLOW / depths.fold(f64::INFINITY, f64::min)).min(0.5);
        Self { starts, ghosts, middle, size, tetrahedra }
    }

    /// Walks from a solid cell, and leaves there the one where it ended.
    pub fn blend(&self, at: DVec3, solid: &mut u32) -> Blend {
        let start = if (*solid as usize) < self.tetrahedra.solid { *solid } else { 0 };
        // As the smaller hull is to the place, so is the hull to this one.
        let outer = self.middle + (at - self.middle) / self.size;
        let found = self.tetrahedra.locate(outer, start);
        let (at, near) = if (found as usize) < self.tetrahedra.solid {
            (at, found)
        } else {
            let ghost = self.nearest(outer, found);
            let on_hull = self.on_face(outer, ghost).0;
            let point: DVec3 = on_hull.iter().map(|one| self.tetrahedra.points[one.0 as usize] * one.1).sum();
            (
                self.middle + (point - self.middle) * self.size,
                self.tetrahedra.cells[ghost as usize].neighbours[3],
            )
        };
        let found = self.tetrahedra.locate(at, near);
        // Nothing of the smaller hull is outside.
        *solid = if (found as usize) < self.tetrahedra.solid { found } else { near };
        self.inside(at, *solid)
    }

    pub(super) fn inside(&self, at: DVec3, cell: u32) -> Blend {
        let volumes = [0, 1, 2, 3].map(|slot| self.tetrahedra.volume_with(cell, slot, at).max(0.0));
        let sum: f64 = volumes.iter().sum();
        let corners = self.tetrahedra.cells[cell as usize].corners;
        [0, 1, 2, 3].map(|k| (corners[k], volumes[k] / sum))
    }

    /// The ghost whose face is nearest to a place that lies beyond the face of `seen`.
    fn nearest(&self, at: DVec3, seen: u32) -> u32 {
        let (mut best, mut least) = (seen, self.on_face(at, seen).1);
        loop {
            let before = best;
            let corners = self.tetrahedra.cells[before as usize].corners;
            for &corner in &corners[..3] {
                let about = self.starts[corner as usize] as usize..self.starts[corner as usize + 1] as usize;
                for &ghost in &self.ghosts[about] {
                    let distance = self.on_face(at, ghost).1;
                    let cell = &self.tetrahedra.cells[ghost as usize];
                    if distance < least && self.tetrahedra.beyond(cell, at) >= 0.0 {
                        (best, least) = (ghost, distance);
                    }
                }
            }
            if best == before {
                return best;
            }
        }
    }

    /// The point of a ghost's face that is nearest, and the square of its distance.
    pub(super) fn on_face(&self, at: DVec3, ghost: u32) -> (Blend, f64) {
        let [i, j, k, _] = self.tetrahedra.cells[ghost as usize].corners;
        let corners = [i, j, k].map(|corner| self.tetrahedra.points[corner as usize]);
        let [u, v, w] = nearest(at, corners);
        let point = corners[0] * u + corners[1] * v + corners[2] * w;
        ([(i, u), (j, v), (k, w), (i, 0.0)], point.distance_squared(at))
    }
}

/// How far a point is behind a face.
fn depth(at: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    (b - a).cross(c - a).normalize().dot(a - at)
}

/// Weights of the corners at the point of a triangle that is nearest (by the regions of its plane about corners,
/// sides and inside; Ericson 2005, 5.1.5).
fn nearest(p: DVec3, [a, b, c]: [DVec3; 3]) -> [f64; 3] {
    let (ab, ac) = (b - a, c - a);
    let (d1, d2) = (ab.dot(p - a), ac.dot(p - a));
    let (d3, d4) = (ab.dot(p - b), ac.dot(p - b));
    let (d5, d6) = (ab.dot(p - c), ac.dot(p - c));
    let side = |t: f64, from: usize, to: usize| {
        let mut weights = [0.0; 3];
        (weights[from], weights[to]) = (1.0 - t, t);
        weights
    };
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return side(d1 / (d1 - d3), 0, 1);
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return side(d2 / (d2 - d6), 0, 2);
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        return side((d4 - d3) / ((d4 - d3) + (d5 - d6)), 1, 2);
    }
    let sum = va + vb + vc;
    [va / sum, vb / sum, vc / sum]
}
