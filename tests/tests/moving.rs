//! What moves in the light of probes: the GPU's numbers against the CPU's, closed forms, no jumps, no work at rest.

use std::f32::consts::PI;

use engine::gpu::{Gpu, buffer};
use engine::render::{Eye, View};
use engine::scene::shape::{self, Shape};
use engine::scene::{Entity, EntityId, LightKind, MeshSource, Scene};
use engine::transport::{Transport, dering, sh};
use glam::{DVec3, Vec3, Vec4};
use tests::picture::{Studio, gpu};
use tests::room;

const LOW: Vec3 = Vec3::new(-1.0, 0.0, -1.0);
const HIGH: Vec3 = Vec3::new(1.0, 2.0, 1.0);

/// A closed room with 27 probes.
fn transport() -> Transport {
    let mut positions = Vec::new();
    for x in [-0.7, 0.1, 0.7] {
        for y in [0.3, 1.0, 1.7] {
            positions.extend([-0.7, 0.0, 0.7].map(|z| Vec3::new(x, y, z)));
        }
    }
    room::with_probes(room::closed_box(LOW, HIGH, 4), LOW, HIGH, &positions)
}

/// A rough ball 0.4 m across, and a lamp.
fn scene(transport: &Transport, albedo: f32) -> Scene {
    let mut scene = room::scene_of(transport, |wall| Vec3::new(0.7, 0.3 + 0.1 * wall as f32, 0.5));
    let mut white = scene.materials[0].clone();
    white.id = engine::scene::MaterialId(50);
    white.albedo.color = Vec3::splat(albedo);
    white.roughness = 1.0;
    scene.materials.push(white);
    let mut ball =
        Entity { id: EntityId(200), mesh: Some(room::mesh(Shape::Sphere, 50)), ..Entity::default() };
    ball.transform.scale = DVec3::splat(0.4);
    ball.transform.translation = DVec3::new(0.0, 1.0, 0.0);
    scene.entities.push(ball);
    scene
}

fn with_lamp(mut scene: Scene) -> Scene {
    scene.entities.push(room::light(100, LightKind::Point, 2.0, DVec3::new(0.4, 1.6, -0.5), DVec3::ZERO));
    scene.materials[2].emission.color = Vec3::new(0.1, 0.4, 0.2);
    scene
}

fn place(scene: &mut Scene, at: DVec3) {
    let ball = scene.entities.iter_mut().find(|entity| entity.id == EntityId(200)).unwrap();
    ball.transform.translation = at;
}

fn studio(gpu: Gpu, transport: Transport) -> Studio {
    let eye = Eye::looking(DVec3::new(0.0, 1.0, 0.9), DVec3::new(0.0, 1.0, 0.0));
    let mut studio = Studio::new(gpu, transport, eye, [32, 32]);
    let source = MeshSource::Shape(Shape::Sphere);
    studio.assets.meshes.insert(source, shape::mesh(Shape::Sphere).into());
    studio
}

fn read(studio: &Studio, buffer: &wgpu::Buffer, count: usize) -> Vec<Vec3> {
    let all: Vec<Vec4> = buffer::read(studio.renderer.gpu(), buffer).unwrap();
    all[..count].iter().map(|value| value.truncate()).collect()
}

#[test]
fn probes_are_windowed_as_on_the_cpu() {
    let Some(gpu) = gpu() else { return };
    let mut transport = transport();
    // The first probe sees one patch, the second two that face each other: both ring.
    let rows = std::mem::take(&mut transport.probe_from_patch);
    for row in 0..rows.len() {
        match row / 9 {
            0 => transport.probe_from_patch.push(rows.row(row).filter(|entry| entry.0 == 70)),
            1 => transport.probe_from_patch.push(rows.row(row).filter(|entry| [5, 25].contains(&entry.0))),
            _ => transport.probe_from_patch.push(rows.row(row)),
        }
    }
    let scene = with_lamp(scene(&transport, 0.5));
    let mut studio = studio(gpu, transport.clone());
    studio.settle(&scene, View::Composite);
    let spaces = studio.renderer.spaces();
    let bounced = read(&studio, &spaces.bounced, transport.patches.len());
    let on_gpu = read(&studio, &spaces.probes[1], 27 * 9);
    let gathered = |row: usize| -> Vec3 {
        transport.probe_from_patch.row(row).map(|(patch, weight)| bounced[patch as usize] * weight).sum()
    };
    let mut windowed = 0;
    for probe in 0..27 {
        let before: [Vec3; 9] = std::array::from_fn(|k| gathered(probe * 9 + k));
        let mut wanted = before;
        dering::dering(&mut wanted);
        windowed += u32::from(wanted != before);
        for k in 0..9 {
            let apart = (on_gpu[probe * 9 + k] - wanted[k]).abs().max_element();
            assert!(apart < 2e-4 * before[0].max_element(), "{probe} {k}: {apart} of {before:?}");
        }
        let mut l = [Vec3::ZERO; 9];
        l.copy_from_slice(&on_gpu[probe * 9..][..9]);
        for n in room::directions(642) {
            let y = sh::basis(n);
            let e: Vec3 = (0..9).map(|k| l[k] * (sh::COSINE[k] * y[k])).sum();
            assert!(e.min_element() >= -1e-5 * l[0].max_element(), "{probe} {n}: {e}");
        }
    }
    assert!(windowed >= 2);
}

