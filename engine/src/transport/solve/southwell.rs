//! Southwell's relaxation, in radiosity progressive refinement or shooting: the patch with the most unshot power gives
//! it to all it sees.
//!
//! ```text
//! i = argmax A_i |r_i|:   B_i <- B_i + r_i,   r_j <- r_j + rho_j P_ji r_i  (P_ji = P_ij A_i / A_j),   r_i <- rho_i P_ii r_i
//! ```
//! A shot reads one row, 1/n of a product, and looks through all residuals for the largest; it is serial. The first
//! bounces of few lamps come for a fraction of a product, which suits a preview; what then is left is spread evenly,
//! and falls as with Gauss-Seidel. Source: Southwell (1940); Cohen, Chen, Wallace, Greenberg (1988).

use super::iterate::{Iteration, Left};
use super::matrix::Matrix;

pub(super) struct Southwell<'a> {
    matrix: &'a Matrix<'a>,
    areas: Vec<f64>,
    /// rho_j / A_j.
    reflects: Vec<f64>,
}

/// Steps that make a product, each of as many shots as that takes.
const STEPS: usize = 32;

impl<'a> Southwell<'a> {
    pub fn new(matrix: &'a Matrix<'a>) -> Self {
        let areas: Vec<f64> = (0..matrix.len()).map(|i| matrix.area(i)).collect();
        let reflects = areas.iter().zip(&matrix.albedo).map(|(area, rho)| rho / area).collect();
        Self { matrix, areas, reflects }
    }

    fn shots(&self) -> usize {
        self.areas.len().div_ceil(STEPS)
    }

    /// The most power first, in eight strands, and then who has it: both loops run over vectors.
    fn brightest(&self, r: &[f64]) -> usize {
        let power = |i: usize| r[i].abs() * self.areas[i];
        let mut most = [0.0; 8];
        for (r, area) in r.chunks(8).zip(self.areas.chunks(8)) {
            for ((most, r), area) in most.iter_mut().zip(r).zip(area) {
                let power = r.abs() * area;
                *most = if power > *most { power } else { *most };
            }
        }
        let most = most.into_iter().fold(0.0, f64::max);
        (0..r.len()).find(|&i| power(i) == most).unwrap_or(0)
    }

    fn shoot(&self, b: &mut [f64], r: &mut [f64]) {
        let brightest = self.brightest(r);
        let unshot = std::mem::take(&mut r[brightest]);
        b[brightest] += unshot;
        let power = unshot * self.areas[brightest];
        let (columns, weights) = self.matrix.row(brightest);
        for (&j, &weight) in columns.iter().zip(weights) {
            let j = j as usize;
            r[j] += self.reflects[j] * f64::from(weight) * power;
        }
    }
}

impl Iteration for Southwell<'_> {
    fn advance(&mut self, b: &mut [f64], r: &mut [f64]) -> Left {
        (0..self.shots()).for_each(|_| self.shoot(b, r));
        Left::Estimated
    }

    fn costs(&self) -> f64 {
        self.shots() as f64 / self.areas.len().max(1) as f64
    }
}
