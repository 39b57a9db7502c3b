//! The inverse of a small dense matrix, for what is solved over aggregates.

/// Gauss-Jordan with row pivots, m x m, row-major; a pivot that vanishes leaves its row out (zeros).
pub(super) fn inverse(mut a: Vec<f64>, m: usize) -> Vec<f64> {
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

/// y = M x, M of x.len() columns, row-major.
pub(super) fn times(matrix: &[f64], x: &[f64], y: &mut [f64]) {
    for (y, row) in y.iter_mut().zip(matrix.chunks_exact(x.len().max(1))) {
        *y = dot(row, x);
    }
}

/// Four sums at once, so that additions overlap.
pub(super) fn dot(a: &[f64], x: &[f64]) -> f64 {
    let ((a, last_a), (x, last_x)) = (a.as_chunks::<4>(), x.as_chunks::<4>());
    let mut sums = [0.0; 4];
    for (a, x) in a.iter().zip(x) {
        for k in 0..4 {
            sums[k] += a[k] * x[k];
        }
    }
    let last: f64 = last_a.iter().zip(last_x).map(|(a, x)| a * x).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + last
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_undoes_the_matrix_and_leaves_out_what_has_none() {
        let a = vec![0.0, 2.0, 0.0, 0.5, 1.0, 0.0, 0.0, 0.0, 0.0];
        let inverse = inverse(a.clone(), 3);
        let (mut y, mut back) = ([0.0; 3], [0.0; 3]);
        times(&a, &[3.0, 5.0, 0.0], &mut y);
        times(&inverse, &y, &mut back);
        assert_eq!(back, [3.0, 5.0, 0.0]);
    }
}
