//! Direct light at patches: the GPU against the plain twin on the CPU, and both against what is known.

use std::f32::consts::PI;

use engine::gpu::{Gpu, buffer};
use engine::render::{Eye, PatchShadows, Settings, View};
use engine::scene::{LightKind, Scene, world_from_local};
use engine::transport::direct::{irradiance_of_patches, placed_lights};
use engine::transport::{Occluders, Transport};
use glam::{DVec3, Vec3, Vec4};
use tests::picture::{Studio, gpu};
use tests::room::{self, Rectangle};

fn empty_room() -> Transport {
    let walls = room::walls(Vec3::new(-2.0, 0.0, -1.0), Vec3::new(2.0, 2.5, 1.0));
    room::with_empty_rows(room::surfaces(&walls, 8))
}

/// White, so that E = H.
fn white(transport: &Transport) -> Scene {
    room::scene_of(transport, |_| Vec3::ONE)
}

fn studio(gpu: Gpu, transport: Transport, shadows: PatchShadows) -> Studio {
    let settings = Settings { samples: Some(1), patch_shadows: Some(shadows), ..Settings::default() };
    let eye = Eye::looking(DVec3::new(0.0, 1.0, 3.0), DVec3::new(0.0, 1.0, 0.0));
    Studio::with(gpu, transport, eye, [16, 16], settings)
}

fn on_gpu(studio: &mut Studio, scene: &Scene) -> Vec<Vec3> {
    studio.draw(scene, View::Composite);
    let count = studio.renderer.transport().patches.len();
    let all: Vec<Vec4> = buffer::read(studio.renderer.gpu(), &studio.renderer.spaces().exitance).unwrap();
    all[..count].iter().map(|value| value.truncate()).collect()
}

fn on_cpu(transport: &Transport, scene: &Scene) -> Vec<Vec3> {
    let occluders = Occluders::new(transport);
    let lights = placed_lights(scene, &world_from_local(scene), transport.origin);
    let visible = |from: Vec3, normal: Vec3, to: Vec3| occluders.free_from_surface(from, normal, to);
    irradiance_of_patches(transport, &lights, &visible)
}

/// Largest difference, as a share of the largest value.
fn apart(a: &[Vec3], b: &[Vec3]) -> f32 {
    let largest = b.iter().map(|b| b.max_element()).fold(0.0, f32::max);
    assert!(largest > 0.0, "nothing is lit");
    a.iter().zip(b).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max) / largest
}

fn flux_into(transport: &Transport, irradiance: &[Vec3]) -> f32 {
    transport.patches.iter().zip(irradiance).map(|(patch, h)| patch.area * h.x).sum()
}

const SPOT: LightKind = LightKind::Spot { inner: 0.3, outer: 0.7 };

fn flux(kind: LightKind) -> f32 {
    match kind {
        LightKind::Spot { inner, outer } => {
            2.0 * PI * (1.0 - inner.cos() + (inner.cos() - outer.cos()) / 3.0)
        }
        _ => 4.0 * PI,
    }
}

/// A light at this distance from the floor, not over the middle of anything; a spot looks aslant at it.
fn lamp(kind: LightKind, height: f64) -> engine::scene::Entity {
    let at = DVec3::new(0.13, height, 0.07);
    room::light(100, kind, 1.0, at, at + DVec3::new(0.2, -1.0, 0.1))
}

#[test]
fn a_light_close_to_a_wall_gives_what_it_has_and_the_gpu_says_the_same() {
    let Some(gpu) = gpu() else { return };
    let transport = empty_room();
    let mut studio = studio(gpu, transport.clone(), PatchShadows::Rays);
    for kind in [LightKind::Point, SPOT] {
        for height in [0.001, 0.05, 0.5] {
            let mut scene = white(&transport);
            scene.entities.push(lamp(kind, height));
            let truth = on_cpu(&transport, &scene);
            let gpu = on_gpu(&mut studio, &scene);
            let received = flux_into(&transport, &gpu) / flux(kind);
            println!(
                "{kind:?} at {height} m: {received} of its light, GPU and CPU {} apart",
                apart(&gpu, &truth)
            );
            assert!(apart(&gpu, &truth) < 1e-4, "{kind:?} at {height}: {}", apart(&gpu, &truth));
            // What the samples of far patches add or lose.
            assert!((received - 1.0).abs() < 5e-3, "{kind:?} at {height}: {received}");
        }
    }
}

