//! Chebyshev's semi-iteration: Jacobi's steps added up so that the largest of all possible errors is least.
//!
//! ```text
//! d <- omega r + (omega - 1) d,   B <- B + d
//! omega_1 = 1,   omega_2 = 1 / (1 - q^2 / 2),   omega_k+1 = 1 / (1 - q^2 omega_k / 4)
//! ```
//! q: |eigenvalues of R P| are at most that. They are real, and as R P w = w - 1 with w > 0, q = 1 - 1 / max w will do
//! (Collatz, Wielandt), which is far below the largest albedo where few patches are bright. A product a step, no
//! products of vectors, about sqrt(2/w) of Jacobi's steps. Source: Golub, Varga (1961).

use super::iterate::{Iteration, Left};

pub(super) struct Chebyshev {
    radius: f64,
    omega: Option<f64>,
    change: Vec<f64>,
}

impl Chebyshev {
    pub fn new(n: usize, radius: f64) -> Self {
        Self { radius, omega: None, change: vec![0.0; n] }
    }
}

impl Iteration for Chebyshev {
    fn advance(&mut self, b: &mut [f64], r: &mut [f64]) -> Left {
        let q2 = self.radius * self.radius;
        let omega = match self.omega {
            None => 1.0,
            Some(1.0) => 1.0 / (1.0 - 0.5 * q2),
            Some(omega) => 1.0 / (1.0 - 0.25 * q2 * omega),
        };
        self.omega = Some(omega);
        for ((b, change), r) in b.iter_mut().zip(&mut self.change).zip(&*r) {
            *change = omega * r + (omega - 1.0) * *change;
            *b += *change;
        }
        Left::Unknown
    }
}
