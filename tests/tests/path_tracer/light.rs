//! The path tracer where the answer is known: furnaces, shiny surfaces under uniform light, lights, lamps, holes.

use std::f64::consts::{PI, TAU};

use bake::reference::Surfaces;
use bake::{Method, Point, Silent};
use engine::scene::{Alpha, LightKind, SkyKind};
use engine::transport::reflection::ggx::split_sum;
use glam::{DVec3, Vec3};
use tests::closed_forms::point_parallel;
use tests::lit::{BLACK, LAMP, Lit, Paint, meter, point};
use tests::room::{light, walls};
use tests::surfaces::{Faces, face, quad};

use crate::{assert_consistent, points_in_box, with_error};

const UP: [f64; 3] = [0.0, 1.0, 0.0];

fn furnace(albedo: f32) -> Lit {
    let names = ["-x", "+x", "-y", "+y", "-z", "+z"];
    let walls = walls(-Vec3::ONE, Vec3::ONE);
    let paint = Paint { albedo, exitance: 1.0 };
    let surfaces: Vec<(&str, Faces, Paint)> =
        names.into_iter().zip(&walls).map(|(name, wall)| (name, face(wall), paint)).collect();
    Lit::new(&surfaces, Vec::new())
}

/// B = M / (1 - rho), and that is what arrives.
#[test]
fn a_furnace_has_its_exact_light_and_errors_are_as_large_as_they_are_said_to_be() {
    for (albedo, paths) in [(0.5, 1024), (0.9, 512)] {
        let points = points_in_box(-Vec3::ONE, Vec3::ONE, 150);
        let found = furnace(albedo).traced(&points, paths);
        let exact = 1.0 / (1.0 - f64::from(albedo));
        let wanted = vec![[DVec3::splat(exact), DVec3::ZERO]; points.len()];
        assert_consistent(&format!("furnace of {albedo}"), &with_error(&found), &wanted);
    }
}

#[test]
fn probes_in_a_furnace_hold_one_coefficient() {
    let tracer = furnace(0.5).tracer(Surfaces::Diffuse);
    let places = [DVec3::new(0.3, -0.2, 0.6), DVec3::ZERO, DVec3::splat(0.95)];
    for probe in tracer.probes(&places, 8192, 3, &Silent).expect("probes") {
        for k in 0..9 {
            // L = 2 / pi, times 2 sqrt(pi) for the constant.
            let wanted = if k == 0 { 4.0 / PI.sqrt() } else { 0.0 };
            let off = (probe.coefficients[k].x - wanted) / probe.standard_error[k].x;
            assert!(off.abs() <= 4.5, "coefficient {k}: {probe:?}");
        }
    }
}

/// What the player mirrors of uniform light, and what it spreads.
fn reflected(albedo: f64, metallic: f64, roughness: f64, cosine: f64) -> f64 {
    let fade = 1.0 - roughness.powi(4);
    let facing = 0.04 * fade * (1.0 - metallic) + albedo * metallic;
    let edge = fade * (1.0 - metallic) + metallic;
    let [x, y] = split_sum(cosine as f32, roughness as f32).map(f64::from);
    let mirrored = (facing * x + edge * y) * (1.0 + facing * (1.0 / (x + y) - 1.0));
    mirrored + albedo * (1.0 - metallic) * (1.0 - mirrored)
}

#[test]
fn shiny_surfaces_under_uniform_light_show_what_the_players_split_says_and_no_more_than_there_is() {
    let floor = quad(Vec3::new(-1.0, 0.0, -1.0), Vec3::Z * 2.0, Vec3::X * 2.0);
    let lit = Lit::new(&[("floor", floor, BLACK)], Vec::new());
    for (albedo, metallic) in [(1.0, 1.0), (0.5, 1.0), (1.0, 0.0), (0.3, 0.0), (0.8, 0.4)] {
        for roughness in [0.0, 0.3, 0.6, 0.95] {
            lit.change(|scene| {
                scene.sky.kind = SkyKind::Constant { radiance: Vec3::ONE };
                let material = &mut scene.materials[0];
                material.albedo.color = Vec3::splat(albedo as f32);
                (material.metallic, material.roughness) = (metallic as f32, roughness as f32);
            });
            let tracer = lit.tracer(Surfaces::Shiny);
            for cosine in [1.0_f64, 0.5, 0.15] {
                let away = DVec3::new((1.0 - cosine * cosine).sqrt(), cosine, 0.0);
                let seen = tracer.radiance(away * 0.5, -away, 8192, 1);
                let (found, wanted) = (seen.radiance.x, reflected(albedo, metallic, roughness, cosine));
                // The player's table holds means over 256 directions, and ends at a roughness of 0.99.
                let limit = 4.0 * seen.standard_error.x + 5e-3;
                let case =
                    format!("albedo {albedo}, metallic {metallic}, roughness {roughness}, cosine {cosine}");
                println!("{case}: {found:.4}, {wanted:.4} wanted");
                assert!((found - wanted).abs() <= limit, "{case}: {found}, not {wanted}");
                assert!(found <= 1.0 + limit, "{case}: {found}");
            }
        }
    }
}

