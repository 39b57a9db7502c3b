//! Form factors and the systems that they make: occluders of stripes, closed forms, turned and mirrored scenes, tiny
//! weights, and what is left out.

use std::f64::consts::PI;

use engine::transport::key::{BakeWith, inputs};
use engine::transport::solve::{System, exact};
use engine::transport::stale::Stale;
use engine::transport::{NONE, Patch, Rows, Transport};
use glam::{DVec3, Vec3};
use tests::project::TestProject;
use tests::solved::{
    Solved, WALLS, apart, baked, block, change, largest, paint, rectangle, settings, shell, system,
};
use tests::surfaces::{entities, form_factor, project};

/// Rays that start on the surfaces of some entities.
fn rays_of(transport: &Transport, of: [u64; 2]) -> f64 {
    let patches = entities(transport).iter().filter(|entity| of.contains(entity)).count();
    patches as f64 * f64::from(transport.certificate.rays_per_row)
}

fn sigma(transport: &Transport, factor: f64, of: [u64; 2]) -> f64 {
    (factor * (1.0 - factor) / rays_of(transport, of)).sqrt()
}

fn assert_closes(transport: &Transport) {
    for (i, patch) in transport.patches.iter().enumerate() {
        let (sum, target) = (transport.patch_from_patch.sum(i), f64::from(patch.target));
        assert!(sum <= target && sum >= target - 2e-7, "row {i} sums to {sum}, its target is {target}");
    }
}

// ---- case 35

const STRIPES: usize = 8;

/// Two unit squares that face each other a metre apart, stripes of half the surface midway.
fn grating() -> TestProject {
    let stripe = 0.5 / STRIPES as f32;
    let bar = |k: usize| rectangle(Vec3::new(2.0 * k as f32 * stripe, 0.5, 0.0), Vec3::Z, Vec3::X * stripe);
    let project = project(&[
        ("floor", rectangle(Vec3::ZERO, Vec3::Z, Vec3::X)),
        ("ceiling", rectangle(Vec3::Y, Vec3::X, Vec3::Z)),
        ("bars", (0..STRIPES).flat_map(bar).collect()),
    ]);
    paint(&project, |name, material| material.double_sided = name == "bars");
    project
}

/// The same by plain random rays: cosine directions from even points, and no tree.
fn grating_by_rays(rays: u32) -> f64 {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut random = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut hits = 0;
    for _ in 0..rays {
        let (x, z, radius, turn) = (random(), random(), random().sqrt(), 2.0 * PI * random());
        let up = (1.0 - radius * radius).sqrt().max(1e-12);
        let at = |height: f64| [x + radius * turn.cos() / up * height, z + radius * turn.sin() / up * height];
        let inside = |[x, z]: [f64; 2]| (0.0..1.0).contains(&x) && (0.0..1.0).contains(&z);
        let middle = at(0.5);
        let blocked = inside(middle) && (middle[0] * STRIPES as f64).fract() < 0.5;
        hits += u32::from(inside(at(1.0)) && !blocked);
    }
    f64::from(hits) / f64::from(rays)
}

/// Rows of this format keep every entry that a ray found: there is no limit on their number, and no bound of
/// what was cut off to be compared with what is.
#[test]
fn light_passes_a_grating_as_far_as_its_gaps_let_it_and_the_rows_close() {
    let transport = baked(&grating(), &settings(0.25, 1024));
    const RAYS: u32 = 1 << 20;
    let wanted = grating_by_rays(RAYS);
    let own = (wanted * (1.0 - wanted) / f64::from(RAYS)).sqrt();
    for [from, to] in [[1, 2], [2, 1]] {
        let found = form_factor(&transport, from, to);
        let sigma = sigma(&transport, wanted, [1, 2]).hypot(own);
        println!("{from} -> {to}: {found:.5}, {wanted:.5} by rays, {:+.2} sigma", (found - wanted) / sigma);
        assert!((found - wanted).abs() <= 4.0 * sigma, "{found} {wanted}");
    }
    assert_eq!(transport.certificate.lost, 0.0);
    assert_closes(&transport);
}

// ---- cases 39 and 40

/// B by patch of unit area for a full matrix.
fn solved(matrix: &[Vec<f64>], albedo: f32, e: &[f64]) -> Vec<f64> {
    let mut rows = Rows::default();
    matrix.iter().for_each(|row| rows.push((0..).zip(row.iter().map(|&share| share as f32))));
    let patches = vec![Patch { area: 1.0, aggregate: NONE, ..Patch::default() }; e.len()];
    let albedo = vec![Vec3::splat(albedo); e.len()];
    let e: Vec<DVec3> = e.iter().map(|&e| DVec3::splat(e)).collect();
    exact(&System { rows: &rows, patches: &patches, albedo: &albedo }, &e, 1e-12)
        .iter()
        .map(|b| b.x)
        .collect()
}

