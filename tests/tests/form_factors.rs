//! Whole bakes of surfaces whose form factors are known in closed form (Howell's catalogue; the wedges by
//! graded Gauss rules over Lambert's formula).
//!
//! The limit is 4 sigma of as many independent rays, sigma = sqrt(F (1 - F) / N), N the rays that start on both
//! surfaces: the balanced rows pool both directions. Where a surface is made of facets, that is said.

use std::f32::consts::TAU;

use bake::{Settings, Silent, bake};
use engine::transport::Transport;
use glam::Vec3;
use tests::room::walls;
use tests::surfaces::{Faces, area, entities, face, form_factor, project, quad, turned};

const RAYS: u32 = 4096;

fn baked(surfaces: &[(&str, Faces)], length: f64, rays: u32) -> Transport {
    let project = project(surfaces);
    let settings = Settings { rays: Some(rays), patch_length: Some(length), ..Settings::default() };
    let baked = bake(project.path(), None, &settings, &Silent).expect("a bake");
    let certificate = &baked.transport.certificate;
    assert!(certificate.holds(), "{:#?}", certificate.statements());
    assert_eq!(certificate.rays_per_row, rays);
    baked.transport
}

fn rays_of(transport: &Transport, of: &[u64]) -> f64 {
    let patches = entities(transport).iter().filter(|entity| of.contains(entity)).count();
    patches as f64 * f64::from(transport.certificate.rays_per_row)
}

fn sigma(transport: &Transport, wanted: f64, of: &[u64]) -> f64 {
    (wanted * (1.0 - wanted) / rays_of(transport, of)).sqrt()
}

/// `systematic`: what the closed form itself may be off by.
fn assert_factor(transport: &Transport, [from, to]: [u64; 2], wanted: f64, systematic: f64) {
    let found = form_factor(transport, from, to);
    let sigma = sigma(transport, wanted, &[from, to]);
    let off = (found - wanted) / sigma;
    println!("{from} -> {to}: {found:.6}, {wanted:.6} wanted, {off:+.2} sigma of {sigma:.1e}");
    assert!(
        (found - wanted).abs() <= 4.0 * sigma + systematic,
        "{from} -> {to}: {found}, not {wanted} ({off} sigma)"
    );
}

/// Two surfaces alone: the rest leaves.
fn assert_pair(first: Faces, second: Faces, wanted: f64, systematic: f64) {
    let ratio = area(&first) / area(&second);
    let transport = baked(&[("first", first), ("second", second)], 0.25, RAYS);
    assert_eq!(transport.certificate.lost, 0.0, "no ray meets a back");
    assert_factor(&transport, [1, 2], wanted, systematic);
    assert_factor(&transport, [2, 1], wanted * ratio, systematic * ratio);
    // Nothing flat sees itself; what rounding lacks stays on the diagonal.
    assert!(form_factor(&transport, 1, 1).max(form_factor(&transport, 2, 2)) <= 2e-7);
}

/// a x b, facing each other at this distance.
fn parallel(a: f32, b: f32, distance: f32) -> [Faces; 2] {
    [quad(Vec3::ZERO, Vec3::Z * b, Vec3::X * a), quad(Vec3::Y * distance, Vec3::X * a, Vec3::Z * b)]
}

/// Unit squares with a common edge.
fn hinged(degrees: f32) -> [Faces; 2] {
    let (sin, cos) = degrees.to_radians().sin_cos();
    [quad(Vec3::ZERO, Vec3::Z, Vec3::X), quad(Vec3::ZERO, Vec3::new(cos, sin, 0.0), Vec3::Z)]
}

#[test]
fn parallel_rectangles_see_what_the_closed_form_says() {
    for (a, distance, wanted) in
        [(1.0, 1.0, 0.199_825), (1.0, 0.5, 0.415_253), (1.0, 2.0, 0.068_589_6), (2.0, 1.0, 0.285_875)]
    {
        let [floor, ceiling] = parallel(a, 1.0, distance);
        assert_pair(floor, ceiling, wanted, 0.0);
    }
}

#[test]
fn plates_close_to_each_other_lose_little_between_them() {
    for (gap, wanted) in [(0.1, 0.826_995), (1e-2, 0.980_417)] {
        let [floor, ceiling] = parallel(1.0, 1.0, gap);
        assert_pair(floor, ceiling, wanted, 0.0);
    }
}

#[test]
fn squares_with_a_common_edge_see_each_other_at_every_angle() {
    for (degrees, wanted) in [
        (1.0, 0.983_00),
        (30.0, 0.619_028),
        (60.0, 0.370_905),
        (90.0, 0.200_044),
        (120.0, 0.086_615),
        (150.0, 0.021_345_3),
    ] {
        let [floor, leaf] = hinged(degrees);
        assert_pair(floor, leaf, wanted, 0.0);
    }
}

#[test]
fn discs_that_face_each_other_see_what_the_closed_form_says() {
    const SIDES: usize = 64;
    let disc = |y: f32| -> Faces {
        let corner = |k: usize| {
            let (sin, cos) = (TAU * k as f32 / SIDES as f32).sin_cos();
            Vec3::new(cos, y, sin)
        };
        vec![(0..SIDES).map(corner).collect()]
    };
    let (floor, ceiling) = (turned(disc(0.0)), disc(1.0));
    // Discs of the polygons' own area: 0.9992 of the radius. Their edges' wiggle is worth less than 1e-4.
    let square = area(&floor) / std::f64::consts::PI;
    let x = 2.0 + 1.0 / square;
    let wanted = (x - (x * x - 4.0).sqrt()) / 2.0;
    assert!((wanted - 0.381_966).abs() < 1e-3, "{wanted}");
    assert_pair(floor, ceiling, wanted, 1e-4);
}

