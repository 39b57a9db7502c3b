//! Form factors from hits: both directions pooled, then made to close again.
//!
//! ```text
//! S_ij = (h_ij + h_ji) / (R/A_i + R/A_j)          pooled by inverse variance; symmetric
//! X_ij = S_ij (1 + f_ij (l_i + l_j))               least squares: (diag(V 1 + s) + V) l = A - S 1 - s
//! ```
//! with V = f S, f = 1 for what chance found and almost 0 for what was sampled towards, and s what a row sends to
//! the sky or loses. Then symmetric scaling, X_ij d_i d_j, finishes (Sinkhorn and Knopp 1967). Reciprocity
//! without closure diverges, closure without reciprocity loses energy; this keeps both.

use engine::transport::Rows;
use rayon::prelude::*;

use crate::emitter::Emitters;
use crate::form_factors::known::Known;
use crate::rays::Hits;
use crate::{BakeError, Watcher};

/// What balancing found and did.
#[derive(Clone, Copy, Debug, Default)]
pub struct Balance {
    /// max |row sum - 1| before, of what both directions pooled say.
    pub defect_raw: f64,
    /// max |row sum - 1| of the f64 matrix after.
    pub defect: f64,
}

/// By row: columns ascending and values, f64; symmetric.
struct Symmetric {
    starts: Vec<usize>,
    columns: Vec<u32>,
    values: Vec<f64>,
    /// How freely least squares may change an entry, times the entry.
    free: Vec<f32>,
    /// By row: to each sky patch, and what is lost or leaves, in area.
    sky: Vec<Vec<(u32, f64)>>,
    lost: Vec<f64>,
}

/// How much of its own size an entry that was sampled towards may change by, against one left to chance.
const SAMPLED_FREEDOM: f32 = 1e-2;

/// `towards`: by patch, its shares towards emitters (empty for emitters themselves); `known`: by patch, entries
/// that stand in for both chance and those. Returns the stored rows,
/// columns patches then sky, and by patch its target 1 - lost.
pub fn balanced_rows(
    hits: &Hits,
    rays: u32,
    areas: &[f64],
    emitters: &Emitters,
    towards: &[Vec<(u32, f64)>],
    known: &[Vec<Known>],
    watcher: &dyn Watcher,
) -> Result<(Rows, Vec<f32>, Balance), BakeError> {
    let mut pooled = pool(hits, rays, areas, emitters, towards);
    replace(&mut pooled, known);
    let mut balance = Balance { defect_raw: defect(&pooled, areas), ..Balance::default() };
    blacken(&mut pooled, areas, |i| f64::from(hits.lost[i]) > 0.999 * f64::from(rays));
    for _ in 0..8 {
        least_squares(&mut pooled, areas, watcher);
        let closes = scale(&mut pooled, areas, 16, watcher);
        if watcher.cancelled() {
            return Err(BakeError::Cancelled);
        }
        if closes {
            break;
        }
    }
    balance.defect = defect(&pooled, areas);
    let kept = |i: usize| match 1.0 - pooled.lost[i] / areas[i] {
        // The difference has no digits left: the sum of the little there is has.
        kept if kept < 1e-3 => (pooled.light(i) / areas[i]).min(1e-3),
        kept => kept.min(1.0),
    };
    let targets: Vec<f32> = (0..areas.len()).map(|i| kept(i) as f32).collect();
    Ok((store(&pooled, areas, &targets), targets, balance))
}

impl Symmetric {
    fn fill(&mut self, rows: Vec<Vec<(u32, f64, f32)>>) {
        self.starts = vec![0];
        self.columns.clear();
        self.values.clear();
        self.free.clear();
        for row in rows {
            for (j, value, free) in row {
                self.columns.push(j);
                self.values.push(value);
                self.free.push(free);
            }
            self.starts.push(self.columns.len());
        }
    }

    fn range(&self, i: usize) -> std::ops::Range<usize> {
        self.starts[i]..self.starts[i + 1]
    }

    fn sum(&self, i: usize) -> f64 {
        self.values[self.range(i)].iter().sum::<f64>() + self.slack(i)
    }

    /// The sum without what is lost.
    fn light(&self, i: usize) -> f64 {
        let sky = self.sky[i].iter().map(|sky| sky.1).sum::<f64>();
        self.values[self.range(i)].iter().sum::<f64>() + sky
    }

    /// To the sky and lost.
    fn slack(&self, i: usize) -> f64 {
        self.sky[i].iter().map(|sky| sky.1).sum::<f64>() + self.lost[i]
    }
}

