//! I - R P for one channel, and products with it: the work that all methods are counted in.
//!
//! A product reads every entry once, 8 bytes each, and is bound by that: rows are dealt to threads, each row is summed
//! by one of them in an order of its own, so that the sums are the same on any number of threads. Four sums at once
//! let additions overlap.

use rayon::prelude::*;

use super::System;
use crate::transport::{NONE, Patch, Rows};

/// Entries below which threads cost more than they bring.
pub(super) const WORTH_THREADS: usize = 1 << 17;

/// I - R P of one channel.
pub struct Matrix<'a> {
    pub rows: &'a Rows,
    pub patches: &'a [Patch],
    /// By patch, in [0, 1].
    pub albedo: Vec<f64>,
    /// By row: where its patch columns end; those of the sky follow.
    ends: Vec<usize>,
}

/// Of albedo.
const NEXT_TO_NOTHING: f64 = 1e-9;

impl<'a> Matrix<'a> {
    /// Albedo is clamped to [0, 1]; what is no number counts as 0.
    pub fn new(rows: &'a Rows, patches: &'a [Patch], albedo: impl IntoIterator<Item = f64>) -> Self {
        let n = patches.len();
        let ends = (0..n).map(|i| {
            let range = rows.range(i);
            range.start + rows.columns[range].partition_point(|&column| (column as usize) < n)
        });
        let shares = |rho: f64| if rho.is_nan() { 0.0 } else { rho.clamp(0.0, 1.0) };
        let mut albedo: Vec<f64> = albedo.into_iter().map(shares).collect();
        albedo.resize(n, 0.0);
        Self { rows, patches, albedo, ends: ends.collect() }
    }

    /// `channel`: 0 red, 1 green, 2 blue.
    pub fn of(system: &System<'a>, channel: usize) -> Self {
        let albedo = system.albedo.iter().map(|albedo| f64::from(albedo[channel]));
        Self::new(system.rows, system.patches, albedo)
    }

    /// Rows.
    pub fn len(&self) -> usize {
        self.patches.len()
    }

    pub fn is_empty(&self) -> bool {
        self.patches.is_empty()
    }

    /// Columns and weights of a row, patches only.
    pub fn row(&self, i: usize) -> (&'a [u32], &'a [f32]) {
        let range = self.rows.starts[i] as usize..self.ends[i];
        (&self.rows.columns[range.clone()], &self.rows.weights[range])
    }

    /// Sum_j P_ij.
    pub fn row_sum(&self, i: usize) -> f64 {
        self.row(i).1.iter().map(|&weight| f64::from(weight)).sum()
    }

    pub fn area(&self, i: usize) -> f64 {
        f64::from(self.patches[i].area)
    }

    /// A / rho, which makes the system symmetric; 0 where nothing is reflected.
    pub(super) fn weights(&self) -> Vec<f64> {
        let weight = |i: usize| if self.albedo[i] > 0.0 { self.area(i) / self.albedo[i] } else { 0.0 };
        (0..self.len()).map(weight).collect()
    }

    /// By patch its aggregate, none where next to nothing is reflected (one bounce is all there is of it, and 1 / albedo
    /// beyond what f32 holds); and how many there are.
    pub(super) fn aggregates(&self) -> (Vec<u32>, usize) {
        let of = |i: usize| if self.albedo[i] > NEXT_TO_NOTHING { self.patches[i].aggregate } else { NONE };
        let aggregates: Vec<u32> = (0..self.len()).map(of).collect();
        let count = aggregates.iter().filter(|&&a| a != NONE).map(|&a| a as usize + 1).max();
        (aggregates, count.unwrap_or(0))
    }

    /// Sum_j P_ij x_j.
    pub(super) fn gathered(&self, i: usize, x: &[f64]) -> f64 {
        let (columns, weights) = self.row(i);
        weigh(columns, weights, x)
    }

    /// out_i = f(i, Sum_j P_ij x_j): one product.
    fn product(&self, x: &[f64], out: &mut [f64], f: impl Fn(usize, f64) -> f64 + Sync) {
        let row = |i: usize| f(i, self.gathered(i, x));
        if self.rows.entries() < WORTH_THREADS {
            out.iter_mut().enumerate().for_each(|(i, out)| *out = row(i));
        } else {
            out.par_iter_mut().enumerate().for_each(|(i, out)| *out = row(i));
        }
    }

    /// r = E + R P B - B: one product. Where nothing is reflected it is E - B.
    pub fn residual(&self, e: &[f64], b: &[f64], r: &mut [f64]) {
        self.product(b, r, |i, gathered| e[i] + self.albedo[i] * gathered - b[i]);
    }

    /// out = (I - R P) x: one product.
    pub fn apply(&self, x: &[f64], out: &mut [f64]) {
        self.product(x, out, |i, gathered| x[i] - self.albedo[i] * gathered);
    }

    /// What rounding may add to a residual of values up to 1: sums of four strands, a little for the rest.
    pub(super) fn rounding(&self) -> f64 {
        let longest = (0..self.len()).map(|i| self.row(i).0.len()).max().unwrap_or(0);
        f64::EPSILON * (longest as f64 / 4.0 + 8.0)
    }
}

fn weigh(columns: &[u32], weights: &[f32], x: &[f64]) -> f64 {
    let (columns, last_columns) = columns.as_chunks::<4>();
    let (weights, last_weights) = weights.as_chunks::<4>();
    let mut sums = [0.0; 4];
    for (columns, weights) in columns.iter().zip(weights) {
        for k in 0..4 {
            sums[k] += f64::from(weights[k]) * x[columns[k] as usize];
        }
    }
    let last = last_columns.iter().zip(last_weights);
    let last: f64 = last.map(|(&column, &weight)| f64::from(weight) * x[column as usize]).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + last
}

/// max |values|.
pub(super) fn largest(values: &[f64]) -> f64 {
    // f64::max would pass over what is no number, which here is larger than any.
    let larger = |max: f64, value: &f64| if value.abs() > max || value.is_nan() { value.abs() } else { max };
    values.iter().fold(0.0, larger)
}
