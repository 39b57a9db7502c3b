//! How many products each method needs, on a box, along a corridor and through doors; and what frames make of it.

use std::collections::BTreeMap;
use std::time::Instant;

use engine::scene::file::Quality;
use engine::transport::solve::{Case, Channel, Coarse, Method, Stop, System, TwoLevel, choose, solve};
use glam::Vec3;
use tests::project::TestProject;
use tests::systems::{BOX, CORRIDOR, Geometry};

use super::{bright, distance, largest, truth};

/// Products until |e| < 1e-3 and 1e-6 of the largest B, from B = E; and ms a product.
fn counts(channel: &Channel, method: Method, e: &[f64]) -> ([Option<f64>; 2], f64) {
    let truth = truth(channel, e).b;
    let mut counts = [None; 2];
    let (mut begun, mut looking) = (Instant::now(), 0.0);
    let mut first = true;
    let stop = Stop::at(1e-7, 1500.0);
    let found = solve(method, channel, e, None, &stop, &mut |iterate| {
        let now = Instant::now();
        if std::mem::take(&mut first) {
            begun = now;
        }
        let error = distance(iterate.b, &truth) / largest(&truth);
        for (count, limit) in counts.iter_mut().zip([1e-3, 1e-6]) {
            if error < limit {
                count.get_or_insert(iterate.products);
            }
        }
        looking += now.elapsed().as_secs_f64();
    });
    let seconds = begun.elapsed().as_secs_f64() - looking;
    (counts, seconds * 1e3 / found.products)
}

/// Those of every method, printed; infinite where 1500 are not enough.
fn table(what: &str, channel: &Channel, e: &[f64]) -> BTreeMap<Method, [f64; 2]> {
    println!("{what}: {} patches, w {:.1}", channel.matrix.len(), channel.largest_gain);
    let row = |method: Method| {
        let (counts, ms) = counts(channel, method, e);
        let [coarse, fine] = counts.map(|count| count.map_or("-".to_owned(), |n| format!("{n:.1}")));
        println!("    {:30} {coarse:>7} {fine:>7}   {ms:.3} ms", method.name());
        (method, counts.map(|count| count.unwrap_or(f64::INFINITY)))
    };
    Method::all().into_iter().map(row).collect()
}

#[test]
fn products_to_a_thousandth_and_a_millionth_are_as_theory_says() {
    for (name, geometry) in [("box", &*BOX), ("corridor", &*CORRIDOR)] {
        for rho in [0.5, 0.7, 0.9, 0.99, 0.9999] {
            let e = bright(geometry.patches.len());
            let of = table(&format!("{name}, albedo {rho}"), &geometry.channel(|_| rho), &e);
            let to_a_millionth = |method: Method| of[&method][1];
            use Method::*;
            for pair in [GaussSeidel, Chebyshev, ConjugateGradients, DeflatedConjugateGradients].windows(2) {
                let slack = if rho < 0.9 { 2.0 } else { 0.0 };
                let [before, after] = [pair[0], pair[1]].map(to_a_millionth);
                assert!(after <= before + slack, "{name} {rho} {pair:?}");
            }
            assert!(
                to_a_millionth(TwoLevel) <= to_a_millionth(Jacobi)
                    && to_a_millionth(GaussSeidel) <= to_a_millionth(Jacobi) + 1.0
            );
            assert!(to_a_millionth(DeflatedConjugateGradients) < 20.0, "{name} {rho}");
            assert!(to_a_millionth(TwoLevel) <= 45.0, "{name} {rho}");
            if rho >= 0.99 {
                assert!(to_a_millionth(Jacobi) > 1000.0, "{name} {rho}");
            }
        }
    }
}

