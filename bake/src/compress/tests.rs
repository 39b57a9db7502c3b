use engine::transport::Patch;
use engine::transport::tree::Node;
use glam::Vec3;

use super::*;
use crate::directions::{hash, unit};

/// Two square walls of n x n patches that meet, and three sky patches.
fn walls(n: usize) -> Transport {
    let mut transport = Transport { sky_patches: 3, ..Transport::default() };
    for (batch, normal) in [(0, Vec3::Y), (1, Vec3::X)] {
        for k in 0..n * n {
            let (u, v) = ((k % n) as f32 + 0.5, (k / n) as f32 + 0.5);
            let centre = if batch == 0 { Vec3::new(u, 0.0, v) } else { Vec3::new(0.0, u, v) };
            let area = 1.0 + 0.5 * random(k as u64) as f32;
            transport.patches.push(Patch { centre, normal, batch, area, ..Patch::default() });
        }
    }
    transport
}

/// In [0, 1).
fn random(seed: u64) -> f64 {
    f64::from(unit(hash(seed) as u32))
}

/// Rows that see all patches and the sky, some more and some less, and sum to 1 or so.
fn rows(transport: &Transport, count: u64, holes: bool) -> Rows {
    let mut rows = Rows::default();
    for row in 0..count {
        let columns = transport.columns() as u64;
        let seen = (0..columns).filter(|j| !holes || random(row * 31 + j * 7) > 0.4);
        let weight = |j: u64| (0.2 + random(row * 1009 + j)) / columns as f64;
        rows.push(seen.map(|j| (j as u32, weight(j) as f32)));
    }
    rows
}

fn light(transport: &Transport, seed: u64) -> Vec<DVec3> {
    let of = |j: u64| DVec3::new(random(seed + 3 * j), random(seed + 3 * j + 1), random(seed + 3 * j + 2));
    (0..transport.columns() as u64).map(of).collect()
}

fn single(transport: &Transport) -> Vec<bool> {
    vec![false; transport.patches.len()]
}

fn largest(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f64::max)
}

#[test]
fn rows_sum_to_what_they_did_and_not_more() {
    let transport = walls(8);
    let whole = rows(&transport, 40, true);
    for tolerance in [0.0, 1e-3, 1e-2, 1.0] {
        let cut = cut_rows(&whole, &transport, &single(&transport), tolerance);
        for row in 0..whole.len() {
            let lost = whole.sum(row) - cut.rows.sum(row);
            assert!((0.0..=1e-7).contains(&lost), "row {row} at {tolerance}: {lost}");
        }
        let columns = transport.columns() + cut.tree.len();
        cut.rows.validate(whole.len(), columns, true).unwrap();
        cut.tree.validate(transport.patches.len()).unwrap();
    }
}

#[test]
fn light_that_is_even_over_each_wall_loses_nothing() {
    let transport = walls(8);
    let whole = rows(&transport, 40, true);
    let cut = cut_rows(&whole, &transport, &single(&transport), 1.0);
    assert!(cut.rows.entries() <= 40 * (2 + 3), "two walls and three sky patches a row");
    let values: Vec<DVec3> = (0..transport.columns())
        .map(|j| {
            transport.patches.get(j).map_or(DVec3::splat(j as f64), |p| DVec3::splat(f64::from(p.batch)))
        })
        .collect();
    let difference = largest(&cut.gather(&transport, &values), &solve::gather(&whole, &values));
    assert!(difference < 2e-5, "{difference}"); // f32 weights, radiosities up to 130
}

#[test]
fn the_error_of_any_light_is_within_the_deviations() {
    let transport = walls(8);
    let whole = rows(&transport, 40, true);
    for tolerance in [1e-4, 1e-3, 3e-3, 1e-2] {
        let cut = cut_rows(&whole, &transport, &single(&transport), tolerance);
        let bounds = deviations(&transport, &whole, &cut);
        for seed in 0..10 {
            let values = light(&transport, seed * 1000);
            let there = cut.gather(&transport, &values);
            for ((a, b), bound) in there.iter().zip(solve::gather(&whole, &values)).zip(&bounds) {
                let error = (*a - b).abs().max_element();
                assert!(error <= 0.5 * bound + 1e-6, "{error}, bound {bound}"); // B ranges over 1
            }
        }
    }
}

