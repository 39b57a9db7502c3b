//! Closed shapes: every share is known from areas, and so is the light.

use bake::{Method, Point};
use engine::transport::Transport;
use glam::{DVec3, Vec3};
use tests::closed_forms::discs;
use tests::lit::{Lit, Paint, belt, disc};
use tests::room::walls;
use tests::surfaces::{Faces, area, face, form_factor, turned};

use crate::factors::{assert_factor, baked, sigma};

fn assert_closed(transport: &Transport) {
    assert_eq!((transport.certificate.lost, transport.certificate.escaped), (0.0, 0.0));
}

#[test]
fn the_faces_of_a_cube_exchange_light_with_the_eigenvalues_of_the_closed_form() {
    let names = ["-x", "+x", "-y", "+y", "-z", "+z"];
    let surfaces: Vec<(&str, Faces)> =
        names.into_iter().zip(walls(Vec3::ZERO, Vec3::ONE).iter().map(face)).collect();
    let transport = baked(&surfaces, 0.25);
    assert_closed(&transport);
    let (opposite, adjacent) = (0.199_825, 0.200_044);
    assert!((opposite + 4.0 * adjacent - 1.0_f64).abs() < 2e-6);
    let mut f = [[0.0; 6]; 6];
    for (i, j) in (0..6).flat_map(|i| (0..6).map(move |j| (i, j))).filter(|(i, j)| i != j) {
        let wanted = if i / 2 == j / 2 { opposite } else { adjacent };
        assert_factor(&transport, [i as u64 + 1, j as u64 + 1], wanted, 0.0);
        f[i][j] = form_factor(&transport, i as u64 + 1, j as u64 + 1);
    }
    // An eigenvalue moves by no more than the matrix does: by 4 sigma of six entries of a row.
    let limit = 4.0 * 6.0_f64.sqrt() * sigma(&transport, [1, 2], adjacent);
    let wanted = [-0.200_263, -0.200_263, -0.199_825, -0.199_825, -0.199_825, 1.0];
    let found = eigenvalues(f);
    println!("{found:?}, within {limit:.1e}");
    for (found, wanted) in found.iter().zip(wanted) {
        assert!((found - wanted).abs() <= limit, "{found} {wanted}");
    }
    assert!((found[5] - 1.0).abs() <= 1e-6, "a closed room keeps its light: {}", found[5]);
}

/// Of a symmetric matrix, ascending: rotations until nothing is left beside the diagonal (Jacobi 1846).
fn eigenvalues(mut a: [[f64; 6]; 6]) -> [f64; 6] {
    for _ in 0..12 {
        for (p, q) in (0..6).flat_map(|p| (p + 1..6).map(move |q| (p, q))) {
            let angle = 0.5 * (2.0 * a[p][q]).atan2(a[q][q] - a[p][p]);
            let (sin, cos) = angle.sin_cos();
            for row in &mut a {
                (row[p], row[q]) = (cos * row[p] - sin * row[q], sin * row[p] + cos * row[q]);
            }
            let (first, second) = (a[p], a[q]);
            a[p] = std::array::from_fn(|k| cos * first[k] - sin * second[k]);
            a[q] = std::array::from_fn(|k| sin * first[k] + cos * second[k]);
        }
    }
    let mut values: [f64; 6] = std::array::from_fn(|k| a[k][k]);
    values.sort_by(f64::total_cmp);
    values
}

#[test]
fn the_inside_of_a_cylinder_exchanges_light_as_its_discs_say() {
    const SIDES: usize = 64;
    let (bottom, top) = (disc(1.0, 0.0, SIDES), turned(disc(1.0, 1.0, SIDES)));
    let (low, high) = (&bottom[0], &disc(1.0, 1.0, SIDES)[0]);
    // Seen from inside.
    let side = |k: usize| vec![low[k], high[k], high[(k + 1) % SIDES], low[(k + 1) % SIDES]];
    let sides: Faces = (0..SIDES).map(side).collect();
    let to_base = area(&bottom) * (1.0 - discs(1.0, 1.0, 1.0)) / area(&sides);
    assert!((to_base - 0.309_017).abs() < 1e-3, "{to_base}");
    let transport = baked(&[("bottom", bottom), ("top", top), ("sides", sides)], 0.3);
    assert_closed(&transport);
    // Of the prism's own areas; the discs' edges waver by less than 1e-4.
    assert_factor(&transport, [1, 2], discs(1.0, 1.0, 1.0), 1e-4);
    assert_factor(&transport, [3, 1], to_base, 1e-4);
    assert_factor(&transport, [3, 2], to_base, 1e-4);
    assert_factor(&transport, [3, 3], 1.0 - 2.0 * to_base, 2e-4);
}

#[test]
fn the_inside_of_a_sphere_lights_all_of_itself_alike() {
    let part = |rings| turned(belt(1.0, 32, 16, rings));
    let (cap, middle, bowl) = (part(0..4), part(4..8), part(8..16));
    let areas = [&cap, &middle, &bowl].map(area);
    let whole: f64 = areas.iter().sum();
    assert!((whole / (4.0 * std::f64::consts::PI) - 1.0).abs() < 0.01, "{whole}");
    let transport = baked(&[("cap", cap), ("belt", middle), ("bowl", bowl)], 0.3);
    assert_closed(&transport);
    for (from, to) in (0..3).flat_map(|from| (0..3).map(move |to| (from, to))) {
        // Facets see nothing of themselves: of 512, less than 1 % of what lies about them.
        let systematic = 0.01 * areas[to] / whole;
        assert_factor(&transport, [from as u64 + 1, to as u64 + 1], areas[to] / whole, systematic);
    }
}

