//! Energy: what is known exactly of any room. Cases 1 to 6 and 9 to 12 of the catalogue.

use std::f64::consts::PI;

use engine::scene::LightKind;
use glam::{DVec3, Vec3};
use tests::enclosure::{
    Wall, corridor, cube, dome, furnished, lift_the_gain_limit, paint, project, rooms_joined_by_slits,
    sphere, under_a_sky, well,
};
use tests::room::light;
use tests::solution::{Solved, apart, largest, solved};
use tests::surfaces::quad;

const RAYS: u32 = 256;
/// Half the distance from 1 to the next float.
const U32: f64 = 6e-8;

fn solve(walls: &[Wall], length: f64) -> Solved {
    solved(&project(walls), length, RAYS)
}

// Case 1.
#[test]
fn a_furnace_glows_with_its_exitance_over_what_it_absorbs_whatever_its_shape() {
    let shapes = [
        ("cube", cube(), 0.3),
        ("furnished", furnished(), 0.25),
        ("corridor", corridor(), 0.7),
        ("ball", sphere(12, 6), 0.4),
        ("two rooms", rooms_joined_by_slits(), 0.6),
    ];
    for (name, walls, length) in shapes {
        let baked = solve(&walls, length);
        for albedo in [0.5, 0.9, 0.99] {
            let furnace = baked.again(|scene| paint(scene, albedo, 1.0));
            let (rho, m) = (f64::from(albedo), furnace.m[0].x);
            let (w, defect) = (1.0 / (1.0 - rho), furnace.transport.certificate.row_sum_defect);
            let wanted = vec![DVec3::splat(m * w); furnace.b.len()];
            let (off, bound) = (apart(&furnace.b, &wanted), rho * defect * w * w + 4.0 * U32 * w);
            println!("{name} {albedo}: {} patches, off {off:.1e} of {bound:.1e}", wanted.len());
            assert!(off <= bound, "{name} {albedo}: {off:e} of {bound:e}");
            assert!((furnace.gain() / w - 1.0).abs() < 1e-4, "{name} {albedo}: {}", furnace.gain());
        }
    }
}

// Case 2.
#[test]
fn a_furnace_that_keeps_all_but_a_millionth_is_limited_and_named() {
    let project = project(&cube());
    tests::enclosure::change(&project, |scene| paint(scene, 0.999_999, 1.0));
    let furnace = solved(&project, 0.3, RAYS);
    let warned = furnace.warnings.iter().map(ToString::to_string);
    let warned: Vec<String> = warned.filter(|text| text.contains("more than 10000")).collect();
    assert_eq!(warned.len(), 1, "{:?}", furnace.warnings);
    assert!(warned[0].contains("entity `-x`") && warned[0].contains("unlimited_gain"), "{warned:?}");
    let gain = furnace.transport.certificate.cavity_gain;
    let off = apart(&furnace.b, &vec![furnace.m[0] * 1e4; furnace.b.len()]) / 1e4;
    println!("gain {gain}, off {off:.1e}");
    assert!((gain / 1e4 - 1.0).abs() < 1e-3 && off < 1e-3, "{gain} {off}");
}

// Case 2, and 34 in f64.
#[test]
fn with_the_limit_lifted_a_furnace_that_keeps_all_but_a_millionth_is_right_to_a_thousandth() {
    for (name, walls, length) in [("cube", cube(), 0.3), ("furnished", furnished(), 0.25)] {
        let project = project(&walls);
        tests::enclosure::change(&project, |scene| paint(scene, 0.999_999, 1.0));
        lift_the_gain_limit(&project);
        let furnace = solved(&project, length, RAYS);
        assert!(furnace.warnings.is_empty(), "{:?}", furnace.warnings);
        // As a float, the albedo is 0.99999899.
        let wanted = furnace.m[0] / (1.0 - f64::from(0.999_999_f32));
        let off = apart(&furnace.b, &vec![wanted; furnace.b.len()]) / wanted.x;
        let gain = furnace.transport.certificate.cavity_gain;
        println!("{name}: B = {} of {}, off {off:.1e}, gain {gain}", furnace.b[0].x, wanted.x);
        assert!(off < 1e-3, "{name}: {off:e}");
        assert!((gain * (1.0 - f64::from(0.999_999_f32)) - 1.0).abs() < 1e-3, "{name}: {gain}");
    }
}

// Case 3.
#[test]
fn in_a_closed_room_of_one_albedo_the_mean_light_is_known_wherever_it_comes_from() {
    for (name, walls, length) in
        [("cube", cube(), 0.3), ("furnished", furnished(), 0.25), ("two rooms", rooms_joined_by_slits(), 0.6)]
    {
        let room = solve(&walls, length).again(|scene| {
            paint(scene, 0.9, 0.0);
            scene.materials[0].emission.color = Vec3::splat(3.0);
            scene.materials[5].emission.color = Vec3::splat(0.2);
        });
        let h = room.h();
        let wanted = room.flux(|i| room.m[i].y) / (1.0 - f64::from(0.9_f32));
        let off = room.flux(|i| h[i].y) / wanted - 1.0;
        println!("{name}: off {off:.1e}");
        assert!(off.abs() < 1e-5, "{name}: {off:e}");
    }
}

