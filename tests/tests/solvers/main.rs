//! The methods side by side: they find one solution, say truly how far from it they are, and need as many products as
//! their theory says.

mod counts;

use std::sync::atomic::{AtomicUsize, Ordering};

use engine::transport::Rows;
use engine::transport::solve::{self, Bracket, Channel, Method, Solved, Stop, System, bracket, solve};
use glam::{DVec3, Vec3};
use tests::systems::{BOX, CORRIDOR, Geometry, SMALL_BOX, apart, open};

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |max, value| value.abs().max(max))
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// One bright patch.
fn bright(n: usize) -> Vec<f64> {
    (0..n).map(|i| if i == n / 3 { 1.0 } else { 0.0 }).collect()
}

fn silently(method: Method, channel: &Channel, e: &[f64], start: Option<&[f64]>, stop: &Stop) -> Solved {
    solve(method, channel, e, start, stop, &mut |_| {})
}

fn truth(channel: &Channel, e: &[f64]) -> Solved {
    let found = silently(Method::DeflatedConjugateGradients, channel, e, None, &Stop::at(1e-11, 500.0));
    assert!(found.bracket.bound < 1e-8, "{}", found.bracket.bound);
    found
}

/// Gauss's elimination of the whole matrix, which knows nothing of light.
fn dense(channel: &Channel, e: &[f64]) -> Vec<f64> {
    let n = e.len();
    let mut a = vec![vec![0.0; n + 1]; n];
    for i in 0..n {
        let (columns, weights) = channel.matrix.row(i);
        for (&j, &weight) in columns.iter().zip(weights) {
            a[i][j as usize] = -channel.matrix.albedo[i] * f64::from(weight);
        }
        a[i][i] += 1.0;
        a[i][n] = e[i];
    }
    for k in 0..n {
        let pivot = a[k].clone();
        for row in a.iter_mut().skip(k + 1) {
            let factor = row[k] / pivot[k];
            row.iter_mut().zip(&pivot).for_each(|(x, p)| *x -= factor * p);
        }
    }
    let mut b = vec![0.0; n];
    for i in (0..n).rev() {
        b[i] = (a[i][n] - (i + 1..n).map(|j| a[i][j] * b[j]).sum::<f64>()) / a[i][i];
    }
    b
}

/// By patch and wall.
type Albedo = fn(u32, u32) -> f64;

/// What there is to solve, by name: closed, black, open, long, in two pieces, patchy, stiff.
fn scenes() -> Vec<(&'static str, Geometry, Albedo)> {
    vec![
        ("closed box", BOX.clone(), |_, _| 0.7),
        ("box with a black wall", BOX.clone(), |_, wall| if wall == 2 { 0.0 } else { 0.8 }),
        ("open box", open(&BOX), |_, _| 0.9),
        ("corridor", CORRIDOR.clone(), |_, _| 0.9),
        ("two boxes", apart(&SMALL_BOX, &BOX), |patch, _| if patch % 3 == 0 { 0.0 } else { 0.85 }),
        ("patchy box", BOX.clone(), |patch, _| [0.98, 0.02, 0.6, 0.95][patch as usize * 7 % 4]),
        ("stiff box", SMALL_BOX.clone(), |_, _| 0.9999),
        ("black box", SMALL_BOX.clone(), |_, _| 0.0),
    ]
}

fn channel<'a>(geometry: &'a Geometry, albedo: Albedo) -> Channel<'a> {
    let patches = geometry.patches.iter().enumerate();
    let albedo = patches.map(|(i, patch)| albedo(i as u32, patch.batch));
    Channel::new(&geometry.rows, &geometry.patches, albedo)
}

#[test]
fn all_methods_find_the_solution_of_gauss() {
    for albedo in [|_, _| 0.5, |patch, _| [0.9, 0.0, 0.3][patch as usize % 3], |_, _| 0.9999] as [Albedo; 3] {
        let channel = channel(&SMALL_BOX, albedo);
        let e = bright(channel.matrix.len());
        let wanted = dense(&channel, &e);
        for method in Method::all() {
            let found = silently(method, &channel, &e, None, &Stop::at(1e-8, 1e6));
            let apart = distance(&found.b, &wanted) / largest(&wanted);
            assert!(found.reached && apart <= 1e-8, "{}: {apart}, {}", method.name(), found.bracket.bound);
        }
    }
}

