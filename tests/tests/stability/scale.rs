//! Scenes far away, tiny and huge. Cases 23 and 24 of the catalogue.

use engine::scene::{LightKind, Scene};
use engine::transport::{Transport, file};
use glam::{DVec3, Vec3};
use tests::enclosure::{Wall, change, furnished, paint, project};
use tests::room::light;
use tests::solution::{Solved, baked, solved};
use tests::surfaces::{form_factor, quad};

const LENGTH: f64 = 0.3;
const RAYS: u32 = 512;

/// The room, glowing and with a lamp, each entity changed as told; lengths grow by `scale`.
fn room(scale: f64, place: impl Fn(&mut Scene)) -> Solved {
    let project = project(&furnished());
    change(&project, |scene| {
        paint(scene, 0.8, 0.0);
        scene.materials[0].emission.color = Vec3::ONE;
        // As bright as before, from farther away.
        let intensity = (scale * scale) as f32;
        let at = DVec3::new(0.5, 0.8, 0.3);
        scene.entities.push(light(100, LightKind::Point, intensity, at, DVec3::ZERO));
        place(scene);
    });
    solved(&project, LENGTH * scale, RAYS)
}

fn moved(by: DVec3) -> Solved {
    room(1.0, |scene| scene.entities.iter_mut().for_each(|entity| entity.transform.translation += by))
}

fn scaled(by: f64) -> Solved {
    room(by, |scene| {
        for entity in &mut scene.entities {
            entity.transform.translation *= by;
            entity.transform.scale *= by;
        }
    })
}

/// All arrays but where the origin is.
fn arrays(transport: &Transport) -> Vec<(&'static str, Vec<u8>)> {
    let arrays = file::arrays(transport).into_iter().filter(|(name, _)| *name != "origin");
    arrays.map(|(name, bytes)| (name, bytes.into_owned())).collect()
}

/// The light of walls, each a mean of 9 patches at least.
fn means(solved: &Solved) -> Vec<f64> {
    (1..=8).map(|id| solved.mean(&solved.of_entity(id), |i| solved.b[i].y)).collect()
}

/// Other rounding, and so other rays: 4 sigma of 9 patches' rays, sigma no more than the light itself.
fn assert_alike(a: &Solved, b: &Solved, what: &str) {
    assert_eq!(a.b.len(), b.b.len(), "{what}: patches");
    let off = means(a).into_iter().zip(means(b)).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
    println!("{what}: means {off:.1e} apart");
    assert!(off < 4.0 / (9.0 * f64::from(RAYS)).sqrt(), "{what}: {off}");
}

// Case 23.
#[test]
fn a_room_a_thousand_kilometres_away_is_baked_as_at_the_origin() {
    let here = moved(DVec3::ZERO);
    let there = moved(DVec3::new(1e6, -1e6, 1e6));
    assert!(there.warnings.is_empty(), "{:?}", there.warnings);
    assert!(arrays(&there.transport) == arrays(&here.transport), "the same to the last bit");
    assert_eq!(there.transport.origin - here.transport.origin, DVec3::new(1e6, -1e6, 1e6));
    assert_eq!(there.b, here.b);
    // By no whole step of the grid on which origins lie.
    assert_alike(&moved(DVec3::new(1_234_567.891, 0.3, -987_654.321)), &here, "moved by anything");
}

// Case 23: no f64 brings back what the mesh itself has lost.
#[test]
fn a_mesh_whose_vertices_are_far_from_its_origin_is_named_with_how_coarse_they_are() {
    let far = Vec3::new(1e6, 0.0, 0.0);
    let floor = |at: Vec3| project(&[Wall::new("floor", quad(at, Vec3::Z, Vec3::X))]);
    let baked_far = baked(&floor(far), 0.25, 256);
    let told = baked_far.warnings.iter().map(ToString::to_string).find(|text| text.contains("`floor`"));
    assert!(told.as_ref().is_some_and(|text| text.contains("6.25e-2 m apart")), "{:?}", baked_far.warnings);
    baked_far.transport.validate().expect("a sound bake");
    assert!(baked(&floor(Vec3::ZERO), 0.25, 256).warnings.is_empty());
}

// Case 24.
#[test]
fn a_room_of_tenths_of_a_millimetre_and_one_of_a_hundred_kilometres_have_the_same_light() {
    let metre = scaled(1.0);
    for exponent in [-13, -1, 1, 17] {
        let other = scaled(f64::from(exponent).exp2());
        assert!(other.transport.patch_from_patch == metre.transport.patch_from_patch, "2^{exponent}");
        assert!(other.transport.receiver_from_patch == metre.transport.receiver_from_patch, "2^{exponent}");
        assert_eq!(other.b, metre.b, "2^{exponent}");
    }
    for scale in [1e-4, 1e5] {
        let other = scaled(scale);
        assert_alike(&other, &metre, &format!("{scale}"));
        for (from, to) in [(1, 2), (3, 4), (7, 3), (1, 8)] {
            let [a, b] = [&other, &metre].map(|solved| form_factor(&solved.transport, from, to));
            // Two estimates, of at least 9 patches' rays each.
            let sigma = (2.0 * b * (1.0 - b) / (9.0 * f64::from(RAYS))).sqrt();
            assert!((a - b).abs() <= 4.0 * sigma, "{scale}, {from} -> {to}: {a} {b}");
        }
    }
}
