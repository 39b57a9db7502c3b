//! Form factors of pairs that are small, close, or touch. Cases 14 to 18 of the catalogue.
//!
//! The limit is 4 sigma of as many independent rays, sigma = sqrt(F (1 - F) / N), N the rays that start on both
//! surfaces: the balanced rows pool both directions.

use engine::transport::Transport;
use glam::Vec3;
use tests::enclosure::{Wall, change, project};
use tests::project::TestProject;
use tests::solution::{baked, solved};
use tests::surfaces::{Faces, area, entities, form_factor, quad};

const RAYS: u32 = 4096;

fn pair(first: Faces, second: Faces) -> TestProject {
    project(&[Wall::new("first", first), Wall::new("second", second)])
}

fn rays_of(transport: &Transport, of: &[u64]) -> f64 {
    let patches = entities(transport).iter().filter(|entity| of.contains(entity)).count();
    patches as f64 * f64::from(transport.certificate.rays_per_row)
}

/// From the first to the second, whose rays count too where `both`.
fn assert_factor(transport: &Transport, [from, to]: [u64; 2], wanted: f64, both: bool) {
    let rays = rays_of(transport, if both { &[1, 2] } else { &[1] });
    let (found, sigma) = (form_factor(transport, from, to), (wanted * (1.0 - wanted) / rays).sqrt());
    println!(
        "{from} -> {to}: {found:.6} of {wanted:.6}, {:+.2} sigma of {sigma:.1e}",
        (found - wanted) / sigma
    );
    assert!((found - wanted).abs() <= 4.0 * sigma, "{from} -> {to}: {found}, not {wanted}");
}

/// Both ways; rows are sound, and closed by balancing alone: what it could not close would lie on the diagonal.
fn assert_pair(first: Faces, second: Faces, length: f64, wanted: f64) -> Transport {
    let ratio = area(&first) / area(&second);
    let transport = baked(&pair(first, second), length, RAYS).transport;
    transport.validate().expect("sound rows");
    assert_factor(&transport, [1, 2], wanted, true);
    assert_factor(&transport, [2, 1], wanted * ratio, true);
    assert!(form_factor(&transport, 1, 1).max(form_factor(&transport, 2, 2)) <= 2e-7);
    assert!((0..transport.patches.len()).all(|i| transport.patch_from_patch.sum(i) <= 1.0));
    transport
}

// Case 14.
#[test]
fn areas_ten_orders_apart_exchange_light_by_reciprocity() {
    let small = quad(Vec3::new(-0.5e-5, 0.0, -0.5e-5), Vec3::Z * 1e-5, Vec3::X * 1e-5);
    let large = quad(Vec3::new(-0.5, 1.0, -0.5), Vec3::X, Vec3::Z);
    let ratio = area(&small) / area(&large);
    let transport = baked(&pair(small, large), 0.25, 1 << 16).transport;
    // All rays that find anything start on the small one.
    assert_factor(&transport, [1, 2], 0.239_456, false);
    let (there, back) = (form_factor(&transport, 1, 2), form_factor(&transport, 2, 1));
    println!("back {back:e} of {:e}", 0.239_456 * ratio);
    // In f64 the pooled matrix is symmetric by construction; what is stored, areas too, is rounded to floats.
    assert!((back / (there * ratio) - 1.0).abs() < 4.0 * f64::from(f32::EPSILON), "{back:e}");
}

// Case 15.
#[test]
fn squares_that_share_an_edge_exchange_what_the_closed_form_says() {
    let floor = || quad(Vec3::ZERO, Vec3::Z, Vec3::X);
    assert_pair(floor(), quad(Vec3::ZERO, Vec3::Y, Vec3::Z), 0.25, 0.200_044);

    // The other estimator: a strip that is sampled towards, by Lambert's formula at points up to its edge.
    let strip = quad(Vec3::ZERO, Vec3::Y * 0.1, Vec3::Z);
    let project = pair(strip, floor());
    change(&project, |scene| scene.materials[0].emission.sampled = true);
    let transport = baked(&project, 0.25, RAYS).transport;
    assert!(transport.patch_from_patch.weights.iter().all(|weight| weight.is_finite()));
    assert_factor(&transport, [1, 2], 0.432_514, true);
    assert_factor(&transport, [2, 1], 0.043_251_4, true);
}

// Case 16.
#[test]
fn squares_that_share_a_corner_exchange_what_the_closed_form_says() {
    let upright = quad(Vec3::Y, Vec3::Y, Vec3::Z);
    assert_pair(quad(Vec3::ZERO, Vec3::X, Vec3::Y), upright, 0.25, 0.040_592_2);
}

// Case 17.
#[test]
fn a_wedge_of_one_degree_keeps_all_but_what_the_closed_form_lets_out() {
    let (sin, cos) = 1.0_f32.to_radians().sin_cos();
    let leaf = quad(Vec3::ZERO, Vec3::new(cos, sin, 0.0), Vec3::Z);
    assert_pair(quad(Vec3::ZERO, Vec3::Z, Vec3::X), leaf, 0.25, 0.983_00);
    // And it can be solved: light between the two bounces 60 times before it is out.
    let leaf = quad(Vec3::ZERO, Vec3::new(cos, sin, 0.0), Vec3::Z);
    let wedge = solved(&pair(quad(Vec3::ZERO, Vec3::Z, Vec3::X), leaf), 0.25, 256);
    let white = wedge.again(|scene| tests::enclosure::paint(scene, 1.0, 1.0));
    println!("gain {}", white.gain());
    assert!((20.0..1e3).contains(&white.gain()), "{}", white.gain());
    assert!(white.b.iter().zip(&white.e).all(|(b, e)| b.is_finite() && b.cmpge(*e).all()));
}

// Case 18. Symmetric scaling alone is slow here, as the plates see nothing but each other; the least squares before it
// are not. Were they, the diagonal would hold what is left open.
#[test]
fn plates_a_thousandth_apart_lose_two_thousandths() {
    for (gap, wanted) in [(1e-3, 0.998_006), (1e-2, 0.980_417)] {
        let floor = quad(Vec3::ZERO, Vec3::Z, Vec3::X);
        assert_pair(floor, quad(Vec3::Y * gap, Vec3::X, Vec3::Z), 0.25, wanted);
    }
}
