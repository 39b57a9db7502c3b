//! Conjugate gradients on the symmetrised system, preconditioned by its diagonal.
//!
//! ```text
//! D (I - R P) B = D E,  D = A / R:  symmetric, as A_i P_ij = A_j P_ji, and positive definite
//! the residual of that, preconditioned by D^-1, is r = E + R P B - B itself:
//! beta = <r, r> / <r, r>_before,   p <- r + beta p,   alpha = <r, r> / <p, (I - R P) p>,   <x, y> = Sum D_i x_i y_i
//! B <- B + alpha p,   r <- r - alpha (I - R P) p
//! ```
//! The same as plain conjugate gradients on I - R^1/2 S R^1/2 with S = A^1/2 P A^-1/2, without roots. Where rho is 0
//! D is not there: B_i = E_i from the start, r_i = p_i = 0 ever after, and no term of it counts.
//!
//! A product and two sums over patches a step, after one product for the first residual. The error falls by
//! (sqrt(k) - 1) / (sqrt(k) + 1), k <= 2 w, and faster where few eigenvalues are near 1. Rows that are only about
//! symmetric bend the recursion of r: it is measured again now and then.
//! Source: Hestenes, Stiefel (1952); for radiosity, Neumann (1994), Baranoski (1997).

use super::deflated::Deflation;
use super::iterate::{Iteration, Left};
use super::matrix::Matrix;

pub(super) struct ConjugateGradients<'a> {
    matrix: &'a Matrix<'a>,
    /// D.
    weights: Vec<f64>,
    /// p and (I - R P) p.
    direction: Vec<f64>,
    image: Vec<f64>,
    /// <r, r> of the step before.
    before: Option<f64>,
    deflation: Option<Deflation>,
}

impl<'a> ConjugateGradients<'a> {
    pub fn new(matrix: &'a Matrix<'a>) -> Self {
        let n = matrix.len();
        let (direction, image) = (vec![0.0; n], vec![0.0; n]);
        Self { matrix, weights: matrix.weights(), direction, image, before: None, deflation: None }
    }

    pub fn deflated(matrix: &'a Matrix<'a>) -> Self {
        Self { deflation: Some(Deflation::new(matrix)), ..Self::new(matrix) }
    }

    fn inner(&self, x: &[f64], y: &[f64]) -> f64 {
        self.weights.iter().zip(x).zip(y).map(|((d, x), y)| d * x * y).sum()
    }
}

impl Iteration for ConjugateGradients<'_> {
    fn restart(&mut self) {
        self.before = None;
    }

    fn advance(&mut self, b: &mut [f64], r: &mut [f64]) -> Left {
        if let (None, Some(deflation)) = (self.before, &mut self.deflation) {
            deflation.correct(b, r);
        }
        let mut now = self.inner(r, r);
        if let Some(deflation) = &mut self.deflation {
            now += deflation.complement(r);
        }
        let beta = self.before.map_or(0.0, |before| now / before);
        self.direction.iter_mut().zip(&*r).for_each(|(p, r)| *p = r + beta * *p);
        if let Some(deflation) = &self.deflation {
            deflation.add(&mut self.direction);
        }
        self.matrix.apply(&self.direction, &mut self.image);
        let curvature = self.inner(&self.direction, &self.image);
        let alpha = now / curvature;
        if !(curvature > 0.0 && alpha > 0.0 && alpha.is_finite()) {
            return Left::Stuck;
        }
        for i in 0..b.len() {
            b[i] += alpha * self.direction[i];
            r[i] -= alpha * self.image[i];
        }
        self.before = Some(now);
        Left::Estimated
    }

    fn costs(&self) -> f64 {
        1.0
    }
}
