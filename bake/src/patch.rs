//! Patches: connected groups of refined triangles, grown about seeds (Lloyd on the surface itself, so that
//! distance is measured along it and no group reaches through a wall).
//!
//! The same step merges the fine triangles of a statue and those of a divided wall. How many patches a piece
//! of surface gets is k = Int dA / h^2, whatever its triangles.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap, HashMap};

use engine::transport::Batch;
use glam::DVec3;
use rayon::prelude::*;

use crate::split::{Fine, Side};

/// Neighbours of refined triangles.
pub struct Links {
    /// By triangle and side: the triangle beyond it in the same entity, unless a cut lies between;
    /// `u32::MAX` for none.
    pub beyond: Vec<[u32; 3]>,
    /// By triangle and side: both ends have the same normal on both sides.
    pub smooth: Vec<[bool; 3]>,
}

pub fn links(fine: &Fine, batches: &[Batch]) -> Links {
    let place = |t: usize, k: usize| -> [u32; 3] {
        let corner = fine.triangles[t].corners[k % 3] as usize;
        (fine.corners[corner].position.as_vec3() + 0.0).to_array().map(f32::to_bits)
    };
    type Between = ([u32; 2], [u32; 3], [u32; 3]);
    let mut sides: HashMap<Between, (u32, u32)> = HashMap::with_capacity(fine.triangles.len() * 3);
    let side = |t: usize, k: usize| -> Between {
        (batches[fine.triangles[t].batch as usize].entity, place(t, k), place(t, k + 1))
    };
    for t in 0..fine.triangles.len() {
        for k in 0..3 {
            sides.entry(side(t, k)).and_modify(|side| side.1 += 1).or_insert(((t * 3 + k) as u32, 1));
        }
    }
    let only = |side: &Between| sides.get(side).filter(|(_, count)| *count == 1).map(|&(at, _)| at);
    let normal = |at: u32| {
        let corner = fine.triangles[at as usize / 3].corners[at as usize % 3];
        fine.corners[corner as usize].normal
    };
    let next = |at: u32| at - at % 3 + (at + 1) % 3;
    let mut links = Links { beyond: Vec::new(), smooth: Vec::new() };
    for (t, triangle) in fine.triangles.iter().enumerate() {
        let (mut beyond, mut smooth) = ([u32::MAX; 3], [false; 3]);
        for k in 0..3 {
            let here = side(t, k);
            let there = only(&here).and_then(|_| only(&(here.0, here.2, here.1)));
            let Some(there) = there.filter(|_| triangle.sides[k] != Side::Cut) else { continue };
            if fine.triangles[there as usize / 3].sides[there as usize % 3] == Side::Cut {
                continue;
            }
            beyond[k] = there / 3;
            let here = (t * 3 + k) as u32;
            let alike = |a: u32, b: u32| normal(a).dot(normal(b)) > 0.99;
            smooth[k] = alike(here, next(there)) && alike(next(here), there);
        }
        links.beyond.push(beyond);
        links.smooth.push(smooth);
    }
    links
}

/// Groups of triangles, each in one batch, in a fixed order.
pub fn group(fine: &Fine, links: &Links, length: f64) -> Vec<Vec<u32>> {
    let facts: Vec<Facts> = (0..fine.triangles.len()).map(|t| Facts::of(fine, t, length)).collect();
    let pieces = pieces(fine, links, &facts);
    let is_beside_a_gap = |t: &u32| fine.triangles[*t as usize].sides.contains(&Side::Smooth);
    let is_small = |piece: &Vec<u32>| share(&facts, piece) < 0.25 && !piece.iter().any(is_beside_a_gap);
    let (small, large): (Vec<_>, Vec<_>) = pieces.into_iter().partition(is_small);
    let mut groups: Vec<Vec<u32>> = large
        .par_iter()
        .flat_map_iter(|piece| {
            let k = (share(&facts, piece).round() as usize).clamp(1, piece.len());
            divide(piece, links, &facts, k)
        })
        .collect();
    // Bolts and leaves: whatever of a batch lies in one cell of the size of a patch.
    let mut cells: BTreeMap<(u32, [i64; 3]), Vec<u32>> = BTreeMap::new();
    for piece in small {
        let first = &facts[piece[0] as usize];
        let cell = (first.centre / first.size).floor().to_array().map(|x| x as i64);
        cells.entry((fine.triangles[piece[0] as usize].batch, cell)).or_default().extend(piece);
    }
    groups.extend(cells.into_values());
    for group in &mut groups {
        group.sort_unstable();
    }
    groups.sort_by_key(|group| (fine.triangles[group[0] as usize].batch, group[0]));
    groups
}