#[test]
fn all_methods_find_what_exact_finds() {
    for (name, geometry, albedo) in &scenes() {
        let channel = channel(geometry, *albedo);
        let n = channel.matrix.len();
        let e = bright(n);
        let wide: Vec<Vec3> = channel.matrix.albedo.iter().map(|&rho| Vec3::splat(rho as f32)).collect();
        let system = System { rows: &geometry.rows, patches: &geometry.patches, albedo: &wide };
        let exact = solve::exact(&system, &e.iter().map(|&e| DVec3::splat(e)).collect::<Vec<_>>(), 1e-12);
        let exact: Vec<f64> = exact.iter().map(|b| b.y).collect();
        for method in Method::all() {
            let found = silently(method, &channel, &e, None, &Stop::at(1e-6, 1e6));
            let apart = distance(&found.b, &exact) / largest(&exact);
            // Albedo of a system is f32.
            let rounded = 6e-8 * channel.largest_gain;
            assert!(found.reached && apart <= 1e-6 + rounded, "{name}, {}: {apart}", method.name());
        }
    }
}

#[test]
fn the_solution_lies_in_the_bracket_of_every_iterate_of_every_method() {
    for (name, geometry, albedo) in &scenes() {
        let channel = channel(geometry, *albedo);
        for e in
            [bright(channel.matrix.len()), (0..channel.matrix.len()).map(|i| (i % 7) as f64 - 3.0).collect()]
        {
            let truth = truth(&channel, &e);
            let off = truth.bracket.bound * largest(&truth.b);
            for method in Method::all() {
                let mut looked = 0;
                solve(method, &channel, &e, None, &Stop::at(1e-9, 30.0), &mut |iterate| {
                    // Southwell's are many.
                    looked += 1;
                    if method != Method::Southwell || looked % 16 == 1 {
                        let found = bracket(&channel, &e, iterate.b);
                        assert_holds(&found, iterate.b, &truth.b, off, &format!("{name}, {}", method.name()));
                    }
                });
                assert!(looked >= 2 || *name == "black box", "{name}, {}", method.name());
            }
        }
    }
}

fn assert_holds(found: &Bracket, b: &[f64], truth: &[f64], off: f64, what: &str) {
    let inside = |i: usize| found.below[i] - off <= truth[i] && truth[i] <= found.above[i] + off;
    assert!((0..b.len()).all(inside), "{what}");
    let error = distance(b, truth);
    assert!(error <= found.bound * largest(b) + off || error == 0.0, "{what}: {error}, {}", found.bound);
}

#[test]
fn a_solver_that_must_stop_early_gives_light_that_is_finite_and_enough_and_a_bound_that_is_true() {
    for (name, geometry, albedo) in &scenes() {
        let channel = channel(geometry, *albedo);
        let e = bright(channel.matrix.len());
        let truth = truth(&channel, &e);
        let off = truth.bracket.bound * largest(&truth.b);
        for method in Method::all() {
            for most in 0..7 {
                let what = format!("{name}, {} after {most} products", method.name());
                let asked = AtomicUsize::new(0);
                let cancelled = || asked.fetch_add(1, Ordering::Relaxed) >= most;
                let by_count = Stop::at(1e-10, most as f64);
                let by_caller = Stop { cancelled: &cancelled, ..Stop::at(1e-10, 1e9) };
                for stop in [by_count, by_caller] {
                    let found = silently(method, &channel, &e, None, &stop);
                    assert!(found.b.iter().zip(&e).all(|(b, e)| b.is_finite() && b >= e), "{what}");
                    assert_holds(&found.bracket, &found.b, &truth.b, off, &what);
                    assert_eq!(found.reached, found.bracket.bound <= 1e-10, "{what}");
                }
                let found = silently(method, &channel, &e, None, &by_count);
                assert!(found.products <= most.max(1) as f64 + 1e-9, "{what}: {}", found.products);
            }
        }
    }
}

