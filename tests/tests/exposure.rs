//! Exposure and tone curves: what the display shows of a radiance that is known, and that automatic exposure finds
//! middle grey in the light of stars as in that of an arc.

use engine::render::{Eye, Settings, View, tonemap};
use engine::scene::{AutoExposure, Scene, Sky, SkyKind, ToneCurve};
use engine::transport::Transport;
use glam::{DVec3, Vec3};
use tests::picture::{Studio, gpu};
use tests::room;

/// Nothing but a sky of one radiance.
fn sky(radiance: Vec3) -> Scene {
    Scene { sky: Sky { kind: SkyKind::Constant { radiance }, ..Sky::default() }, ..Scene::default() }
}

fn studio(samples: Option<u32>) -> Option<Studio> {
    let eye = Eye::looking(DVec3::ZERO, DVec3::NEG_Z);
    let settings = Settings { samples, ..Settings::default() };
    Some(Studio::with(gpu()?, Transport::default(), eye, [16, 16], settings))
}

/// Linear, of the pixel in the middle.
fn shown(studio: &Studio) -> Vec3 {
    let pixel = &studio.pixels()[(8 * 16 + 8) * 4..][..3];
    Vec3::from_slice(&pixel.iter().map(|&byte| decoded(byte)).collect::<Vec<_>>())
}

fn decoded(byte: u8) -> f32 {
    engine::scene::assets::linear(f32::from(byte) / 255.0)
}

/// To what eight bits hold.
fn close(found: Vec3, wanted: Vec3) {
    let byte = |light: f32| if light <= 0.0 { 0.0 } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 };
    let apart = (found.map(byte) - wanted.map(byte)).abs().max_element();
    assert!(apart < 1.5 / 255.0, "{found} instead of {wanted}");
}

#[test]
fn the_curves_on_the_gpu_are_those_on_the_cpu() {
    let Some(mut studio) = studio(Some(1)) else { return };
    let tints = [Vec3::ONE, Vec3::new(1.0, 0.02, 0.0), Vec3::new(0.1, 0.7, 1.0)];
    for curve in [ToneCurve::Neutral, ToneCurve::Agx] {
        studio.eye.tonemap = curve;
        for (tint, strength) in
            tints.iter().flat_map(|tint| [0.0, 0.01, 0.18, 0.9, 4.0, 300.0].map(|s| (tint, s)))
        {
            studio.draw(&sky(tint * strength), View::Composite);
            close(shown(&studio), tonemap::displayed(tint * strength, curve));
        }
    }
}

#[test]
fn radiance_far_beyond_half_floats_is_drawn_and_exposed_as_it_is() {
    let Some(mut studio) = studio(Some(1)) else { return };
    for (radiance, stops) in [(1e7, -25.0), (3e5, -20.3), (2e-6, 17.0), (0.3, 0.0)] {
        studio.eye.exposure = stops;
        studio.draw(&sky(Vec3::splat(radiance)), View::Composite);
        let found = studio.radiance_at(3, 3).x;
        assert!((found / radiance - 1.0).abs() < 1e-3, "{found} instead of {radiance}");
        close(shown(&studio), tonemap::displayed(Vec3::splat(radiance * stops.exp2()), ToneCurve::Neutral));
    }
}

#[test]
fn the_first_picture_is_exposed_to_middle_grey() {
    for samples in [Some(1), None] {
        let Some(mut studio) = studio(samples) else { return };
        for (radiance, compensation) in [(1e-4, 0.0), (0.18, 0.0), (55.0, 1.0), (1e7, 0.0)] {
            studio.eye.auto_exposure = None;
            studio.draw(&sky(Vec3::ZERO), View::Composite);
            studio.eye.auto_exposure = Some(AutoExposure { compensation, ..AutoExposure::default() });
            studio.draw(&sky(Vec3::splat(radiance)), View::Composite);
            let grey = shown(&studio).x / compensation.exp2();
            // A bin of the histogram is 0.16 stops wide.
            assert!((0.16..0.2).contains(&grey), "{radiance}: {grey}");
        }
    }
}

#[test]
fn adaptation_takes_its_time_and_stays_within_its_limits() {
    let Some(mut studio) = studio(Some(1)) else { return };
    let auto = AutoExposure { speed: 2.0, ..AutoExposure::default() };
    studio.eye.auto_exposure = Some(auto);
    let stops = |studio: &Studio| studio.renderer.exposed().unwrap().exposure.log2();
    studio.draw_at(&sky(Vec3::splat(0.2)), View::Composite, 0.0);
    let start = stops(&studio);
    for picture in 1..=20 {
        studio.draw_at(&sky(Vec3::splat(0.2 * 1024.0)), View::Composite, f64::from(picture) * 0.05);
        let seconds = picture as f32 * 0.05;
        let expected = start - 10.0 * (1.0 - (-2.0 * seconds).exp());
        assert!((stops(&studio) - expected).abs() < 0.17, "{seconds}: {} {expected}", stops(&studio));
    }
    let standing = stops(&studio);
    studio.draw_at(&sky(Vec3::splat(0.2)), View::Composite, 1.0);
    assert_eq!(stops(&studio), standing, "time stands");
    studio.eye.auto_exposure = Some(AutoExposure { least: -3.0, most: 1.0, speed: f32::INFINITY, ..auto });
    for (radiance, limit) in [(1e-3, 1.0), (1e3, -3.0)] {
        studio.draw_at(&sky(Vec3::splat(radiance)), View::Composite, 9.0 + f64::from(radiance));
        assert!((stops(&studio) - limit).abs() < 1e-5);
    }
}

#[test]
fn views_that_show_no_light_are_neither_exposed_nor_bent() {
    let Some(gpu) = gpu() else { return };
    let transport = room::closed_box(Vec3::splat(-1.0), Vec3::splat(1.0), 2);
    let scene = room::scene_of(&transport, |_| Vec3::new(0.9, 0.5, 0.1));
    let eye = Eye::looking(DVec3::ZERO, DVec3::NEG_Z);
    let mut studio = Studio::new(gpu, transport, eye, [16, 16]);
    studio.eye.tonemap = ToneCurve::Agx;
    for stops in [0.0, 20.0, -20.0] {
        studio.eye.exposure = stops;
        studio.draw(&scene, View::Albedo);
        close(shown(&studio), Vec3::new(0.9, 0.5, 0.1));
        studio.draw(&scene, View::Normal);
        close(shown(&studio), Vec3::new(0.5, 0.5, 1.0));
    }
    studio.eye.auto_exposure = Some(AutoExposure::default());
    studio.draw(&scene, View::Albedo);
    close(shown(&studio), Vec3::new(0.9, 0.5, 0.1));
}