/// What the grouping asks of a triangle.
struct Facts {
    centre: DVec3,
    normal: DVec3,
    area: f64,
    /// The length of patches here.
    size: f64,
}

impl Facts {
    fn of(fine: &Fine, t: usize, length: f64) -> Self {
        let corners = fine.triangles[t].corners.map(|corner| fine.corners[corner as usize]);
        let [a, b, c] = corners.map(|corner| corner.position);
        let cross = (b - a).cross(c - a);
        let density = f64::from(corners.iter().map(|corner| corner.density).sum::<f32>() / 3.0);
        let size = length / density.max(1e-3);
        Self {
            centre: (a + b + c) / 3.0,
            normal: cross.normalize_or_zero(),
            area: cross.length() * 0.5,
            size,
        }
    }
}

/// How many patches a piece is worth.
fn share(facts: &[Facts], piece: &[u32]) -> f64 {
    piece.iter().map(|&t| &facts[t as usize]).map(|f| f.area / (f.size * f.size)).sum()
}

/// Connected triangles of one batch without sharp edges between them. Edges between triangles that are far
/// smaller than a patch do not count as sharp.
fn pieces(fine: &Fine, links: &Links, facts: &[Facts]) -> Vec<Vec<u32>> {
    let tiny = |t: u32| facts[t as usize].area < 0.05 * facts[t as usize].size.powi(2);
    let joined = |a: u32, b: u32| {
        let turn = facts[a as usize].normal.dot(facts[b as usize].normal);
        fine.triangles[a as usize].batch == fine.triangles[b as usize].batch
            && (turn > 0.8
                || (turn > 0.3 && tiny(a) && tiny(b) && fine.triangles[a as usize].sides == [Side::Open; 3]))
    };
    let mut seen = vec![false; facts.len()];
    let mut pieces = Vec::new();
    for start in 0..facts.len() as u32 {
        if std::mem::replace(&mut seen[start as usize], true) {
            continue;
        }
        let mut piece = vec![start];
        let mut next = 0;
        while next < piece.len() {
            let t = piece[next];
            let sides = fine.triangles[t as usize].sides;
            let open =
                links.beyond[t as usize].into_iter().zip(sides).filter(|(_, side)| *side == Side::Open);
            for other in open.map(|(other, _)| other).filter(|&other| other != u32::MAX) {
                if !seen[other as usize] && joined(t, other) {
                    seen[other as usize] = true;
                    piece.push(other);
                }
            }
            next += 1;
        }
        piece.sort_unstable();
        pieces.push(piece);
    }
    pieces
}

#[derive(PartialEq)]
struct Distance(f64);

impl Eq for Distance {}

