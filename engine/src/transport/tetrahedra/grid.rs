//! Points on a grid of 2^21 steps over their box, so that what is decided about them can be decided exactly.
//!
//! The grid moves each axis by itself: points in boxes (a grid of probes along the axes, evenly spaced or not) stay
//! in boxes, whose corners lie on spheres exactly.

use glam::DVec3;

const STEPS: f64 = (1 << 21) as f64;
/// A set that is flat before it goes to the grid is this flat on it [steps]: each point moves by less than one, and
/// the plane is laid through three of them that lie far apart.
const FLAT: f64 = 4.0;

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
    /// position = low + step * point
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
        let fold = |with: fn(DVec3, DVec3) -> DVec3| positions.iter().fold(first, |all, &p| with(all, p));
        let (low, high) = (fold(DVec3::min), fold(DVec3::max));
        let extent = (high - low).max_element();
        let step = if extent > 0.0 { extent / STEPS } else { 1.0 };
        let mut placed: Vec<(u64, u32, DVec3)> = (0..)
            .zip(positions)
            .map(|(index, &position)| {
                let point = ((position - low) / step).round();
                (morton(point), index, point)
            })
            .collect();
        placed.sort_unstable_by_key(|&(order, index, _)| (order, index));
        let mut grid = Self { low, step, ..Self::default() };
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
        (position - self.low) / self.step
    }
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