fn pool(
    hits: &Hits,
    rays: u32,
    areas: &[f64],
    emitters: &Emitters,
    towards: &[Vec<(u32, f64)>],
) -> Symmetric {
    let n = areas.len();
    let by_chance = |i: usize, j: u32| emitters.is_emitter[i] == emitters.is_emitter[j as usize];
    let backwards = Transposed::new(n, |i| {
        hits.row(i).take_while(|&(j, _)| (j as usize) < n).filter(move |&(j, _)| by_chance(i, j))
    });
    let towards_backwards = Transposed::new(n, |i| towards[i].iter().map(|&(j, share)| (j, share)));
    let rays = f64::from(rays);
    let rows: Vec<Vec<(u32, f64, f32)>> = (0..n)
        .into_par_iter()
        .map(|i| {
            let mut row: Vec<(u32, f64, f32)> = Vec::new();
            let own = hits.row(i).take_while(|&(j, _)| (j as usize) < n).filter(|&(j, _)| by_chance(i, j));
            merge(own, backwards.row(i), |j, there, back| {
                let hits = f64::from(there.unwrap_or(0)) + f64::from(back.unwrap_or(0));
                row.push((j, hits / (rays / areas[i] + rays / areas[j as usize]), 1.0));
            });
            row.extend(towards[i].iter().map(|&(j, share)| (j, areas[i] * share, SAMPLED_FREEDOM)));
            row.extend(
                towards_backwards.row(i).map(|(j, share)| (j, areas[j as usize] * share, SAMPLED_FREEDOM)),
            );
            row.sort_unstable_by_key(|entry| entry.0);
            row
        })
        .collect();
    let mut symmetric = Symmetric {
        starts: vec![0],
        columns: Vec::new(),
        values: Vec::new(),
        free: Vec::new(),
        sky: Vec::new(),
        lost: (0..n).map(|i| areas[i] * f64::from(hits.lost[i] + hits.escaped[i]) / rays).collect(),
    };
    symmetric.fill(rows);
    for (i, area) in areas.iter().enumerate() {
        let sky = hits.row(i).filter(|&(j, _)| j as usize >= n);
        symmetric.sky.push(sky.map(|(j, count)| (j, area * f64::from(count) / rays)).collect());
    }
    symmetric
}

/// Known entries take the places of others.
fn replace(x: &mut Symmetric, known: &[Vec<Known>]) {
    let n = x.lost.len();
    let rows: Vec<Vec<(u32, f64, f32)>> = (0..n)
        .into_par_iter()
        .map(|i| {
            let kept = x.range(i).map(|k| (x.columns[k], (x.values[k], x.free[k])));
            let known = known[i].iter().map(|known| (known.column, (known.exchange, known.freedom)));
            let mut row = Vec::with_capacity(x.range(i).len() + known.len());
            merge(kept, known, |j, kept, known| {
                row.extend(
                    known.or(kept).filter(|entry| entry.0 > 0.0).map(|(value, free)| (j, value, free)),
                );
            });
            row
        })
        .collect();
    x.fill(rows);
}

/// The same entries by column.
struct Transposed<T> {
    starts: Vec<usize>,
    entries: Vec<(u32, T)>,
}

impl<T: Copy + Default> Transposed<T> {
    fn new<I: Iterator<Item = (u32, T)>>(n: usize, row: impl Fn(usize) -> I) -> Self {
        let mut starts = vec![0; n + 1];
        for i in 0..n {
            row(i).for_each(|(j, _)| starts[j as usize + 1] += 1);
        }
        for j in 0..n {
            starts[j + 1] += starts[j];
        }
        let mut at = starts.clone();
        let mut entries = vec![(0, T::default()); starts[n]];
        for i in 0..n {
            for (j, value) in row(i) {
                entries[at[j as usize]] = (i as u32, value);
                at[j as usize] += 1;
            }
        }
        Self { starts, entries }
    }

    fn row(&self, j: usize) -> impl Iterator<Item = (u32, T)> + '_ {
        self.entries[self.starts[j]..self.starts[j + 1]].iter().copied()
    }
}

/// Two ascending rows, side by side.
fn merge<T>(
    a: impl Iterator<Item = (u32, T)>,
    b: impl Iterator<Item = (u32, T)>,
    mut each: impl FnMut(u32, Option<T>, Option<T>),
) {
    let (mut a, mut b) = (a.peekable(), b.peekable());
    loop {
        match (a.peek().map(|a| a.0), b.peek().map(|b| b.0)) {
            (None, None) => return,
            (Some(i), Some(j)) if i == j => each(i, a.next().map(|a| a.1), b.next().map(|b| b.1)),
            (Some(i), j) if j.is_none_or(|j| i < j) => each(i, a.next().map(|a| a.1), None),
            (_, Some(j)) => each(j, None, b.next().map(|b| b.1)),
            (Some(_), None) => unreachable!("the arm before takes it"),
        }
    }
}

