//! Symmetric scaling until every row closes, to rounding: the plain twin of the bake's balance.
//!
//! ```text
//! X_ij = d_i S_ij d_j        Sum_j X_ij + d_i^2 s_i = A_i        s_i: what patch i sends to the sky or loses, in area
//! ```
//! First d_i <- d_i sqrt(A_i / row sum) a few times (Sinkhorn and Knopp 1967), then Newton's method on the row sums
//! (Knight and Ruiz 2013), which also ends where plates that face each other make the first crawl:
//! ```text
//! (diag(X 1 + 2 d^2 s) + X) e = A - row sums        d_i <- d_i exp(e_i)
//! ```

use rayon::prelude::*;

const SWEEPS: usize = 32;
const STEPS: usize = 40;
/// Of a row sum, relative: a few roundings of a sum of thousands.
const CLOSED: f64 = 1e-13;

/// S, n x columns of which the first n are patches, and what patches send elsewhere or lose; both in area.
pub struct Pooled<'a> {
    pub matrix: &'a [f64],
    pub columns: usize,
    pub slack: &'a [f64],
    pub areas: &'a [f64],
}

/// Returns d, and how far the worst row is from closing, relative.
pub fn close(pooled: &Pooled) -> (Vec<f64>, f64) {
    let areas = pooled.areas;
    let mut d = vec![1.0; areas.len()];
    for step in 0..SWEEPS + STEPS {
        let sums = pooled.row_sums(&d);
        if defect(&sums, areas) <= CLOSED {
            break;
        }
        if step < SWEEPS {
            let open = |i: &usize| sums[*i] > 0.0;
            (0..d.len()).filter(open).for_each(|i| d[i] *= (areas[i] / sums[i]).sqrt());
        } else {
            pooled.newton(&sums, &mut d);
        }
    }
    let defect = defect(&pooled.row_sums(&d), areas);
    (d, defect)
}

impl Pooled<'_> {
    /// Sum over j of S_ij x_j.
    fn product(&self, i: usize, x: &[f64]) -> f64 {
        dot(&row_of(self.matrix, self.columns, i)[..x.len()], x)
    }

    fn row_sums(&self, d: &[f64]) -> Vec<f64> {
        let row = |i: usize| d[i] * self.product(i, d) + d[i] * d[i] * self.slack[i];
        (0..d.len()).into_par_iter().map(row).collect()
    }

    fn newton(&self, sums: &[f64], d: &mut [f64]) {
        let n = d.len();
        let diagonal: Vec<f64> = (0..n).map(|i| sums[i] + d[i] * d[i] * self.slack[i]).collect();
        let lack: Vec<f64> = (0..n).map(|i| self.areas[i] - sums[i]).collect();
        let apply = |e: &[f64]| -> Vec<f64> {
            let scaled: Vec<f64> = e.iter().zip(d.iter()).map(|(e, d)| e * d).collect();
            let row = |i: usize| diagonal[i] * e[i] + d[i] * self.product(i, &scaled);
            (0..n).into_par_iter().map(row).collect()
        };
        let e = gradients(apply, &lack, &diagonal, 1e-10);
        d.iter_mut().zip(e).for_each(|(d, e)| *d *= e.clamp(-1.0, 1.0).exp());
    }
}

fn defect(sums: &[f64], areas: &[f64]) -> f64 {
    sums.iter().zip(areas).map(|(sum, area)| (sum / area - 1.0).abs()).fold(0.0, f64::max)
}

pub fn row_of<T>(matrix: &[T], columns: usize, i: usize) -> &[T] {
    &matrix[i * columns..(i + 1) * columns]
}

pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Conjugate gradients with the diagonal as preconditioner, to a relative residual (Hestenes and Stiefel 1952).
pub fn gradients(
    apply: impl Fn(&[f64]) -> Vec<f64>,
    rhs: &[f64],
    diagonal: &[f64],
    tolerance: f64,
) -> Vec<f64> {
    let precondition = |r: &[f64]| -> Vec<f64> {
        r.iter().zip(diagonal).map(|(r, d)| if *d > 0.0 { r / d } else { 0.0 }).collect()
    };
    let mut x = vec![0.0; rhs.len()];
    let mut r = rhs.to_vec();
    let mut z = precondition(&r);
    let mut p = z.clone();
    let mut rz = dot(&r, &z);
    let stop = tolerance * tolerance * rz;
    for _ in 0..1000 {
        let ap = apply(&p);
        let curvature = dot(&p, &ap);
        if rz <= stop || curvature <= 0.0 {
            break;
        }
        let step = rz / curvature;
        x.iter_mut().zip(&p).for_each(|(x, p)| *x += step * p);
        r.iter_mut().zip(&ap).for_each(|(r, ap)| *r -= step * ap);
        z = precondition(&r);
        let next = dot(&r, &z);
        let keep = next / rz;
        rz = next;
        p.iter_mut().zip(&z).for_each(|(p, z)| *p = z + keep * *p);
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_close_to_rounding_also_where_plates_face_each_other() {
        // Two groups that see almost nothing but each other, by noisy amounts.
        let n = 40;
        let noise = |i: usize, j: usize| 1.0 + 0.3 * ((i * 7 + j * 7 + i * j * 3) as f64).sin();
        let pooled: Vec<f64> = (0..n * n)
            .map(|k| (k / n, k % n))
            .map(|(i, j)| if (i < n / 2) == (j < n / 2) { 0.0 } else { noise(i.min(j), i.max(j)) / 20.0 })
            .collect();
        let slack: Vec<f64> = (0..n).map(|i| 1e-3 * (1.0 + (i as f64).cos().abs())).collect();
        let areas = vec![1.0; n];
        let (d, defect) = close(&Pooled { matrix: &pooled, columns: n, slack: &slack, areas: &areas });
        assert!(defect <= 1e-12, "{defect:e}");
        assert!(d.iter().all(|&d| d > 0.5 && d < 2.0), "{d:?}");
    }
}