/// A closed box whose walls all glow alike: B = M / (1 - rho), L = B / pi from everywhere.
#[test]
fn in_a_furnace_a_probe_reads_l_and_a_ball_shows_albedo_times_l() {
    let Some(gpu) = gpu() else { return };
    let transport = transport();
    let mut scene = scene(&transport, 0.6);
    for material in scene.materials.iter_mut().take(6) {
        material.albedo.color = Vec3::splat(0.8);
        material.emission.color = Vec3::splat(0.25);
    }
    let l = 0.25 / (1.0 - 0.8);
    let mut studio = studio(gpu, transport);
    studio.settle(&scene, View::Composite);
    let spaces = studio.renderer.spaces();
    let (direct, indirect) = (read(&studio, &spaces.probes[0], 243), read(&studio, &spaces.probes[1], 243));
    for probe in 0..27 {
        for k in 0..9 {
            let sum = direct[probe * 9 + k] + indirect[probe * 9 + k];
            let wanted = if k == 0 { 2.0 * PI.sqrt() * l } else { 0.0 };
            assert!((sum - wanted).abs().max_element() < 2e-3 * l, "{probe} {k}: {sum}");
        }
    }
    for at in [DVec3::new(0.0, 1.0, 0.0), DVec3::new(0.1, 0.9, 0.15)] {
        place(&mut scene, at);
        studio.settle(&scene, View::Composite);
        // The ball fills the middle, a wall the corner.
        let (ball, wall) = (studio.radiance_at(16, 16), studio.radiance_at(0, 0));
        assert!((ball - 0.6 * l).abs().max_element() < 3e-3 * l, "{ball}");
        assert!((wall - l).abs().max_element() < 3e-3 * l, "{wall}");
    }
}

#[test]
fn objects_are_lit_by_their_four_probes_as_on_the_cpu() {
    let Some(gpu) = gpu() else { return };
    let transport = transport();
    let mut scene = with_lamp(scene(&transport, 0.5));
    let mut studio = studio(gpu, transport);
    studio.settle(&scene, View::Composite);
    for at in [DVec3::new(0.21, 0.83, -0.4), DVec3::new(-0.6, 1.9, 0.1), DVec3::new(5.0, -3.0, 0.2)] {
        place(&mut scene, at);
        studio.settle(&scene, View::Composite);
        let objects = studio.renderer.objects();
        let weights = objects.field().weights(at.as_vec3(), &mut Default::default());
        assert_eq!(objects.weights().len(), 1);
        for k in 0..4 {
            let found = objects.weights()[0];
            let of = |probe: u32, weights: &engine::transport::probe_field::Weights| -> f32 {
                (0..4).filter(|&i| weights.probes[i] == probe).map(|i| weights.weights[i]).sum()
            };
            let probe = weights.probes[k];
            assert!((of(probe, &weights) - of(probe, &found)).abs() < 1e-4, "{weights:?} {found:?}");
        }
        let spaces = studio.renderer.spaces();
        for (probes, light) in spaces.probes.iter().zip(objects.light()) {
            let (probes, light) = (read(&studio, probes, 243), read(&studio, light, 9));
            let weights = objects.weights()[0];
            for k in 0..9 {
                let blended: Vec3 =
                    (0..4).map(|i| probes[weights.probes[i] as usize * 9 + k] * weights.weights[i]).sum();
                assert!((light[k] - blended).abs().max_element() < 1e-4, "{k}: {} {blended}", light[k]);
            }
        }
    }
}