/// Of flat trapezoids, facing outward.
fn sphere(radius: f32, around: usize, down: usize) -> Faces {
    let at = |i: usize, j: usize| {
        let (sin, cos) = (TAU * (i % around) as f32 / around as f32).sin_cos();
        let (ring, height) = (TAU * 0.5 * j as f32 / down as f32).sin_cos();
        let ring = if j == 0 || j == down { 0.0 } else { ring };
        Vec3::new(ring * cos, height, ring * sin) * radius
    };
    let mut faces = Faces::new();
    for i in 0..around {
        for j in 0..down {
            let mut face = vec![at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            face.dedup();
            if face.first() == face.last() {
                face.pop();
            }
            faces.push(face);
        }
    }
    faces
}

#[test]
fn a_sphere_in_a_sphere_is_all_that_it_sees() {
    let (inner, outer) = (sphere(1.0, 24, 12), turned(sphere(2.0, 24, 12)));
    // The facets' own areas; the closed form asks no more of the inner one than that it is convex.
    let ratio = area(&inner) / area(&outer);
    let transport = baked(&[("inner", inner), ("outer", outer)], 0.5, RAYS);
    let certificate = &transport.certificate;
    assert_eq!((certificate.lost, certificate.escaped), (0.0, 0.0));
    assert!((form_factor(&transport, 1, 2) - 1.0).abs() <= 1e-6, "{}", form_factor(&transport, 1, 2));
    assert!(form_factor(&transport, 1, 1) <= 2e-7);
    assert_factor(&transport, [2, 1], ratio, 0.0);
    assert_factor(&transport, [2, 2], 1.0 - ratio, 0.0);
}

#[test]
fn areas_ten_orders_apart_exchange_what_reciprocity_says() {
    let small = quad(Vec3::new(-0.5e-5, 0.0, -0.5e-5), Vec3::Z * 1e-5, Vec3::X * 1e-5);
    let large = quad(Vec3::new(-0.5, 1.0, -0.5), Vec3::X, Vec3::Z);
    let transport = baked(&[("small", small), ("large", large)], 0.25, 1 << 16);
    assert_eq!(transport.certificate.lost, 0.0);
    // All rays that find anything start on the small one.
    let (there, back) = (form_factor(&transport, 1, 2), form_factor(&transport, 2, 1));
    let (wanted, rays) = (0.239_456, rays_of(&transport, &[1]));
    println!("{there}, {wanted} wanted; {back:e} back");
    assert!((there - wanted).abs() <= 4.0 * (wanted * (1.0 - wanted) / rays).sqrt(), "{there}");
    let of = |entity: u64| -> f64 {
        let patches = transport.patches.iter().zip(entities(&transport));
        patches.filter(|(_, of)| *of == entity).map(|(patch, _)| f64::from(patch.area)).sum()
    };
    let (flux, flux_back) = (of(1) * there, of(2) * back);
    assert!((flux - flux_back).abs() <= 1e-6 * flux, "{flux:e} there, {flux_back:e} back");
}

#[test]
fn a_closed_cube_of_384_patches_keeps_all_its_light() {
    let walls = walls(Vec3::ZERO, Vec3::ONE);
    let names = ["-x", "+x", "-y", "+y", "-z", "+z"];
    let surfaces: Vec<(&str, Faces)> = names.into_iter().zip(walls.iter().map(face)).collect();
    let transport = baked(&surfaces, 0.125, RAYS);
    let certificate = &transport.certificate;
    println!("{} patches, {} receivers", certificate.patches, certificate.receivers);
    assert_eq!((certificate.lost, certificate.escaped), (0.0, 0.0));
    let rows = &transport.patch_from_patch;
    for (i, patch) in transport.patches.iter().enumerate() {
        assert_eq!(patch.target, 1.0);
        let sum = rows.sum(i);
        assert!((1.0 - 2e-7..=1.0).contains(&sum), "row {i} sums to {sum:.9}");
    }
    let area = |i: usize| f64::from(transport.patches[i].area);
    let exchange = |i: usize, j: usize| -> f64 {
        let entry = rows.row(i).find(|entry| entry.0 as usize == j);
        area(i) * entry.map_or(0.0, |entry| f64::from(entry.1))
    };
    let (mut worst, mut largest) = (0.0_f64, 0.0_f64);
    for i in 0..rows.len() {
        for (j, weight) in rows.row(i) {
            let there = area(i) * f64::from(weight);
            worst = worst.max((there - exchange(j as usize, i)).abs());
            largest = largest.max(there);
        }
    }
    println!("reciprocity missed by {:.1e} of the largest", worst / largest);
    assert!(worst <= 1e-6 * largest, "{worst:e} of {largest:e}");
    for from in 1..=6_u64 {
        for to in 1..=6_u64 {
            match ((from - 1) / 2 == (to - 1) / 2, from == to) {
                (_, true) => assert!(form_factor(&transport, from, to) <= 2e-7, "a flat wall sees itself"),
                (opposite, false) => {
                    assert_factor(&transport, [from, to], if opposite { 0.199_825 } else { 0.200_044 }, 0.0);
                }
            }
        }
    }
}
