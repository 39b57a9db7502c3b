//! The linear system B = E + rho P B, one channel at a time where the truth is wanted and three at once where
//! speed is.
//!
//! * [`exact`]: deflated conjugate gradients on the symmetrised system (A P is symmetric after balancing),
//!   ```text
//!   K x = b,  K = I - R^1/2 S R^1/2,  S = A^1/2 P A^-1/2,  x = (A/R)^1/2 B
//!   ```
//!   with the aggregates as deflation space, refined until the residual of the stored rows themselves is small.
//!   Rows without albedo drop out: their B is their E.
//! * [`TwoLevel`]: what the runtime does: Jacobi from the last frame's B, then a coarse correction over the
//!   aggregates, then B >= E.
//! * [`cavity_gain`]: w with (I - RP) w = 1; |error_i| <= w_i max|residual| for any iterate (I - RP is an
//!   M-matrix).

use glam::{DVec3, Vec3, Vec4};
use rayon::prelude::*;

use super::{NONE, Patch, Rows};

/// What is solved: P's first `patches.len()` columns are patches; what lies behind them (the sky) is in E.
pub struct System<'a> {
    pub rows: &'a Rows,
    pub patches: &'a [Patch],
    /// By patch.
    pub albedo: &'a [Vec3],
}

/// Sum over the row's patch columns, f64.
fn product(rows: &Rows, n: usize, x: &[f64], out: &mut [f64]) {
    out.par_iter_mut().enumerate().for_each(|(i, out)| {
        let row = rows.row(i).take_while(|&(column, _)| (column as usize) < n);
        *out = row.map(|(column, weight)| f64::from(weight) * x[column as usize]).sum();
    });
}

/// Row sums times values of all columns: irradiance from radiosity.
pub fn gather(rows: &Rows, values: &[DVec3]) -> Vec<DVec3> {
    (0..rows.len())
        .into_par_iter()
        .map(|i| rows.row(i).map(|(column, weight)| values[column as usize] * f64::from(weight)).sum())
        .collect()
}

/// Solves for all three channels to a relative residual of `tolerance` (of the largest E). Channels that do
/// not reach it within a few hundred products are as near as they came.
pub fn exact(system: &System, e: &[DVec3], tolerance: f64) -> Vec<DVec3> {
    let mut b = vec![DVec3::ZERO; e.len()];
    for channel in 0..3 {
        let rho: Vec<f64> = system.albedo.iter().map(|albedo| f64::from(albedo[channel])).collect();
        let rhs: Vec<f64> = e.iter().map(|e| e[channel]).collect();
        for (b, x) in b.iter_mut().zip(exact_channel(system, &rho, &rhs, tolerance)) {
            b[channel] = x;
        }
    }
    b
}

fn exact_channel(system: &System, rho: &[f64], e: &[f64], tolerance: f64) -> Vec<f64> {
    let n = e.len();
    let scale = e.iter().fold(0.0_f64, |max, e| max.max(e.abs()));
    if scale == 0.0 || rho.iter().all(|&rho| rho == 0.0) {
        return e.to_vec();
    }
    let symmetric = Symmetric::new(system, rho);
    let mut b = e.to_vec();
    let mut gathered = vec![0.0; n];
    let mut last = f64::INFINITY;
    // Each round solves for what is left with the symmetric form; the residual is that of the stored rows.
    for _ in 0..12 {
        product(system.rows, n, &b, &mut gathered);
        let residual: Vec<f64> = (0..n).map(|i| e[i] + rho[i] * gathered[i] - b[i]).collect();
        let size = residual.iter().fold(0.0_f64, |max, r| max.max(r.abs()));
        if size <= tolerance * scale || size >= last * 0.9 {
            break;
        }
        last = size;
        let correction = symmetric.solve(&residual, 1e-6);
        b.iter_mut().zip(&correction).for_each(|(b, c)| *b += c);
    }
    b
}

/// K and its deflation space for one channel.
struct Symmetric<'a> {
    rows: &'a Rows,
    rho: &'a [f64],
    /// sqrt(rho / A): x to B.
    to_b: Vec<f64>,
    /// By patch: its deflation vector, or none.
    aggregate: Vec<u32>,
    /// The value of that vector there, K times each vector (m x n), and the inverse of W^T K W.
    w: Vec<f64>,
    kw: Vec<Vec<f64>>,
    inverse: Vec<f64>,
}