/// Patches inside a solid, which see almost nothing but back faces, reflect nothing and are seen by nobody. One
/// whose light leaves the scene instead may still be most of what a small patch sees.
fn blacken(x: &mut Symmetric, areas: &[f64], is_inside: impl Fn(usize) -> bool) {
    let black: Vec<bool> = (0..areas.len()).map(is_inside).collect();
    for i in 0..areas.len() {
        for k in x.range(i) {
            if black[i] || black[x.columns[k] as usize] {
                x.values[k] = 0.0;
            }
        }
        if black[i] {
            x.sky[i].clear();
            x.lost[i] = areas[i];
        }
    }
}

fn defect(x: &Symmetric, areas: &[f64]) -> f64 {
    (0..areas.len()).into_par_iter().map(|i| (x.sum(i) / areas[i] - 1.0).abs()).reduce(|| 0.0, f64::max)
}

fn least_squares(x: &mut Symmetric, areas: &[f64], watcher: &dyn Watcher) {
    let n = areas.len();
    let diagonal: Vec<f64> = (0..n)
        .into_par_iter()
        .map(|i| x.range(i).map(|k| x.values[k] * f64::from(x.free[k])).sum::<f64>() + x.slack(i))
        .collect();
    let rhs: Vec<f64> = (0..n).into_par_iter().map(|i| areas[i] - x.sum(i)).collect();
    let apply = |l: &[f64]| -> Vec<f64> {
        let row = |i: usize| -> f64 {
            x.range(i).map(|k| x.values[k] * f64::from(x.free[k]) * l[x.columns[k] as usize]).sum()
        };
        (0..n).into_par_iter().map(|i| diagonal[i] * l[i] + row(i)).collect()
    };
    let l = gradients(apply, &rhs, &diagonal, watcher);
    // A multiplier near zero or below would not be a share of light any more: leave it all to the scaling.
    let least = (0..n)
        .flat_map(|i| x.range(i).map(move |k| (i, k)))
        .map(|(i, k)| 1.0 + f64::from(x.free[k]) * (l[i] + l[x.columns[k] as usize]))
        .fold(f64::INFINITY, f64::min);
    if least < 0.1 || (0..n).any(|i| x.slack(i) > 0.0 && 1.0 + l[i] < 0.1) {
        return;
    }
    for i in 0..n {
        for k in x.range(i) {
            x.values[k] *= 1.0 + f64::from(x.free[k]) * (l[i] + l[x.columns[k] as usize]);
        }
        x.sky[i].iter_mut().for_each(|sky| sky.1 *= 1.0 + l[i]);
        x.lost[i] *= 1.0 + l[i];
    }
}

/// Conjugate gradients with the diagonal as preconditioner.
fn gradients(
    apply: impl Fn(&[f64]) -> Vec<f64>,
    rhs: &[f64],
    diagonal: &[f64],
    watcher: &dyn Watcher,
) -> Vec<f64> {
    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let precondition = |r: &[f64]| -> Vec<f64> {
        r.iter().zip(diagonal).map(|(r, d)| if *d > 0.0 { r / d } else { 0.0 }).collect()
    };
    let mut x = vec![0.0; rhs.len()];
    let mut r = rhs.to_vec();
    let mut z = precondition(&r);
    let mut p = z.clone();
    let mut rz = dot(&r, &z);
    let stop = 1e-24 * rz;
    for _ in 0..100 {
        if rz <= stop || rz == 0.0 || watcher.cancelled() {
            break;
        }
        let ap = apply(&p);
        let curvature = dot(&p, &ap);
        if curvature <= 0.0 {
            break;
        }
        let step = rz / curvature;
        for i in 0..x.len() {
            x[i] += step * p[i];
            r[i] -= step * ap[i];
        }
        z = precondition(&r);
        let next = dot(&r, &z);
        let keep = next / rz;
        rz = next;
        p.iter_mut().zip(&z).for_each(|(p, z)| *p = z + keep * *p);
    }
    x
}

