//! One way to run every method: from any start, observed after each step, ended by the bound, by a count of products
//! or by the caller, and then judged by a residual of the stored rows that was really computed.

use super::bracket::{self, Bracket, of_residual};
use super::chebyshev::Chebyshev;
use super::conjugate_gradients::ConjugateGradients;
use super::gauss_seidel::GaussSeidel;
use super::jacobi::Jacobi;
use super::matrix::{Matrix, largest};
use super::southwell::Southwell;
use super::two_level::TwoLevelJacobi;
use super::{Method, System};
use crate::transport::{Patch, Rows};

/// What is solved, one channel, with what turns a residual into a bound of the error.
pub struct Channel<'a> {
    pub matrix: Matrix<'a>,
    /// w, by patch: (I - R P) w >= 1.
    pub gain: Vec<f64>,
    pub largest_gain: f64,
    pub(super) rounding: f64,
}

impl<'a> Channel<'a> {
    /// Solves for the gain, once for an albedo.
    pub fn new(rows: &'a Rows, patches: &'a [Patch], albedo: impl IntoIterator<Item = f64>) -> Self {
        Self::of_matrix(Matrix::new(rows, patches, albedo))
    }

    /// `channel`: 0 red, 1 green, 2 blue.
    pub fn of(system: &System<'a>, channel: usize) -> Self {
        Self::of_matrix(Matrix::of(system, channel))
    }

    fn of_matrix(matrix: Matrix<'a>) -> Self {
        let gain = bracket::gain(&matrix);
        let (largest_gain, rounding) = (largest(&gain), matrix.rounding());
        Self { matrix, gain, largest_gain, rounding }
    }
}

/// When to stop.
#[derive(Clone, Copy)]
pub struct Stop<'a> {
    /// Of the bound of the error, as a share of the largest |B|.
    pub tolerance: f64,
    /// At most so many products, but one in any case: without it nothing would be known of the start.
    pub products: f64,
    /// Asked after every product.
    pub cancelled: &'a (dyn Fn() -> bool + Sync),
}

impl Stop<'static> {
    /// By the bound, or after so many products.
    pub fn at(tolerance: f64, products: f64) -> Self {
        Self { tolerance, products, cancelled: &|| false }
    }
}

/// A look at the work. The first is of the start, when all that is prepared once is prepared.
pub struct Iterate<'a> {
    /// Spent on it.
    pub products: f64,
    pub b: &'a [f64],
}

/// Finite; nowhere below E where E >= 0.
#[derive(Clone, Debug)]
pub struct Solved {
    pub b: Vec<f64>,
    /// With P: each reads all its entries once. Southwell's shots count 1/n each.
    pub products: f64,
    /// Of `b`, from its own residual.
    pub bracket: Bracket,
    /// Whether the bound is as small as was asked for.
    pub reached: bool,
}

/// Solves for one channel from `start`, or from B = E. What is not finite in E counts as 0, in the start as E.
pub fn solve(
    method: Method,
    channel: &Channel,
    e: &[f64],
    start: Option<&[f64]>,
    stop: &Stop,
    observe: &mut dyn FnMut(&Iterate),
) -> Solved {
    let e: Vec<f64> = e.iter().map(|&e| if e.abs() <= LARGEST { e } else { 0.0 }).collect();
    let near = |r: &[f64], b: &[f64]| {
        let (b, r) = (largest(b), largest(r));
        bracket::relative(channel.largest_gain * (r + channel.rounding * b), b) <= stop.tolerance
    };
    let run = Run { near: &near, products: stop.products, cancelled: stop.cancelled };
    let mut iteration = prepare(method, &channel.matrix, 1.0 - 1.0 / channel.largest_gain, &e);
    let Ended { b, r, products } = run.from(iteration.as_mut(), &channel.matrix, &e, start, observe);
    let bracket = of_residual(channel, &e, &b, &r);
    // The solution is nowhere below: what is lifted to it has come nearer.
    let b = if e.iter().all(|&e| e >= 0.0) { b.iter().zip(&e).map(|(b, e)| b.max(*e)).collect() } else { b };
    let reached = bracket.bound <= stop.tolerance;
    Solved { b, products, bracket, reached }
}

/// Whose squares are finite, with room for gains.
const LARGEST: f64 = 1e120;

/// How an iteration left its residual.
pub(super) enum Left {
    /// Not known: the next product is spent on it.
    Unknown,
    /// `r` is as near to it as recursion gets, or above it.
    Estimated,
    /// Nothing more can be done.
    Stuck,
}

/// A method at work.
pub(super) trait Iteration {
    /// Moves B on. `r`: its residual, measured or as left last time.
    fn advance(&mut self, b: &mut [f64], r: &mut [f64]) -> Left;

