//! How wrong a matrix is, how long it took, and two ways of making it side by side.

use std::time::Instant;

use glam::Vec3;

use super::{FormFactors, by_plain_rays, of_faces};
use crate::{BakeError, Silent};

/// Of a matrix against a reference, both n x n.
#[derive(Clone, Copy, Debug, Default)]
pub struct MatrixError {
    /// rms of the differences over rms of the reference.
    pub rms: f64,
    /// The mean over rows of the sum of all differences' sizes.
    pub row_l1: f64,
    /// rms of A_i F_ij - A_j F_ji over rms of A_i F_ij.
    pub reciprocity: f64,
    /// The largest difference of row sums.
    pub row_sum: f64,
}

impl FormFactors {
    /// Row after row.
    pub fn dense(&self) -> Vec<f32> {
        let n = self.rows.len();
        let mut dense = vec![0.0; n * n];
        for i in 0..n {
            self.rows.row(i).for_each(|(j, share)| dense[i * n + j as usize] = share);
        }
        dense
    }

    /// `reference`: F_ij, row after row.
    pub fn error(&self, reference: &[f32]) -> MatrixError {
        let n = self.rows.len();
        let dense = self.dense();
        let square = |x: f64| x * x;
        let (mut off, mut all, mut l1, mut one_way, mut exchanged) = (0.0, 0.0, 0.0, 0.0, 0.0);
        let mut row_sum = 0.0_f64;
        for i in 0..n {
            let mut sums = 0.0;
            for j in 0..n {
                let (found, wanted) = (f64::from(dense[i * n + j]), f64::from(reference[i * n + j]));
                off += square(found - wanted);
                all += square(wanted);
                l1 += (found - wanted).abs();
                sums += found - wanted;
                let there = self.areas[i] * found;
                one_way += square(there - self.areas[j] * f64::from(dense[j * n + i]));
                exchanged += square(there);
            }
            row_sum = row_sum.max(sums.abs());
        }
        let rms = |part: f64, of: f64| if of > 0.0 { (part / of).sqrt() } else { 0.0 };
        MatrixError {
            rms: rms(off, all),
            row_l1: l1 / n.max(1) as f64,
            reciprocity: rms(one_way, exchanged),
            row_sum,
        }
    }
}

/// One way at one number of rays.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    pub rays: u32,
    /// Median of the runs.
    pub seconds: f64,
    pub error: MatrixError,
}

/// Both ways over the same faces in turn, so that what else the machine does hits both.
pub struct Comparison {
    pub product: Vec<Point>,
    pub plain: Vec<Point>,
}

/// `runs` times each; seconds are medians.
pub fn compare(
    faces: &[[Vec3; 3]],
    reference: &[f32],
    product_rays: &[u32],
    plain_rays: &[u32],
    runs: usize,
) -> Result<Comparison, BakeError> {
    let mut product = vec![Vec::new(); product_rays.len()];
    let mut plain = vec![Vec::new(); plain_rays.len()];
    for run in 0..runs.max(1) {
        for k in 0..product_rays.len().max(plain_rays.len()) {
            if let Some(&rays) = product_rays.get(k) {
                product[k].push(timed(rays, reference, || of_faces(faces, rays, &Silent))?);
            }
            if let Some(&rays) = plain_rays.get(k) {
                plain[k].push(timed(rays, reference, || by_plain_rays(faces, rays, run as u64))?);
            }
        }
    }
    let medians = |runs: Vec<Vec<Point>>| runs.into_iter().map(median).collect();
    Ok(Comparison { product: medians(product), plain: medians(plain) })
}

fn timed(
    rays: u32,
    reference: &[f32],
    make: impl FnOnce() -> Result<FormFactors, BakeError>,
) -> Result<Point, BakeError> {
    let started = Instant::now();
    let made = make()?;
    let seconds = started.elapsed().as_secs_f64();
    Ok(Point { rays, seconds, error: made.error(reference) })
}

fn median(mut runs: Vec<Point>) -> Point {
    runs.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
    runs[runs.len() / 2]
}

impl Comparison {
    /// By point of the product: its error over the plain twin's in the same time.
    pub fn errors_at_equal_time(&self) -> Vec<f64> {
        let plain: Vec<[f64; 2]> = self.plain.iter().map(|point| [point.seconds, point.error.rms]).collect();
        self.product.iter().map(|point| point.error.rms / interpolated(&plain, point.seconds)).collect()
    }

    /// By point of the product: its time over the plain twin's for the same error.
    pub fn times_at_equal_error(&self) -> Vec<f64> {
        let plain: Vec<[f64; 2]> = self.plain.iter().map(|point| [point.error.rms, point.seconds]).collect();
        self.product.iter().map(|point| point.seconds / interpolated(&plain, point.error.rms)).collect()
    }
}

/// y at x, linear in the logarithms of both; beyond the ends along the nearest two points.
fn interpolated(points: &[[f64; 2]], x: f64) -> f64 {
    let mut logs: Vec<[f64; 2]> = points.iter().map(|point| point.map(f64::ln)).collect();
    logs.sort_by(|a, b| a[0].total_cmp(&b[0]));
    match logs.len() {
        0 => return f64::NAN,
        1 => return logs[0][1].exp(),
        _ => {}
    }
    let x = x.ln();
    let right = logs.partition_point(|point| point[0] < x).clamp(1, logs.len() - 1);
    let ([x0, y0], [x1, y1]) = (logs[right - 1], logs[right]);
    (y0 + (y1 - y0) * (x - x0) / (x1 - x0)).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_law_is_followed_within_and_beyond_its_points() {
        let points: Vec<[f64; 2]> = [1.0, 3.0, 20.0].map(|x: f64| [x, 2.0 / x.sqrt()]).to_vec();
        for x in [0.1, 2.0, 7.0, 400.0_f64] {
            assert!((interpolated(&points, x) - 2.0 / x.sqrt()).abs() < 1e-12);
        }
    }
}
