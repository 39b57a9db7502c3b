//! Form factors between two surfaces of a bake.
//!
//! The limit is 4 sigma of as many independent rays, sigma = sqrt(F (1 - F) / N), N the rays that start on both
//! surfaces: the balanced rows pool both directions. Where a surface is made of facets, that is said.

use bake::{Settings, Silent, bake};
use engine::transport::Transport;
use glam::Vec3;
use tests::closed_forms::{discs, opposed, parallel, perpendicular};
use tests::lit::disc;
use tests::surfaces::{Faces, area, entities, form_factor, project, quad, turned};

pub const RAYS: u32 = 4096;

pub fn baked(surfaces: &[(&str, Faces)], length: f64) -> Transport {
    let project = project(surfaces);
    let settings = Settings { rays: Some(RAYS), patch_length: Some(length), ..Settings::default() };
    let baked = bake(project.path(), None, &settings, &Silent).expect("a bake");
    let certificate = &baked.transport.certificate;
    assert!(certificate.holds(), "{:#?}", certificate.statements());
    baked.transport
}

/// Of the form factor between two entities.
pub fn sigma(transport: &Transport, [from, to]: [u64; 2], wanted: f64) -> f64 {
    let patches = entities(transport).iter().filter(|entity| [from, to].contains(entity)).count();
    (wanted * (1.0 - wanted) / (patches as f64 * f64::from(RAYS))).sqrt()
}

/// `systematic`: what the closed form itself may be off by.
pub fn assert_factor(transport: &Transport, pair: [u64; 2], wanted: f64, systematic: f64) {
    let found = form_factor(transport, pair[0], pair[1]);
    let sigma = sigma(transport, pair, wanted);
    let off = (found - wanted) / sigma;
    println!("{pair:?}: {found:.6}, {wanted:.6} wanted, {off:+.2} sigma of {sigma:.1e}");
    assert!(
        (found - wanted).abs() <= 4.0 * sigma + systematic,
        "{pair:?}: {found}, not {wanted} ({off} sigma)"
    );
}

/// Two surfaces alone: the rest leaves. `wanted`: from the first to the second.
fn assert_pair(first: Faces, second: Faces, wanted: f64, systematic: f64, length: f64) {
    let ratio = area(&first) / area(&second);
    let transport = baked(&[("first", first), ("second", second)], length);
    assert_eq!(transport.certificate.lost, 0.0, "no ray meets a back");
    assert_factor(&transport, [1, 2], wanted, systematic);
    assert_factor(&transport, [2, 1], wanted * ratio, systematic * ratio);
    assert!(
        form_factor(&transport, 1, 1).max(form_factor(&transport, 2, 2)) <= 2e-7,
        "flat ones see themselves"
    );
}

/// x, z in the plane y, facing up.
fn floor(x: [f32; 2], z: [f32; 2], y: f32) -> Faces {
    quad(Vec3::new(x[0], y, z[0]), Vec3::Z * (z[1] - z[0]), Vec3::X * (x[1] - x[0]))
}

/// z, y in the plane x = 0, facing +x.
fn wall(z: [f32; 2], y: [f32; 2]) -> Faces {
    quad(Vec3::new(0.0, y[0], z[0]), Vec3::Y * (y[1] - y[0]), Vec3::Z * (z[1] - z[0]))
}

fn wide([from, to]: [f32; 2]) -> [f64; 2] {
    [f64::from(from), f64::from(to)]
}

const UNIT: [f32; 2] = [0.0, 1.0];

#[test]
fn plates_far_apart_see_little_of_each_other() {
    assert_pair(floor(UNIT, UNIT, 0.0), turned(floor(UNIT, UNIT, 10.0)), opposed(1.0, 1.0, 10.0), 0.0, 0.25);
}

#[test]
fn parallel_rectangles_may_be_shifted_and_of_other_sizes() {
    for (x, z, wanted) in [([1.0, 2.0], [1.0, 2.0], 0.043_327_4), ([-0.5, 1.5], [-0.5, 1.5], 0.517_653)] {
        let closed = parallel(wide(UNIT), wide(UNIT), wide(x), wide(z), 1.0);
        assert!((closed - wanted).abs() < 1e-6, "{closed}");
        assert_pair(floor(UNIT, UNIT, 0.0), turned(floor(x, z, 1.0)), closed, 0.0, 0.25);
    }
}

