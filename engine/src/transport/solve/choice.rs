//! Which method a scene is given: read off the measured diagram of error against products (`tests/tests/solvers.rs`
//! measures it again).
//!
//! A frame may choose between Jacobi and two-level Jacobi, which need no sums over all patches. What one product
//! leaves of the error is known for Jacobi, 1 - 1/w, and was measured for two-level as about 1/3 where products are
//! worth the most, over the first three digits, from w = 2 to w = 10^4. A product reads all entries of the rows; the
//! coarse correction adds its own m x n, and two dispatches. The cheaper way to the tolerance is taken:
//!
//! ```text
//! Jacobi     ln(10^3) / -ln(1 - 1/w)  x  (entries + dispatches)
//! two-level  ln(10^3) / ln 3          x  (entries + 1.. m n + dispatches)
//! ```
//! The truth is solved for by conjugate gradients: the fewest products by far, and its sums cost nothing on a CPU.

use super::Method;
use crate::transport::Patch;

/// What a choice depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Case {
    /// w, the largest.
    pub gain: f64,
    pub patches: usize,
    /// Of the patches' rows.
    pub entries: usize,
    pub aggregates: usize,
    /// Entries that a frame may read for the bounce.
    pub budget: f64,
}

/// How frames iterate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    pub method: Method,
    /// What one product leaves of the error, about.
    pub leaves: f64,
    /// Products that a frame may make at most.
    pub most: u32,
    /// In a few words.
    pub why: &'static str,
}

/// What one product of two-level Jacobi leaves, as long as it matters to the eye.
pub const TWO_LEVEL_LEAVES: f64 = 1.0 / 3.0;
/// Entries that could be read in the time of a dispatch that waits for the one before.
const DISPATCH: f64 = 2e4;
/// The most aggregates that one workgroup solves for.
const MOST_AGGREGATES: usize = 64;
/// Products of a frame: at most, and what light that moves needs in any case.
const MOST: f64 = 8.0;
const LEAST: f64 = 2.0;

/// For frames.
pub fn choose(case: &Case) -> Choice {
    let entries = case.entries as f64;
    let coarse = case.aggregates as f64 * case.patches as f64;
    // product, correct; restrict and solve besides
    let (jacobi, two_level) = (entries + 2.0 * DISPATCH, entries + coarse + 4.0 * DISPATCH);
    let left = (1.0 - 1.0 / case.gain.max(1.0)).max(f64::EPSILON);
    let steps = |leaves: f64| 1.0 / -leaves.ln();
    let can = (1..=MOST_AGGREGATES).contains(&case.aggregates);
    let (method, leaves, cost, why) = if !can {
        (Method::Jacobi, left, jacobi, "it has no aggregates to correct")
    } else if steps(left) * jacobi <= steps(TWO_LEVEL_LEAVES) * two_level {
        (Method::Jacobi, left, jacobi, "few bounces count")
    } else {
        (Method::TwoLevel, TWO_LEVEL_LEAVES, two_level, "light wanders from room to room for long")
    };
    let most = (case.budget / cost).floor().clamp(LEAST, MOST) as u32;
    Choice { method, leaves, most, why }
}

impl Method {
    /// For the truth on the CPU: deflated where an aggregate has more than one patch.
    pub fn for_truth(patches: &[Patch]) -> Self {
        let mut members = vec![0_u32; patches.len()];
        for patch in patches {
            members.get_mut(patch.aggregate as usize).into_iter().for_each(|count| *count += 1);
        }
        let again = members.iter().any(|&count| count > 1);
        if again { Self::DeflatedConjugateGradients } else { Self::ConjugateGradients }
    }
}