/// What surfaces absorb, what leaves to the sky and what is lost on back faces, by what they are given.
fn balance(name: &str, room: &Solved) {
    let (h, n) = (room.h(), room.b.len());
    let rows = &room.transport.patch_from_patch;
    let to_sky = |i: usize| -> f64 {
        rows.row(i).filter(|&(j, _)| j as usize >= n).map(|(_, weight)| f64::from(weight)).sum()
    };
    let absorbed = room.flux(|i| (1.0 - f64::from(room.albedo[i].y)) * h[i].y);
    let escaped = room.flux(|i| room.b[i].y * to_sky(i));
    let lost = room.flux(|i| room.b[i].y * (1.0 - rows.sum(i)));
    let given = room.flux(|i| room.m[i].y + room.direct[i].y + room.from_sky[i].y);
    let off = (absorbed + escaped + lost) / given - 1.0;
    println!(
        "{name}: absorbed {absorbed:.3}, escaped {escaped:.3}, lost {lost:.3} of {given:.3}: off {off:.1e}"
    );
    assert!(off.abs() < 1e-4, "{name}: {off:e}");
}

// Case 4.
#[test]
fn every_room_absorbs_loses_and_lets_out_what_it_is_given() {
    let lamp = || light(100, LightKind::Point, 1.0, DVec3::new(0.5, 0.8, 0.3), DVec3::ZERO);
    let closed = solve(&furnished(), 0.25).again(|scene| {
        paint(scene, 0.8, 0.0);
        scene.materials[1].albedo.color = Vec3::new(0.9, 0.1, 0.3);
        scene.materials[6].emission.color = Vec3::ONE;
        scene.entities.push(lamp());
    });
    balance("furnished", &closed);
    let given = closed.flux(|i| closed.direct[i].y) / (4.0 * PI);
    println!("the lamp gives {given} of its light");
    // Sixteen samples a patch.
    assert!((given - 1.0).abs() < 0.02, "{given}");

    // A shelf without an underside swallows what comes from below.
    let mut walls = well(1.0);
    walls.push(Wall::new("shelf", quad(Vec3::new(0.2, 0.5, 0.2), Vec3::Z * 0.4, Vec3::X * 0.4)));
    let project = project(&walls);
    tests::enclosure::change(&project, |scene| {
        paint(scene, 0.7, 0.1);
        under_a_sky(scene, 2.0);
        scene.entities.push(lamp());
    });
    let open = solved(&project, 0.2, RAYS);
    assert!(open.transport.certificate.lost > 0.01, "{}", open.transport.certificate.lost);
    balance("well with a shelf", &open);
}

// Case 5.
#[test]
fn under_a_white_sky_whatever_is_white_is_as_bright_as_the_sky() {
    let mut in_the_open =
        vec![Wall::new("ground", quad(Vec3::new(-1.0, 0.0, -1.0), Vec3::Z * 2.0, Vec3::X * 2.0))];
    in_the_open.push(tests::enclosure::block("stone", Vec3::new(-0.3, 0.2, -0.2), Vec3::new(0.3, 0.6, 0.4)));
    let shapes = [("well", well(1.0), 0.25), ("deep well", well(8.0), 0.5), ("dome", dome(12, 8), 0.3)];
    for (name, walls, length) in shapes.into_iter().chain([("stone", in_the_open, 0.3)]) {
        let project = project(&walls);
        tests::enclosure::change(&project, |scene| {
            paint(scene, 1.0, 0.0);
            under_a_sky(scene, 1.0);
        });
        let white = solved(&project, length, RAYS);
        assert_eq!(white.transport.certificate.lost, 0.0, "{name}: nothing has its back to the light");
        let off = apart(&white.b, &vec![DVec3::splat(PI); white.b.len()]) / PI;
        let read = white.h_of_receivers();
        let off_there = apart(&read, &vec![DVec3::splat(PI); read.len()]) / PI;
        assert!(white.transport.receivers.iter().all(|receiver| receiver.valid == 1.0), "{name}");
        println!("{name}: gain {:.1}, off {off:.1e}, receivers {off_there:.1e}", white.gain());
        assert!(off < 1e-4 && off_there < 1e-4, "{name}: {off:e} {off_there:e}");
    }
}

// Case 6.
#[test]
fn a_floor_alone_under_a_sky_receives_pi_times_its_radiance() {
    let project = project(&[Wall::new("floor", quad(Vec3::ZERO, Vec3::Z * 2.0, Vec3::X * 3.0))]);
    tests::enclosure::change(&project, |scene| {
        paint(scene, 0.6, 0.0);
        under_a_sky(scene, 0.25);
    });
    let floor = solved(&project, 0.5, RAYS);
    let wanted = 0.25 * PI;
    let off =
        |values: &[DVec3], wanted: f64| apart(values, &vec![DVec3::splat(wanted); values.len()]) / wanted;
    let offs = [
        off(&floor.h(), wanted),
        off(&floor.h_of_receivers(), wanted),
        off(&floor.b, f64::from(0.6_f32) * wanted),
    ];
    println!("{offs:?}");
    // Counts over a power of two are exact; so are their sums. The rest is the sums' own rounding.
    assert!(offs.iter().all(|&off| off < 1e-14), "{offs:?}");
}