impl PartialOrd for Distance {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Distance {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

/// Divides a connected piece into k groups: nearest seed along the surface, seeds moved to the middle of their
/// group, a few times.
fn divide(piece: &[u32], links: &Links, facts: &[Facts], k: usize) -> Vec<Vec<u32>> {
    if k == 1 {
        return vec![piece.to_vec()];
    }
    let mut seeds = first_seeds(piece, facts, k);
    let mut groups = Vec::new();
    for _ in 0..8 {
        groups = grow(piece, links, facts, &seeds);
        let moved: Vec<u32> = groups.iter().map(|group| middle(group, facts)).collect();
        if moved == seeds {
            break;
        }
        seeds = moved;
    }
    groups
}

/// Evenly along a Morton curve through the piece, by how many patches its surface is worth.
fn first_seeds(piece: &[u32], facts: &[Facts], k: usize) -> Vec<u32> {
    let low = piece.iter().fold(DVec3::INFINITY, |low, &t| low.min(facts[t as usize].centre));
    let high = piece.iter().fold(DVec3::NEG_INFINITY, |high, &t| high.max(facts[t as usize].centre));
    let extent = (high - low).max_element().max(1e-12);
    let mut order: Vec<(u64, u32)> =
        piece.iter().map(|&t| (morton((facts[t as usize].centre - low) / extent), t)).collect();
    order.sort_unstable();
    let total = share(facts, piece);
    let (mut sum, mut seeds) = (0.0, Vec::with_capacity(k));
    for (i, &(_, t)) in order.iter().enumerate() {
        let f = &facts[t as usize];
        sum += f.area / (f.size * f.size);
        let wanted = k - seeds.len();
        if wanted > 0 && (sum >= total * (seeds.len() as f64 + 0.5) / k as f64 || order.len() - i == wanted) {
            seeds.push(t);
        }
    }
    seeds
}

fn morton(p: DVec3) -> u64 {
    let spread = |x: f64| {
        let x = (x.clamp(0.0, 1.0) * 65535.0) as u64;
        (0..16).fold(0, |bits, bit| bits | (x >> bit & 1) << (3 * bit))
    };
    spread(p.x) | spread(p.y) << 1 | spread(p.z) << 2
}

fn grow(piece: &[u32], links: &Links, facts: &[Facts], seeds: &[u32]) -> Vec<Vec<u32>> {
    let local: HashMap<u32, usize> = piece.iter().enumerate().map(|(i, &t)| (t, i)).collect();
    let mut owner = vec![usize::MAX; piece.len()];
    let mut queue: BinaryHeap<Reverse<(Distance, u32, usize)>> =
        seeds.iter().enumerate().map(|(seed, &t)| Reverse((Distance(0.0), t, seed))).collect();
    let mut groups = vec![Vec::new(); seeds.len()];
    while let Some(Reverse((Distance(distance), t, seed))) = queue.pop() {
        let at = local[&t];
        if owner[at] != usize::MAX {
            continue;
        }
        owner[at] = seed;
        groups[seed].push(t);
        let (here, middle) = (&facts[t as usize], &facts[seeds[seed] as usize]);
        for other in links.beyond[t as usize] {
            let Some(&next) = local.get(&other) else { continue };
            if owner[next] == usize::MAX {
                let there = &facts[other as usize];
                // At least the straight way from the seed, so that groups are round and not angular.
                let way = (distance + 0.1 * here.centre.distance(there.centre) / here.size)
                    .max(middle.centre.distance(there.centre) / here.size);
                let turn = 1.0 - middle.normal.dot(there.normal);
                queue.push(Reverse((Distance(way + 0.02 * turn), other, seed)));
            }
        }
    }
    groups
}

/// The triangle nearest to the middle of a group.
fn middle(group: &[u32], facts: &[Facts]) -> u32 {
    let area: f64 = group.iter().map(|&t| facts[t as usize].area).sum();
    let centre =
        group.iter().map(|&t| facts[t as usize].centre * facts[t as usize].area).sum::<DVec3>() / area;
    let nearest = group.iter().min_by(|&&a, &&b| {
        let [a_far, b_far] = [a, b].map(|t| facts[t as usize].centre.distance_squared(centre));
        a_far.total_cmp(&b_far).then(a.cmp(&b))
    });
    *nearest.unwrap_or(&group[0])
}
