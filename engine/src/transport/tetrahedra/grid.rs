//! Points on a grid of 2^21 steps over their box, so that what is decided about them can be decided exactly.
//!
//! The grid moves each coordinate by itself, and those that are nearly equal to one value: points in boxes (rows of probes,
//! evenly spaced or not) stay in boxes, whose corners lie on spheres exactly. Were they only nearly there, each face
//! between two boxes would hold a tetrahedron as thin as the rounding, and light would jump in passing it. Rows of probes
//! may be turned as a whole: the grid is turned with them.

use glam::{DMat3, DVec3};

const STEPS: f64 = (1 << 21) as f64;
/// A set that is flat before it goes to the grid is this flat on it [steps]: each point moves by less than one, and
/// the plane is laid through three of them that lie far apart.
const FLAT: f64 = 8.0;
/// Coordinates no further apart than this are one [steps].
const ALIKE: f64 = 2.0;

/// How far a set of points reaches, with points that show it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rank {
    #[default]
    None,
    One,
    /// Two ends.
    Line([u32; 2]),
    /// Three points far from one line.
    Plane([u32; 3]),
    /// Four points far from one plane.
    Space([u32; 4]),
}

#[derive(Clone, Debug, Default)]
pub struct Grid {
    /// position = world_from_grid * (low + step * point)
    pub world_from_grid: DMat3,
    pub low: DVec3,
    pub step: f64,
    /// Whole numbers from 0 to 2^21, all different, in Morton order: those that are near follow one another.
    pub points: Vec<DVec3>,
    /// By point: the first of the given positions that came to lie there.
    pub first: Vec<u32>,
    /// Positions that came to lie on another's point, each with that other one.
    pub merged: Vec<[u32; 2]>,
    pub rank: Rank,
}

impl Grid {
    /// Of finite positions, all in one unit.
    pub fn new(positions: &[DVec3]) -> Self {
        let Some(&first) = positions.first() else { return Self { step: 1.0, ..Self::default() } };
        let world_from_grid = axes(positions);
        let mut points: Vec<DVec3> = positions.iter().map(|&p| world_from_grid.transpose() * p).collect();
        let fold = |with: fn(DVec3, DVec3) -> DVec3| points.iter().copied().reduce(with).unwrap_or(first);
        let (low, high) = (fold(DVec3::min), fold(DVec3::max));
        let extent = (high - low).max_element();
        let step = if extent > 0.0 { extent / STEPS } else { 1.0 };
        points.iter_mut().for_each(|point| *point = (*point - low) / step);
        (0..3).for_each(|axis| snap(&mut points, axis));
        let mut placed: Vec<(u64, u32, DVec3)> =
            (0..).zip(points).map(|(index, point)| (morton(point), index, point)).collect();
        placed.sort_unstable_by_key(|&(order, index, _)| (order, index));
        let mut grid = Self { world_from_grid, low, step, ..Self::default() };
        for (_, index, point) in placed {
            match grid.points.last() {
                Some(&last) if last == point => {
                    grid.merged.push([index, grid.first[grid.first.len() - 1]]);
                }
                _ => {
                    grid.points.push(point);
                    grid.first.push(index);
                }
            }
        }
        grid.rank = rank(&grid.points);
        grid
    }

    /// Where a position lies on the grid, not rounded.
    pub fn at(&self, position: DVec3) -> DVec3 {
        (self.world_from_grid.transpose() * position - self.low) / self.step
    }
}

/// Rounds a coordinate, the same for all points in which it is nearly equal.
fn snap(points: &mut [DVec3], axis: usize) {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&a, &b| points[a][axis].total_cmp(&points[b][axis]));
    let (mut last, mut kept) = (f64::NEG_INFINITY, 0.0);
    for index in order {
        let coordinate = points[index][axis];
        if coordinate - last > ALIKE {
            kept = coordinate.round();
        }
        last = coordinate;
        points[index][axis] = kept;
    }
}

/// Of the world's axes, and of those that the neighbours of some points lie along, the ones in which the points have
/// the fewest different coordinates.
fn axes(positions: &[DVec3]) -> DMat3 {
    const TRIED: usize = 8;
    let each = positions.len().div_ceil(TRIED).max(1);
    let about = positions.iter().step_by(each).filter_map(|&from| axes_about(from, positions));
    let tried = std::iter::once(DMat3::IDENTITY).chain(about);
    let counted = tried.map(|axes| (coordinates(positions, &axes), axes));
    // The first of equals: the world's, if they will do.
    counted.reduce(|best, one| if one.0 < best.0 { one } else { best }).map_or(DMat3::IDENTITY, |best| best.1)
}

/// Towards the nearest neighbour, towards the nearest one across, and across both.
fn axes_about(from: DVec3, positions: &[DVec3]) -> Option<DMat3> {
    let nearest = |counts: &dyn Fn(DVec3) -> bool| {
        let ways = positions.iter().map(|&p| p - from).filter(|&way| way != DVec3::ZERO && counts(way));
        ways.min_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))
    };
    let first = nearest(&|_| true)?.normalize();
    let across = nearest(&|way| way.normalize().dot(first).abs() < 1e-3)?;
    let second = (across - first * across.dot(first)).normalize();
    Some(DMat3::from_cols(first, second, first.cross(second)))
}

/// How many different coordinates there are along three axes.
fn coordinates(positions: &[DVec3], axes: &DMat3) -> usize {
    let along = |axis: usize| {
        let mut all: Vec<f64> = positions.iter().map(|p| p.dot(axes.col(axis))).collect();
        all.sort_by(f64::total_cmp);
        let alike = ALIKE * (all[all.len() - 1] - all[0]) / STEPS;
        1 + all.windows(2).filter(|pair| pair[1] - pair[0] > alike).count()
    };
    (0..3).map(along).sum()
}

/// Bits of three numbers below 2^21 + 1, taken by turns.
fn morton(point: DVec3) -> u64 {
    let spread = |x: f64| {
        let x = (x as u64).min((1 << 21) - 1);
        (0..21).map(|bit| (x >> bit & 1) << (3 * bit)).sum::<u64>()
    };
    spread(point.x) | spread(point.y) << 1 | spread(point.z) << 2
}

fn rank(points: &[DVec3]) -> Rank {
    let Some(&first) = points.first() else { return Rank::None };
    let furthest = |measure: &dyn Fn(DVec3) -> f64| {
        let all = (0..).zip(points).map(|(index, &point)| (measure(point), index));
        all.fold((0.0, 0), |most, one| if one.0 > most.0 { one } else { most })
    };
    let (_, a) = furthest(&|p| p.distance_squared(first));
    let at = |index: u32| points[index as usize];
    let (length, b) = furthest(&|p| p.distance(at(a)));
    if length == 0.0 {
        return Rank::One;
    }
    let (off_line, c) = furthest(&|p| (p - at(a)).cross(at(b) - at(a)).length() / length);
    if off_line <= FLAT {
        return Rank::Line([a, b]);
    }
    let normal = (at(b) - at(a)).cross(at(c) - at(a)).normalize();
    let (off_plane, d) = furthest(&|p| (p - at(a)).dot(normal).abs());
    if off_plane <= FLAT { Rank::Plane([a, b, c]) } else { Rank::Space([a, b, c, d]) }
}
