//! The dense matrix: against closed forms, patch by patch; against the bake's rows; and against the path tracer.

use bake::reference::{MatrixReference, Surfaces};
use bake::{Point, Silent};
use engine::scene::assets::Assets;
use engine::transport::{Patch, Transport};
use glam::{DVec3, Vec3};
use tests::closed_forms::{parallel, perpendicular};
use tests::room::{scene_of, surfaces, walls};

use crate::{coloured_room, points_in_box};

const RAYS: u32 = 1 << 14;

/// The inside of a unit cube, n x n square patches a wall; no rows.
fn cube(n: u32) -> Transport {
    surfaces(&walls(Vec3::ZERO, Vec3::ONE), n)
}

/// A patch of a wall of the cube: which wall, and what it covers along each axis.
struct Cell {
    wall: usize,
    ranges: [[f64; 2]; 3],
}

fn cells(transport: &Transport) -> Vec<Cell> {
    let cell = |patch: &Patch| {
        let first = patch.first_triangle as usize;
        let corners: Vec<Vec3> = (first..first + 2).flat_map(|t| transport.surface.positions(t)).collect();
        let range = |axis: usize| {
            let along = corners.iter().map(|corner| f64::from(corner[axis]));
            [along.clone().fold(f64::INFINITY, f64::min), along.fold(f64::NEG_INFINITY, f64::max)]
        };
        Cell { wall: patch.batch as usize, ranges: [0, 1, 2].map(range) }
    };
    transport.patches.iter().map(cell).collect()
}

fn form_factor(from: &Cell, to: &Cell) -> f64 {
    let (p, q) = (from.wall / 2, to.wall / 2);
    if from.wall == to.wall {
        return 0.0;
    }
    if p == q {
        let (u, v) = ((p + 1) % 3, (p + 2) % 3);
        return parallel(from.ranges[u], from.ranges[v], to.ranges[u], to.ranges[v], 1.0);
    }
    // From the edge that both walls share.
    let off =
        |[a, b]: [f64; 2], wall: usize| if wall.is_multiple_of(2) { [a, b] } else { [1.0 - b, 1.0 - a] };
    let common = 3 - p - q;
    let (x, xi) = (off(from.ranges[q], to.wall), off(to.ranges[p], from.wall));
    perpendicular(x, from.ranges[common], to.ranges[common], xi)
}

#[test]
fn patches_of_a_cube_exchange_what_the_closed_forms_say() {
    let transport = cube(4);
    let scene = scene_of(&transport, |_| Vec3::splat(0.5));
    let reference =
        MatrixReference::new(&scene, &Assets::default(), &transport, RAYS, 1, &Silent).expect("rows");
    let (cells, n) = (cells(&transport), transport.patches.len());
    let (mut chi, mut pairs, mut squares, mut all) = (0.0, 0.0, 0.0, 0.0);
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let (found, wanted) = (reference.matrix()[i * n + j], form_factor(&cells[i], &cells[j]));
        assert!((found - reference.matrix()[j * n + i]).abs() <= 1e-15, "not reciprocal: {i} {j}");
        if wanted == 0.0 {
            assert_eq!(found, 0.0);
            continue;
        }
        // Rays of both patches count.
        chi += (found - wanted).powi(2) / (wanted / (2.0 * f64::from(RAYS)));
        (pairs, squares, all) = (pairs + 1.0, squares + (found - wanted).powi(2), all + wanted * wanted);
    }
    let relative = (squares / all).sqrt();
    println!("chi-square {:.3}, rms error {:.2} % of rms F", chi / pairs, relative * 100.0);
    // Even points and closed rows do better than chance, whose chi-square is 1.
    assert!(chi / pairs <= 1.0, "{}", chi / pairs);
    assert!(reference.defect() <= 1e-13, "{:e}", reference.defect());
    for row in reference.matrix().chunks(n) {
        assert!((row.iter().sum::<f64>() - 1.0).abs() <= 1e-13);
    }
}

#[test]
fn its_solution_leaves_no_residual_whatever_the_albedo() {
    let transport = cube(3);
    let scene = scene_of(&transport, |_| Vec3::splat(0.99));
    let reference =
        MatrixReference::new(&scene, &Assets::default(), &transport, 1024, 1, &Silent).expect("rows");
    let n = transport.patches.len();
    // The scene's own: a furnace.
    for b in reference.solve(&vec![DVec3::ONE; n]) {
        assert!((b / 100.0 - 1.0).abs().max_element() <= 1e-5, "{b}"); // 0.99 as f32 is
    }
    let albedo: Vec<DVec3> =
        (0..n).map(|i| DVec3::new(0.0, 0.9999, if i % 3 == 0 { 0.0 } else { i as f64 / n as f64 })).collect();
    let e: Vec<DVec3> = (0..n).map(|i| DVec3::splat(if i < 3 { 1.0 } else { 0.0 })).collect();
    let b = reference.solve_with(&albedo, &e);
    let gathered = reference.gather(&b);
    let largest = b.iter().fold(DVec3::ZERO, |max, b| max.max(*b));
    for i in 0..n {
        let residual = (e[i] + albedo[i] * gathered[i] - b[i]).abs() / largest;
        assert!(residual.max_element() <= 1e-12, "{residual}");
        assert_eq!(b[i].x, e[i].x, "black reflects nothing");
    }
}

