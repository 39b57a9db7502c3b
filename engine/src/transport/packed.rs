//! Entries of rows in four bytes: the f16 of 2^15 times a weight, above its column.
//!
//! A share of light is at most 1, so that half of f16's exponents would never be used: the factor moves weights down to
//! 2^-29 into the range where f16 has 11 bits, and further ones are told apart to 2^-39. Rows that were [`fold`]ed are
//! held without loss, and their sums are those of before: rounding alone would make light or lose it, by 3e-6 a row
//! and more at each bounce.

/// A column is the lower half.
pub const MOST_COLUMNS: usize = 1 << 16;
const SCALE: f32 = 32768.0;
/// f16 holds 2^-24 times an integer below this.
const LEAST_NORMAL: f32 = 1.0 / 16384.0;
const LEAST: f32 = 1.0 / 16_777_216.0;
const BEYOND: f32 = 65536.0;
/// Bits of f32's mantissa that f16 does not have.
const BELOW: u32 = 0x1fff;

/// None where four bytes do not hold them exactly.
pub fn pack(column: u32, weight: f32) -> Option<u32> {
    let scaled = weight * SCALE;
    let size = scaled.abs();
    let fits = (column as usize) < MOST_COLUMNS && size < BEYOND && floor(size) == size;
    if !fits {
        return None;
    }
    let bits = if size < LEAST_NORMAL { (size / LEAST) as u32 } else { (size.to_bits() >> 13) - (112 << 10) };
    let sign = if scaled.is_sign_negative() { 0x8000 } else { 0 };
    Some((sign | bits) << 16 | column)
}

/// Column and weight, as `transport/rows.wgsl` reads them.
pub fn unpack(entry: u32) -> (u32, f32) {
    let half = entry >> 16;
    let bits = half & 0x7fff;
    let size = if bits < 0x400 { bits as f32 * LEAST } else { f32::from_bits((bits + (112 << 10)) << 13) };
    let sign = if half & 0x8000 == 0 { 1.0 } else { -1.0 };
    (entry & 0xffff, sign * size / SCALE)
}

/// All entries, or none where one does not fit.
pub fn pack_all(columns: &[u32], weights: &[f32]) -> Option<Vec<u32>> {
    columns.iter().zip(weights).map(|(&column, &weight)| pack(column, weight)).collect()
}

/// The largest f16 that is not above, for >= 0.
fn floor(size: f32) -> f32 {
    if size < LEAST_NORMAL { (size / LEAST).floor() * LEAST } else { f32::from_bits(size.to_bits() & !BELOW) }
}

/// Two weights that four bytes hold each, whose sum is `weight` to 22 bits and not beyond it.
pub fn split(weight: f64) -> [f32; 2] {
    let held = |weight: f64| {
        let exact = weight.abs() * f64::from(SCALE);
        let near = exact as f32;
        let size = if f64::from(near) > exact { near.next_down() } else { near };
        (floor(size.min(BEYOND.next_down())) / SCALE).copysign(weight as f32)
    };
    let high = held(weight);
    [high, held(weight - f64::from(high))]
}

/// The weight itself, or its two neighbours that four bytes hold, the lower one first.
fn around(weight: f32) -> [f32; 2] {
    let size = weight.abs() * SCALE;
    let low = floor(size);
    let has_neighbours = size < BEYOND && low != size;
    if !has_neighbours {
        return [weight; 2];
    }
    let high = if low < LEAST_NORMAL { low + LEAST } else { f32::from_bits(low.to_bits() + BELOW + 1) };
    let [near, far] = [low, high].map(|size| (size / SCALE).copysign(weight));
    if weight > 0.0 { [near, far] } else { [far, near] }
}

