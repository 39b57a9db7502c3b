//! The truth: conjugate gradients, deflated where there are aggregates, until the residual of the stored rows
//! themselves is small.

use glam::DVec3;

use super::iterate::{Run, prepare};
use super::matrix::{Matrix, largest};
use super::{Method, System};

/// Solves for all three channels to a relative residual of `tolerance` (of the largest E). Channels that do
/// not reach it within a few hundred products are as near as they came.
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

/// Until max |r| <= tolerance max |E|, or as near as it comes.
pub(super) fn approach(matrix: &Matrix, method: Method, e: &[f64], tolerance: f64) -> Vec<f64> {
    const MOST: f64 = 2000.0;
    let finite: Vec<f64> = e.iter().map(|&e| if e.is_finite() { e } else { 0.0 }).collect();
    let enough = tolerance * largest(&finite);
    let near = |r: &[f64], _: &[f64]| largest(r) <= enough;
    let run = Run { near: &near, products: MOST, cancelled: &|| false };
    let mut iteration = prepare(method, matrix, 1.0, &finite);
    run.from(iteration.as_mut(), matrix, &finite, None, &mut |_| {}).b
}
