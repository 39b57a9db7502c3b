//! The references that everything fast is measured against: the path tracer against closed forms, against another
//! path tracer and against itself; the dense matrix against closed forms and against the bake's rows.

mod itself;
mod light;
mod matrix;
mod others;

use bake::Point;
use bake::reference::Measured;
use engine::scene::LightKind;
use glam::{DVec3, Vec3};
use tests::lit::{BLACK, Lit, Paint};
use tests::room::{light, walls};
use tests::surfaces::{Faces, face, quad};

/// A room of 2 m x 2 m x 1 m with a red and a green wall, a lamp under its ceiling and a point light.
fn coloured_room() -> Lit {
    let grey = Paint { albedo: 0.6, exitance: 0.0 };
    let names = ["-x", "+x", "-y", "+y", "-z", "+z"];
    let walls = walls(Vec3::ZERO, Vec3::new(2.0, 1.0, 2.0));
    let mut surfaces: Vec<(&str, Faces, Paint)> =
        names.into_iter().zip(&walls).map(|(name, wall)| (name, face(wall), grey)).collect();
    let lamp = quad(Vec3::new(0.5, 0.9, 0.5), Vec3::X * 0.5, Vec3::Z * 0.5);
    surfaces.push(("lamp", lamp, Paint { exitance: 5.0, ..BLACK }));
    let candle = light(50, LightKind::Point, 0.2, DVec3::new(1.6, 0.3, 1.5), DVec3::ZERO);
    let lit = Lit::new(&surfaces, vec![candle]);
    lit.change(|scene| {
        scene.materials[0].albedo.color = Vec3::new(0.8, 0.1, 0.1);
        scene.materials[1].albedo.color = Vec3::new(0.1, 0.7, 0.2);
    });
    lit
}

/// So many points on the walls of a box, evenly (Roberts' sequence), off its edges.
fn points_in_box(low: Vec3, high: Vec3, count: usize) -> Vec<Point> {
    let walls = walls(low, high);
    let point = |k: usize| {
        let at = |step: f64| (0.02 + 0.96 * (0.5 + step * k as f64).fract()) as f32;
        let wall = &walls[k % 6];
        Point {
            position: wall.at(at(0.754_877_666), at(0.569_840_291)).as_dvec3(),
            normal: wall.normal().as_dvec3(),
        }
    };
    (0..count).map(point).collect()
}

/// What differences say of the errors that two sides claim: mean chi-square, by channel the bias in sigmas of the sum,
/// and the largest difference in sigmas.
#[derive(Debug)]
struct Consistency {
    chi_square: f64,
    bias: DVec3,
    worst: f64,
}

fn consistency(found: &[[DVec3; 2]], wanted: &[[DVec3; 2]]) -> Consistency {
    let (mut chi, mut sum, mut variance, mut worst) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO, 0.0_f64);
    let mut known = 0.0;
    for ([found, sigma], [wanted, other]) in found.iter().zip(wanted) {
        let squared = *sigma * *sigma + *other * *other;
        let difference = *found - *wanted;
        if squared.min_element() <= 0.0 {
            assert!(
                difference.abs().max_element() <= 1e-6 * wanted.max_element(),
                "{found} is said to be exact"
            );
            continue;
        }
        known += 1.0;
        chi += difference * difference / squared;
        sum += difference;
        variance += squared;
        worst = worst.max((difference / squared.map(f64::sqrt)).abs().max_element());
    }
    Consistency { chi_square: chi.element_sum() / (3.0 * known), bias: sum / variance.map(f64::sqrt), worst }
}

fn with_error(measured: &[Measured]) -> Vec<[DVec3; 2]> {
    measured.iter().map(|point| [point.total(), point.standard_error]).collect()
}

/// Differences over errors of 16 replicates are Student's t with 15 degrees of freedom: the mean of their squares is
/// 15/13, with a spread of 1.84 over the root of the number of points.
fn assert_consistent(what: &str, found: &[[DVec3; 2]], wanted: &[[DVec3; 2]]) {
    let consistency = consistency(found, wanted);
    println!("{what}: {consistency:.2?}");
    let spread = 4.0 * 1.84 / (found.len() as f64).sqrt();
    assert!((consistency.chi_square - 15.0 / 13.0).abs() <= spread.max(0.4), "{what}: {consistency:?}");
    assert!(consistency.bias.abs().max_element() <= 3.5, "{what}: {consistency:?}");
    assert!(consistency.worst <= 6.5, "{what}: {consistency:?}");
}
