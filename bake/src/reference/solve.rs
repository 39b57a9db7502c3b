//! (I - R P) B = E for a dense P, to rounding.
//!
//! ```text
//! (A_i / rho_i) B_i - Sum_j S_ij B_j = (A_i / rho_i) E_i          S = A P symmetric
//! ```
//! by conjugate gradients, over the patches that reflect; those that do not have B = E, and stand on the right.
//! Corrected by the residual of the equation itself until that is rounding.

use rayon::prelude::*;

use super::closing::{dot, gradients, row_of};

/// Of the largest E.
const RESIDUAL: f64 = 1e-13;

/// One channel: P is n x columns of which the first n are patches, `areas` and `rho` are by patch.
pub fn solve(matrix: &[f64], columns: usize, areas: &[f64], rho: &[f64], e: &[f64]) -> Vec<f64> {
    let n = areas.len();
    let product = |b: &[f64]| -> Vec<f64> {
        (0..n).into_par_iter().map(|i| dot(&row_of(matrix, columns, i)[..n], b)).collect()
    };
    let weight: Vec<f64> = (0..n).map(|i| if rho[i] > 0.0 { areas[i] / rho[i] } else { 0.0 }).collect();
    let apply = |b: &[f64]| -> Vec<f64> {
        let gathered = product(b);
        let row = |i: usize| if rho[i] > 0.0 { weight[i] * b[i] - areas[i] * gathered[i] } else { 0.0 };
        (0..n).map(row).collect()
    };
    let largest = e.iter().fold(0.0_f64, |max, e| max.max(e.abs()));
    let mut b = e.to_vec();
    let mut last = f64::INFINITY;
    for _ in 0..20 {
        let gathered = product(&b);
        let residual: Vec<f64> = (0..n).map(|i| e[i] + rho[i] * gathered[i] - b[i]).collect();
        let size = residual.iter().fold(0.0_f64, |max, r| max.max(r.abs()));
        if size <= RESIDUAL * largest || size >= 0.5 * last {
            break;
        }
        last = size;
        let rhs: Vec<f64> = residual.iter().zip(&weight).map(|(r, w)| r * w).collect();
        let correction = gradients(apply, &rhs, &weight, 1e-8);
        b.iter_mut().zip(correction).for_each(|(b, c)| *b += c);
    }
    b
}