/// M = 1 W/m2 on one surface, one albedo for all.
fn lit(project: &TestProject, bright: &str, albedo: f32) {
    paint(project, |name, material| {
        material.albedo.color = Vec3::splat(albedo);
        material.emission.color = Vec3::splat(if name == bright { 1.0 / PI as f32 } else { 0.0 });
    });
}

#[test]
fn two_squares_that_face_each_other_exchange_light_as_the_closed_form_says() {
    const F: f64 = 0.199_825;
    let wanted = [1.010_083, 0.100_920];
    let b = solved(&[vec![0.0, F], vec![F, 0.0]], 0.5, &[1.0, 0.0]);
    assert!(b.iter().zip(wanted).all(|(b, wanted)| (b - wanted).abs() < 1e-6), "{b:?}");

    let project = project(&[
        ("lit", rectangle(Vec3::ZERO, Vec3::Z, Vec3::X)),
        ("dark", rectangle(Vec3::Y, Vec3::X, Vec3::Z)),
    ]);
    lit(&project, "lit", 0.5);
    let light = Solved::of(&project, &settings(0.25, 2048));
    // B_2 = rho F B_1, B_1 = 1 + rho F B_2: an error of F goes into B_2 halved, into B_1 as a tenth.
    let sigma = sigma(&light.transport, F, [1, 2]);
    for (entity, wanted, share) in [(1, wanted[0], 0.1), (2, wanted[1], 0.5)] {
        let found = light.mean_of(entity).x;
        println!("{found:.6}, {wanted:.6} wanted, {:+.2} sigma", (found - wanted) / (share * sigma));
        assert!((found - wanted).abs() <= 4.0 * share * sigma + 1e-6, "{found} {wanted}");
    }
}