#[test]
fn perpendicular_rectangles_may_have_any_widths_gaps_and_shifts() {
    for (x, z, wall_z, wall_y, wanted) in [
        (UNIT, UNIT, UNIT, [0.0, 2.0], 0.232_853),
        ([0.0, 2.0], UNIT, UNIT, UNIT, 0.116_426),
        (UNIT, UNIT, UNIT, [0.0, 0.5], 0.146_187),
        ([0.0, 0.1], UNIT, UNIT, UNIT, 0.432_514),
        ([0.1, 1.1], UNIT, UNIT, UNIT, 0.162_823),
        (UNIT, UNIT, [1.0, 2.0], UNIT, 0.040_592_2),
    ] {
        let closed = perpendicular(wide(x), wide(z), wide(wall_z), wide(wall_y));
        assert!((closed - wanted).abs() < 1e-6, "{closed}");
        assert_pair(floor(x, z, 0.0), wall(wall_z, wall_y), closed, 0.0, 0.25);
    }
}

#[test]
fn discs_of_any_radii_see_what_the_closed_form_says() {
    for (r1, r2, h, wanted) in
        [(1.0, 2.0, 1.0, 0.763_932), (1.0, 1.0, 0.1, 0.904_875), (0.5, 1.0, 2.0, 0.192_236)]
    {
        let closed = discs(f64::from(r1), f64::from(r2), f64::from(h));
        assert!((closed - wanted).abs() < 1e-6, "{closed}");
        // Polygons of the discs' areas; what their edges waver by is worth less than 1e-4.
        assert_pair(disc(r1, 0.0, 64), turned(disc(r2, h, 64)), closed, 1e-4, 0.25);
    }
}

/// Long strips against Hottel's crossed strings, to 1 % (their ends), and to noise where the finite form is known.
#[test]
fn long_strips_see_what_crossed_strings_say() {
    const LENGTH: f32 = 100.0;
    let strip = |x: [f32; 2]| floor(x, [0.0, LENGTH], 0.0);
    for (height, wanted) in [(1.0, 0.414_214), (0.1, 0.904_988)] {
        let closed = opposed(1.0, f64::from(LENGTH), f64::from(height));
        assert!((closed / wanted - 1.0).abs() <= 0.01, "{closed}");
        assert_pair(strip(UNIT), turned(floor(UNIT, [0.0, LENGTH], height)), closed, 0.0, 1.0);
    }
    for (height, wanted) in [(1.0, 0.292_893), (2.0, 0.381_966)] {
        let closed = perpendicular(wide(UNIT), [0.0, 100.0], [0.0, 100.0], [0.0, f64::from(height)]);
        assert!((closed / wanted - 1.0).abs() <= 0.01, "{closed}");
        assert_pair(strip(UNIT), wall([0.0, LENGTH], [0.0, height]), closed, 0.0, 1.0);
    }
}

#[test]
fn sides_of_wedges_and_prisms_see_what_crossed_strings_say() {
    const LENGTH: f32 = 100.0;
    let leaf = |degrees: f32| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        quad(Vec3::ZERO, Vec3::new(cos, sin, 0.0), Vec3::Z * LENGTH)
    };
    let strip = || floor(UNIT, [0.0, LENGTH], 0.0);
    // 1 - sin(a/2), but for the ends.
    let transport = baked(&[("floor", strip()), ("leaf", leaf(30.0))], 1.0);
    for pair in [[1, 2], [2, 1]] {
        assert_factor(&transport, pair, 0.741_181, 0.01 * 0.741_181);
    }
    // A ray starts 2e-6 of the scene's size above its surface: in the wedge's last 0.4 mm, behind the other leaf.
    assert!(transport.certificate.lost <= 1e-3, "{}", transport.certificate.lost);
    let third = quad(Vec3::X, Vec3::Z * LENGTH, Vec3::new(-0.5, 0.75_f32.sqrt(), 0.0));
    let transport = baked(&[("floor", strip()), ("leaf", leaf(60.0)), ("roof", third)], 1.0);
    for pair in [[1, 2], [1, 3], [2, 3]] {
        assert_factor(&transport, pair, 0.5, 0.01 * 0.5);
    }
}
