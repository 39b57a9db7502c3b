//! Gauss-Seidel's iteration: Jacobi's that uses what it has just found.
//!
//! ```text
//! B_i <- (E_i + rho_i Sum_{j != i} P_ij B_j) / (1 - rho_i P_ii),   i = 1 .. n in place
//! ```
//! A sweep costs a product, but is serial. Its factor is about the square of Jacobi's, (1 - 1/w)^2: half the sweeps.
//! With d the changes of a sweep, its residual is r_i = rho_i Sum_{j > i} P_ij d_j, nowhere more than max |d|, and so
//! d stands in for it. Source: Seidel (1874); Varga (1962) for the comparison with Jacobi on M-matrices.

use super::iterate::{Iteration, Left};
use super::matrix::Matrix;

pub(super) struct GaussSeidel<'a> {
    matrix: &'a Matrix<'a>,
    e: &'a [f64],
    /// rho_i P_ii.
    own: Vec<f64>,
}

impl<'a> GaussSeidel<'a> {
    pub fn new(matrix: &'a Matrix<'a>, e: &'a [f64]) -> Self {
        let own = |i: usize| {
            let (columns, weights) = matrix.row(i);
            let at = columns.binary_search(&(i as u32));
            at.map_or(0.0, |at| matrix.albedo[i] * f64::from(weights[at]))
        };
        Self { matrix, e, own: (0..matrix.len()).map(own).collect() }
    }
}

impl Iteration for GaussSeidel<'_> {
    fn advance(&mut self, b: &mut [f64], r: &mut [f64]) -> Left {
        for i in 0..b.len() {
            let gathered = self.matrix.gathered(i, b);
            let change = self.e[i] + self.matrix.albedo[i] * gathered - b[i];
            r[i] = change / (1.0 - self.own[i]).max(f64::EPSILON);
            b[i] += r[i];
        }
        Left::Estimated
    }

    fn costs(&self) -> f64 {
        1.0
    }
}