/// Numerics case 48 on the GPU: from end to end of the room and out of it.
#[test]
fn a_ball_that_moves_through_the_room_has_continuous_light() {
    let Some(gpu) = gpu() else { return };
    let transport = transport();
    let mut scene = with_lamp(scene(&transport, 0.5));
    // Its shadow would change the light itself.
    scene.entities.last_mut().unwrap().light.as_mut().unwrap().casts_shadows = false;
    let mut studio = studio(gpu, transport);
    studio.settle(&scene, View::Composite);
    let spaces = studio.renderer.spaces();
    let all = read(&studio, &spaces.probes[1], 243);
    let range = all.iter().step_by(9).map(|l| l.max_element()).fold(0.0, f32::max);
    let (from, to) = (DVec3::new(-1.3, 0.2, -0.9), DVec3::new(1.2, 1.9, 1.1));
    const STEPS: u32 = 400;
    let mut light_at = |k: u32| {
        place(&mut scene, from.lerp(to, f64::from(k) / f64::from(STEPS)));
        let drawn = studio.draw(&scene, View::Composite);
        assert!(drawn.transport_dispatches <= 1, "only the ball's own light: {drawn:?}");
        read(&studio, &studio.renderer.objects().light()[1], 9)
    };
    let mut last = light_at(0);
    let mut largest = 0.0_f32;
    for k in 1..=STEPS {
        let now = light_at(k);
        let change = now.iter().zip(&last).map(|(a, b)| (*a - *b).abs().max_element());
        largest = largest.max(change.fold(0.0, f32::max) / range);
        last = now;
    }
    println!(
        "steps of {:.4} m change at most {largest} of the largest",
        from.distance(to) / f64::from(STEPS)
    );
    assert!(largest < 0.02, "{largest}");
}

#[test]
fn nothing_that_moves_costs_nothing() {
    let Some(gpu) = gpu() else { return };
    let transport = transport();
    let mut scene = with_lamp(scene(&transport, 0.5));
    scene.entities.last_mut().unwrap().light.as_mut().unwrap().casts_shadows = false;
    let mut studio = studio(gpu, transport);
    studio.settle(&scene, View::Composite);
    assert_eq!(studio.draw(&scene, View::Composite).transport_dispatches, 0);
    place(&mut scene, DVec3::new(0.3, 1.0, 0.0));
    assert_eq!(studio.draw(&scene, View::Composite).transport_dispatches, 1);
    assert_eq!(studio.draw(&scene, View::Composite).transport_dispatches, 0);
    // Probes are shown though nothing moves.
    scene.entities.retain(|entity| entity.id != EntityId(200));
    studio.settle(&scene, View::Composite);
    assert_eq!(studio.draw(&scene, View::Composite).transport_dispatches, 0);
    assert!(studio.draw(&scene, View::Probes).transport_dispatches > 0);
    assert_eq!(studio.draw(&scene, View::Tetrahedra).transport_dispatches, 0);
}

/// More objects than there was room for at first.
#[test]
fn many_objects_have_light_each_of_their_own() {
    let Some(gpu) = gpu() else { return };
    let transport = transport();
    let mut scene = with_lamp(scene(&transport, 0.5));
    let mut studio = studio(gpu, transport);
    studio.settle(&scene, View::Composite);
    let ball = scene.entities.iter().find(|entity| entity.id == EntityId(200)).unwrap().clone();
    for k in 1..50 {
        let mut more = ball.clone();
        more.id = EntityId(200 + k);
        more.transform.translation = DVec3::new(0.03 * k as f64 - 0.8, 1.0, 0.3);
        scene.entities.push(more);
    }
    studio.settle(&scene, View::Composite);
    let objects = studio.renderer.objects();
    assert_eq!(objects.weights().len(), 50);
    let light = read(&studio, &objects.light()[1], 450);
    let brightest: Vec<f32> = light.iter().step_by(9).map(|l| l.max_element()).collect();
    assert!(brightest.iter().all(|&light| light > 0.01), "{brightest:?}");
    assert!(brightest.windows(2).skip(1).all(|pair| (pair[0] - pair[1]).abs() < 0.1 * pair[0]));
}
