//! Components (what can exchange light) and aggregates (room-sized groups, for the coarse correction).

use std::collections::BTreeMap;

use engine::transport::{NONE, Patch, Rows};
use glam::Vec3;

/// Sets `component` and `aggregate` of every patch.
pub fn mark(patches: &mut [Patch], rows: &Rows) {
    components(patches, rows);
    aggregates(patches, rows);
}

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
    let wanted = (patches.len() / 64).clamp(8, 64);
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
        let k = share.clamp(1, (members.len() / 8).max(1)).min(64 - next);
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
