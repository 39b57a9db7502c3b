//! Components (what can exchange light) and aggregates (room-sized groups, for the coarse correction).
//!
//! Aggregates are cut by where things are, then by what sees what, and then tried: light that lingers in spite of the
//! correction shows where a group is missing (as in adaptive multigrid: Brezina et al. 2005).

use std::collections::BTreeMap;

use engine::transport::solve::{Channel, Method, Stop, solve};
use engine::transport::{NONE, Patch, Rows};
use glam::Vec3;

use crate::Watcher;

/// Sets `component` and `aggregate` of every patch. A bake that is told to stop has them untried.
pub fn mark(patches: &mut [Patch], rows: &Rows, watcher: &dyn Watcher) {
    components(patches, rows);
    aggregates(patches, rows);
    (0..ROUNDS).all(|_| !watcher.cancelled() && part_where_light_lingers(patches, rows));
    renumber(patches);
}

/// How often aggregates are tried and parted at most.
const ROUNDS: usize = 12;
/// Share of the error that a product may leave at the albedo that aggregates are made for.
const LEAVES: f64 = 0.6;
const ALBEDO: f64 = 0.99;
/// Aggregates in all: one workgroup solves for them.
const MOST: usize = 64;

fn components(patches: &mut [Patch], rows: &Rows) {
    let n = patches.len();
    let mut parent: Vec<u32> = (0..n as u32).collect();
    fn root(parent: &mut [u32], mut at: u32) -> u32 {
        while parent[at as usize] != at {
            parent[at as usize] = parent[parent[at as usize] as usize];
            at = parent[at as usize];
        }
        at
    }
    for i in 0..n {
        for (j, _) in rows.row(i).take_while(|&(j, _)| (j as usize) < n) {
            let (a, b) = (root(&mut parent, i as u32), root(&mut parent, j));
            parent[a.max(b) as usize] = a.min(b);
        }
    }
    let mut numbers = BTreeMap::new();
    for i in 0..n as u32 {
        let next = numbers.len() as u32;
        patches[i as usize].component = *numbers.entry(root(&mut parent, i)).or_insert(next);
    }
}

/// 8 to 64 in all, by area: each component gets its share, as clusters in space (Lloyd) that then follow the
/// strongest coupling, so that a wall between two rooms parts them.
fn aggregates(patches: &mut [Patch], rows: &Rows) {
    let total: f64 = patches.iter().map(|patch| f64::from(patch.area)).sum();
    let wanted = (patches.len() / 64).clamp(8, MOST);
    let mut members: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    patches.iter().enumerate().for_each(|(i, patch)| members.entry(patch.component).or_default().push(i));
    let mut by_area: Vec<(f64, Vec<usize>)> = members
        .into_values()
        .map(|members| (members.iter().map(|&i| f64::from(patches[i].area)).sum(), members))
        .collect();
    by_area.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1[0].cmp(&b.1[0])));
    let mut next = 0;
    for (area, members) in by_area {
        let share = (wanted as f64 * area / total).round() as usize;
        let k = share.clamp(1, (members.len() / 8).max(1)).min(MOST - next);
        if k == 0 || members.len() < 2 {
            continue; // no room left, or nothing to correct
        }
        let labels = cluster(patches, &members, k);
        for (&i, label) in members.iter().zip(labels) {
            patches[i].aggregate = next as u32 + label;
        }
        next += k;
    }
    (0..4).for_each(|_| follow_coupling(patches, rows, next));
    renumber(patches);
}

/// Parts the aggregates in which the most is left of an error after some products: a pocket under a table, a niche
/// behind a door are even in themselves, but not even with the room that they were counted to. Returns whether
/// something was parted.
fn part_where_light_lingers(patches: &mut [Patch], rows: &Rows) -> bool {
    let m = patches.iter().filter(|patch| patch.aggregate != NONE).map(|patch| patch.aggregate + 1).max();
    let m = m.unwrap_or(0) as usize;
    // The correction reads m numbers a patch: a quarter of what a product reads.
    let most = (rows.entries() / (4 * patches.len()).max(1)).min(MOST);
    if m == 0 || m >= most {
        return false;
    }
    let (left, leaves) = lingering(patches, rows);
    if leaves <= LEAVES {
        return false;
    }
    let mut ranges = vec![[f64::INFINITY, f64::NEG_INFINITY]; m];
    for (patch, left) in patches.iter().zip(&left).filter(|(patch, _)| patch.aggregate != NONE) {
        let [low, high] = &mut ranges[patch.aggregate as usize];
        (*low, *high) = (low.min(*left), high.max(*left));
    }
    let spread = |a: &usize| ranges[*a][1] - ranges[*a][0];
    let mut uneven: Vec<usize> = (0..m).collect();
    uneven.sort_by(|a, b| spread(b).total_cmp(&spread(a)));
    let limit = 0.5 * spread(&uneven[0]);
    uneven.retain(|a| spread(a) > 0.0 && spread(a) >= limit);
    for (new, a) in uneven.iter().take(most - m).enumerate() {
        let middle = 0.5 * (ranges[*a][0] + ranges[*a][1]);
        let members = patches.iter_mut().zip(&left).filter(|(patch, _)| patch.aggregate as usize == *a);
        let above = members.filter(|(_, left)| **left > middle);
        above.for_each(|(patch, _)| patch.aggregate = (m + new) as u32);
    }
    !uneven.is_empty()
}

