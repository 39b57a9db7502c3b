//! Rows as cuts through a tree over the patches: patches that a receiver need not tell apart become one entry.
//!
//! Diffuse light is smooth, not sparse: the largest 128 of 1400 factors hold 62 % of it, so nothing may be dropped,
//! but much may be merged. An entry for node t spreads what its patches sent evenly over their area. What that loses is
//! exactly what the halves l and r of t, their halves, and so on, would have told apart (the Haar wavelets of a row
//! against those of B; Gortler, Schroeder, Cohen and Hanrahan 1993):
//! ```text
//! G_it = Sum_{j in t} G_ij        d_is = G_il - G_is A_l / A_s
//! Sum_{j in t} G_ij B_j = G_it B_t + Sum_{s at or below t} d_is (B_l - B_r)              (1)
//! E_it^2 = Sum_{s at or below t} d_is^2                                                  (2)
//! ```
//! B is not known at bake: what will be lit changes. E is the error in the mean square for a light whose halves differ
//! by 1 W/m2, whatever their size, without order in the signs. The cut is the one that makes
//! ```text
//! Sum_{t in cut} E_it^2 + tolerance^2 * entries                                          (3)
//! ```
//! least: an entry stays apart where it takes more than the tolerance off the error. One walk from the leaves up finds
//! it (Chou, Lookabaugh and Gray 1989), and as every row pays the same price, no other choice of as many entries in
//! all rows together has a smaller sum of (2).
//!
//! What never shares a node: patches of two batches (colour and emission are run-time values of a batch's material), the
//! sides of a surface, patches that exchange no light with each other, and marked emitters (single always). So no light
//! crosses into a closed room, and a batch that glows evenly is exact.

mod forest;

use std::collections::BTreeMap;

use engine::scene::Scene;
use engine::transport::{Rows, Transport, Tree, solve};
use glam::DVec3;
use rayon::prelude::*;

use crate::balance::cap;
use forest::{Cut, Forest};

/// Rows that name nodes of a tree behind the patches and sky patches.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CutRows {
    pub tree: Tree,
    pub rows: Rows,
    /// By row: the sum of (2) over its cut.
    pub errors: Vec<f64>,
}

impl CutRows {
    pub fn bytes(&self) -> usize {
        self.rows.bytes() + self.tree.bytes()
    }

    /// What arrives from these values of all columns, as [`solve::gather`] does for whole rows.
    pub fn gather(&self, transport: &Transport, values: &[DVec3]) -> Vec<DVec3> {
        let mut columns = values.to_vec();
        columns.extend(self.tree.values(&transport.patches, values));
        solve::gather(&self.rows, &columns)
    }
}

/// By patch: marked by its material to be sampled towards. Such a patch is an entry of its own in every row.
pub fn marked(scene: &Scene, transport: &Transport) -> Vec<bool> {
    crate::pipeline::sampled(scene, transport)
}

/// The tolerance at which an entry stays apart for what one ray carries: below it lies the noise of the rows.
pub fn one_ray(transport: &Transport) -> f64 {
    1.0 / f64::from(transport.certificate.rays_per_row.max(1))
}

/// Cuts rows of irradiance: weights are shares >= 0, and each row sums to what it did, or up to 1e-7 less.
pub fn cut_rows(rows: &Rows, transport: &Transport, single: &[bool], tolerance: f64) -> CutRows {
    let forest = Forest::new(&transport.patches, single);
    let first = transport.columns() as u32;
    let cuts: Vec<(Vec<(u32, f32)>, f64)> = (0..rows.len())
        .into_par_iter()
        .map(|row| {
            let entries = rows.row(row).map(|(column, weight)| (column, [f64::from(weight)]));
            let Cut { entries, error } = forest.cut(entries, first, tolerance);
            let mut cut: Vec<_> = entries.into_iter().map(|(column, [sum])| (column, sum as f32)).collect();
            cap(&mut cut, rows.sum(row));
            (cut, error)
        })
        .collect();
    let mut cut = CutRows::default();
    for (row, error) in cuts {
        cut.rows.push(row);
        cut.errors.push(error);
    }
    cut.tree = forest.prune(first, &mut cut.rows);
    cut
}

/// By row, Sum over its nodes of dev_it = Sum_{j in t} |G_ij - G_it A_j / A_t|: half of it times how far B ranges within
/// nodes bounds the error of any light.
pub fn deviations(transport: &Transport, rows: &Rows, cut: &CutRows) -> Vec<f64> {
    let first = transport.columns() as u32;
    let area = |&j: &u32| f64::from(transport.patches[j as usize].area);
    let of_node = |row: &BTreeMap<u32, f64>, members: &[u32], sum: f32| -> f64 {
        let even = f64::from(sum) / members.iter().map(area).sum::<f64>();
        members.iter().map(|j| (row.get(j).copied().unwrap_or(0.0) - even * area(j)).abs()).sum()
    };
    let of_row = |row: usize| -> f64 {
        let whole: BTreeMap<u32, f64> = rows.row(row).map(|(j, weight)| (j, f64::from(weight))).collect();
        let nodes = cut.rows.row(row).filter(|&(column, _)| column >= first);
        nodes.map(|(node, sum)| of_node(&whole, cut.tree.members((node - first) as usize), sum)).sum()
    };
    (0..rows.len()).into_par_iter().map(of_row).collect()
}

#[cfg(test)]
mod tests;
