//! Rows in fewer bytes: weights of 16 and of 8 bits, and rows cut to their largest entries.
//!
//! ```text
//! f16        w ~ scale half(w / scale)                     scale: the row's largest weight
//! u8 sqrt    w ~ scale (round(255 sqrt(w / scale)) / 255)^2
//! top K      the K largest weights of a row
//! ```
//! Each row is then multiplied so that it sums to what it summed to (one f32 a row): without that, eight bits cost five
//! times the error at an albedo of 0.95. Truncation stands here as a warning: diffuse light is smooth, not sparse, and
//! what is cut off is put onto what is near.

use engine::transport::Rows;
use half::f16;
use rayon::prelude::*;

/// How weights are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kept {
    F32,
    F16,
    U8,
    /// In f32, so many entries a row.
    Largest(usize),
}

impl Kept {
    pub fn name(self) -> String {
        match self {
            Self::F32 => "f32".to_owned(),
            Self::F16 => "f16".to_owned(),
            Self::U8 => "u8, square roots".to_owned(),
            Self::Largest(count) => format!("the largest {count}"),
        }
    }

    /// Of rows kept so: a column of 4 bytes and a weight an entry, a start of 8 and, where weights are scaled, a scale
    /// and a factor of 4 each a row.
    pub fn bytes(self, rows: &Rows) -> usize {
        let (weight, scales) = match self {
            Self::F32 | Self::Largest(_) => (4, 0),
            Self::F16 => (2, 8),
            Self::U8 => (1, 8),
        };
        rows.entries() * (4 + weight) + rows.starts.len() * (8 + scales)
    }
}

/// The rows as they come back.
pub fn kept(rows: &Rows, how: Kept) -> Rows {
    let finished: Vec<Vec<(u32, f32)>> = (0..rows.len())
        .into_par_iter()
        .map(|i| {
            let row: Vec<(u32, f32)> = rows.row(i).collect();
            let sum: f64 = row.iter().map(|entry| f64::from(entry.1)).sum();
            summing_to(sum, stored(row, how))
        })
        .collect();
    let mut rows = Rows::default();
    finished.into_iter().for_each(|row| rows.push(row));
    rows
}

fn stored(mut row: Vec<(u32, f32)>, how: Kept) -> Vec<(u32, f32)> {
    let scale = row.iter().fold(0.0_f32, |max, entry| max.max(entry.1.abs()));
    if scale == 0.0 {
        return row;
    }
    match how {
        Kept::F32 => {}
        Kept::F16 => {
            row.iter_mut().for_each(|entry| entry.1 = f16::from_f32(entry.1 / scale).to_f32() * scale)
        }
        Kept::U8 => row.iter_mut().for_each(|entry| {
            let code = (255.0 * (entry.1 / scale).max(0.0).sqrt()).round() / 255.0;
            entry.1 = code * code * scale;
        }),
        Kept::Largest(count) => {
            row.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
            row.truncate(count);
            row.sort_unstable_by_key(|entry| entry.0);
        }
    }
    row.retain(|entry| entry.1 != 0.0);
    row
}

fn summing_to(sum: f64, mut row: Vec<(u32, f32)>) -> Vec<(u32, f32)> {
    let kept: f64 = row.iter().map(|entry| f64::from(entry.1)).sum();
    if kept > 0.0 && kept != sum {
        let factor = sum / kept;
        row.iter_mut().for_each(|entry| entry.1 = (f64::from(entry.1) * factor) as f32);
        crate::balance::cap(&mut row, sum);
    }
    row
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row() -> Rows {
        let mut rows = Rows::default();
        let weights = (1..400).map(|k| (k, 1.0 / (400.0 * (k as f32).powf(0.8))));
        rows.push(weights);
        rows.push([]);
        rows
    }

    #[test]
    fn rows_in_fewer_bytes_keep_their_sums_and_lose_less_the_more_bytes_they_have() {
        let rows = row();
        let far = |how| {
            let kept = kept(&rows, how);
            assert_eq!(kept.len(), 2);
            assert!((kept.sum(0) - rows.sum(0)).abs() < 2e-7, "{how:?}: {} of {}", kept.sum(0), rows.sum(0));
            let found =
                |column: u32| kept.row(0).find(|entry| entry.0 == column).map_or(0.0, |entry| entry.1);
            rows.row(0).map(|(column, weight)| f64::from((weight - found(column)).abs())).sum::<f64>()
        };
        let [all, half, byte, few] = [Kept::F32, Kept::F16, Kept::U8, Kept::Largest(64)].map(far);
        assert!(all == 0.0 && half > 0.0 && half < 1e-3 * rows.sum(0), "{half}");
        assert!(byte > 4.0 * half && byte < 0.1 * rows.sum(0), "{byte}");
        assert!(few > 10.0 * byte, "{few}");
    }
}