impl<'a> Symmetric<'a> {
    fn new(system: &System<'a>, rho: &'a [f64]) -> Self {
        let n = rho.len();
        let area = |i: usize| f64::from(system.patches[i].area);
        let to_b: Vec<f64> = (0..n).map(|i| (rho[i] / area(i)).sqrt()).collect();
        let aggregate: Vec<u32> =
            (0..n).map(|i| if rho[i] > 0.0 { system.patches[i].aggregate } else { NONE }).collect();
        let m = aggregate.iter().filter(|&&a| a != NONE).map(|&a| a + 1).max().unwrap_or(0) as usize;
        // Constant radiosity over an aggregate, in x.
        let w: Vec<f64> = (0..n).map(|i| if aggregate[i] == NONE { 0.0 } else { 1.0 / to_b[i] }).collect();
        let mut symmetric =
            Self { rows: system.rows, rho, to_b, aggregate, w, kw: Vec::new(), inverse: Vec::new() };
        for a in 0..m as u32 {
            let column: Vec<f64> =
                (0..n).map(|i| if symmetric.aggregate[i] == a { symmetric.w[i] } else { 0.0 }).collect();
            let mut kw = vec![0.0; n];
            symmetric.apply(&column, &mut kw);
            symmetric.kw.push(kw);
        }
        let mut matrix = vec![0.0; m * m];
        for b in 0..m {
            for (a, sum) in symmetric.restrict(&symmetric.kw[b], m).into_iter().enumerate() {
                matrix[a * m + b] = sum;
            }
        }
        symmetric.inverse = inverse(matrix, m);
        symmetric
    }

    /// K x.
    fn apply(&self, x: &[f64], out: &mut [f64]) {
        let b: Vec<f64> = x.iter().zip(&self.to_b).map(|(x, s)| x * s).collect();
        product(self.rows, x.len(), &b, out);
        for i in 0..x.len() {
            // sqrt(rho A) = rho / sqrt(rho / A)
            let back = if self.to_b[i] > 0.0 { self.rho[i] / self.to_b[i] } else { 0.0 };
            out[i] = x[i] - back * out[i];
        }
    }

    /// W^T x.
    fn restrict(&self, x: &[f64], m: usize) -> Vec<f64> {
        let mut sums = vec![0.0; m];
        for (i, &a) in self.aggregate.iter().enumerate().filter(|(_, a)| **a != NONE) {
            sums[a as usize] += self.w[i] * x[i];
        }
        sums
    }

    fn coarse(&self, x: &[f64]) -> Vec<f64> {
        let m = self.kw.len();
        let restricted = self.restrict(x, m);
        (0..m).map(|a| (0..m).map(|b| self.inverse[a * m + b] * restricted[b]).sum()).collect()
    }

    /// x less K W E^-1 W^T x.
    fn project(&self, x: &mut [f64]) {
        for (c, kw) in self.coarse(x).into_iter().zip(&self.kw) {
            x.iter_mut().zip(kw).for_each(|(x, kw)| *x -= c * kw);
        }
    }

    /// The B that answers a residual r = (I - RP) B, to a relative tolerance.
    fn solve(&self, r: &[f64], tolerance: f64) -> Vec<f64> {
        let n = r.len();
        // Rows without albedo are solved already; what they leave reaches the others.
        let known: Vec<f64> = (0..n).map(|i| if self.rho[i] == 0.0 { r[i] } else { 0.0 }).collect();
        let mut from_known = vec![0.0; n];
        product(self.rows, n, &known, &mut from_known);
        let rhs: Vec<f64> =
            (0..n)
                .map(|i| {
                    if self.to_b[i] > 0.0 { (r[i] + self.rho[i] * from_known[i]) / self.to_b[i] } else { 0.0 }
                })
                .collect();
        let x = self.deflated_gradients(&rhs, tolerance);
        (0..n).map(|i| known[i] + x[i] * self.to_b[i]).collect()
    }

    /// Deflated conjugate gradients (Nicolaides 1987).
    fn deflated_gradients(&self, rhs: &[f64], tolerance: f64) -> Vec<f64> {
        let n = rhs.len();
        let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
        let mut residual = rhs.to_vec();
        self.project(&mut residual);
        let (mut x, mut kp) = (vec![0.0; n], vec![0.0; n]);
        let mut p = residual.clone();
        let mut rr = dot(&residual, &residual);
        let stop = tolerance * tolerance * dot(rhs, rhs);
        for _ in 0..400 {
            if rr <= stop || rr == 0.0 {
                break;
            }
            self.apply(&p, &mut kp);
            self.project(&mut kp);
            let curvature = dot(&p, &kp);
            if curvature <= 0.0 {
                break;
            }
            let step = rr / curvature;
            for i in 0..n {
                x[i] += step * p[i];
                residual[i] -= step * kp[i];
            }
            let next = dot(&residual, &residual);
            let keep = next / rr;
            rr = next;
            p.iter_mut().zip(&residual).for_each(|(p, r)| *p = r + keep * *p);
        }
        // x = W E^-1 W^T (b - K x) + x
        self.apply(&x, &mut kp);
        let left: Vec<f64> = rhs.iter().zip(&kp).map(|(b, kx)| b - kx).collect();
        let coarse = self.coarse(&left);
        for (i, &a) in self.aggregate.iter().enumerate().filter(|(_, a)| **a != NONE) {
            x[i] += coarse[a as usize] * self.w[i];
        }
        x
    }
}

