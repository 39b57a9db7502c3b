//! The bounce from frame to frame: how soon it is right, that it ends, and that no brightness is too much for it.

use engine::gpu::buffer;
use engine::render::{Drawn, Eye, Settings, View};
use engine::scene::{LightKind, Scene};
use engine::transport::Transport;
use engine::transport::solve::{self, System};
use glam::{DVec3, Vec3, Vec4};
use tests::picture::{Studio, gpu};
use tests::{room, systems};

const ALBEDO: f32 = 0.95;

fn transport() -> Transport {
    room::closed_box(Vec3::new(-2.0, 0.0, -1.0), Vec3::new(2.0, 2.5, 1.0), 6)
}

fn scene(transport: &Transport, intensity: f32) -> Scene {
    let mut scene = room::scene_of(transport, |_| Vec3::splat(ALBEDO));
    let at = DVec3::new(0.5, 1.5, 0.2);
    scene.entities.push(room::light(100, LightKind::Point, intensity, at, DVec3::ZERO));
    scene
}

fn studio(transport: &Transport) -> Option<Studio> {
    let settings = Settings { samples: Some(1), ..Settings::default() };
    let eye = Eye::looking(DVec3::new(0.0, 1.0, 0.9), DVec3::new(0.0, 1.0, 0.0));
    Some(Studio::with(gpu()?, transport.clone(), eye, [16, 16], settings))
}

fn lamp(scene: &mut Scene) -> &mut engine::scene::Light {
    scene.entities.last_mut().unwrap().light.as_mut().unwrap()
}

/// By patch [W/m2].
fn read(studio: &Studio, buffer: &wgpu::Buffer) -> Vec<Vec3> {
    let all: Vec<Vec4> = buffer::read(studio.renderer.gpu(), buffer).unwrap();
    let patches = studio.renderer.transport().patches.len();
    all[..patches].iter().map(|value| value.truncate() * studio.renderer.light_unit()).collect()
}

fn radiosity(studio: &Studio) -> Vec<Vec3> {
    read(studio, &studio.renderer.spaces().radiosity)
}

fn exitance(studio: &Studio) -> Vec<Vec3> {
    read(studio, &studio.renderer.spaces().exitance)
}

fn largest(values: &[Vec3]) -> f32 {
    values.iter().map(|value| value.abs().max_element()).fold(0.0, f32::max)
}

fn apart(a: &[Vec3], b: &[Vec3]) -> f32 {
    a.iter().zip(b).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max)
}

fn exact(transport: &Transport, e: &[Vec3]) -> Vec<Vec3> {
    exact_of(transport, ALBEDO, e)
}

fn exact_of(transport: &Transport, albedo: f32, e: &[Vec3]) -> Vec<Vec3> {
    let albedo = vec![Vec3::splat(albedo); transport.patches.len()];
    let system = System { rows: &transport.patch_from_patch, patches: &transport.patches, albedo: &albedo };
    let scale = largest(e).max(f32::MIN_POSITIVE);
    let wide: Vec<_> = e.iter().map(|e| (*e / scale).as_dvec3()).collect();
    solve::exact(&system, &wide, 1e-9).iter().map(|b| b.as_vec3() * scale).collect()
}

#[test]
fn a_point_light_switched_off_leaves_nothing_and_then_no_dispatch_happens() {
    let transport = transport();
    let Some(mut studio) = studio(&transport) else { return };
    let mut scene = scene(&transport, 4.0);
    let lit = studio.settle(&scene, View::Composite);
    assert_eq!(lit.transport_dispatches, 0);
    let before = radiosity(&studio);
    lamp(&mut scene).on = false;
    // Nothing shines: the solution is known.
    let frames: Vec<Drawn> = (0..4).map(|_| studio.draw(&scene, View::Composite)).collect();
    assert!(
        frames.iter().all(|drawn| drawn.transport_dispatches == 0 && drawn.bound == Some(0.0)),
        "{frames:?}"
    );
    assert_eq!(largest(&radiosity(&studio)), 0.0);
    assert!(studio.radiance().iter().all(|radiance| *radiance == Vec3::ZERO));
    lamp(&mut scene).on = true;
    studio.settle(&scene, View::Composite);
    assert!(apart(&radiosity(&studio), &before) < 2e-3 * largest(&before));
}

