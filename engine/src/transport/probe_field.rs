//! The light between light probes: which of them an object reads, and how much of each.
//!
//! Probes are joined to tetrahedra ([`super::tetrahedra`]); inside one, the four at its corners are blended by
//! barycentric weights (Cupisz, "Light probe interpolation using tetrahedral tessellations", GDC 2012). The
//! tetrahedron is found by walking from the one where the object was last.
//!
//! Beyond the hull, the light is that of the hull's nearest point. The hull is convex: that point is one, and it moves no
//! faster than the object, so that light is continuous out there too. (Extruding the hull along vertex normals, as
//! Cupisz does, is as constant outwards, but folds over itself beside obtuse triangles of the hull.) The same
//! rule holds where probes span less than space: on a line and in a plane, the nearest point there is taken.
//!
//! What a probe does not see it does not light: its weight is multiplied by the share that [`super::depths`] gives, at
//! least a thousandth, so that there is always some light. Probes inside solids are not used.
//!
//! Every weight is >= 0, they sum to 1, and all of it is a continuous function of the place.

mod line;
mod plane;
mod space;

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};

use super::tetrahedra::{Grid, Rank, tetrahedralise};
use super::{Depths, Transport};
use line::Line;
use plane::Plane;
use space::Space;

/// A probe that sees nothing of an object keeps this share of its weight.
const LEAST_SEEN: f64 = 1e-3;

/// How deep a hull's faces may be hollow where they should be flat, in steps of the grid: probes are moved to it by up
/// to one, and they come in f32.
const HOLLOW: f64 = 32.0;

/// Up to four probes, and the share of each; all 0 where there are no probes. `Weights` in
/// `transport/objects.wgsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Weights {
    pub probes: [u32; 4],
    pub weights: [f32; 4],
}

impl Weights {
    pub fn is_none(&self) -> bool {
        self.weights == [0.0; 4]
    }
}

/// What an object remembers from frame to frame: where it was.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cell {
    solid: u32,
    last: Weights,
}

/// Points of the grid and their shares.
type Blend = [(u32, f64); 4];

/// All of one.
fn only(point: u32) -> Blend {
    [(point, 1.0), (point, 0.0), (point, 0.0), (point, 0.0)]
}

#[derive(Clone, Debug)]
enum Shape {
    None,
    One,
    Line(Line),
    Plane(Plane),
    Space(Space),
}

/// An edge between two probes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    pub probes: [u32; 2],
    pub on_hull: bool,
}

#[derive(Clone, Debug)]
pub struct ProbeField {
    grid: Grid,
    shape: Shape,
    /// By point of the grid.
    probes: Vec<u32>,
    positions: Vec<Vec3>,
    maps: Vec<Option<u32>>,
    depths: Depths,
    /// Probes that lie in another's place and are not used, each with that other one.
    pub merged: Vec<[u32; 2]>,
}

impl ProbeField {
    /// Of the valid probes.
    pub fn new(transport: &Transport) -> Self {
        let probes = (0..).zip(&transport.probes);
        let valid: Vec<u32> = probes
            .filter(|(_, probe)| probe.valid > 0.5 && probe.position.is_finite())
            .map(|(index, _)| index)
            .collect();
        let position = |&probe: &u32| transport.probes[probe as usize].position;
        let given: Vec<DVec3> = valid.iter().map(|probe| position(probe).as_dvec3()).collect();
        let grid = Grid::new(&given);
        let probes: Vec<u32> = grid.first.iter().map(|&first| valid[first as usize]).collect();
        let map = |probe: &u32| transport.depths.probes.binary_search(probe).ok().map(|map| map as u32);
        Self {
            shape: match grid.rank {
                Rank::None => Shape::None,
                Rank::One => Shape::One,
                Rank::Line(ends) => Shape::Line(Line::new(&grid.points, ends)),
                Rank::Plane(corners) => Plane::new(&grid.points, corners).map_or(Shape::One, Shape::Plane),
                Rank::Space(start) => Shape::Space(Space::new(tetrahedralise(&grid.points, start))),
            },
            positions: probes.iter().map(position).collect(),
            maps: probes.iter().map(map).collect(),
            depths: transport.depths.clone(),
            merged: grid.merged.iter().map(|pair| pair.map(|one| valid[one as usize])).collect(),
            probes,
            grid,
        }
    }

    /// The light at a place, in metres from the transport's origin: shares of up to four probes. A place that is no
    /// number has the light of the last one that was.
    pub fn weights(&self, at: Vec3, cell: &mut Cell) -> Weights {
        if matches!(self.shape, Shape::None) || (!at.is_finite() && !cell.last.is_none()) {
            return cell.last;
        }
        let at = if at.is_finite() { at } else { self.positions[0] };
        let mut blend = self.blend(self.grid.at(at.as_dvec3()), cell);
        for (point, weight) in &mut blend {
            *weight *= self.seen(*point as usize, at).max(LEAST_SEEN);
        }
        let sum: f64 = blend.iter().map(|one| one.1).sum();
        cell.last = Weights {
            probes: blend.map(|(point, _)| self.probes[point as usize]),
            weights: blend.map(|(_, weight)| (weight / sum) as f32),
        };
        cell.last
    }

    fn blend(&self, at: DVec3, cell: &mut Cell) -> Blend {
        match &self.shape {
            Shape::None | Shape::One => only(0),
            Shape::Line(line) => line.blend(at),
            Shape::Plane(plane) => plane.blend(at),
            Shape::Space(space) => space.blend(at, &mut cell.solid),
        }
    }

    fn seen(&self, point: usize, at: Vec3) -> f64 {
        let map = self.maps[point];
        map.map_or(1.0, |map| f64::from(self.depths.seen(map as usize, at - self.positions[point])))
    }

    /// Neighbours, each pair once.
    pub fn edges(&self) -> Vec<Edge> {
        let edges = match &self.shape {
            Shape::None | Shape::One => Vec::new(),
            Shape::Line(line) => line.edges(),
            Shape::Plane(plane) => plane.edges(),
            Shape::Space(space) => space.tetrahedra.edges(),
        };
        let edge = |(points, on_hull): ([u32; 2], bool)| Edge {
            probes: points.map(|point| self.probes[point as usize]),
            on_hull,
        };
        edges.into_iter().map(edge).collect()
    }

    /// Probes at the corners of each tetrahedron; none where probes span less than space.
    pub fn cells(&self) -> Vec<[u32; 4]> {
        let Shape::Space(Space { tetrahedra, .. }) = &self.shape else { return Vec::new() };
        let solid = &tetrahedra.cells[..tetrahedra.solid];
        solid.iter().map(|cell| cell.corners.map(|point| self.probes[point as usize])).collect()
    }
}

#[cfg(test)]
mod tests;
