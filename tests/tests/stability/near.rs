//! Lights where light is infinite: on a surface, and inside a solid. Cases 27 and 28 of the catalogue.

use std::f64::consts::PI;

use engine::scene::LightKind;
use engine::transport::Transport;
use glam::{DVec3, Vec3};
use tests::enclosure::{Wall, block, change, cube, paint, project, room};
use tests::room::light;
use tests::runtime::Runtime;
use tests::solution::{Solved, largest, solved, wide};
use tests::surfaces::quad;

const RAYS: u32 = 64;

fn lamp_at(solved: &Solved, at: DVec3) -> Solved {
    solved.again(|scene| {
        paint(scene, 1.0, 0.0);
        scene.entities.push(light(100, LightKind::Point, 1.0, at, DVec3::ZERO));
    })
}

/// No patch takes more than half of the light's sphere sends, and all of them together no more than there is.
fn assert_bounded(transport: &Transport, h: &[DVec3], what: &str) -> f64 {
    let area = |i: usize| f64::from(transport.patches[i].area);
    for (i, h) in h.iter().enumerate() {
        let share = h.y * area(i) / (2.0 * PI);
        assert!(h.is_finite() && h.min_element() >= 0.0 && share <= 1.0 + 1e-5, "{what}, patch {i}: {share}");
    }
    let all = h.iter().enumerate().map(|(i, h)| h.y * area(i)).sum::<f64>() / (4.0 * PI);
    // What the samples of far patches add.
    assert!(all <= 1.01, "{what}: {all} of its light");
    all
}

// Case 27.
#[test]
fn a_light_on_a_surface_gives_no_patch_more_than_half_of_its_light() {
    let baked = solved(&project(&cube()), 0.25, RAYS);
    let mut runtime = Runtime::new(&baked);
    let transport = &baked.transport;
    let patch = &transport.patches[baked.of_entity(3)[5]];
    let world = |at: Vec3| at.as_dvec3() + transport.origin;
    let sample = transport.samples[patch.first_sample as usize];
    let [a, b, _] = transport.surface.positions(patch.first_triangle as usize);
    let places = [
        ("on a sample", sample.position),
        ("in its middle", patch.centre),
        ("on a vertex", a),
        ("on an edge", (a + b) * 0.5),
        ("a hair above", patch.centre + Vec3::Y * 1e-7),
        ("a hair below", patch.centre - Vec3::Y * 1e-7),
        ("in a corner of the room", Vec3::ZERO - transport.origin.as_vec3()),
    ];
    for (what, at) in places {
        let lit = lamp_at(&baked, world(at));
        let all = assert_bounded(transport, &lit.direct, what);
        println!("{what}: {all} of its light, at most {}", largest(&lit.direct));
        assert!(lit.b.iter().all(|b| b.is_finite()));
        if let Some(runtime) = &mut runtime {
            runtime.frame(&lit.scene);
            assert_bounded(transport, &wide(&runtime.exitance()), &format!("{what}, on the GPU"));
        }
    }
}

// Case 27.
#[test]
fn a_light_close_to_a_sheet_gives_its_other_side_nothing() {
    let mut walls = cube();
    walls.push(Wall::new("sheet", quad(Vec3::new(0.2, 0.5, 0.2), Vec3::Z * 0.6, Vec3::X * 0.6)));
    let project = project(&walls);
    change(&project, |scene| scene.materials[6].double_sided = true);
    let baked = solved(&project, 0.25, RAYS);
    for height in [1e-6, 1e-5, 1e-3, 0.1] {
        for side in [1.0, -1.0] {
            let lit = lamp_at(&baked, DVec3::new(0.47, 0.5 + side * height, 0.52));
            let faces = |i: &usize| f64::from(lit.transport.patches[*i].normal.y) * side > 0.0;
            let (front, back): (Vec<usize>, Vec<usize>) = lit.of_entity(7).into_iter().partition(faces);
            assert!(
                !back.is_empty() && back.iter().all(|&i| lit.direct[i] == DVec3::ZERO),
                "{height} {side}"
            );
            let taken = front.iter().map(|&i| lit.area(i) * lit.direct[i].y).sum::<f64>() / (4.0 * PI);
            println!("{height} m off: the side that it lights takes {taken} of its light");
            // From 4 u l / h off an edge, in floats, both sides of it may see the light over themselves.
            let most = 0.5 + 4.0 * 6e-8 * 0.3 / height;
            assert!((0.3..=most).contains(&taken), "{height} {side}: {taken}");
            // Shadow rays end 64 times the step of floats short of the light, as it may lie on what they meet there:
            // so close, a sheet without thickness stops nothing of what goes past it.
            if height > 64.0 * f64::from(f32::EPSILON) {
                assert_bounded(&lit.transport, &lit.direct, "beside a sheet");
            }
        }
    }
}

// Case 28.
#[test]
fn a_light_inside_a_solid_lights_nothing_outside() {
    let mut walls = room(Vec3::ZERO, Vec3::splat(2.0));
    walls.push(block("solid", Vec3::new(0.7, 0.1, 0.7), Vec3::new(1.3, 0.9, 1.3)));
    let baked = solved(&project(&walls), 0.4, RAYS);
    let mut runtime = Runtime::new(&baked);
    for at in [DVec3::new(1.0, 0.5, 1.0), DVec3::new(0.705, 0.11, 0.71), DVec3::new(1.0, 0.899, 1.0)] {
        let lit = lamp_at(&baked, at);
        assert!(lit.direct.iter().chain(&lit.b).all(|light| *light == DVec3::ZERO), "{at}");
        if let Some(runtime) = &mut runtime {
            runtime.settle(&lit.scene);
            assert!(
                runtime.exitance().iter().chain(&runtime.radiosity()).all(|light| *light == Vec3::ZERO),
                "{at}"
            );
        }
    }
    // It does shine.
    assert!(largest(&lamp_at(&baked, DVec3::new(1.0, 1.5, 1.0)).direct) > 0.1);
}