// Case 9.
#[test]
fn a_single_flat_patch_sees_the_sky_alone() {
    let project = project(&[Wall::new("floor", quad(Vec3::ZERO, Vec3::Z, Vec3::X))]);
    tests::enclosure::change(&project, |scene| {
        paint(scene, 0.9, 0.5);
        under_a_sky(scene, 1.0);
    });
    let floor = solved(&project, 1.0, RAYS);
    let rows = &floor.transport.patch_from_patch;
    assert_eq!(rows.len(), 1);
    assert!(rows.row(0).all(|(column, _)| column > 0), "P = [0]");
    assert_eq!(rows.sum(0), 1.0);
    assert_eq!(floor.b, floor.e);
}

// Case 10. A patch may be a whole ball: it is one piece without sharp edges, and worth less than one and a half
// patches of this length.
#[test]
fn a_ball_that_is_one_patch_sees_nothing_but_itself() {
    let walls = [Wall::new("ball", tests::enclosure::ball_inside(1.0, 24, 12))];
    let ball = solve(&walls, 4.0).again(|scene| paint(scene, 0.9, 1.0));
    let rows = &ball.transport.patch_from_patch;
    assert_eq!(rows.len(), 1);
    assert_eq!(rows.row(0).collect::<Vec<_>>(), [(0, 1.0)], "{}", ball.transport.patches[0].target);
    let wanted = ball.m[0].x / (1.0 - f64::from(0.9_f32));
    println!("{} of {wanted}", ball.b[0].x);
    assert!((ball.b[0].x / wanted - 1.0).abs() < 1e-12);
}

// Case 11.
#[test]
fn in_a_ball_of_many_patches_each_sees_all_by_their_area() {
    let ball = solve(&sphere(24, 12), 0.25).again(|scene| {
        paint(scene, 0.8, 0.0);
        scene.materials[0].emission.color = Vec3::ONE;
    });
    let n = ball.b.len();
    let total = ball.flux(|_| 1.0);
    let rho = f64::from(0.8_f32);
    let h = ball.h();
    // H is the same everywhere: Sum E_j A_j / (A (1 - rho)).
    let wanted = ball.flux(|i| ball.e[i].y) / (total * (1.0 - rho));
    let parts: Vec<Vec<usize>> = (1..=3).map(|id| ball.of_entity(id)).collect();
    for (from, own) in parts.iter().enumerate() {
        let off = ball.mean(own, |i| h[i].y) / wanted - 1.0;
        println!("{n} patches, part {from}: H {off:+.1e} off");
        // A flat facet does not see itself, nor do those beside it see all of it: that is O(1/N).
        assert!(off.abs() < 4.0 / n as f64, "part {from}: {off}");
    }
    // One patch's own light: what its rays leave, and its facets.
    let noise = |i: usize| {
        let row = ball.transport.patch_from_patch.row(i);
        let squares: f64 = row.map(|(j, weight)| f64::from(weight) * ball.b[j as usize].y.powi(2)).sum();
        ((squares - h[i].y * h[i].y).max(0.0) / f64::from(RAYS)).sqrt()
    };
    let worst = (0..n).map(|i| (h[i].y - wanted).abs() / (4.0 * noise(i) + 4.0 / n as f64 * wanted));
    let worst = worst.fold(0.0, f64::max);
    println!("the worst patch is off by {worst} of four sigma and four patches' share");
    assert!(worst <= 1.0, "{worst}");
}

// Case 12.
#[test]
fn emitters_of_sixteen_orders_of_magnitude_add_up() {
    let glow = [1e8, 1e-8, 3e3, 1e-5, 2e-3, 5.0];
    let baked = solve(&cube(), 0.25);
    let lit = |lit: &dyn Fn(usize) -> bool| {
        let solved = baked.again(|scene| {
            paint(scene, 0.8, 0.0);
            let glowing = scene.materials.iter_mut().zip(glow).enumerate().filter(|(wall, _)| lit(*wall));
            glowing.for_each(|(_, (material, glow))| material.emission.color = Vec3::splat(glow));
        });
        let bright = |(b, e): (&DVec3, &DVec3)| b.is_finite() && b.cmpge(*e).all();
        assert!(solved.b.iter().zip(&solved.e).all(bright), "B >= E");
        solved.b
    };
    let all = lit(&|_| true);
    let mut sum = vec![DVec3::ZERO; all.len()];
    for wall in 0..6 {
        sum.iter_mut().zip(lit(&|other| other == wall)).for_each(|(sum, one)| *sum += one);
    }
    let off = apart(&all, &sum) / largest(&all);
    println!("off {off:.1e}");
    assert!(off < 1e-10, "{off:e}");
}
