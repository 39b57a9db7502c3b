//! Deflation: what is constant over aggregates is solved for directly, and conjugate gradients work on the rest.
//!
//! ```text
//! W: column a is rho on aggregate a, 0 elsewhere      Q = (I - R P) W      G = W^T D Q      D = A / R
//! at a start:  c = G^-1 W^T D r,  B <- B + W c,  r <- r - Q c             so that W^T D r = 0, and stays 0
//! each step:   z = r + W G^-1 (W - Q)^T D r,  p <- z + beta p             p is conjugate to all of W
//! ```
//! W^T D r is 0 but for rounding, which G^-1 multiplies by the gain: without that term what rounding brings into W
//! grows from step to step (at a gain of 1e4 until nothing is left of the solution), with it each step takes it out.
//!
//! Irradiance, not radiosity, is what is about even in a room: the error of B is R P times what it was before, so its
//! shape is albedo times something smooth, and a black wall has none.
//!
//! The slow part of the error (eigenvalues near 1: light that wanders from room to room) lies in W; the rest falls by
//! 0.15 .. 0.4 a product however large w is. Q is made in one pass over the rows and counts as no product; a step adds
//! n m to its product's n K. Source: Nicolaides (1987); in this form Saad, Yeung, Erhel, Guyomarc'h (2000);
//! the term that keeps it stable: Tang, Nabben, Vuik, Erlangga (2009), A-DEF2.

use rayon::prelude::*;

use super::inverse::{dot, inverse, times};
use super::matrix::Matrix;
use crate::transport::NONE;

pub(super) struct Deflation {
    /// By patch: its column of W, and the value there.
    aggregates: Vec<u32>,
    albedo: Vec<f64>,
    /// D W at the patch: its area, or 0.
    restricts: Vec<f64>,
    /// Q and D, by patch: m numbers each.
    q: Vec<f64>,
    weights: Vec<f64>,
    /// G^-1.
    inverse: Vec<f64>,
    sums: Vec<f64>,
    /// W^T D r.
    held: Vec<f64>,
    c: Vec<f64>,
}

impl Deflation {
    pub fn new(matrix: &Matrix) -> Self {
        let (aggregates, m) = matrix.aggregates();
        let weights = matrix.weights();
        let restricts: Vec<f64> =
            (0..matrix.len()).map(|i| if aggregates[i] == NONE { 0.0 } else { matrix.area(i) }).collect();
        let q = images(matrix, &aggregates, m);
        let mut galerkin = vec![0.0; m * m];
        for (i, q) in q.chunks_exact(m.max(1)).enumerate().filter(|&(i, _)| aggregates[i] != NONE) {
            let row = &mut galerkin[aggregates[i] as usize * m..][..m];
            row.iter_mut().zip(q).for_each(|(sum, q)| *sum += restricts[i] * q);
        }
        Self {
            albedo: matrix.albedo.clone(),
            inverse: inverse(galerkin, m),
            sums: vec![0.0; m],
            held: vec![0.0; m],
            c: vec![0.0; m],
            aggregates,
            restricts,
            q,
            weights,
        }
    }

    /// Solves for what r holds of W.
    pub fn correct(&mut self, b: &mut [f64], r: &mut [f64]) {
        self.sums.fill(0.0);
        for (i, &a) in self.aggregates.iter().enumerate().filter(|(_, a)| **a != NONE) {
            self.sums[a as usize] += self.restricts[i] * r[i];
        }
        times(&self.inverse, &self.sums, &mut self.c);
        self.add(b);
        for (r, q) in r.iter_mut().zip(self.q.chunks_exact(self.c.len().max(1))) {
            *r -= dot(q, &self.c);
        }
    }

    /// c of z = r + W c; returns <r, W c>.
    pub fn complement(&mut self, r: &[f64]) -> f64 {
        let m = self.c.len();
        self.sums.fill(0.0);
        self.held.fill(0.0);
        for (i, &r) in r.iter().enumerate() {
            let weighted = r * self.weights[i];
            self.sums.iter_mut().zip(&self.q[i * m..][..m]).for_each(|(sum, q)| *sum -= weighted * q);
            if self.aggregates[i] != NONE {
                self.held[self.aggregates[i] as usize] += self.restricts[i] * r;
            }
        }
        self.sums.iter_mut().zip(&self.held).for_each(|(sum, held)| *sum += held);
        times(&self.inverse, &self.sums, &mut self.c);
        dot(&self.c, &self.held)
    }

    /// x + W c.
    pub fn add(&self, x: &mut [f64]) {
        for (i, &a) in self.aggregates.iter().enumerate().filter(|(_, a)| **a != NONE) {
            x[i] += self.albedo[i] * self.c[a as usize];
        }
    }
}

/// (I - R P) W, n x m, row-major: one pass over the rows.
fn images(matrix: &Matrix, aggregates: &[u32], m: usize) -> Vec<f64> {
    let mut q = vec![0.0; matrix.len() * m];
    q.par_chunks_mut(m.max(1)).enumerate().for_each(|(i, q)| {
        let (columns, weights) = matrix.row(i);
        for (&j, &weight) in columns.iter().zip(weights) {
            let j = j as usize;
            if aggregates[j] != NONE {
                q[aggregates[j] as usize] -= f64::from(weight) * matrix.albedo[j];
            }
        }
        q.iter_mut().for_each(|q| *q *= matrix.albedo[i]);
        if aggregates[i] != NONE {
            q[aggregates[i] as usize] += matrix.albedo[i];
        }
    });
    q
}