/// Gauss-Jordan with row pivots; a pivot that vanishes leaves its row out (zeros).
fn inverse(mut a: Vec<f64>, m: usize) -> Vec<f64> {
    let mut inverse = vec![0.0; m * m];
    (0..m).for_each(|i| inverse[i * m + i] = 1.0);
    for column in 0..m {
        let pivot = (column..m).max_by(|&p, &q| a[p * m + column].abs().total_cmp(&a[q * m + column].abs()));
        let pivot = pivot.unwrap_or(column);
        for k in 0..m {
            a.swap(pivot * m + k, column * m + k);
            inverse.swap(pivot * m + k, column * m + k);
        }
        let value = a[column * m + column];
        let scale = if value.abs() > 1e-300 { 1.0 / value } else { 0.0 };
        for k in 0..m {
            a[column * m + k] *= scale;
            inverse[column * m + k] *= scale;
        }
        for row in (0..m).filter(|&row| row != column) {
            let factor = a[row * m + column];
            if factor != 0.0 {
                for k in 0..m {
                    a[row * m + k] -= factor * a[column * m + k];
                    inverse[row * m + k] -= factor * inverse[column * m + k];
                }
            }
        }
    }
    inverse
}

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

/// The coarse correction: what an iterate lacks as a constant on each aggregate.
///
/// ```text
/// restricted = R^T rho P      m x n, row-major, rgb        R^T: area mean over an aggregate
/// inverse    = (R^T (I - rho P) W)^-1                      m x m, row-major, by channel
/// B' = E + rho P B;   B = max(B' + W inverse (restricted (B' - B)), E)
/// ```
#[derive(Clone, Debug, Default)]
pub struct Coarse {
    pub m: usize,
    pub restricted: Vec<Vec4>,
    pub inverse: [Vec<f32>; 3],
}

impl Coarse {
    pub fn new(system: &System) -> Self {
        let (n, patches) = (system.patches.len(), system.patches);
        let aggregates = patches.iter().map(|patch| patch.aggregate).filter(|&a| a != NONE);
        let m = aggregates.map(|a| a + 1).max().unwrap_or(0) as usize;
        let mut areas = vec![0.0; m];
        for patch in patches.iter().filter(|patch| patch.aggregate != NONE) {
            areas[patch.aggregate as usize] += f64::from(patch.area);
        }
        let mut sums = vec![DVec3::ZERO; m * n];
        for (i, patch) in patches.iter().enumerate().filter(|(_, patch)| patch.aggregate != NONE) {
            let a = patch.aggregate as usize;
            let share = system.albedo[i].as_dvec3() * (f64::from(patch.area) / areas[a]);
            for (j, weight) in system.rows.row(i).take_while(|&(j, _)| (j as usize) < n) {
                sums[a * n + j as usize] += share * f64::from(weight);
            }
        }
        let inverse = std::array::from_fn(|channel| {
            let mut matrix = vec![0.0; m * m];
            for a in 0..m {
                matrix[a * m + a] += 1.0;
                for (j, patch) in patches.iter().enumerate().filter(|(_, patch)| patch.aggregate != NONE) {
                    matrix[a * m + patch.aggregate as usize] -= sums[a * n + j][channel];
                }
            }
            inverse(matrix, m).into_iter().map(|x| x as f32).collect()
        });
        Self { m, restricted: sums.iter().map(|sum| sum.as_vec3().extend(0.0)).collect(), inverse }
    }

    /// Aggregates' corrections for a change B' - B.
    pub fn correction(&self, change: &[Vec3]) -> Vec<Vec3> {
        let n = change.len();
        let restricted: Vec<Vec3> = (0..self.m)
            .into_par_iter()
            .map(|a| {
                self.restricted[a * n..(a + 1) * n].iter().zip(change).map(|(r, c)| r.truncate() * *c).sum()
            })
            .collect();
        let at = |a: usize, channel: usize| -> f32 {
            (0..self.m).map(|b| self.inverse[channel][a * self.m + b] * restricted[b][channel]).sum()
        };
        (0..self.m).map(|a| Vec3::new(at(a, 0), at(a, 1), at(a, 2))).collect()
    }
}

/// The runtime's iteration on the CPU, f32: the plain twin of the GPU's bounce.
pub struct TwoLevel<'a> {
    pub system: &'a System<'a>,
    pub coarse: &'a Coarse,
}

impl TwoLevel<'_> {
    /// One step from B; returns the largest change that Jacobi made (the residual of the B given).
    pub fn step(&self, e: &[Vec3], b: &mut [Vec3]) -> f32 {
        let (rows, n) = (self.system.rows, b.len());
        let next: Vec<Vec3> = (0..n)
            .into_par_iter()
            .map(|i| {
                let row = rows.row(i).take_while(|&(j, _)| (j as usize) < n);
                e[i] + self.system.albedo[i] * row.map(|(j, weight)| b[j as usize] * weight).sum::<Vec3>()
            })
            .collect();
        let change: Vec<Vec3> = next.iter().zip(b.iter()).map(|(next, b)| *next - *b).collect();
        let residual = change.iter().fold(0.0_f32, |max, change| max.max(change.abs().max_element()));
        let correction = self.coarse.correction(&change);
        for i in 0..n {
            let aggregate = self.system.patches[i].aggregate;
            let lift = correction.get(aggregate as usize).copied().unwrap_or(Vec3::ZERO);
            b[i] = (next[i] + lift).max(e[i]);
        }
        residual
    }
}
