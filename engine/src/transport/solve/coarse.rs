//! The coarse correction: what an iterate lacks as an even irradiance over each aggregate.
//!
//! ```text
//! W: column a is rho on aggregate a      T: row a is the area mean over aggregate a (W^T A / R, scaled)
//! restricted = T R P                     m x n
//! inverse    = (T (I - R P) W)^-1        m x m
//! B' = E + R P B,   c = inverse (restricted (B' - B)),   B = max(B' + W c, E)
//! ```
//! restricted (B' - B) is T times the residual of B' without another product: r' = R P r. As T is W^T D up to scale, the
//! correction is the projection that is orthogonal in the energy of the symmetric system: it never adds to the error's
//! energy, whatever the albedo is and however poor the aggregates. What is black stays as it is. The clamp is true of
//! the solution and so never adds to an error either. Source: two-grid with additive aggregates, Hackbusch (1985).

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::System;
use super::inverse::{dot, inverse, times};
use super::matrix::{Matrix, WORTH_THREADS};
use crate::transport::NONE;

/// For the runtime: f32, three channels at once.
#[derive(Clone, Debug, Default)]
pub struct Coarse {
    pub m: usize,
    /// m x n, row-major, rgb.
    pub restricted: Vec<Vec4>,
    /// m x m, row-major, by channel.
    pub inverse: [Vec<f32>; 3],
}

impl Coarse {
    pub fn new(system: &System) -> Self {
        let level = |channel: usize| Level::new(&Matrix::of(system, channel));
        let grey = system.albedo.iter().all(|albedo| albedo.x == albedo.y && albedo.y == albedo.z);
        let levels = if grey { vec![level(0)] } else { (0..3).map(level).collect() };
        let levels = [0, 1, 2].map(|channel| &levels[channel.min(levels.len() - 1)]);
        // An aggregate that is black in one channel is there in others.
        let m = levels.iter().map(|level| level.m).max().unwrap_or(0);
        let [red, green, blue] = levels;
        let n = system.patches.len();
        let at = |level: &Level, k: usize| level.restricted.get(k).map_or(0.0, |&x| x as f32);
        let restricted = (0..m * n).map(|k| Vec4::new(at(red, k), at(green, k), at(blue, k), 0.0)).collect();
        Self { m, restricted, inverse: levels.map(|level| level.inverse_of(m)) }
    }

    /// Aggregates' corrections for a change B' - B: what irradiance they lack.
    pub fn correction(&self, change: &[Vec3]) -> Vec<Vec3> {
        let n = change.len();
        let restricted: Vec<Vec3> = (0..self.m)
            .into_par_iter()
            .map(|a| {
                self.restricted[a * n..(a + 1) * n].iter().zip(change).map(|(r, c)| r.truncate() * *c).sum()
            })
            .collect();
        let at = |a: usize, channel: usize| -> f32 {
            (0..self.m).map(|b| self.inverse[channel][a * self.m + b] * restricted[b][channel]).sum()
        };
        (0..self.m).map(|a| Vec3::new(at(a, 0), at(a, 1), at(a, 2))).collect()
    }
}

/// One channel in f64.
pub(super) struct Level {
    pub m: usize,
    /// By patch; none where nothing is reflected.
    pub aggregates: Vec<u32>,
    pub restricted: Vec<f64>,
    pub inverse: Vec<f64>,
}

impl Level {
    pub fn new(matrix: &Matrix) -> Self {
        let n = matrix.len();
        let (aggregates, m) = matrix.aggregates();
        let mut members: Vec<Vec<usize>> = vec![Vec::new(); m];
        for i in (0..n).filter(|&i| aggregates[i] != NONE) {
            members[aggregates[i] as usize].push(i);
        }
        let mut restricted = vec![0.0; m * n];
        restricted
            .par_chunks_mut(n.max(1))
            .zip(&members)
            .for_each(|(row, members)| restrict(matrix, members, row));
        let mut system = vec![0.0; m * m];
        for a in 0..m {
            let row = &mut system[a * m..][..m];
            let area: f64 = members[a].iter().map(|&i| matrix.area(i)).sum();
            row[a] = members[a].iter().map(|&i| matrix.area(i) * matrix.albedo[i]).sum::<f64>()
                / area.max(f64::MIN_POSITIVE);
            for j in (0..n).filter(|&j| aggregates[j] != NONE) {
                row[aggregates[j] as usize] -= restricted[a * n + j] * matrix.albedo[j];
            }
        }
        Self { m, aggregates, restricted, inverse: inverse(system, m) }
    }

    /// c = inverse (restricted change).
    pub fn correction(&self, change: &[f64], sums: &mut [f64], c: &mut [f64]) {
        let n = change.len().max(1);
        let restrict = |(sum, row): (&mut f64, &[f64])| *sum = dot(row, change);
        if self.restricted.len() < WORTH_THREADS {
            sums.iter_mut().zip(self.restricted.chunks_exact(n)).for_each(restrict);
        } else {
            sums.par_iter_mut().zip(self.restricted.par_chunks_exact(n)).for_each(restrict);
        }
        times(&self.inverse, sums, c);
    }

    /// As f32, with nothing for aggregates beyond its own.
    fn inverse_of(&self, m: usize) -> Vec<f32> {
        let at =
            |a: usize, b: usize| if a < self.m && b < self.m { self.inverse[a * self.m + b] } else { 0.0 };
        (0..m * m).map(|k| at(k / m, k % m) as f32).collect()
    }
}

/// A row of T R P: what the patches of an aggregate reflect of each patch's light, on average over their area.
fn restrict(matrix: &Matrix, members: &[usize], row: &mut [f64]) {
    let area: f64 = members.iter().map(|&i| matrix.area(i)).sum();
    for &i in members {
        let share = matrix.albedo[i] * matrix.area(i) / area;
        let (columns, weights) = matrix.row(i);
        for (&j, &weight) in columns.iter().zip(weights) {
            row[j as usize] += share * f64::from(weight);
        }
    }
}
