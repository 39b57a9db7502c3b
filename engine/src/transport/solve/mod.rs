//! The linear system B = E + rho P B: three channels of light, each a system of its own.
//!
//! ```text
//! (I - R P) B = E        R = diag(rho), rho in [0, 1]; P >= 0, row sums <= 1, A_i P_ij = A_j P_ji
//! ```
//! * A / rho (I - R P) is symmetric and positive definite, so R P has real eigenvalues in [-q, q] with
//!   q <= max rho_i Sum_j P_ij, and conjugate gradients apply. Rows without albedo are solved already: B_i = E_i.
//! * I - R P is an M-matrix: its inverse is >= 0 entry by entry. So B >= E wherever E >= 0, and with the *cavity
//!   gain* w, (I - R P) w = 1, every iterate says how far it is from the solution: [`bracket`].
//!
//! Every [`Method`] has a file of its own with its equation and what it costs; all of them start from any B, go on
//! until the bound is small enough or they must stop, and say what they know then: [`solve`]. Costs are counted in
//! products with P, of which each reads every stored entry once. Iterations that are known, with their share of the
//! error that one product leaves (w: the largest cavity gain):
//!
//! ```text
//! Jacobi                         1 - 1/w
//! Gauss-Seidel                   about (1 - 1/w)^2
//! Southwell                      the first bounces for a fraction of a product, then as Gauss-Seidel
//! Chebyshev                      about 1 - sqrt(2/w)
//! conjugate gradients            about 1 - 2 / sqrt(w), better where few eigenvalues are near 1
//! deflated conjugate gradients   without what is constant over aggregates: 0.15 .. 0.4 whatever w is
//! two-level Jacobi               the same for Jacobi: 0.3 .. 0.7 whatever w is
//! ```
//! Source of the analysis: Varga, Matrix Iterative Analysis (1962); of radiosity as such a system: Goral, Torrance,
//! Greenberg, Battaile (1984); Cohen, Wallace, Radiosity and Realistic Image Synthesis (1993).

mod bracket;
mod chebyshev;
mod choice;
mod coarse;
mod conjugate_gradients;
mod deflated;
mod exact;
mod gain;
mod gauss_seidel;
mod inverse;
mod iterate;
mod jacobi;
mod matrix;
mod southwell;
mod two_level;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::{Patch, Rows};

pub use bracket::{Bracket, bracket};
pub use choice::{Case, Choice, choose, choose_for_frames};
pub use coarse::Coarse;
pub use exact::exact;
pub use gain::{GAIN_LIMIT, cavity_gain, limit_gain};
pub use iterate::{Channel, Iterate, Solved, Stop, solve};
pub use matrix::Matrix;
pub use two_level::TwoLevel;

/// What is solved: P's first `patches.len()` columns are patches; what lies behind them (the sky) is in E.
pub struct System<'a> {
    pub rows: &'a Rows,
    pub patches: &'a [Patch],
    /// By patch.
    pub albedo: &'a [Vec3],
}

/// How the system is solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Method {
    Jacobi,
    GaussSeidel,
    Southwell,
    Chebyshev,
    ConjugateGradients,
    DeflatedConjugateGradients,
    TwoLevel,
}

impl Method {
    pub fn all() -> [Self; 7] {
        use Method::*;
        [Jacobi, GaussSeidel, Southwell, Chebyshev, ConjugateGradients, DeflatedConjugateGradients, TwoLevel]
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::Jacobi => "Jacobi",
            Self::GaussSeidel => "Gauss-Seidel",
            Self::Southwell => "Southwell",
            Self::Chebyshev => "Chebyshev",
            Self::ConjugateGradients => "conjugate gradients",
            Self::DeflatedConjugateGradients => "deflated conjugate gradients",
            Self::TwoLevel => "two-level Jacobi",
        }
    }
}

/// Row sums times values of all columns: irradiance from radiosity.
pub fn gather(rows: &Rows, values: &[DVec3]) -> Vec<DVec3> {
    (0..rows.len())
        .into_par_iter()
        .map(|i| rows.row(i).map(|(column, weight)| values[column as usize] * f64::from(weight)).sum())
        .collect()
}