/// KHR_lights_punctual's formulas, put down once more; and what stands in the way.
#[test]
fn punctual_lights_are_exact_and_cast_shadows() {
    let floor = quad(Vec3::new(-3.0, 0.0, -3.0), Vec3::Z * 6.0, Vec3::X * 6.0);
    let shade = quad(Vec3::new(1.0, 1.0, -3.0), Vec3::Z * 6.0, Vec3::X * 2.0);
    let above = DVec3::new(0.0, 2.0, 0.0);
    let points: Vec<Point> = (0..7).map(|k| point([-2.0 + 0.7 * f64::from(k), 0.0, 0.1], UP)).collect();
    let cone = [0.4_f32, 0.9];
    for kind in [LightKind::Point, LightKind::Spot { inner: cone[0], outer: cone[1] }, LightKind::Sun] {
        for casts_shadows in [true, false] {
            let mut entity = light(50, kind, 3.0, above, DVec3::ZERO);
            let lamp = entity.light.as_mut().expect("a light");
            (lamp.range, lamp.casts_shadows) = (Some(2.8), casts_shadows);
            let lit =
                Lit::new(&[("floor", floor.clone(), BLACK), ("shade", shade.clone(), BLACK)], vec![entity]);
            for (point, found) in points.iter().zip(lit.traced(&points, 16)) {
                let way = above - point.position;
                let cosine = way.y / way.length();
                let [inner, outer] = cone.map(|angle| f64::from(angle).cos());
                let share = ((cosine - outer) / (inner - outer)).clamp(0.0, 1.0).powi(2);
                let window = (1.0 - (way.length() / 2.8).powi(4)).max(0.0);
                let inverse_square = 3.0 * window * cosine / way.length_squared();
                let open = match kind {
                    LightKind::Sun => 3.0,
                    LightKind::Point => inverse_square,
                    LightKind::Spot { .. } => inverse_square * share,
                };
                // From 2 m over 0, the shade at 1 m from 1 on covers the floor from 2 on; a sun's from 1 on.
                let edge = if kind == LightKind::Sun { 1.0 } else { 2.0 };
                let wanted = if casts_shadows && point.position.x > edge { 0.0 } else { open };
                assert!((found.direct.x - wanted).abs() <= 3e-6 * 3.0, "{kind:?}: {found:?}, not {wanted}");
                assert_eq!((found.indirect, found.standard_error), (DVec3::ZERO, DVec3::ZERO));
            }
        }
    }
}

#[test]
fn a_lamp_of_two_sides_shines_both_ways_and_one_of_one_side_does_not() {
    let lamp = quad(Vec3::Y, Vec3::X, Vec3::Z); // faces down
    let points = [point([0.0, 0.0, 0.0], UP), point([0.5, 2.0, 0.5], [0.0, -1.0, 0.0])];
    let meters: Faces = points.iter().flat_map(|point| meter(point, 0.02)).collect();
    let lit = Lit::new(&[("meters", meters, BLACK), ("lamp", lamp, LAMP)], Vec::new());
    let wanted = [point_parallel([0.0, 1.0], [0.0, 1.0], 1.0), point_parallel([-0.5, 0.5], [-0.5, 0.5], 1.0)];
    for double_sided in [false, true] {
        lit.change(|scene| scene.materials[1].double_sided = double_sided);
        let found = lit.traced(&points, 4096);
        let wanted = [wanted[0], if double_sided { wanted[1] } else { 0.0 }];
        for (found, wanted) in found.iter().zip(wanted) {
            let limit = 4.5 * found.standard_error.x;
            assert!((found.direct.x - wanted).abs() <= limit, "{found:?}, not {wanted}");
        }
    }
}

#[test]
fn two_panes_that_let_half_through_let_a_quarter_through() {
    const RAYS: u32 = 1 << 14;
    let under = point([0.0, 0.0, 0.0], UP);
    let pane = |height: f32| quad(Vec3::new(-20.0, height, -20.0), Vec3::X * 40.0, Vec3::Z * 40.0);
    let lit = Lit::new(
        &[("meter", meter(&under, 0.02), BLACK), ("low", pane(0.1), BLACK), ("high", pane(0.2), BLACK)],
        Vec::new(),
    );
    lit.change(|scene| {
        scene.sky.kind = SkyKind::Constant { radiance: Vec3::splat(2.0 / TAU as f32) };
        for material in &mut scene.materials[1..] {
            (material.alpha, material.opacity) = (Alpha::Blend, 0.5);
        }
    });
    lit.bake(5.0, RAYS);
    // Beside the panes less than 1e-4 of the half space is seen.
    let limit = 4.0 * (0.25 * 0.75 / f64::from(RAYS)).sqrt() + 1e-4;
    let traced = lit.traced(&[under], RAYS)[0].direct.x;
    let queried = [Method::Receivers, Method::Gather].map(|method| lit.query(&[under], method)[0].direct.x);
    for found in queried.into_iter().chain([traced]) {
        println!("{found:.4}");
        assert!((found - 0.25).abs() <= limit, "{found}");
    }
}