#[test]
fn a_light_that_reaches_no_patch_any_more_fades_to_nothing_and_then_no_dispatch_happens() {
    let transport = transport();
    let Some(mut studio) = studio(&transport) else { return };
    let mut scene = scene(&transport, 4.0);
    studio.settle(&scene, View::Composite);
    // It shines on, into a millimetre of air.
    lamp(&mut scene).range = Some(1e-3);
    let mut frames = 0;
    while studio.draw(&scene, View::Composite).transport_dispatches > 0 {
        frames += 1;
        assert!(frames <= 12, "{:?}", studio.renderer.bound());
    }
    println!("dark after {frames} frames");
    assert_eq!(largest(&radiosity(&studio)), 0.0);
    for _ in 0..3 {
        assert_eq!(studio.draw(&scene, View::Composite).transport_dispatches, 0);
    }
    assert!(studio.radiance().iter().all(|radiance| *radiance == Vec3::ZERO));
}

#[test]
fn after_a_switch_the_error_is_a_thousandth_within_ten_frames() {
    let transport = transport();
    let Some(mut studio) = studio(&transport) else { return };
    let mut scene = scene(&transport, 1.0);
    studio.settle(&scene, View::Composite);
    for (what, intensity, range) in [("up", 1e6, None), ("down", 1.0, None), ("off", 1.0, Some(1e-3))] {
        let before = largest(&radiosity(&studio));
        lamp(&mut scene).intensity = intensity;
        lamp(&mut scene).range = range;
        let mut errors = Vec::new();
        for _ in 0..10 {
            studio.draw(&scene, View::Composite);
            let (b, e) = (radiosity(&studio), exitance(&studio));
            let truth = exact(&transport, &e);
            assert!(b.iter().zip(&e).all(|(b, e)| b.is_finite() && b.cmpge(*e).all()), "B >= E");
            errors.push(apart(&b, &truth) / before.max(largest(&truth)));
        }
        println!("{what}: {errors:?}");
        assert!(errors[9] <= 1e-3, "{what}: {errors:?}");
    }
}

#[test]
fn a_light_that_flickers_never_gives_more_than_one_that_stays() {
    let transport = transport();
    let Some(mut studio) = studio(&transport) else { return };
    let mut scene = scene(&transport, 4.0);
    studio.settle(&scene, View::Composite);
    let most = largest(&exact(&transport, &exitance(&studio)));
    for frame in 0..100 {
        lamp(&mut scene).intensity = if frame % 2 == 0 { 0.01 } else { 4.0 };
        studio.draw(&scene, View::Composite);
        if frame % 10 < 2 {
            let now = largest(&radiosity(&studio));
            assert!(now <= most * 1.001, "frame {frame}: {now} of {most}");
        }
    }
}

/// B after four frames from darkness, and after four more with half the light.
fn two_stages(transport: &Transport, intensity: f32) -> Option<[Vec<Vec3>; 2]> {
    let mut studio = studio(transport)?;
    let mut scene = scene(transport, intensity);
    for _ in 0..4 {
        studio.draw(&scene, View::Composite);
    }
    let first = radiosity(&studio);
    lamp(&mut scene).intensity *= 0.37;
    for _ in 0..4 {
        studio.draw(&scene, View::Composite);
    }
    Some([first, radiosity(&studio)])
}