/// What two-level Jacobi leaves of an error of random signs, and the share of it that a product leaves in the end.
fn lingering(patches: &[Patch], rows: &Rows) -> (Vec<f64>, f64) {
    const PRODUCTS: usize = 20;
    let channel = Channel::new(rows, patches, patches.iter().map(|_| ALBEDO));
    let sign = |i: usize| if (i as u32).wrapping_mul(0x9E37_79B9) >> 31 == 0 { 1.0 } else { -1.0 };
    let wanted: Vec<f64> = (0..patches.len()).map(sign).collect();
    let mut e = vec![0.0; wanted.len()];
    channel.matrix.apply(&wanted, &mut e);
    let (mut left, mut sizes) = (wanted.clone(), Vec::new());
    let stop = Stop::at(0.0, PRODUCTS as f64);
    solve(Method::TwoLevel, &channel, &e, Some(&vec![0.0; wanted.len()]), &stop, &mut |iterate| {
        left.iter_mut().zip(&wanted).zip(iterate.b).for_each(|((left, wanted), b)| *left = wanted - b);
        sizes.push(left.iter().fold(0.0_f64, |max, left| max.max(left.abs())));
    });
    let (last, before) = (sizes.len() - 1, sizes.len().saturating_sub(5));
    let leaves = (sizes[last] / sizes[before]).powf(1.0 / (last - before).max(1) as f64);
    // Where nothing is left there is nothing to part.
    (left, if leaves.is_finite() { leaves } else { 0.0 })
}

fn cluster(patches: &[Patch], members: &[usize], k: usize) -> Vec<u32> {
    // Seeds: each the farthest from those before it.
    let mut seeds = vec![patches[members[0]].centre];
    let mut far: Vec<f32> = members.iter().map(|&i| patches[i].centre.distance_squared(seeds[0])).collect();
    while seeds.len() < k {
        let farthest =
            (0..members.len()).max_by(|&a, &b| far[a].total_cmp(&far[b]).then(b.cmp(&a))).unwrap_or(0);
        let seed = patches[members[farthest]].centre;
        seeds.push(seed);
        for (far, &i) in far.iter_mut().zip(members) {
            *far = far.min(patches[i].centre.distance_squared(seed));
        }
    }
    let mut labels = vec![0; members.len()];
    for _ in 0..8 {
        let mut sums = vec![(Vec3::ZERO, 0.0); k];
        for (label, &i) in labels.iter_mut().zip(members) {
            let at = patches[i].centre;
            let nearest = (0..k)
                .min_by(|&a, &b| at.distance_squared(seeds[a]).total_cmp(&at.distance_squared(seeds[b])));
            *label = nearest.unwrap_or(0) as u32;
            let (sum, area) = &mut sums[*label as usize];
            *sum += at * patches[i].area;
            *area += patches[i].area;
        }
        for (seed, (sum, area)) in seeds.iter_mut().zip(sums) {
            if area > 0.0 {
                *seed = sum / area;
            }
        }
    }
    labels
}

/// Each patch joins the aggregate that most of its light comes from, if that beats its own clearly.
fn follow_coupling(patches: &mut [Patch], rows: &Rows, m: usize) {
    let n = patches.len();
    let before: Vec<u32> = patches.iter().map(|patch| patch.aggregate).collect();
    let mut sums = vec![0.0_f32; m];
    for i in 0..n {
        if before[i] == NONE {
            continue;
        }
        sums.fill(0.0);
        for (j, weight) in rows.row(i).take_while(|&(j, _)| (j as usize) < n) {
            if before[j as usize] != NONE {
                sums[before[j as usize] as usize] += weight;
            }
        }
        let best = (0..m).max_by(|&a, &b| sums[a].total_cmp(&sums[b]).then(b.cmp(&a))).unwrap_or(0);
        // A flat wall sees nothing of its own surroundings: it stays where it is unless another room calls.
        if sums[before[i] as usize] < 0.05 && sums[best] > 0.3 {
            patches[i].aggregate = best as u32;
        }
    }
}

/// Aggregates without gaps, in the order of their first patch.
fn renumber(patches: &mut [Patch]) {
    let mut numbers = BTreeMap::new();
    for patch in patches.iter_mut().filter(|patch| patch.aggregate != NONE) {
        let next = numbers.len() as u32;
        patch.aggregate = *numbers.entry(patch.aggregate).or_insert(next);
    }
}