    /// Products that this costs, besides the one that measures.
    fn costs(&self) -> f64 {
        0.0
    }

    /// `r` has just been measured: what recursion carried along no longer fits it.
    fn restart(&mut self) {}
}

/// `radius`: |eigenvalues of R P| are at most this.
pub(super) fn prepare<'a>(
    method: Method,
    matrix: &'a Matrix<'a>,
    radius: f64,
    e: &'a [f64],
) -> Box<dyn Iteration + 'a> {
    match method {
        Method::Jacobi => Box::new(Jacobi),
        Method::GaussSeidel => Box::new(GaussSeidel::new(matrix, e)),
        Method::Southwell => Box::new(Southwell::new(matrix)),
        Method::Chebyshev => Box::new(Chebyshev::new(matrix.len(), radius)),
        Method::ConjugateGradients => Box::new(ConjugateGradients::new(matrix)),
        Method::DeflatedConjugateGradients => Box::new(ConjugateGradients::deflated(matrix)),
        Method::TwoLevel => Box::new(TwoLevelJacobi::new(matrix, e)),
    }
}

/// What ends an iteration.
pub(super) struct Run<'a> {
    /// Is B, with this residual, near enough?
    pub near: &'a dyn Fn(&[f64], &[f64]) -> bool,
    pub products: f64,
    pub cancelled: &'a (dyn Fn() -> bool + Sync),
}

/// B with its measured residual.
pub(super) struct Ended {
    pub b: Vec<f64>,
    pub r: Vec<f64>,
    pub products: f64,
}

impl Run<'_> {
    pub fn from(
        &self,
        iteration: &mut dyn Iteration,
        matrix: &Matrix,
        e: &[f64],
        start: Option<&[f64]>,
        observe: &mut dyn FnMut(&Iterate),
    ) -> Ended {
        let mut b = begin(matrix, e, start);
        let (mut r, mut products) = (vec![0.0; b.len()], 0.0);
        let (mut steps, mut before) = (Steps::One, f64::INFINITY);
        observe(&Iterate { products, b: &b });
        loop {
            matrix.residual(e, &b, &mut r);
            products += 1.0;
            let size = largest(&r);
            if !size.is_finite() {
                // Rows that are shares do not lead here; others get light that is at least finite.
                b = begin(matrix, e, None);
                matrix.residual(e, &b, &mut r);
                return Ended { b, r, products: products + 1.0 };
            }
            // Recursion that brings nothing any more has met the rounding of the rows.
            let settled = matches!(steps, Steps::Many) && size >= 0.5 * before;
            let last = settled || matches!(steps, Steps::Last);
            if last || (self.near)(&r, &b) || self.must_stop(products + iteration.costs()) {
                return Ended { b, r, products };
            }
            before = size;
            steps = self.steps(iteration, &mut b, &mut r, &mut products, observe);
        }
    }

    /// Goes on until the residual has to be measured.
    fn steps(
        &self,
        iteration: &mut dyn Iteration,
        b: &mut [f64],
        r: &mut [f64],
        products: &mut f64,
        observe: &mut dyn FnMut(&Iterate),
    ) -> Steps {
        let far = TRUSTED * largest(r);
        iteration.restart();
        loop {
            let left = iteration.advance(b, r);
            *products += iteration.costs();
            observe(&Iterate { products: *products, b });
            match left {
                Left::Unknown => return Steps::One,
                Left::Stuck => return Steps::Last,
                Left::Estimated => {}
            }
            let size = largest(r);
            let measure = !(size > far && size.is_finite()) || self.must_stop(*products + iteration.costs());
            if measure || (self.near)(r, b) {
                return Steps::Many;
            }
        }
    }

    /// Once so many are spent, is there none left to measure with?
    fn must_stop(&self, products: f64) -> bool {
        products + 1.0 > self.products || (self.cancelled)()
    }
}

/// How far recursion of a residual is trusted: rows are stored as f32, and symmetric to 1e-7.
const TRUSTED: f64 = 1e-6;

/// What was done between two measured residuals.
enum Steps {
    One,
    Many,
    Last,
}

/// From E, or from what is given as far as it can be the solution.
fn begin(matrix: &Matrix, e: &[f64], start: Option<&[f64]>) -> Vec<f64> {
    let lit = e.iter().all(|&e| e >= 0.0);
    let from = |i: usize| match start.and_then(|start| start.get(i)) {
        Some(&b) if b.abs() <= f64::MAX && matrix.albedo[i] > 0.0 => {
            if lit {
                b.max(e[i])
            } else {
                b
            }
        }
        _ => e[i],
    };
    (0..e.len()).map(from).collect()
}