#[test]
fn a_cube_of_six_patches_has_the_radiosity_of_its_analytic_matrix() {
    const OPPOSITE: f64 = 0.199_825;
    let adjacent = (1.0 - OPPOSITE) / 4.0;
    let share = |i: usize, j: usize| match (i == j, i / 2 == j / 2) {
        (true, _) => 0.0,
        (_, true) => OPPOSITE,
        _ => adjacent,
    };
    let matrix: Vec<Vec<f64>> = (0..6).map(|i| (0..6).map(|j| share(i, j)).collect()).collect();
    let project = project(&shell(Vec3::ZERO, Vec3::ONE, WALLS));
    for (albedo, wanted) in
        [(0.5, [1.090_909, 0.181_836, 0.181_746]), (0.9, [2.372_881, 1.525_452, 1.525_311])]
    {
        let b = solved(&matrix, albedo, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
        for (found, wanted) in [(b[3], wanted[0]), (b[0], wanted[1]), (b[2], wanted[2])] {
            assert!((found - wanted).abs() < 1.5e-6, "rho {albedo}: {found} {wanted}");
        }

        lit(&project, "+y", albedo);
        let light = Solved::of(&project, &settings(1.0, 16384));
        assert_eq!(light.patches(), 6);
        // Balanced rows keep the sum of light whatever rays found.
        let sum: f64 = light.b().iter().map(|b| b.x).sum();
        assert!((sum * f64::from(1.0 - albedo) - 1.0).abs() < 1e-5, "rho {albedo}: {sum}");
        // Beside that sum, I - rho P stretches by 1 + 0.2 rho: P's other eigenvalues are -0.2. What arrives is
        // wrong by dF (B_ceiling - B_floor), as rows close; taking the mean off at most doubles it.
        let rho = f64::from(albedo);
        let sigma = (OPPOSITE * (1.0 - OPPOSITE) / (2.0 * 16384.0)).sqrt();
        let bound = 4.0 * sigma * rho * 2.0 * (wanted[0] - wanted[2]) / (1.0 + 0.2 * rho);
        for (entity, wanted) in [(4, wanted[0]), (1, wanted[1]), (3, wanted[2])] {
            let found = light.mean_of(entity).x;
            println!("rho {albedo}: {found:.6}, {wanted:.6} wanted, bound {bound:.1e}");
            assert!((found - wanted).abs() <= bound, "rho {albedo}: {found} {wanted}");
        }
    }
}

// ---- case 42

/// A room that is the same from no two sides.
fn crooked() -> Vec<(&'static str, Vec<Vec<Vec3>>)> {
    let mut surfaces = shell(Vec3::ZERO, Vec3::new(2.0, 1.0, 1.5), WALLS);
    surfaces.push(("block", block(Vec3::new(0.25, 0.25, 0.5), Vec3::new(0.75, 0.875, 1.0))));
    surfaces
}

#[test]
fn a_scene_that_is_turned_or_mirrored_has_the_same_form_factors() {
    let settings = settings(0.5, 1024);
    let plain = baked(&project(&crooked()), &settings);
    let turned = |faces: Vec<Vec<Vec3>>| -> Vec<Vec<Vec3>> {
        faces.iter().map(|face| face.iter().map(|p| Vec3::new(p.z, p.y, -p.x)).collect()).collect()
    };
    let surfaces: Vec<_> = crooked().into_iter().map(|(name, faces)| (name, turned(faces))).collect();
    let turned = baked(&project(&surfaces), &settings);
    let mirrored = project(&crooked());
    change(&mirrored, |scene| scene.entities.iter_mut().for_each(|entity| entity.transform.scale.x = -1.0));
    let mirrored = baked(&mirrored, &settings);
    for (what, transport) in [("turned", &turned), ("mirrored", &mirrored)] {
        // Walls still face the inside: no ray meets a back.
        assert_eq!(transport.certificate.lost, 0.0, "{what}");
        let mut worst = 0.0_f64;
        for from in 1..=7 {
            for to in (1..=7).filter(|&to| to != from) {
                let (a, b) = (form_factor(&plain, from, to), form_factor(transport, from, to));
                // A wall's rays find the small block more seldom than its own find the wall.
                let wanted = 0.5 * (a + b);
                let sigma = sigma(&plain, wanted, [from, to]) * 2.0_f64.sqrt();
                worst = worst.max((a - b).abs() / sigma.max(1e-12));
            }
        }
        println!("{what}: form factors differ by at most {worst:.2} sigma");
        assert!(worst <= 4.0, "{what}: {worst}");
    }
    let middle = Vec3::new(-1.0, 0.5, 0.75) - mirrored.origin.as_vec3();
    let of = entities(&mirrored);
    let inward = (0..of.len()).filter(|&i| of[i] <= 6);
    for patch in inward.map(|i| &mirrored.patches[i]) {
        assert!(patch.normal.dot(middle - patch.centre) > 0.0, "{patch:?}");
    }
}

// ---- case 46

/// Rows are stored as f32, in which nothing of this size underflows: there is nothing to fold, and the bound is the
/// one that all rows keep.
#[test]
fn weights_too_small_for_half_floats_are_kept_and_rows_still_close() {
    let side = 1e-4;
    let speck = rectangle(Vec3::new(0.5, 0.5, 0.5), Vec3::X * side, Vec3::Z * side);
    let mut surfaces = shell(Vec3::ZERO, Vec3::ONE, WALLS);
    surfaces.push(("speck", speck));
    let project = project(&surfaces);
    paint(&project, |name, material| material.double_sided = name == "speck");
    let transport = baked(&project, &settings(0.25, 512));
    assert_closes(&transport);
    let (there, back) = (form_factor(&transport, 1, 7), form_factor(&transport, 7, 1));
    println!("towards the speck {there:.3e}, from it {back:.3}");
    let least = transport.patch_from_patch.weights.iter().copied().fold(1.0, f32::min);
    assert!(least > 0.0 && least < 6e-8, "{least}");
    let of = entities(&transport);
    let speck = transport.patches.iter().zip(of).filter(|(_, of)| *of == 7);
    let area: f64 = speck.map(|(patch, _)| f64::from(patch.area)).sum();
    assert!((there / (area * back) - 1.0).abs() < 1e-5, "reciprocity: {there} {back}");
}

// ---- case 61

/// Two rooms that no light passes between; the names of the second end on 2.
fn apart_rooms() -> TestProject {
    let names = ["-x 2", "+x 2", "-y 2", "+y 2", "-z 2", "+z 2"];
    let mut surfaces = shell(Vec3::ZERO, Vec3::ONE, WALLS);
    surfaces.extend(shell(Vec3::new(2.0, 0.0, 0.0), Vec3::new(3.0, 1.0, 1.0), names));
    let project = project(&surfaces);
    lit(&project, "+y", 0.8);
    project
}

#[test]
fn taking_out_what_no_light_reaches_leaves_the_rest_as_it_is() {
    let project = apart_rooms();
    let whole = Solved::of(&project, &settings(0.25, 256));
    let of = entities(&whole.transport);
    let first: Vec<usize> = (0..of.len()).filter(|&i| of[i] <= 6).collect();

    // As the runtime does with what is gone since the bake.
    let mut scene = whole.scene.clone();
    scene.entities.retain(|entity| entity.id.0 <= 6);
    let certificate = &whole.transport.certificate;
    let with = BakeWith {
        quality: Default::default(),
        rays: certificate.rays_per_row,
        length: certificate.base_length,
    };
    let stale =
        Stale::between(&certificate.inputs, &inputs(&scene, &whole.assets, &with, &Default::default()));
    assert_eq!(stale.gone.len(), 6, "{stale}");
    let mut transport = whole.transport.clone();
    transport.leave_out(&stale);
    transport.validate().expect("a sound transport");
    let rest = Solved::with(scene, whole.assets.clone(), transport);
    let b = |light: &Solved| -> Vec<DVec3> { first.iter().map(|&i| light.b()[i]).collect() };
    assert!(largest(&b(&whole)) > 1.0);
    let off = apart(&b(&whole), &b(&rest)) / largest(&b(&whole));

    // And with the rows themselves gone.
    let mut rows = Rows::default();
    for &i in &first {
        rows.push(whole.transport.patch_from_patch.row(i));
    }
    let patches: Vec<Patch> = first.iter().map(|&i| whole.transport.patches[i]).collect();
    let albedo: Vec<Vec3> = first.iter().map(|&i| whole.materials.albedo[i]).collect();
    let e: Vec<DVec3> = first.iter().map(|&i| whole.exitance[i]).collect();
    assert!(rows.validate(first.len(), first.len(), true).is_ok(), "no row names what is gone");
    let alone = exact(&System { rows: &rows, patches: &patches, albedo: &albedo }, &e, 1e-10);
    let off_alone = apart(&b(&whole), &alone) / largest(&alone);
    println!("left out {off:.1e}, removed {off_alone:.1e}");
    assert!(off <= 1e-6 && off_alone <= 1e-6, "{off} {off_alone}");
    let dark = (0..of.len()).filter(|&i| of[i] > 6);
    assert!(dark.into_iter().all(|i| whole.b()[i] == DVec3::ZERO));
}

// ---- case 62

/// There is no light through surfaces in this program, and so no tau beside rho that would have to be scaled: of the
/// case there remains that both sides of a card are surfaces of their own, that an albedo above 1 counts as 1 and is
/// told, and that nothing comes through.
#[test]
fn a_card_with_two_sides_reflects_on_both_lets_nothing_through_and_never_gives_more_than_it_gets() {
    let mut surfaces = shell(Vec3::ZERO, Vec3::new(2.0, 1.0, 1.0), WALLS);
    surfaces.push(("card", rectangle(Vec3::X, Vec3::Y, Vec3::Z)));
    let project = project(&surfaces);
    lit(&project, "-x", 0.5);
    paint(&project, |name, material| {
        if name == "card" {
            (material.albedo.color, material.double_sided) = (Vec3::splat(1.2), true);
        }
    });
    let light = Solved::of(&project, &settings(0.25, 512));
    let told = &light.transport.certificate.warnings;
    assert!(told.iter().any(|line| line.contains("`card`") && line.contains("clamped")), "{told:?}");
    let of = entities(&light.transport);
    let card: Vec<usize> = (0..of.len()).filter(|&i| of[i] == 7).collect();
    let light_of = |back: u32| -> Vec<DVec3> {
        let side = card.iter().filter(|&&i| light.transport.patches[i].back == back);
        side.map(|&i| light.b()[i]).collect()
    };
    assert!(light_of(0).len() >= 8 && light_of(0).len() == light_of(1).len());
    assert!(card.iter().all(|&i| light.materials.albedo[i] == Vec3::ONE));
    // The front looks along +x, away from the light.
    assert_eq!(largest(&light_of(0)), 0.0);
    assert!(light_of(1).iter().all(|b| b.x > 0.0));
    for (i, patch) in light.transport.patches.iter().enumerate() {
        let beyond = f64::from(patch.centre.x) + light.transport.origin.x > 1.0 + 1e-6;
        assert!(!beyond || light.b()[i] == DVec3::ZERO, "{patch:?}");
    }
    let [gone, given] = light.balance();
    assert!((gone.x / given.x - 1.0).abs() < 1e-4, "{gone} {given}");
    // A card that would give off 1.2 of what it gets would be singular here, or worse.
    let b = exact(&system(&light.transport, &light.materials.albedo), &light.exitance, 1e-10);
    assert!(largest(&b) <= 1.0 / (1.0 - 0.5));
}
