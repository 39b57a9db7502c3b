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
use crate::transport::{NONE, Patch, Rows};

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

/// Entries of patch rows that a frame may read: 2 GB, what a desktop's GPU reads in a third of a frame.
const BUDGET: f64 = 2.5e8;
/// What one product of two-level Jacobi leaves, as long as it matters to the eye.
pub const TWO_LEVEL_LEAVES: f64 = 1.0 / 3.0;
/// Entries that could be read while a dispatch waits for the one before it: a few microseconds.
const DISPATCH: f64 = 1e5;
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
    let left = (1.0 - 1.0 / case.gain.max(1.0)).clamp(f64::EPSILON, 1.0 - f64::EPSILON);
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

/// For the frames of a bake with this cavity gain.
pub fn choose_for_frames(rows: &Rows, patches: &[Patch], gain: f64) -> Choice {
    let aggregates = patches.iter().map(|patch| patch.aggregate).filter(|&a| a != NONE);
    choose(&Case {
        gain,
        patches: patches.len(),
        entries: rows.entries(),
        aggregates: aggregates.max().map_or(0, |last| last as usize + 1),
        budget: BUDGET,
    })
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A room of 2000 patches.
    const ROOM: Case = Case { gain: 5.0, patches: 2000, entries: 1_500_000, aggregates: 31, budget: 1e9 };

    #[test]
    fn the_correction_is_for_scenes_whose_light_lasts() {
        assert_eq!(choose(&ROOM).method, Method::TwoLevel);
        assert_eq!(choose(&Case { gain: 1e4, ..ROOM }).method, Method::TwoLevel);
        let dim = choose(&Case { gain: 1.4, ..ROOM });
        assert_eq!((dim.method, dim.why), (Method::Jacobi, "few bounces count"));
        assert!(dim.leaves < 1.0 / 3.0, "{dim:?}");
    }

    #[test]
    fn where_products_are_cheap_dispatches_count() {
        let small = Case { gain: 2.2, patches: 100, entries: 5_000, aggregates: 8, ..ROOM };
        assert_eq!(choose(&small).method, Method::Jacobi);
        assert_eq!(choose(&Case { gain: 2.2, ..ROOM }).method, Method::TwoLevel);
    }

    #[test]
    fn without_aggregates_or_with_too_many_there_is_no_correction() {
        for aggregates in [0, 65] {
            let choice = choose(&Case { gain: 1e3, aggregates, ..ROOM });
            assert_eq!((choice.method, choice.why), (Method::Jacobi, "it has no aggregates to correct"));
            assert!((choice.leaves - 0.999).abs() < 1e-9);
        }
    }

    #[test]
    fn a_frame_bears_fewer_products_of_a_large_scene_but_two() {
        assert_eq!(choose(&ROOM).most, 8);
        assert_eq!(choose(&Case { budget: 8e6, ..ROOM }).most, 4);
        assert_eq!(choose(&Case { budget: 1e5, ..ROOM }).most, 2);
    }

    #[test]
    fn nonsense_is_answered_too() {
        for gain in [f64::NAN, -1.0, 0.0, f64::INFINITY] {
            let choice = choose(&Case { gain, ..ROOM });
            assert!(choice.leaves > 0.0 && choice.leaves < 1.0 && choice.most >= 2, "{gain}: {choice:?}");
        }
    }
}
