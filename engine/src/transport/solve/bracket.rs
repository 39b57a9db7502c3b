//! How far an iterate is from the solution, without knowing the solution.
//!
//! ```text
//! r = E - (I - R P) B,  B* - B = (I - R P)^-1 r,  (I - R P)^-1 >= 0,  (I - R P)^-1 1 = w
//! B_i - w_i max(-r, 0)  <=  B*_i  <=  B_i + w_i max(r, 0)         |error_i| <= w_i max |r|
//! ```
//! Any w > 0 with (I - R P) w >= 1 will do in place of the cavity gain, and that there is one is what makes I - R P an
//! M-matrix (Berman, Plemmons 1979). So w is solved for and then divided by the least (I - R P) w that it really has:
//! the bound is true whatever the solver left. Rounding of the residual itself is added.

use super::exact::approach;
use super::matrix::{Matrix, largest};
use super::{Channel, Method};

/// The solution is nowhere below `below` and nowhere above `above`.
#[derive(Clone, Debug, PartialEq)]
pub struct Bracket {
    pub below: Vec<f64>,
    pub above: Vec<f64>,
    /// |error_i| <= `bound` times the largest |B|; infinite where nothing is known.
    pub bound: f64,
}

/// Of any B, at the cost of one product. B >= E is used where E >= 0.
pub fn bracket(channel: &Channel, e: &[f64], b: &[f64]) -> Bracket {
    let mut r = vec![0.0; b.len()];
    channel.matrix.residual(e, b, &mut r);
    of_residual(channel, e, b, &r)
}

pub(super) fn of_residual(channel: &Channel, e: &[f64], b: &[f64], r: &[f64]) -> Bracket {
    let rounding = channel.rounding * largest(b).max(largest(e));
    let lacking = r.iter().fold(0.0_f64, |max, &r| max.max(r)) + rounding;
    let excess = r.iter().fold(0.0_f64, |max, &r| max.max(-r)) + rounding;
    let lit = e.iter().all(|&e| e >= 0.0);
    let floor = |i: usize| if lit { e[i] } else { f64::MIN };
    let (w, n) = (&channel.gain, b.len());
    Bracket {
        below: (0..n).map(|i| (b[i] - w[i] * excess).max(floor(i))).collect(),
        above: (0..n).map(|i| (b[i] + w[i] * lacking).min(f64::MAX)).collect(),
        bound: relative(channel.largest_gain * lacking.max(excess), largest(b)),
    }
}

/// An error as a share of what it is an error of; 0 where there is no light.
pub(super) fn relative(error: f64, largest: f64) -> f64 {
    if error == 0.0 { 0.0 } else { error / largest }
}

/// w with (I - R P) w >= 1, by patch; the largest number where none was found.
pub(super) fn gain(matrix: &Matrix) -> Vec<f64> {
    let n = matrix.len();
    let ones = vec![1.0; n];
    let method = Method::for_truth(matrix.patches);
    let w = approach(matrix, method, &ones, 1e-7);
    let mut one = vec![0.0; n];
    matrix.apply(&w, &mut one);
    let least = one.iter().fold(f64::INFINITY, |min, &one| min.min(one)) - matrix.rounding() * largest(&w);
    if least > 0.5 && w.iter().all(|&w| w > 0.0 && w.is_finite()) {
        return w.into_iter().map(|w| w / least).collect();
    }
    vec![stand_in(matrix); n]
}

/// max w <= 1 / (1 - max rho_i Sum_j P_ij).
fn stand_in(matrix: &Matrix) -> f64 {
    let most = (0..matrix.len()).map(|i| matrix.albedo[i] * matrix.row_sum(i)).fold(0.0, f64::max);
    if most < 1.0 { 1.0 / (1.0 - most) } else { f64::MAX }
}
