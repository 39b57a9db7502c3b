//! The path tracer against itself: lots and threads change nothing, errors are asked for and come true, and what is no
//! point is refused.

use std::f64::consts::TAU;

use bake::reference::Surfaces;
use bake::{BakeError, Point, Silent, Watcher};
use glam::{DVec3, Vec3};

use crate::{assert_consistent, coloured_room, points_in_box, with_error};

fn points(count: usize) -> Vec<Point> {
    points_in_box(Vec3::ZERO, Vec3::new(2.0, 1.0, 2.0), count)
}

#[test]
fn roulette_changes_no_mean() {
    let lit = coloured_room();
    for surfaces in [Surfaces::Diffuse, Surfaces::Shiny] {
        let points = points(60);
        let with = lit.tracer(surfaces).irradiance(&points, 1024, 1, &Silent).expect("irradiance");
        let without = lit.tracer(surfaces).without_roulette();
        let without = without.irradiance(&points, 1024, 2, &Silent).expect("irradiance");
        assert_consistent("roulette", &with_error(&with), &with_error(&without));
    }
}

#[test]
fn threads_change_no_bit() {
    let lit = coloured_room();
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let tracer = lit.tracer(Surfaces::Shiny);
            let irradiance = tracer.irradiance(&points(20), 256, 7, &Silent).expect("irradiance");
            let places = [DVec3::new(0.3, 0.5, 0.4), DVec3::new(1.2, 0.2, 1.7)];
            (irradiance, tracer.probes(&places, 256, 7, &Silent).expect("probes"))
        })
    };
    let one = on(1);
    assert!(one.0.iter().all(|point| point.total().min_element() > 0.0));
    assert_eq!(one, on(3));
}

#[test]
fn an_error_that_is_asked_for_is_reached_and_time_ends_it_too() {
    let tracer = coloured_room().tracer(Surfaces::Diffuse);
    let points = points(24);
    let relative = |found: &[[DVec3; 2]]| {
        let mean = found.iter().map(|[e, _]| e.element_sum()).sum::<f64>();
        let squares = found.iter().map(|[_, sigma]| sigma.length_squared()).sum::<f64>();
        (squares * 3.0 * found.len() as f64).sqrt() / mean
    };
    let asked = tracer.irradiance_until(&points, 0.01, 300.0, 1, &Silent).expect("irradiance");
    let asked = with_error(&asked);
    assert!(relative(&asked) <= 0.01, "{}", relative(&asked));
    let hurried = tracer.irradiance_until(&points, 0.0, 0.0, 1, &Silent).expect("irradiance");
    let hurried = with_error(&hurried);
    assert!(relative(&hurried) > 0.01, "{}", relative(&hurried));
    assert_consistent("in a hurry", &hurried, &asked);
}

#[test]
fn the_probe_of_a_wall_tells_the_irradiance_before_it() {
    let tracer = coloured_room().tracer(Surfaces::Diffuse);
    // One pixel of a wall, seen straight on: rho E / pi, of the wall and of nothing else.
    let (at, normal) = (DVec3::new(1.3, 0.0, 0.4), DVec3::Y);
    let e = tracer.irradiance(&[Point { position: at, normal }], 16_384, 1, &Silent).expect("irradiance")[0];
    let seen = tracer.radiance(at + normal * 0.5, -normal, 16_384, 2);
    let wanted = [e.total() * 0.6 / (0.5 * TAU), e.standard_error * 0.6 / (0.5 * TAU)];
    let sigma = (seen.standard_error.powf(2.0) + wanted[1].powf(2.0)).powf(0.5);
    let off = (seen.radiance - wanted[0]) / sigma;
    assert!(off.abs().max_element() <= 4.0, "{:?}, {wanted:?} wanted, {off} sigma", seen);
}

struct Impatient;

impl Watcher for Impatient {
    fn cancelled(&self) -> bool {
        true
    }
}

#[test]
fn what_is_no_point_is_refused_by_its_number_and_a_run_can_be_cancelled() {
    let tracer = coloured_room().tracer(Surfaces::Diffuse);
    let good = points(1)[0];
    for bad in [
        Point { position: DVec3::NAN, ..good },
        Point { normal: DVec3::ZERO, ..good },
        Point { position: DVec3::splat(1e9), ..good },
        Point { normal: -good.normal, ..good },
    ] {
        let error = tracer.irradiance(&[good, bad], 16, 1, &Silent).expect_err("a refusal");
        assert!(error.to_string().contains("point 2"), "{error}");
    }
    let error = tracer.probes(&[DVec3::ZERO, DVec3::INFINITY], 16, 1, &Silent).expect_err("a refusal");
    assert!(error.to_string().contains("probe 2"), "{error}");
    for (origin, direction) in [(DVec3::NAN, DVec3::X), (DVec3::ONE, DVec3::ZERO), (DVec3::ONE, DVec3::NAN)] {
        assert_eq!(tracer.radiance(origin, direction, 16, 1).radiance, DVec3::ZERO);
    }
    assert!(matches!(tracer.irradiance(&[good], 16, 1, &Impatient), Err(BakeError::Cancelled)));
    assert!(tracer.irradiance(&[], 16, 1, &Silent).expect("nothing").is_empty());
}