#[test]
fn the_bakes_rows_differ_from_it_by_their_noise() {
    let lit = coloured_room();
    let transport = lit.bake(0.4, 4096);
    let scene = lit.project.scene();
    let reference =
        MatrixReference::new(&scene, &Assets::default(), &transport, RAYS, 5, &Silent).expect("rows");
    assert!(reference.defect() <= 1e-12, "{:e}", reference.defect());
    let n = transport.patches.len();
    let (mut chi, mut pairs) = (0.0, 0.0);
    for i in 0..n {
        let own = f64::from(transport.patches[i].area);
        let mut row = vec![0.0; transport.columns()];
        transport.patch_from_patch.row(i).for_each(|(j, weight)| row[j as usize] = f64::from(weight));
        for (j, &found) in row.iter().enumerate().take(n) {
            let there = f64::from(transport.patches[j].area);
            let wanted = reference.matrix()[i * n + j];
            // P / (A_i (R / A_i + R / A_j)), of both sides.
            let variance = |rays: f64| wanted / (own * (rays / own + rays / there));
            if wanted > 1e-3 {
                chi += (found - wanted).powi(2) / (variance(4096.0) + variance(f64::from(RAYS)));
                pairs += 1.0;
            }
        }
    }
    println!("{n} patches, chi-square {:.3} of {pairs} pairs", chi / pairs);
    // Even points and rows towards the lamp are better than chance; a wrong balance would be far worse.
    assert!(chi / pairs <= 1.0, "{}", chi / pairs);
    assert!(chi / pairs >= 0.05, "{}: not the same matrix", chi / pairs);
}

/// B from the lamp alone, gathered at points: what patches cost.
#[test]
fn its_light_at_points_is_near_the_path_tracers() {
    let lit = coloured_room();
    lit.change(|scene| scene.entities.retain(|entity| entity.light.is_none()));
    let transport = lit.bake(0.2, 256);
    let scene = lit.project.scene();
    let reference =
        MatrixReference::new(&scene, &Assets::default(), &transport, 4096, 5, &Silent).expect("rows");
    let lamp = transport.surface.batches.iter().position(|batch| batch.entity().0 == 7).expect("the lamp");
    let emitted = |patch: &Patch| DVec3::splat(if patch.batch as usize == lamp { 5.0 } else { 0.0 });
    let e: Vec<DVec3> = transport.patches.iter().map(emitted).collect();
    let b = reference.solve(&e);
    let points: Vec<Point> = points_in_box(Vec3::ZERO, Vec3::new(2.0, 1.0, 2.0), 36);
    let found = reference.irradiance(&points, &b, RAYS, 9, &Silent).expect("irradiance");
    let traced = lit.tracer(Surfaces::Diffuse).irradiance(&points, 4096, 3, &Silent).expect("irradiance");
    let mean = traced.iter().map(|point| point.total().element_sum()).sum::<f64>();
    let squares = found.iter().zip(&traced).map(|(f, t)| (*f - t.total()).length_squared()).sum::<f64>();
    let bias = found.iter().zip(&traced).map(|(f, t)| (*f - t.total()).element_sum()).sum::<f64>() / mean;
    let rms = (squares * 3.0 * points.len() as f64).sqrt() / mean;
    println!("{} patches: rms {:.2} % of the mean, bias {:+.2} %", b.len(), rms * 100.0, bias * 100.0);
    assert!(rms <= 0.02 && bias.abs() <= 0.01, "{rms} {bias}");
}

#[test]
fn a_matrix_that_does_not_fit_is_refused_with_what_it_needs() {
    let transport = Transport { patches: vec![Patch::default(); 20_000], ..Transport::default() };
    let scene = scene_of(&transport, |_| Vec3::ONE);
    let error = MatrixReference::new(&scene, &Assets::default(), &transport, 16, 1, &Silent);
    let message = error.err().expect("a refusal").to_string();
    assert!(message.contains("20000 patches") && message.contains("4.8 GB"), "{message}");
}