#[test]
fn light_is_continuous_where_a_lamp_comes_near() {
    let transport = empty_room();
    for kind in [LightKind::Point, SPOT] {
        let mut before: Option<Vec<Vec3>> = None;
        let mut largest = 0.0_f32;
        for step in 0..=2000 {
            // From 1 m to 1 mm: 0.35 % nearer a step, which by itself makes a wall 0.7 % brighter.
            let height = 0.9965_f64.powi(step);
            let mut scene = white(&transport);
            scene.entities.push(lamp(kind, height));
            let now = on_cpu(&transport, &scene);
            let most = now.iter().map(|h| h.x).fold(0.0, f32::max);
            if let Some(before) = before {
                let jump = now.iter().zip(&before).map(|(now, before)| (now.x - before.x).abs());
                let jump = jump.fold(0.0, f32::max) / most;
                largest = largest.max(jump);
            }
            before = Some(now);
        }
        println!("{kind:?}: largest step {largest}");
        assert!(largest < 0.01, "{kind:?}: {largest}");
    }
}

/// A room with blocks in it: their outsides face the room.
fn furnished() -> Transport {
    let mut rectangles = room::walls(Vec3::new(-2.0, 0.0, -1.5), Vec3::new(2.0, 2.5, 1.5)).to_vec();
    let block = |low: [f32; 3], size: [f32; 3]| {
        let low = Vec3::from(low);
        let outwards =
            |wall: Rectangle| Rectangle { corner: wall.corner, edges: [wall.edges[1], wall.edges[0]] };
        room::walls(low, low + Vec3::from(size)).map(outwards)
    };
    rectangles.extend(block([-1.2, 0.0, -0.9], [0.6, 0.8, 0.5]));
    rectangles.extend(block([0.4, 0.3, 0.1], [0.9, 0.05, 0.7]));
    rectangles.extend(block([-0.3, 1.2, -0.2], [0.11, 0.6, 0.13]));
    room::with_empty_rows(room::surfaces(&rectangles, 10))
}

fn lamps(scene: &mut Scene, count: u64) {
    for k in 0..count {
        let turn = k as f64 * 2.4;
        let at = DVec3::new(1.6 * turn.cos(), 1.9 - 0.05 * k as f64, 1.2 * turn.sin());
        let kind = [LightKind::Point, LightKind::Spot { inner: 0.5, outer: 0.9 }][k as usize % 2];
        scene.entities.push(room::light(100 + k, kind, 3.0, at, DVec3::new(0.1, 0.0, -0.2)));
    }
}

fn count_apart(a: &[Vec3], b: &[Vec3]) -> usize {
    let largest = b.iter().map(|b| b.max_element()).fold(0.0, f32::max);
    a.iter().zip(b).filter(|(a, b)| (**a - **b).abs().max_element() > 1e-5 * largest).count()
}

#[test]
fn rays_on_the_gpu_see_what_rays_on_the_cpu_see() {
    let Some(gpu) = gpu() else { return };
    let transport = furnished();
    let mut studio = studio(gpu, transport.clone(), PatchShadows::Rays);
    let (mut wrong, mut all) = (0, 0);
    for k in 0..8 {
        let mut scene = white(&transport);
        lamps(&mut scene, k + 1);
        // One lamp at a time; the last is a sun that comes through the walls: all is dark.
        scene.entities.retain(|entity| entity.light.is_none() || entity.id.0 == 100 + k);
        let (truth, found) = (on_cpu(&transport, &scene), on_gpu(&mut studio, &scene));
        wrong += count_apart(&found, &truth);
        all += transport.patches.len();
        let lit = truth.iter().filter(|h| h.x > 0.0).count();
        assert!(lit > 100, "lamp {k} lights {lit} patches");
    }
    println!("{wrong} of {all} patches differ");
    // A patch has four samples.
    assert!(wrong * 1000 <= all * 4, "{wrong} of {all}");
}
