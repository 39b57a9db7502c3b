//! Form factors at points: black meters of 2 cm about them, and a lamp of radiosity 1.
//!
//! Three witnesses: the receivers of the bake, a final gather, the path tracer. The first two may be off by 4 sigma of
//! as many independent rays, the last by 4 of its own standard errors.

use bake::{Method, Point};
use glam::{DVec3, Vec3};
use tests::closed_forms::{point_parallel, point_perpendicular, point_polygon};
use tests::lit::{BLACK, LAMP, Lit, belt, disc, meter, point};
use tests::surfaces::{Faces, quad, turned};

const RAYS: u32 = 1 << 14;

/// `systematic`: what the closed form itself may be off by.
fn assert_factors(lamp: Faces, points: &[(Point, f64)], systematic: f64) {
    let meters: Faces = points.iter().flat_map(|(point, _)| meter(point, 0.02)).collect();
    let lit = Lit::new(&[("meters", meters, BLACK), ("lamp", lamp, LAMP)], Vec::new());
    lit.bake(0.25, RAYS);
    let (points, wanted): (Vec<Point>, Vec<f64>) = points.iter().copied().unzip();
    for method in [Method::Receivers, Method::Gather] {
        for (found, wanted) in lit.query(&points, method).iter().zip(&wanted) {
            let limit = 4.0 * (wanted * (1.0 - wanted) / f64::from(RAYS)).sqrt() + systematic;
            println!("{method:?}: {:.6}, {wanted:.6} wanted, limit {limit:.1e}", found.direct.x);
            assert!((found.direct.x - wanted).abs() <= limit, "{method:?}: {}, not {wanted}", found.direct.x);
            assert_eq!(found.indirect.x, 0.0);
        }
    }
    for (found, wanted) in lit.traced(&points, 1 << 13).iter().zip(&wanted) {
        let limit = 4.0 * found.standard_error.x + systematic;
        println!("path tracer: {:.6}, {wanted:.6} wanted, limit {limit:.1e}", found.direct.x);
        assert!((found.direct.x - wanted).abs() <= limit, "path tracer: {}, not {wanted}", found.direct.x);
        assert_eq!(found.indirect.x, 0.0);
    }
}

const UP: [f64; 3] = [0.0, 1.0, 0.0];
const RIGHT: [f64; 3] = [1.0, 0.0, 0.0];

/// x, z of 0..1 at this height, facing down.
fn square(height: f32) -> Faces {
    quad(Vec3::Y * height, Vec3::X, Vec3::Z)
}

#[test]
fn a_point_under_a_rectangle_gets_what_the_closed_form_says() {
    let under = |x: f64, z: f64| (point([x, 0.0, z], UP), point_parallel([-x, 1.0 - x], [-z, 1.0 - z], 1.0));
    assert!((under(0.0, 0.0).1 - 0.138_532).abs() < 1e-6);
    assert!((under(0.5, 0.5).1 - 0.239_456).abs() < 1e-6);
    assert_factors(square(1.0), &[under(0.0, 0.0), under(0.5, 0.5), under(-1.5, 0.25), under(3.0, 2.0)], 0.0);
}

#[test]
fn a_point_beside_a_rectangle_gets_what_the_closed_form_says() {
    let beside = |x: f64, z: f64| {
        let along = [(-x).max(0.0), 1.0 - x];
        (point([x, 0.0, z], RIGHT), point_perpendicular(along, [-z, 1.0 - z], 1.0))
    };
    assert!((beside(0.0, 0.0).1 - 0.055_734_2).abs() < 1e-6);
    assert_factors(square(1.0), &[beside(0.0, 0.0), beside(0.5, 0.5), beside(-2.0, 0.3)], 0.0);
}

#[test]
fn a_point_under_a_disc_gets_what_the_closed_form_says() {
    // A polygon of the disc's area: below 1e-4 of it.
    let on_axis = |height: f64| 1.0 / (1.0 + height * height);
    assert_factors(turned(disc(1.0, 1.0, 64)), &[(point([0.0; 3], UP), on_axis(1.0))], 1e-4);
    assert_factors(turned(disc(1.0, 3.0, 64)), &[(point([0.0; 3], UP), on_axis(3.0))], 1e-4);
}

/// (r/d)^2, but for the facets: what each of those that face the point sends there is Lambert's.
#[test]
fn a_point_that_faces_a_sphere_gets_the_square_of_its_apparent_size() {
    let ball: Faces = belt(1.0, 24, 12, 0..12);
    let facing = |y: f64| {
        let (position, normal) = (DVec3::Y * y, DVec3::Y * -y.signum());
        let of = |face: &Vec<Vec3>| {
            let corners: Vec<DVec3> = face.iter().map(|corner| corner.as_dvec3()).collect();
            point_polygon(position, normal, &corners)
        };
        let wanted: f64 = ball.iter().map(of).sum();
        assert!((wanted * y * y - 1.0).abs() < 0.02, "{wanted}");
        (Point { position, normal }, wanted)
    };
    assert_factors(ball.clone(), &[facing(-2.0), facing(4.0)], 0.0);
}

#[test]
fn nothing_flat_lights_its_own_plane_or_what_is_behind_it() {
    let beside = point([2.0, 1.0, 0.5], [0.0, -1.0, 0.0]);
    let behind = point([0.5, 2.0, 0.5], [0.0, -1.0, 0.0]);
    assert_factors(square(1.0), &[(beside, 0.0), (behind, 0.0)], 0.0);
    let lit = Lit::new(&[("lamp", square(1.0), LAMP)], Vec::new());
    lit.bake(0.25, 1024);
    let own = [point([0.3, 1.0, 0.6], [0.0, -1.0, 0.0])];
    for method in [Method::Receivers, Method::Gather] {
        assert_eq!(lit.query(&own, method)[0].direct.x, 0.0);
    }
    assert_eq!(lit.traced(&own, 1024)[0].direct.x, 0.0);
}