/// Rounds weights to what four bytes hold. Each becomes one of its two neighbours, large ones first, so that what they
/// have gained or lost in all stays least (error diffusion); at the end the sum is not above that of before, and less
/// by no more than a step of the smallest weight in rows that have a few.
pub fn fold(row: &mut [(u32, f32)]) {
    let sum = |row: &[(u32, f32)]| row.iter().map(|entry| f64::from(entry.1)).sum::<f64>();
    let before = sum(row);
    let mut order: Vec<usize> = (0..row.len()).collect();
    order.sort_by(|&a, &b| row[b].1.abs().total_cmp(&row[a].1.abs()));
    let mut owed = 0.0;
    for &at in &order {
        let weight = f64::from(row[at].1);
        let left = |to: f32| owed + weight - f64::from(to);
        let [low, high] = around(row[at].1);
        row[at].1 = if left(low).abs() < left(high).abs() { low } else { high };
        owed = left(row[at].1);
    }
    if !before.is_finite() {
        return;
    }
    for &at in order.iter().rev() {
        if sum(row) <= before {
            return;
        }
        let lower = around(row[at].1.next_down())[0];
        // A share stays one: what has nothing left to give keeps it.
        if lower >= 0.0 || row[at].1 < 0.0 {
            row[at].1 = lower;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_packed_comes_back() {
        for half in 0..=0xffff_u32 {
            if half & 0x7c00 == 0x7c00 {
                continue; // infinite, or no number
            }
            let (column, weight) = unpack(half << 16 | 77);
            assert_eq!(column, 77);
            assert_eq!(pack(column, weight), Some(half << 16 | 77), "{weight}");
        }
        assert_eq!(unpack(pack(9, 0.5).unwrap()), (9, 0.5));
    }

    #[test]
    fn two_halves_hold_what_one_does_not() {
        for weight in [1.0 / 3.0, 1.0, -0.7, 1e-3, 1e-6, 0.0, -1.234_567_8e-2] {
            let halves = split(weight);
            assert!(halves.iter().all(|&half| pack(0, half).is_some()), "{weight}: {halves:?}");
            let sum = f64::from(halves[0]) + f64::from(halves[1]);
            assert!(
                sum.abs() <= weight.abs() && (weight - sum).abs() <= 3e-7 * weight.abs() + 2e-12,
                "{weight}: {sum}"
            );
        }
    }

    #[test]
    fn what_does_not_fit_is_not_packed() {
        for weight in [1.0 / 3.0, 2.0, -2.5, f32::NAN, f32::INFINITY, 1e-13, f32::MAX] {
            assert_eq!(pack(0, weight), None, "{weight}");
        }
        assert_eq!(pack(65536, 0.5), None);
        assert_eq!(pack(65535, 1.0).map(unpack), Some((65535, 1.0)));
        assert_eq!(pack_all(&[1, 2], &[0.5, 0.3]), None);
    }

    #[test]
    fn neighbours_are_held_and_stand_around() {
        for weight in [0.3_f32, -0.3, 1e-4, -1e-4, 3.33e-10, 1e-11, -1e-11, 1.999] {
            let [low, high] = around(weight);
            assert!(low < weight && weight < high, "{low} {weight} {high}");
            assert!(pack(0, low).is_some(), "{low}");
            assert!(high >= 2.0 || pack(0, high).is_some(), "{high}");
            assert!(high - low <= (weight.abs() * 1e-3).max(2e-12), "{low} {high}");
        }
        assert_eq!(around(0.25), [0.25; 2]);
        assert_eq!(around(0.0), [0.0; 2]);
    }

    /// A histogram of 2048 rays, and a lamp.
    fn row(seed: u32) -> Vec<(u32, f32)> {
        let count = |j: u32| (j.wrapping_mul(2_654_435_761).wrapping_add(seed.wrapping_mul(97)) >> 29) as f32;
        let mut row: Vec<(u32, f32)> =
            (0..500).map(|j| (j, count(j))).filter(|entry| entry.1 > 0.0).collect();
        let all: f32 = row.iter().map(|entry| entry.1).sum();
        row.iter_mut().for_each(|entry| entry.1 *= 0.9 / all);
        row.push((600, 0.0987 + seed as f32 * 1e-5));
        row
    }

    #[test]
    fn folded_rows_are_held_and_keep_their_sums() {
        let sum = |row: &[(u32, f32)]| row.iter().map(|entry| f64::from(entry.1)).sum::<f64>();
        for seed in 0..50 {
            let before = row(seed);
            let mut after = before.clone();
            fold(&mut after);
            let lost = sum(&before) - sum(&after);
            assert!((0.0..=5e-7).contains(&lost), "{seed}: {lost}"); // a step below 2^-10 is 2^-21
            for (a, b) in after.iter().zip(&before) {
                assert!(pack(a.0, a.1).is_some(), "{}", a.1);
                assert!((a.1 - b.1).abs() <= 2e-3 * b.1, "{} {}", a.1, b.1);
            }
            let again = after.clone();
            fold(&mut after);
            assert_eq!(after, again, "what is held stays");
        }
    }

    #[test]
    fn shares_stay_shares() {
        let mut row: Vec<(u32, f32)> = vec![(0, 0.0), (1, 1e-12), (2, 0.5), (3, 0.3)];
        let before: f64 = row.iter().map(|entry| f64::from(entry.1)).sum();
        fold(&mut row);
        let after: f64 = row.iter().map(|entry| f64::from(entry.1)).sum();
        assert!(row.iter().all(|entry| entry.1 >= 0.0), "{row:?}");
        assert!(after <= before, "{before} {after}");
    }

    #[test]
    fn signed_rows_keep_their_sums_too() {
        let mut row: Vec<(u32, f32)> = (0..200).map(|j| (j, ((j * 37 % 101) as f32 - 50.0) * 1e-4)).collect();
        let before: f64 = row.iter().map(|entry| f64::from(entry.1)).sum();
        fold(&mut row);
        let after: f64 = row.iter().map(|entry| f64::from(entry.1)).sum();
        assert!((0.0..=2e-7).contains(&(before - after)), "{before} {after}");
        assert!(row.iter().all(|entry| pack(entry.0, entry.1).is_some()));
    }

    #[test]
    fn what_four_bytes_cannot_hold_stays_as_it_is() {
        let mut row = vec![(0, 3.3_f32), (1, f32::NAN)];
        fold(&mut row);
        assert_eq!(row[0], (0, 3.3));
        assert!(row[1].1.is_nan());
        fold(&mut []);
    }
}
