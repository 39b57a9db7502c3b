//! Tetrahedra between points: the Delaunay tetrahedralisation, in which no point lies inside the sphere about the
//! corners of any tetrahedron.
//!
//! Points are inserted one by one (Bowyer 1981, Watson 1981): the tetrahedra whose sphere holds the new point are
//! taken out, and the hole is filled from it. Beyond each face of the hull stands a *ghost*, a tetrahedron with a
//! corner at infinity, whose "sphere" is all that lies beyond its face: with ghosts every tetrahedron has four
//! neighbours and no case is special.
//!
//! Signs are exact (Shewchuk 1997, by the crate `robust`) on points that were moved to a grid ([`Grid`]). A sphere
//! holds a point only where it is strictly inside. Then no new tetrahedron is flat: were the new point in the plane of
//! a face of the hole, it would lie inside the circle about that face, and so inside the spheres on both of its
//! sides, and the face would not be one of the hole's. So the eight corners of a box, all on one sphere, need no
//! perturbation.

mod build;
mod grid;

use glam::DVec3;
use robust::Coord3D;

pub use build::tetrahedralise;
pub use grid::{Grid, Rank};

/// The corner at infinity.
pub const GHOST: u32 = u32::MAX;

/// Four corners, and behind the face opposite to each the neighbour there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cell {
    /// Points; seen from the last one the first three run clockwise. A ghost's last corner is [`GHOST`]: its first
    /// three are a face of the hull, counter-clockwise seen from outside.
    pub corners: [u32; 4],
    pub neighbours: [u32; 4],
}

/// Solid tetrahedra fill the convex hull of all points; a ghost stands on each of its faces.
#[derive(Clone, Debug, Default)]
pub struct Tetrahedra {
    /// Whole numbers.
    pub points: Vec<DVec3>,
    /// Solid ones, then ghosts.
    pub cells: Vec<Cell>,
    pub solid: usize,
}

impl Cell {
    /// Where the corner at infinity stands.
    fn ghost(&self) -> Option<usize> {
        self.corners.iter().position(|&corner| corner == GHOST)
    }
}

impl Tetrahedra {
    /// Faces of the hull, counter-clockwise seen from outside.
    pub fn hull(&self) -> impl ExactSizeIterator<Item = [u32; 3]> + '_ {
        self.cells[self.solid..].iter().map(|cell| [cell.corners[0], cell.corners[1], cell.corners[2]])
    }

    /// All edges once, the lower point first, ascending; true where the edge lies on the hull.
    pub fn edges(&self) -> Vec<([u32; 2], bool)> {
        let of = |corners: &[u32], on_hull: bool, edges: &mut Vec<([u32; 2], bool)>| {
            for (i, &a) in corners.iter().enumerate() {
                edges.extend(corners[i + 1..].iter().map(|&b| ([a.min(b), a.max(b)], on_hull)));
            }
        };
        let mut edges = Vec::new();
        self.cells[..self.solid].iter().for_each(|cell| of(&cell.corners, false, &mut edges));
        self.hull().for_each(|face| of(&face, true, &mut edges));
        // Of one edge those of the hull come first.
        edges.sort_unstable_by_key(|&(edge, on_hull)| (edge, !on_hull));
        edges.dedup_by_key(|(edge, _)| *edge);
        edges
    }

    /// Six times the volume of a solid cell with another point in place of one corner: positive where that point
    /// is on the corner's side of the face opposite to it. The sign is exact.
    pub fn volume_with(&self, cell: u32, slot: usize, at: DVec3) -> f64 {
        let mut points = self.cells[cell as usize].corners.map(|corner| self.points[corner as usize]);
        points[slot] = at;
        volume(points)
    }

    /// The solid cell that holds a point, or the ghost on a face that it lies strictly beyond; walks there from a
    /// solid cell. In a Delaunay tetrahedralisation such a walk never comes back to where it was (Edelsbrunner 1990).
    pub fn locate(&self, at: DVec3, from: u32) -> u32 {
        let mut cell = from;
        'walk: loop {
            for slot in 0..4 {
                if self.volume_with(cell, slot, at) < 0.0 {
                    cell = self.cells[cell as usize].neighbours[slot];
                    if cell as usize >= self.solid {
                        return cell;
                    }
                    continue 'walk;
                }
            }
            return cell;
        }
    }

    /// Neighbours are neighbours of each other and share three corners, solid cells have a volume, ghosts stand
    /// outside. Says what does not hold.
    pub fn validate(&self) -> Result<(), String> {
        for (index, cell) in self.cells.iter().enumerate() {
            let is_ghost = index >= self.solid;
            if cell.ghost() != is_ghost.then_some(3) {
                return Err(format!("cell {index} has its ghost at {:?}", cell.ghost()));
            }
            for slot in 0..4 {
                let there = self.cells.get(cell.neighbours[slot] as usize);
                let there = there.ok_or(format!("cell {index} has no neighbour {slot}"))?;
                let shared = |corner: &u32| *corner != cell.corners[slot] && there.corners.contains(corner);
                if !there.neighbours.contains(&(index as u32))
                    || cell.corners.iter().filter(|corner| shared(corner)).count() != 3
                {
                    return Err(format!("cell {index} and its neighbour {slot} share no face"));
                }
            }
            let points = |cell: &Cell| cell.corners.map(|corner| self.points[corner as usize]);
            if !is_ghost && volume(points(cell)) <= 0.0 {
                return Err(format!("cell {index} is flat or inside out"));
            }
            let behind = &self.cells[cell.neighbours[3] as usize];
            let last = behind.corners.iter().find(|corner| !cell.corners.contains(corner));
            if is_ghost && last.is_some_and(|&last| self.beyond(cell, self.points[last as usize]) >= 0.0) {
                return Err(format!("ghost {index} stands inside"));
            }
        }
        Ok(())
    }

    /// Positive beyond the face of a ghost.
    pub fn beyond(&self, ghost: &Cell, at: DVec3) -> f64 {
        let [a, b, c, _] = ghost.corners;
        volume([self.points[a as usize], self.points[b as usize], self.points[c as usize], at])
    }
}

/// Six times the volume of a tetrahedron, negative where it is inside out. The sign is exact.
fn volume([a, b, c, d]: [DVec3; 4]) -> f64 {
    // `robust` counts what lies below as positive.
    robust::orient3d(coord(a), coord(c), coord(b), coord(d))
}

/// Positive where a point is strictly inside the sphere about a tetrahedron that is not inside out.
fn inside_sphere([a, b, c, d]: [DVec3; 4], at: DVec3) -> f64 {
    robust::insphere(coord(a), coord(c), coord(b), coord(d), coord(at))
}

fn coord(p: DVec3) -> Coord3D<f64> {
    Coord3D { x: p.x, y: p.y, z: p.z }
}

#[cfg(test)]
mod tests;
