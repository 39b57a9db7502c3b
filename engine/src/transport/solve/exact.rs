//! The truth: conjugate gradients, deflated where there are aggregates, until the residual of the stored rows
//! themselves is small.
//!
//! Channels are solved one after the other, and what is grey once.

use glam::DVec3;

use super::iterate::{Ended, Run, prepare};
use super::matrix::{Matrix, largest};
use super::{Method, System};

/// Solves for all three channels to a relative residual of `tolerance` (of the largest E). What is no number in E counts
/// as 0. Channels that do
/// not reach it within a thousand products are as near as they came.
pub fn exact(system: &System, e: &[DVec3], tolerance: f64) -> Vec<DVec3> {
    let mut b = vec![DVec3::ZERO; e.len()];
    let channel_of_e = |channel: usize| -> Vec<f64> { e.iter().map(|e| e[channel]).collect() };
    for channel in 0..3 {
        if let Some(same) = (0..channel).find(|&before| is_same(system, e, before, channel)) {
            b.iter_mut().for_each(|b| b[channel] = b[same]);
            continue;
        }
        let matrix = Matrix::of(system, channel);
        let method = Method::for_truth(matrix.patches);
        let solved = approach(&matrix, method, &channel_of_e(channel), tolerance);
        b.iter_mut().zip(solved).for_each(|(b, x)| b[channel] = x);
    }
    b
}

/// Grey scenes are solved once.
fn is_same(system: &System, e: &[DVec3], a: usize, b: usize) -> bool {
    system.albedo.iter().all(|albedo| albedo[a] == albedo[b]) && e.iter().all(|e| e[a] == e[b])
}

/// Until max |r| <= tolerance max |E|, or as near as it comes: what one method does not reach, the next goes on with.
/// Rows that are not symmetric enough for conjugate gradients, which no bake leaves, are left to two-level Jacobi: it
/// needs no symmetry.
pub(super) fn approach(matrix: &Matrix, method: Method, e: &[f64], tolerance: f64) -> Vec<f64> {
    const MOST: f64 = 1000.0;
    let finite: Vec<f64> = e.iter().map(|&e| if e.is_finite() { e } else { 0.0 }).collect();
    let enough = tolerance * largest(&finite);
    let near = |r: &[f64], _: &[f64]| largest(r) <= enough;
    let run = Run { near: &near, products: MOST, cancelled: &|| false };
    let mut nearest: Option<Ended> = None;
    for method in [method, Method::ConjugateGradients, Method::TwoLevel] {
        let mut iteration = prepare(method, matrix, 1.0, &finite);
        let start = nearest.as_ref().map(|nearest| nearest.b.as_slice());
        let ended = run.from(iteration.as_mut(), matrix, &finite, start, &mut |_| {});
        if nearest.as_ref().is_none_or(|nearest| largest(&ended.r) < largest(&nearest.r)) {
            nearest = Some(ended);
        }
        if nearest.as_ref().is_some_and(|nearest| largest(&nearest.r) <= enough) {
            break;
        }
    }
    nearest.map_or(finite, |nearest| nearest.b)
}
