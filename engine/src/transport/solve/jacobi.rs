//! Jacobi's iteration: every patch gathers what all others gave a step ago; the k-th iterate from E holds k bounces.
//!
//! ```text
//! B <- E + R P B = B + r
//! ```
//! A product a step. The error falls by 1 - 1/w a step (in the norm max |e_i| / w_i: R P w = w - 1), and never changes
//! sign where it had one: from E the iterates rise, from above they sink. The residual is the next change, for nothing.
//! Source: Jacobi (1845); as gathering in radiosity, Goral et al. (1984).

use super::iterate::{Iteration, Left};

pub(super) struct Jacobi;

impl Iteration for Jacobi {
    fn advance(&mut self, b: &mut [f64], r: &mut [f64]) -> Left {
        b.iter_mut().zip(&*r).for_each(|(b, r)| *b += r);
        Left::Unknown
    }
}