/// Symmetric diagonal scaling until every row closes to 1e-10; false where that takes more sweeps than these.
fn scale(x: &mut Symmetric, areas: &[f64], sweeps: usize, watcher: &dyn Watcher) -> bool {
    let n = areas.len();
    for _ in 0..sweeps {
        let sums: Vec<f64> = (0..n).into_par_iter().map(|i| x.sum(i)).collect();
        let worst = (0..n).map(|i| (sums[i] / areas[i] - 1.0).abs()).fold(0.0, f64::max);
        if worst < 1e-10 {
            return true;
        }
        if watcher.cancelled() {
            return false;
        }
        let d: Vec<f64> =
            (0..n).map(|i| if sums[i] > 0.0 { (areas[i] / sums[i]).sqrt() } else { 1.0 }).collect();
        let (starts, columns) = (&x.starts, &x.columns);
        let mut rest = x.values.as_mut_slice();
        let mut rows = Vec::with_capacity(n);
        for i in 0..n {
            let (row, after) = rest.split_at_mut(starts[i + 1] - starts[i]);
            rows.push((i, row));
            rest = after;
        }
        rows.into_par_iter().for_each(|(i, row)| {
            let columns = &columns[starts[i]..];
            row.iter_mut().zip(columns).for_each(|(value, &j)| *value *= d[i] * d[j as usize]);
        });
        for ((sky, lost), d) in x.sky.iter_mut().zip(&mut x.lost).zip(&d) {
            sky.iter_mut().for_each(|sky| sky.1 *= d * d);
            *lost *= d * d;
        }
    }
    false
}

/// f32 shares whose f64 sum is at most the target, by lowering the largest one. What a row still lacks stays with the
/// patch itself: the diagonal is as symmetric as the rest, and no energy comes or goes. Mostly that is what floats round
/// off, 1e-8, which a closed room of albedo 0.999999 would otherwise show as a hundredth of its light; where balancing
/// did not end (plates that hardly part, a handful of hits) it is more.
fn store(x: &Symmetric, areas: &[f64], targets: &[f32]) -> Rows {
    let fullest = (0..areas.len()).map(|i| x.sum(i) / areas[i]).fold(1.0, f64::max);
    let finished: Vec<Vec<(u32, f32)>> = (0..areas.len())
        .into_par_iter()
        .map(|i| {
            let patches = x.range(i).map(|k| (x.columns[k], x.values[k]));
            let entries = patches.chain(x.sky[i].iter().copied());
            let mut row: Vec<(u32, f32)> = entries
                .map(|(j, value)| (j, (value / (areas[i] * fullest)) as f32))
                .filter(|entry| entry.1 > 0.0)
                .collect();
            cap(&mut row, f64::from(targets[i]));
            keep_lack(&mut row, i as u32, f64::from(targets[i]));
            cap(&mut row, f64::from(targets[i]));
            row
        })
        .collect();
    let mut rows = Rows::default();
    finished.into_iter().for_each(|row| rows.push(row));
    rows
}

fn keep_lack(row: &mut Vec<(u32, f32)>, own: u32, target: f64) {
    let lack = target - row.iter().map(|entry| f64::from(entry.1)).sum::<f64>();
    // Less than the sum itself may be rounded by.
    if lack <= 1e-12 {
        return;
    }
    let at = row.binary_search_by_key(&own, |entry| entry.0).unwrap_or_else(|at| {
        row.insert(at, (own, 0.0));
        at
    });
    // Not quite all: added up again, the row may come out higher by what sums are rounded by.
    // A little of what floats round off is left, so that the sum does not pass its target; of what is more, no more.
    row[at].1 = below(f64::from(row[at].1) + lack - 1e-3 * lack.min(1e-8));
}

/// The largest float that is not above.
fn below(value: f64) -> f32 {
    let nearest = value as f32;
    if f64::from(nearest) > value { nearest.next_down() } else { nearest }
}

/// Lowers the largest weight until the f64 sum of the row is at most its target.
pub fn cap(row: &mut [(u32, f32)], target: f64) {
    for _ in 0..64 {
        let sum: f64 = row.iter().map(|entry| f64::from(entry.1)).sum();
        let Some(largest) = row.iter_mut().max_by(|a, b| a.1.total_cmp(&b.1)) else { return };
        if sum <= target {
            return;
        }
        let lowered = (f64::from(largest.1) - (sum - target)).max(0.0) as f32;
        largest.1 = if lowered < largest.1 { lowered } else { largest.1.next_down().max(0.0) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_keeps_what_it_lacks_however_much_it_is() {
        for lack in [1e-3, 1e-5, 1e-8, 1e-9] {
            let mut row: Vec<(u32, f32)> = (0..1000).map(|j| (j, (1e-3 * (1.0 - lack)) as f32)).collect();
            keep_lack(&mut row, 500, 1.0);
            cap(&mut row, 1.0);
            let left = 1.0 - row.iter().map(|entry| f64::from(entry.1)).sum::<f64>();
            assert!((0.0..=1e-9).contains(&left), "{lack}: {left}");
        }
    }

    #[test]
    fn a_row_is_capped_from_above_and_hardly() {
        let mut row: Vec<(u32, f32)> = (0..1000).map(|j| (j, 1.0 / 999.9995)).collect();
        cap(&mut row, 1.0);
        let sum: f64 = row.iter().map(|entry| f64::from(entry.1)).sum();
        assert!((1.0 - 2e-7..=1.0).contains(&sum), "{sum}");
    }
}