#[test]
fn a_corridor_as_stiff_as_may_be_is_solved_as_far_as_f32_can() {
    let transport = systems::baked_box(Vec3::ZERO, Vec3::new(20.0, 1.0, 1.0), 0.5);
    for (albedo, gain) in [(0.99, 100.0_f32), (0.9999, 1e4)] {
        let Some(mut studio) = studio(&transport) else { return };
        let mut scene = room::scene_of(&transport, |_| Vec3::splat(albedo));
        let at = DVec3::new(0.5, 0.5, 0.5);
        scene.entities.push(room::light(100, LightKind::Point, 1.0, at, DVec3::ZERO));
        let mut frames = 0;
        while studio.draw(&scene, View::Composite).transport_dispatches > 0 {
            frames += 1;
            assert!(frames <= 40, "albedo {albedo}: {:?}", studio.renderer.bound());
            let (b, e) = (radiosity(&studio), exitance(&studio));
            assert!(b.iter().zip(&e).all(|(b, e)| b.is_finite() && b.cmpge(*e).all()), "frame {frames}");
        }
        let truth = exact_of(&transport, albedo, &exitance(&studio));
        let error = apart(&radiosity(&studio), &truth) / largest(&truth);
        let bound = studio.renderer.bound().unwrap();
        println!("albedo {albedo}: {error:.1e} after {frames} frames, bound {bound:.1e}");
        assert!(error <= bound && bound <= (4.0 * f32::EPSILON * gain).max(1e-3), "{error} {bound}");
    }
}

#[test]
fn light_scaled_by_a_power_of_two_bounces_scaled_to_the_last_bit() {
    let transport = transport();
    let Some(base) = two_stages(&transport, 3.0) else { return };
    for k in [-60, -25, -7, 11, 31, 60] {
        let factor = (k as f32).exp2();
        let scaled = two_stages(&transport, 3.0 * factor).unwrap();
        for (base, scaled) in base.iter().zip(&scaled) {
            let wrong = base.iter().zip(scaled).filter(|(base, scaled)| **base * factor != **scaled).count();
            assert_eq!(wrong, 0, "2^{k}: {wrong} patches differ");
        }
    }
}

#[test]
fn neither_starlight_nor_a_furnace_is_too_much() {
    let transport = transport();
    // Case 44: flushing to 0 is allowed, nothing else.
    for intensity in [1e-40_f32, 1e-35, 1e-20, 1e20, 1e30] {
        let Some(mut studio) = studio(&transport) else { return };
        let mut scene = scene(&transport, 0.0);
        scene.entities.pop();
        scene.materials[3].emission.color = Vec3::splat(intensity);
        studio.settle(&scene, View::Composite);
        let (b, e) = (radiosity(&studio), exitance(&studio));
        assert!(b.iter().all(|b| b.is_finite() && b.min_element() >= 0.0), "{intensity}");
        let truth = exact(&transport, &e);
        let error = apart(&b, &truth) / largest(&truth).max(f32::MIN_POSITIVE);
        println!("{intensity}: unit {}, error {error}", studio.renderer.light_unit());
        assert!(error < 2e-3 || intensity < 1e-37, "{intensity}: {error}");
        let receivers: Vec<Vec4> =
            buffer::read(studio.renderer.gpu(), &studio.renderer.spaces().receivers[1]).unwrap();
        assert!(receivers.iter().all(|light| light.is_finite()));
    }
}

#[test]
fn bright_and_dim_emitters_add_up() {
    let transport = transport();
    // Case 12: 1e-8 .. 1e8 in one scene.
    let glow = [1e8, 1e-8, 3e3, 0.0, 2e-3, 5.0];
    let solved = |lit: &dyn Fn(usize) -> bool| -> Option<Vec<Vec3>> {
        let mut studio = studio(&transport)?;
        let mut scene = scene(&transport, 0.0);
        scene.entities.pop();
        for (wall, glow) in glow.iter().enumerate().filter(|(wall, _)| lit(*wall)) {
            scene.materials[wall].emission.color = Vec3::splat(*glow);
        }
        for _ in 0..12 {
            studio.draw(&scene, View::Composite);
        }
        let (b, e) = (radiosity(&studio), exitance(&studio));
        assert!(b.iter().zip(&e).all(|(b, e)| b.is_finite() && b.cmpge(*e).all()));
        Some(b)
    };
    let Some(all) = solved(&|_| true) else { return };
    let mut sum = vec![Vec3::ZERO; all.len()];
    for wall in (0..6).filter(|&wall| glow[wall] > 0.0) {
        let one = solved(&|other| other == wall).unwrap();
        sum.iter_mut().zip(one).for_each(|(sum, one)| *sum += one);
    }
    // As far as the bound lets frames stop.
    assert!(apart(&all, &sum) <= 2e-3 * largest(&all), "{}", apart(&all, &sum) / largest(&all));
}
