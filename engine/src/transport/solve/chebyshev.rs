//! Chebyshev's semi-iteration: Jacobi's steps added up so that the largest of all possible errors is least. One step of
//! Jacobi's comes before.
//!
//! ```text
//! B <- B + r,   then   d <- omega r + (omega - 1) d,   B <- B + d
//! omega_1 = 1,   omega_2 = 1 / (1 - q^2 / 2),   omega_k+1 = 1 / (1 - q^2 omega_k / 4)
//! error after 1 + k steps, by eigenvalue l of R P:   l T_k(l / q) / T_k(1 / q)
//! ```
//! q: |eigenvalues of R P| are at most that. They are real, and as R P w = w - 1 with w > 0, q = 1 - 1 / max w will do
//! (Collatz, Wielandt), which is far below the largest albedo where few patches are bright. A product a step, no
//! products of vectors, about sqrt(2/w) of Jacobi's steps. Source: Golub, Varga (1961).
//!
//! The first step is for eigenvalues near 0, of which a room has most: light that is new on a surface and has not been
//! spread out. Jacobi's iteration ends them in a step; T_k alone makes them no smaller than any other, so that in a room
//! two steps of it left more than one (measured by the report: a sun that moves over the Cornell box, 0.73 % after 0.43).

use super::iterate::{Iteration, Left};

pub(super) struct Chebyshev {
    radius: f64,
    next: Step,
    change: Vec<f64>,
}

#[derive(Clone, Copy)]
enum Step {
    Jacobi,
    First,
    After { omega: f64 },
}

impl Chebyshev {
    pub fn new(n: usize, radius: f64) -> Self {
        Self { radius, next: Step::Jacobi, change: vec![0.0; n] }
    }

    /// How much of Jacobi's step is made, and of the step before once more.
    fn weights(&mut self) -> (f64, f64) {
        let q2 = self.radius * self.radius;
        let (weights, next) = match self.next {
            Step::Jacobi => ((1.0, 0.0), Step::First),
            Step::First => ((1.0, 0.0), Step::After { omega: 1.0 / (1.0 - 0.5 * q2) }),
            Step::After { omega } => {
                ((omega, omega - 1.0), Step::After { omega: 1.0 / (1.0 - 0.25 * q2 * omega) })
            }
        };
        self.next = next;
        weights
    }
}

impl Iteration for Chebyshev {
    fn advance(&mut self, b: &mut [f64], r: &mut [f64]) -> Left {
        let (omega, again) = self.weights();
        for ((b, change), r) in b.iter_mut().zip(&mut self.change).zip(&*r) {
            *change = omega * r + again * *change;
            *b += *change;
        }
        Left::Unknown
    }
}
