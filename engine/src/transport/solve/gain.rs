//! The cavity gain, a scene's stiffness, and the albedo that closed rooms can bear.
//!
//! ```text
//! (I - R P) w = 1,    max w = || (I - R P)^-1 ||: what one unit of light everywhere becomes, and one of residual
//! ```
//! 1 / (1 - rho) in a closed room of one albedo; far less where light gets lost.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::{System, exact};
use crate::transport::{Patch, Rows};

/// w with (I - RP) w = 1, by channel; its maximum is the cavity gain, the scene's stiffness.
pub fn cavity_gain(system: &System) -> Vec<DVec3> {
    exact(system, &vec![DVec3::ONE; system.patches.len()], 1e-7)
}

/// Closed components whose gain would exceed this have their albedo limited.
pub const GAIN_LIMIT: f64 = 1e4;

/// Limits albedo where light would be multiplied by more than [`GAIN_LIMIT`], and returns the components in which it
/// did. A closed component whose area mean of the gain, A / Sum A_i (1 - rho_i t_i), is beyond the limit has its albedo
/// capped so that this is 1e4, which is exact where albedo is uniform. What is still beyond it (a pocket that hardly
/// leaks into the rest) is capped at 1 - 1e-4: w_i = 1 + rho_i Sum P_ij w_j is then at most 1e4 wherever it is largest.
pub fn limit_gain(rows: &Rows, patches: &[Patch], albedo: &mut [Vec3]) -> Vec<u32> {
    let components = patches.iter().map(|patch| patch.component + 1).max().unwrap_or(0);
    let mut members: Vec<Vec<usize>> = vec![Vec::new(); components as usize];
    patches.iter().enumerate().for_each(|(i, patch)| members[patch.component as usize].push(i));
    let kept: Vec<f64> =
        (0..patches.len()).into_par_iter().map(|i| patch_sum(rows, patches.len(), i)).collect();
    let most = 1.0 - 1.0 / GAIN_LIMIT;
    if (0..patches.len()).all(|i| f64::from(albedo[i].max_element()) * kept[i] <= most) {
        return Vec::new(); // no row can multiply by more
    }
    let mut limited = Vec::new();
    for (component, members) in members.iter().enumerate() {
        let gain = |channel: usize, cap: f64| {
            let area: f64 = members.iter().map(|&i| f64::from(patches[i].area)).sum();
            let lost = members.iter().map(|&i| {
                f64::from(patches[i].area) * (1.0 - f64::from(albedo[i][channel]).min(cap) * kept[i])
            });
            area / lost.sum::<f64>().max(1e-300)
        };
        let caps: [Option<f64>; 3] = std::array::from_fn(|channel| {
            // Rounding leaves a closed component's sums up to 2e-7 below 1: far under the limit's 1e-4.
            (gain(channel, 1.0) > GAIN_LIMIT).then(|| {
                let (mut low, mut high) = (0.0, 1.0);
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if gain(channel, middle) > GAIN_LIMIT { high = middle } else { low = middle }
                }
                low
            })
        });
        if caps.iter().any(Option::is_some) {
            limited.push(component as u32);
        }
        for &i in members {
            for channel in 0..3 {
                let cap = caps[channel].unwrap_or(1.0) as f32;
                albedo[i][channel] = albedo[i][channel].min(cap);
            }
        }
    }
    let w = cavity_gain(&System { rows, patches, albedo });
    for i in 0..patches.len() {
        // A gain that is negative or not finite is one that could not be solved for.
        let bearable = |channel: usize| (0.0..=1.0001 * GAIN_LIMIT).contains(&w[i][channel]);
        if !(0..3).all(bearable) {
            albedo[i] = albedo[i].min(Vec3::splat(most as f32));
            limited.push(patches[i].component);
        }
    }
    limited.sort_unstable();
    limited.dedup();
    limited
}

fn patch_sum(rows: &Rows, n: usize, i: usize) -> f64 {
    rows.row(i).take_while(|&(column, _)| (column as usize) < n).map(|(_, weight)| f64::from(weight)).sum()
}
