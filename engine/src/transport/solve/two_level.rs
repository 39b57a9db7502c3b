//! Two-level Jacobi: a product, then the coarse correction over aggregates, then B >= E. What frames iterate with.
//!
//! ```text
//! B' = B + r,   B <- max(B' + W c, E),   c = inverse (restricted r)          see `coarse`
//! ```
//! A product and n m a step, no sums over all patches: it suits a GPU, and goes on from the light of the last frame
//! whatever happened to E. The error falls by 0.3 .. 0.7 a step however large w is, if light crosses an aggregate in
//! few bounces; never slower than Jacobi's. [`TwoLevel`] is the plain twin of the GPU's passes.

use glam::Vec3;
use rayon::prelude::*;

use super::System;
use super::coarse::{Coarse, Level};
use super::iterate::{Iteration, Left};
use super::matrix::Matrix;
use crate::transport::NONE;

/// One channel in f64.
pub(super) struct TwoLevelJacobi<'a> {
    matrix: &'a Matrix<'a>,
    e: &'a [f64],
    /// E >= 0, and so B >= E.
    lit: bool,
    level: Level,
    sums: Vec<f64>,
    c: Vec<f64>,
}

impl<'a> TwoLevelJacobi<'a> {
    pub fn new(matrix: &'a Matrix<'a>, e: &'a [f64]) -> Self {
        let level = Level::new(matrix);
        let (sums, c) = (vec![0.0; level.m], vec![0.0; level.m]);
        Self { matrix, e, lit: e.iter().all(|&e| e >= 0.0), level, sums, c }
    }
}

impl Iteration for TwoLevelJacobi<'_> {
    fn advance(&mut self, b: &mut [f64], r: &mut [f64]) -> Left {
        self.level.correction(r, &mut self.sums, &mut self.c);
        for i in 0..b.len() {
            b[i] += r[i];
            if self.level.aggregates[i] != NONE {
                b[i] += self.matrix.albedo[i] * self.c[self.level.aggregates[i] as usize];
            }
            if self.lit {
                b[i] = b[i].max(self.e[i]);
            }
        }
        Left::Unknown
    }
}

/// The runtime's iteration on the CPU, f32: the plain twin of the GPU's bounce.
pub struct TwoLevel<'a> {
    pub system: &'a System<'a>,
    pub coarse: &'a Coarse,
}

impl TwoLevel<'_> {
    /// One step from B; returns the largest change that Jacobi made (the residual of the B given).
    pub fn step(&self, e: &[Vec3], b: &mut [Vec3]) -> f32 {
        let (rows, n) = (self.system.rows, b.len());
        let next: Vec<Vec3> = (0..n)
            .into_par_iter()
            .map(|i| {
                let row = rows.row(i).take_while(|&(j, _)| (j as usize) < n);
                e[i] + self.system.albedo[i] * row.map(|(j, weight)| b[j as usize] * weight).sum::<Vec3>()
            })
            .collect();
        let change: Vec<Vec3> = next.iter().zip(b.iter()).map(|(next, b)| *next - *b).collect();
        let residual = change.iter().fold(0.0_f32, |max, change| max.max(change.abs().max_element()));
        let correction = self.coarse.correction(&change);
        for i in 0..n {
            let aggregate = self.system.patches[i].aggregate;
            let lacks = correction.get(aggregate as usize).copied().unwrap_or(Vec3::ZERO);
            b[i] = (next[i] + self.system.albedo[i] * lacks).max(e[i]);
        }
        residual
    }
}