#[test]
fn the_solution_as_a_start_costs_one_product_and_a_near_start_saves_some() {
    for (name, geometry, albedo) in &scenes() {
        let channel = channel(geometry, *albedo);
        let e = bright(channel.matrix.len());
        let truth = truth(&channel, &e);
        let near: Vec<f64> =
            truth.b.iter().enumerate().map(|(i, b)| b * (1.0 + 1e-5 * (i % 3) as f64)).collect();
        for method in Method::all() {
            let stop = Stop::at(1e-6, 3e5);
            let [cold, warm, there] = [None, Some(&near[..]), Some(&truth.b[..])]
                .map(|start| silently(method, &channel, &e, start, &stop));
            assert!(cold.reached && warm.reached && there.reached, "{name}, {}", method.name());
            assert_eq!(there.products, 1.0, "{name}, {}", method.name());
            assert!(warm.products <= cold.products, "{name}, {}", method.name());
        }
    }
}

#[test]
fn light_that_has_changed_is_followed_from_what_was() {
    let channel = channel(&CORRIDOR, |_, _| 0.95);
    let n = channel.matrix.len();
    let on = truth(&channel, &bright(n)).b;
    for method in Method::all() {
        // Off: what is left must go, and nothing is below 0 on the way.
        let mut lit = true;
        let found = solve(method, &channel, &vec![0.0; n], Some(&on), &Stop::at(1e-3, 1e4), &mut |iterate| {
            lit &= iterate.b.iter().all(|b| b.is_finite());
        });
        assert!(lit && found.b.iter().all(|&b| b >= 0.0), "{}", method.name());
        let left = largest(&found.b) / largest(&on);
        assert!(found.products > 1e3 || found.reached || left < 1e-6, "{}: {left}", method.name());
    }
}

#[test]
fn nothing_that_is_put_in_makes_light_that_is_no_number() {
    let mut wild = SMALL_BOX.clone();
    // Rows that are no shares: no bake leaves them, and the loader refuses them.
    wild.rows.weights.iter_mut().for_each(|weight| *weight *= 1.5);
    let numbers = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1.0, 1e-320, 2.0];
    for geometry in [&*SMALL_BOX, &wild] {
        let n = geometry.patches.len();
        let hostile: Vec<f64> = (0..n).map(|i| numbers[i % numbers.len()]).collect();
        let tame = bright(n);
        for albedo in [&hostile, &vec![1.0; n], &vec![0.9; n]] {
            let channel = Channel::new(&geometry.rows, &geometry.patches, albedo.iter().copied());
            assert!(channel.gain.iter().all(|w| w.is_finite() && *w > 0.0));
            for (e, start) in [(&hostile, &tame), (&tame, &hostile), (&hostile, &hostile)] {
                for method in Method::all() {
                    let found = silently(method, &channel, e, Some(start), &Stop::at(1e-6, 40.0));
                    let finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
                    assert!(finite(&found.b) && finite(&found.bracket.above), "{}", method.name());
                    assert!(
                        finite(&found.bracket.below) && !found.bracket.bound.is_nan(),
                        "{}",
                        method.name()
                    );
                }
            }
        }
    }
    let no_rows = Rows::default();
    let nothing = Channel::new(&no_rows, &[], []);
    for method in Method::all() {
        let found = silently(method, &nothing, &[], None, &Stop::at(1e-6, 40.0));
        assert!(found.reached && found.b.is_empty());
    }
}