#[test]
fn rooms_with_doors_need_few_products_too() {
    let folder = tests::source::workspace().join("projects/gallery");
    let settings = bake::Settings { quality: Some(Quality::Draft), ..Default::default() };
    let baked =
        bake::bake(TestProject::copy_of(&folder).path(), None, &settings, &bake::Silent).expect("a bake");
    let gallery = Geometry::from(baked.transport);
    let aggregates = gallery.patches.iter().map(|patch| patch.aggregate.wrapping_add(1)).max();
    println!("{aggregates:?} aggregates, {} entries", gallery.rows.entries());
    for rho in [0.9, 0.99, 0.9999] {
        let channel = gallery.channel(|_| rho);
        // One room is lit.
        let e: Vec<f64> =
            gallery.patches.iter().map(|patch| if patch.aggregate == 0 { 1.0 } else { 0.0 }).collect();
        let of = table(&format!("gallery, albedo {rho}"), &channel, &e);
        let to_a_millionth = |method: Method| of[&method][1];
        assert!(to_a_millionth(Method::TwoLevel) <= 45.0, "albedo {rho}");
        assert!(to_a_millionth(Method::DeflatedConjugateGradients) < 20.0, "albedo {rho}");
    }
}

#[test]
fn shooting_shows_the_first_bounces_for_less_than_a_product() {
    let channel = CORRIDOR.channel(|_| 0.5);
    let e = bright(channel.matrix.len());
    let truth = truth(&channel, &e).b;
    let mut spent = None;
    solve(Method::Southwell, &channel, &e, None, &Stop::at(1e-6, 10.0), &mut |iterate| {
        if distance(iterate.b, &truth) < 0.02 * largest(&truth) {
            spent.get_or_insert(iterate.products);
        }
    });
    // One product measures the start.
    assert!(spent.is_some_and(|spent| spent < 1.5), "{spent:?}");
}

#[test]
fn the_frames_iteration_in_f32_comes_down_to_its_rounding() {
    let n = CORRIDOR.patches.len();
    for rho in [0.5_f32, 0.99, 0.9999] {
        let albedo = vec![Vec3::splat(rho); n];
        let system = System { rows: &CORRIDOR.rows, patches: &CORRIDOR.patches, albedo: &albedo };
        let channel = Channel::of(&system, 0);
        let truth = truth(&channel, &bright(n)).b;
        let e: Vec<Vec3> = bright(n).iter().map(|&e| Vec3::splat(e as f32)).collect();
        let coarse = Coarse::new(&system);
        let mut b = e.clone();
        for _ in 0..80 {
            TwoLevel { system: &system, coarse: &coarse }.step(&e, &mut b);
        }
        let found: Vec<f64> = b.iter().map(|b| f64::from(b.y)).collect();
        let error = distance(&found, &truth) / largest(&truth);
        let floor = 4.0 * f64::from(f32::EPSILON) * channel.largest_gain;
        println!("albedo {rho}: {error:.1e}, floor {floor:.1e}");
        assert!(error <= floor, "albedo {rho}: {error}, {floor}");
    }
}

#[test]
fn what_frames_are_given_is_never_far_from_the_cheaper_way() {
    for geometry in [&*BOX, &*CORRIDOR] {
        for rho in [0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.99] {
            let channel = geometry.channel(|_| rho);
            let aggregates = geometry.patches.iter().map(|patch| patch.aggregate as usize + 1).max().unwrap();
            let (patches, entries) = (geometry.patches.len(), geometry.rows.entries());
            let case = Case { gain: channel.largest_gain, patches, entries, aggregates, budget: 1e9 };
            let cost = |method: Method| {
                let products = counts(&channel, method, &bright(patches)).0[0].unwrap_or(1e4);
                // Two dispatches wait for each other, or four.
                let corrected = (aggregates * patches) as f64 + 2e5;
                let one = entries as f64 + 2e5 + if method == Method::TwoLevel { corrected } else { 0.0 };
                products * one
            };
            let (jacobi, two_level) = (cost(Method::Jacobi), cost(Method::TwoLevel));
            let choice = choose(&case);
            let (chosen, other) =
                if choice.method == Method::Jacobi { (jacobi, two_level) } else { (two_level, jacobi) };
            println!("albedo {rho}: {}, {:.2} of the other's cost", choice.method.name(), chosen / other);
            assert!(chosen <= 1.5 * other, "albedo {rho}: {choice:?} {chosen} {other}");
        }
    }
}