#[test]
fn no_tolerance_is_no_error_and_more_tolerance_fewer_entries() {
    let transport = walls(8);
    let whole = rows(&transport, 40, true);
    let values = light(&transport, 5);
    let exact = solve::gather(&whole, &values);
    let mut last = (usize::MAX, 0.0);
    for tolerance in [0.0, 1e-4, 1e-3, 2e-3, 5e-3, 1e-2] {
        let cut = cut_rows(&whole, &transport, &single(&transport), tolerance);
        let error = cut.errors.iter().sum::<f64>();
        assert!(cut.rows.entries() <= last.0 && error >= last.1, "{tolerance}");
        last = (cut.rows.entries(), error);
        let difference = largest(&cut.gather(&transport, &values), &exact);
        assert!(tolerance > 0.0 || difference < 1e-6, "{difference}");
        // (3): each entry that was saved added at most its price.
        let saved = (whole.entries() - cut.rows.entries()) as f64;
        assert!(error <= saved * tolerance * tolerance * (1.0 + 1e-9), "{error} for {saved}");
    }
    assert!(last.0 < whole.entries() / 4, "{} of {}", last.0, whole.entries());
}

/// (1) and (2): lights whose halves differ by +-1 at one node at a time have exactly the error that (2) sums.
#[test]
fn the_stated_error_is_that_of_the_wavelets_below_the_cut() {
    let transport = walls(4);
    let whole = rows(&transport, 6, false);
    let none = single(&transport);
    let cut = cut_rows(&whole, &transport, &none, 1.0);
    let forest = Forest::new(&transport.patches, &none);
    let mut squares = vec![0.0; whole.len()];
    for node in (0..forest.nodes.len() as u32).filter(|&node| forest.only(node).is_none()) {
        let [left, right] = forest.children(node);
        let mut values = vec![DVec3::ZERO; transport.columns()];
        // Mean 0 over the node, so that nothing above it sees it.
        for (half, sign, other) in [(left, 1.0, right), (right, -1.0, left)] {
            let share = forest.areas[other as usize] / forest.areas[node as usize];
            let Node { first, count } = forest.nodes[half as usize];
            for &patch in &forest.order[first as usize..(first + count) as usize] {
                values[patch as usize] = DVec3::splat(sign * share);
            }
        }
        let (a, b) = (cut.gather(&transport, &values), solve::gather(&whole, &values));
        squares.iter_mut().zip(a.iter().zip(&b)).for_each(|(sum, (a, b))| *sum += (a.x - b.x).powi(2));
    }
    for (stated, found) in cut.errors.iter().zip(squares) {
        assert!((stated - found).abs() < 1e-4 * found, "{stated} {found}");
    }
}

#[test]
fn what_must_stay_apart_shares_no_node() {
    let mut transport = walls(6);
    transport.patches[7].component = 1;
    transport.patches[20].back = 1;
    let mut marked = single(&transport);
    marked[30] = true;
    let whole = rows(&transport, 20, false);
    let cut = cut_rows(&whole, &transport, &marked, 1.0);
    for node in 0..cut.tree.len() {
        let members = cut.tree.members(node);
        let kind = |&j: &u32| (transport.patches[j as usize].batch, [7, 20, 30].contains(&j));
        assert!(members.iter().all(|j| kind(j) == kind(&members[0])), "{members:?}");
        assert!(members.len() > 1);
    }
    for row in 0..whole.len() {
        for alone in [7, 20, 30] {
            let weight = |rows: &Rows| rows.row(row).find(|entry| entry.0 == alone).unwrap().1;
            assert_eq!(weight(&cut.rows), weight(&whole));
        }
    }
}

#[test]
fn rows_without_patches_stay_as_they_are() {
    let transport = walls(3);
    let mut whole = Rows::default();
    whole.push([]);
    whole.push([(18, 0.25), (20, 0.5)]);
    let cut = cut_rows(&whole, &transport, &single(&transport), 1.0);
    assert_eq!(cut.rows, whole);
    assert!(cut.tree.is_empty() && cut.tree.order.is_empty());
}

#[test]
fn no_patches_are_no_tree() {
    let cut = cut_rows(&Rows::default(), &Transport::default(), &[], 0.1);
    assert_eq!(cut, CutRows::default());
}

#[test]
fn halves_have_half_of_the_area_and_planes_part_first() {
    // One batch that has both walls.
    let mut transport = walls(8);
    transport.patches.iter_mut().for_each(|patch| patch.batch = 0);
    let forest = Forest::new(&transport.patches, &single(&transport));
    let [floor, wall] = forest.children(0).map(|node| forest.nodes[node as usize]);
    assert_eq!((floor.count, wall.count), (64, 64));
    for node in (0..forest.nodes.len()).filter(|&node| forest.nodes[node].count >= 16) {
        let [left, _] = forest.children(node as u32);
        let share = forest.areas[left as usize] / forest.areas[node];
        assert!((0.3..0.7).contains(&share), "{share}");
    }
}