#[test]
fn what_is_black_has_its_own_light_on_every_iterate_and_no_other() {
    let albedo = |patch: u32, _| if patch.is_multiple_of(3) { 0.0 } else { 0.95 };
    let channel = channel(&CORRIDOR, albedo);
    let e = bright(channel.matrix.len());
    for method in Method::all() {
        solve(method, &channel, &e, None, &Stop::at(1e-6, 50.0), &mut |iterate| {
            let black = (0..e.len()).filter(|i| channel.matrix.albedo[*i] == 0.0);
            assert!(black.into_iter().all(|i| iterate.b[i] == e[i]), "{}", method.name());
        });
    }
}

#[test]
fn the_correction_never_adds_to_the_energy_of_the_error_however_poor_the_aggregates() {
    let mut poor = BOX.clone();
    poor.patches.iter_mut().enumerate().for_each(|(i, patch)| patch.aggregate = (i * i) as u32 % 5);
    let channel = channel(&poor, |patch, _| [0.99, 0.01, 0.5, 0.97, 0.2][patch as usize * 11 % 5]);
    let n = channel.matrix.len();
    // Signed light, so that nothing is clamped.
    let e: Vec<f64> = (0..n).map(|i| (i % 7) as f64 - 3.0).collect();
    let truth = truth(&channel, &e);
    let energy = |b: &[f64]| -> f64 {
        let error: Vec<f64> = b.iter().zip(&truth.b).map(|(b, truth)| truth - b).collect();
        let mut image = vec![0.0; n];
        channel.matrix.apply(&error, &mut image);
        let weight = |i: usize| channel.matrix.area(i) / channel.matrix.albedo[i];
        (0..n).map(|i| weight(i) * error[i] * image[i]).sum()
    };
    let mut energies = [Vec::new(), Vec::new()];
    for (method, energies) in [Method::Jacobi, Method::TwoLevel].into_iter().zip(&mut energies) {
        solve(method, &channel, &e, None, &Stop::at(1e-6, 40.0), &mut |iterate| {
            energies.push(energy(iterate.b))
        });
        let falls = energies.windows(2).all(|pair| pair[1] <= pair[0]);
        assert!(falls, "{}: {energies:?}", method.name());
    }
    let worse = energies[1].iter().zip(&energies[0]).skip(1).any(|(two_level, jacobi)| two_level > jacobi);
    assert!(!worse, "{energies:?}");
}

#[test]
fn deflation_stays_what_it_is_over_hundreds_of_steps_at_a_gain_of_ten_thousand() {
    let mut rooms = (1..12).fold(SMALL_BOX.clone(), |rooms, _| apart(&rooms, &SMALL_BOX));
    rooms.patches.iter_mut().enumerate().for_each(|(i, patch)| patch.aggregate = (i * i) as u32 % 7);
    // Slow light in each room, of which aggregates across rooms know little.
    let channel = rooms.channel(|patch| 1.0 - 1e-4 * f64::from(1 + patch.component % 12));
    let e: Vec<f64> = (0..channel.matrix.len()).map(|i| (i % 11) as f64).collect();
    let plain = silently(Method::ConjugateGradients, &channel, &e, None, &Stop::at(1e-9, 1000.0));
    assert!(plain.reached, "{}", plain.bracket.bound);
    let mut far = Vec::new();
    let deflated = Method::DeflatedConjugateGradients;
    solve(deflated, &channel, &e, None, &Stop::at(0.0, 600.0), &mut |iterate| {
        far.push(distance(iterate.b, &plain.b) / largest(&plain.b));
    });
    let arrived = far.iter().position(|&far| far < 1e-7).expect("it arrives");
    assert!(far[arrived..].iter().all(|&far| far < 1e-7), "and stays: {far:?}");
}

#[test]
fn at_albedo_0_9999_light_is_bounded_and_finite_whenever_it_is_looked_at() {
    for geometry in [&*BOX, &*CORRIDOR] {
        let channel = geometry.channel(|_| 0.9999);
        let e = bright(channel.matrix.len());
        for method in Method::all() {
            solve(method, &channel, &e, None, &Stop::at(1e-9, 100.0), &mut |iterate| {
                let most = largest(iterate.b);
                assert!(most <= channel.largest_gain * (1.0 + 1e-6), "{}: {most}", method.name());
            });
        }
    }
}