#[test]
fn a_bowl_sends_half_of_its_light_to_its_lid() {
    let bowl = turned(belt(1.0, 32, 16, 8..16));
    let rim: Vec<Vec3> = (0..32).map(|i| belt(1.0, 32, 16, 7..8)[i][3]).collect();
    let lid: Faces = vec![rim];
    let share = area(&lid) / area(&bowl);
    assert!((share - 0.5).abs() < 5e-3, "{share}");
    let transport = baked(&[("bowl", bowl), ("lid", lid)], 0.3);
    assert_closed(&transport);
    // Exact for whatever a flat lid closes.
    assert_factor(&transport, [1, 2], share, 0.0);
    assert_factor(&transport, [1, 1], 1.0 - share, 0.0);
    assert!((form_factor(&transport, 2, 1) - 1.0).abs() <= 1e-6);
}

#[test]
fn each_side_of_a_tetrahedron_gets_a_third() {
    let corners =
        [Vec3::ONE, Vec3::new(1.0, -1.0, -1.0), Vec3::new(-1.0, 1.0, -1.0), Vec3::new(-1.0, -1.0, 1.0)];
    let side = |k: usize| -> Faces {
        let [a, b, c] = [1, 2, 3].map(|step| corners[(k + step) % 4]);
        let inward = (b - a).cross(c - a).dot(corners[k] - a) > 0.0;
        vec![if inward { vec![a, b, c] } else { vec![a, c, b] }]
    };
    let names = ["first", "second", "third", "fourth"];
    let surfaces: Vec<(&str, Faces)> = names.into_iter().zip((0..4).map(side)).collect();
    let transport = baked(&surfaces, 0.7);
    assert_closed(&transport);
    for (i, j) in (1..=4).flat_map(|i| (1..=4).map(move |j| (i, j))).filter(|(i, j)| i != j) {
        assert_factor(&transport, [i, j], 1.0 / 3.0, 0.0);
    }
}

/// B_1 = M_1 + rho_1 B_2, B_2 = rho_2 (F_21 B_1 + F_22 B_2): F_12 = 1 and F_21 = A_1 / A_2 for a convex body inside.
#[test]
fn a_body_in_an_enclosure_settles_at_the_light_of_two_equations() {
    let (inner, outer) = (belt(0.5, 24, 12, 0..12), turned(belt(1.0, 24, 12, 0..12)));
    let back = area(&inner) / area(&outer);
    let (rho_1, rho_2) = (0.4, 0.7);
    // B_2 (1 - rho_2 (1 - back) - rho_1 rho_2 back) = rho_2 back M
    let b_2 = rho_2 * back / (1.0 - rho_2 * (1.0 - back) - rho_1 * rho_2 * back);
    let b_1 = 1.0 + rho_1 * b_2;
    let wanted = [b_2, back * b_1 + (1.0 - back) * b_2];
    let middles = |faces: &Faces| -> Vec<Point> {
        let middle = |face: &Vec<Vec3>| Point {
            position: (face.iter().sum::<Vec3>() / face.len() as f32).as_dvec3(),
            normal: (face[1] - face[0]).cross(face[2] - face[0]).normalize().as_dvec3(),
        };
        faces.iter().step_by(13).map(middle).collect()
    };
    let points = [middles(&inner), middles(&outer)];
    let lit = Lit::new(
        &[
            ("inner", inner, Paint { albedo: rho_1 as f32, exitance: 1.0 }),
            ("outer", outer, Paint { albedo: rho_2 as f32, exitance: 0.0 }),
        ],
        Vec::new(),
    );
    assert_closed(&lit.bake(0.25, 4096));
    for (points, wanted) in points.iter().zip(wanted) {
        let count = points.len() as f64;
        let traced = lit.traced(points, 4096);
        let error = traced.iter().map(|point| point.standard_error.x).sum::<f64>() / count / count.sqrt();
        let means = [
            ("traced", traced.iter().map(|point| point.total().x).sum::<f64>() / count),
            ("receivers", mean(&lit, points, Method::Receivers)),
            ("gather", mean(&lit, points, Method::Gather)),
        ];
        for (method, mean) in means {
            println!("{method}: {mean:.5}, {wanted:.5} wanted, path tracer's error {error:.1e}");
            // Facets are flat: what they get varies by a few thousandths over each of them.
            assert!(
                (mean / wanted - 1.0).abs() <= 4e-3 + 4.0 * error / wanted,
                "{method}: {mean}, not {wanted}"
            );
        }
    }
}

fn mean(lit: &Lit, points: &[Point], method: Method) -> f64 {
    let sum: DVec3 = lit.query(points, method).iter().map(|found| found.direct + found.indirect).sum();
    sum.x / points.len() as f64
}
