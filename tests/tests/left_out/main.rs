//! What a scene does without is not on the GPU, is not compiled, and is not done; it comes with whoever needs it and
//! goes with the last; and nobody sees that it is gone.

mod one_channel;

use engine::gpu::{Gpu, buffer};
use engine::render::{Eye, Settings, View};
use engine::scene::shape::{self, Shape};
use engine::scene::{
    Alpha, Entity, EntityId, Feature, Forced, LightKind, MaterialId, MeshSource, ReflectionProbe, Refresh,
    Scene, Sky, SkyKind, Transform,
};
use engine::transport::solve::gather;
use engine::transport::solved::{Response, Source, Spread};
use engine::transport::{Rows, Solved, Transport};
use glam::{DVec3, Vec3, Vec4};
use tests::picture::{Studio, gpu};
use tests::room;

const LOW: Vec3 = Vec3::new(-1.0, 0.0, -1.0);
const HIGH: Vec3 = Vec3::new(1.0, 2.0, 1.0);
const SIZE: u32 = 24;

/// A closed room with a light probe in each of its upper and lower corners.
fn transport() -> Transport {
    let corner = |k: usize| Vec3::new([-0.7, 0.7][k & 1], [0.3, 1.7][k >> 1 & 1], [-0.7, 0.7][k >> 2 & 1]);
    let corners: Vec<Vec3> = (0..8).map(corner).collect();
    room::with_probes(room::closed_box(LOW, HIGH, 4), LOW, HIGH, &corners)
}

/// Rough walls, one of which glows.
fn plain(transport: &Transport) -> Scene {
    let mut scene = room::scene_of(transport, |wall| Vec3::new(0.7, 0.2 + 0.1 * wall as f32, 0.5));
    scene.materials.iter_mut().for_each(|material| material.roughness = 1.0);
    scene.materials[2].emission.color = Vec3::new(0.4, 0.5, 0.2);
    scene
}

fn lamp(casts_shadows: bool) -> Entity {
    let mut lamp = room::light(100, LightKind::Point, 2.0, DVec3::new(0.4, 1.6, -0.5), DVec3::ZERO);
    lamp.light.as_mut().expect("a light").casts_shadows = casts_shadows;
    lamp
}

fn ball(at: DVec3) -> Entity {
    let mut ball =
        Entity { id: EntityId(200), mesh: Some(room::mesh(Shape::Sphere, 0)), ..Entity::default() };
    (ball.transform.scale, ball.transform.translation) = (DVec3::splat(0.4), at);
    ball
}

fn mirror(id: u64, at: DVec3, half: f32) -> Entity {
    let probe = ReflectionProbe {
        half_size: Vec3::splat(half),
        blend_distance: 0.05,
        resolution: 16,
        refresh: Refresh::OnChange,
        ..ReflectionProbe::default()
    };
    Entity {
        id: EntityId(id),
        transform: Transform::at(at),
        reflection_probe: Some(probe),
        ..Entity::default()
    }
}

fn studio(gpu: Gpu, transport: &Transport, said: &[(Feature, Forced)]) -> Studio {
    let eye = Eye::looking(DVec3::new(0.0, 1.0, 0.9), DVec3::new(0.0, 0.9, 0.0));
    let settings = Settings { samples: Some(1), ..Settings::default() };
    let mut studio = Studio::asked(gpu, transport.clone(), eye, [SIZE, SIZE], settings, said);
    let source = MeshSource::Shape(Shape::Sphere);
    studio.assets.meshes.insert(source, shape::mesh(Shape::Sphere).into());
    studio
}

/// Until nothing is dispatched or captured any more.
fn settle(studio: &mut Studio, scene: &Scene) {
    for _ in 0..200 {
        let drawn = studio.draw(scene, View::Composite);
        if drawn.transport_dispatches == 0 && drawn.captures == 0 {
            return;
        }
    }
    panic!("does not settle");
}

/// Largest difference of two pictures, as a share of the brightest.
fn apart(a: &[Vec3], b: &[Vec3]) -> f32 {
    let brightest = b.iter().map(|b| b.max_element()).fold(0.0, f32::max);
    let off = a.iter().zip(b).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max);
    assert!(brightest > 0.0 && a.len() == b.len());
    off / brightest
}

fn compiled(studio: &Studio, word: &str) -> bool {
    studio.renderer.gpu().pipelines().iter().any(|name| name.contains(word))
}

// ---- pipelines

#[test]
fn a_plain_room_compiles_what_it_draws_with_and_nothing_else() {
    let Some(gpu) = gpu() else { return };
    let transport = transport();
    let scene = plain(&transport);
    let mut studio = studio(gpu, &transport, &[]);
    assert_eq!(studio.renderer.gpu().pipelines(), [""; 0], "before the first picture");
    studio.settle(&scene, View::Composite);
    let names = studio.renderer.gpu().pipelines();
    let solver = ["bounce", "measure", "restrict_change", "solve", "correct"];
    let expected = solver.into_iter().chain(["gather", "surface", "tonemap"]).collect::<Vec<_>>();
    let is_expected = |name: &String| expected.iter().any(|expected| name.starts_with(expected));
    assert!(names.iter().all(is_expected), "{names:?}");
    assert!(names.contains(&"surface".to_owned()), "no part of the shader is needed: {names:?}");
    let count = names.len();
    studio.draw(&scene, View::Composite);
    assert_eq!(studio.renderer.gpu().pipelines().len(), count, "none is made twice");
    studio.draw(&scene, View::Patches);
    assert!(compiled(&studio, "patches"));
}

#[test]
fn each_kind_of_material_brings_its_own_pipeline() {
    let Some(gpu) = gpu() else { return };
    let transport = transport();
    let mut scene = plain(&transport);
    let mut studio = studio(gpu, &transport, &[]);
    studio.draw(&scene, View::Composite);
    for (word, alpha) in [("mask", Alpha::Mask { cutoff: 0.5 }), ("blend", Alpha::Blend)] {
        assert!(!compiled(&studio, word));
        scene.materials[4].alpha = alpha;
        studio.draw(&scene, View::Composite);
        assert!(compiled(&studio, word));
    }
    assert!(!compiled(&studio, "unlit") && !compiled(&studio, "lights") && !compiled(&studio, "sky"));
    scene.materials[4].unlit = true;
    scene.entities.push(lamp(true));
    scene.sky = Sky { kind: SkyKind::Constant { radiance: Vec3::ONE }, ..Sky::default() };
    studio.draw(&scene, View::Composite);
    assert!(
        ["unlit", "lights", "sky", "shadow", "direct_by_rays"].iter().all(|word| compiled(&studio, word))
    );
}

// ---- what comes and goes

#[test]
fn the_light_of_probes_comes_with_what_moves_and_goes_with_it() {
    let Some(gpu) = gpu() else { return };
    let transport = transport();
    let mut scene = plain(&transport);
    let mut studio = studio(gpu, &transport, &[]);
    let kinds = ["light of probes", "rows of probes"];
    studio.settle(&scene, View::Composite);
    let alone = studio.radiance();
    assert_eq!(kinds.map(|kind| studio.bytes(kind)), [0, 0]);
    assert!(!compiled(&studio, "dering") && !compiled(&studio, "objects"));
    scene.entities.push(ball(DVec3::new(0.0, 0.9, 0.0)));
    studio.settle(&scene, View::Composite);
    assert!(kinds.into_iter().all(|kind| studio.bytes(kind) > 0));
    assert!(compiled(&studio, "dering") && compiled(&studio, "objects"));
    let with_ball = studio.radiance();
    assert!(apart(&with_ball, &alone) > 0.01, "it is seen");
    scene.entities.pop();
    studio.settle(&scene, View::Composite);
    assert_eq!(kinds.map(|kind| studio.bytes(kind)), [0, 0]);
    assert_eq!(apart(&studio.radiance(), &alone), 0.0);
    scene.entities.push(ball(DVec3::new(0.0, 0.9, 0.0)));
    studio.draw(&scene, View::Composite);
    assert!(apart(&studio.radiance(), &with_ball) < 1e-3, "in its first picture already");
}

#[test]
fn shadow_maps_are_there_while_a_light_casts_shadows() {
    let Some(gpu) = gpu() else { return };
    let transport = transport();
    let mut scene = plain(&transport);
    let mut studio = studio(gpu, &transport, &[]);
    let kinds = ["shadow maps", "shadow rays"];
    let mut draw = |scene: &Scene| {
        studio.settle(scene, View::Composite);
        let passes = studio.draw(scene, View::Composite).passes;
        assert_eq!((passes.render, passes.compute), (2, 0), "surfaces and tone curve");
        kinds.map(|kind| studio.bytes(kind) > 0)
    };
    assert_eq!(draw(&scene), [false, false]);
    scene.entities.push(lamp(false));
    assert_eq!(draw(&scene), [false, true], "triangles: a light near a patch gives by its solid angle");
    *scene.entities.last_mut().expect("the lamp") = lamp(true);
    assert_eq!(draw(&scene), [true, true]);
    scene.entities.pop();
    assert_eq!(draw(&scene), [false, false]);
}

#[test]
fn cubemaps_are_there_for_probes_that_something_smooth_reads() {
    let Some(gpu) = gpu() else { return };
    let transport = transport();
    let mut scene = plain(&transport);
    scene.entities.push(mirror(800, DVec3::new(0.75, 0.5, 0.0), 0.2));
    let mut studio = studio(gpu, &transport, &[]);
    settle(&mut studio, &scene);
    assert_eq!(studio.bytes("cubemaps"), 0);
    assert!(!compiled(&studio, "blur"));
    // The left wall is smooth, but out of reach; then the right one.
    scene.materials[0].roughness = 0.1;
    settle(&mut studio, &scene);
    assert_eq!(studio.bytes("cubemaps"), 0, "nothing that is smooth reads it");
    scene.materials[1].roughness = 0.1;
    settle(&mut studio, &scene);
    assert!(studio.bytes("cubemaps") > 0 && compiled(&studio, "blur"));
    scene.materials.iter_mut().for_each(|material| material.roughness = 1.0);
    settle(&mut studio, &scene);
    assert_eq!(studio.bytes("cubemaps"), 0);
}

#[test]
fn a_probe_that_nothing_in_view_reads_waits_and_is_fresh_when_it_is_read() {
    let transport = transport();
    let mut scene = plain(&transport);
    // Walls read no cubemap; a ball of metal does.
    let walls = scene.entities.iter_mut().filter_map(|entity| entity.mesh.as_mut());
    walls.for_each(|wall| wall.reflection.probes = Some(Vec::new()));
    let mut metal = scene.materials[0].clone();
    (metal.id, metal.metallic, metal.roughness) = (MaterialId(50), 1.0, 0.1);
    scene.materials.push(metal);
    let at = DVec3::new(0.0, 1.0, 0.6);
    let mut shiny = ball(at);
    shiny.mesh = Some(room::mesh(Shape::Sphere, 50));
    shiny.transform.scale = DVec3::splat(0.2);
    scene.entities.extend([shiny, mirror(800, at, 0.3)]);
    let shown = |said: &[(Feature, Forced)]| {
        let mut scene = scene.clone();
        let mut studio = studio(gpu()?, &transport, said);
        // Towards the far wall, then to the ball behind, in the light that was changed in between.
        studio.eye = Eye::looking(DVec3::Y, DVec3::new(0.0, 1.0, -1.0));
        settle(&mut studio, &scene);
        scene.materials[2].emission.color *= 2.0;
        let mut captures = 0;
        for _ in 0..60 {
            captures += studio.draw(&scene, View::Composite).captures;
        }
        studio.eye = Eye::looking(DVec3::Y, at);
        let first = studio.draw(&scene, View::Composite).captures;
        Some((captures, first, studio.radiance()))
    };
    let Some((waited, first, seen)) = shown(&[]) else { return };
    let (followed, _, fresh) = shown(&[(Feature::UnseenCaptures, Forced::In)]).expect("a GPU");
    assert_eq!((waited, first), (0, 6));
    assert!(followed > 0);
    assert!(apart(&seen, &fresh) < 1e-3, "{}", apart(&seen, &fresh));
}

// ---- light that was solved at the bake

/// The light of a studio that is settled, as the one thing that never changes; rows and samples are gone.
fn solved(studio: &Studio, transport: &Transport) -> Transport {
    let spaces = studio.renderer.spaces();
    let read = |buffer: &wgpu::Buffer, count: usize| -> Vec<Vec3> {
        let all: Vec<Vec4> = buffer::read(studio.renderer.gpu(), buffer).unwrap();
        all[..count].iter().map(|light| light.truncate()).collect()
    };
    let both = |buffers: &[wgpu::Buffer; 2], count| buffers.each_ref().map(|buffer| read(buffer, count));
    let spread = Spread {
        radiosity: read(&spaces.radiosity, transport.patches.len()),
        receivers: both(&spaces.receivers, transport.receivers.len()),
        // As the baker stores them: they are windowed when they are read.
        probes: [&spaces.emitted, &spaces.bounced].map(|buffer| {
            let columns = read(buffer, transport.columns());
            let wide: Vec<DVec3> = columns.iter().map(|light| light.as_dvec3()).collect();
            gather(&transport.probe_from_patch, &wide).iter().map(|light| light.as_vec3()).collect()
        }),
        ..Spread::default()
    };
    let mut without = transport.clone();
    without.samples.clear();
    without.patches.iter_mut().for_each(|patch| (patch.first_sample, patch.sample_count) = (0, 0));
    for rows in
        [&mut without.patch_from_patch, &mut without.receiver_from_patch, &mut without.probe_from_patch]
    {
        *rows = Rows::default();
    }
    without.solved = Some(Solved { responses: vec![Response { source: Source::Never, spread }] });
    without
}

#[test]
fn light_that_was_solved_takes_no_rows_no_products_and_no_dispatch() {
    let Some(gpu) = gpu() else { return };
    let transport = transport();
    let mut scene = plain(&transport);
    scene.entities.extend([lamp(true), ball(DVec3::new(0.0, 0.9, 0.0))]);
    let mut live = studio(gpu, &transport, &[]);
    live.settle(&scene, View::Composite);
    let without = solved(&live, &transport);
    let (truth, light) = (live.radiance(), live.renderer.solved().unwrap());
    drop(live);
    let mut studio = studio(tests::picture::gpu().expect("a GPU"), &without, &[]);
    studio.draw(&scene, View::Composite);
    assert!(apart(&studio.radiance(), &truth) < 1e-3, "{}", apart(&studio.radiance(), &truth));
    assert_eq!(studio.draw(&scene, View::Composite).transport_dispatches, 0);
    let kinds = ["rows", "rows of probes", "coarse correction", "shadow rays"];
    assert_eq!(kinds.map(|kind| studio.bytes(kind)), [0; 4]);
    let words = ["bounce", "gather", "direct", "correct"];
    assert!(words.iter().all(|word| !compiled(&studio, word)), "{:?}", studio.renderer.gpu().pipelines());
    let found = studio.renderer.solved().unwrap();
    assert_eq!(found.radiosity.len(), transport.patches.len());
    assert!(apart(&found.probes, &light.probes) < 1e-5, "{}", apart(&found.probes, &light.probes));
    // Nothing moves: not even that is dispatched.
    scene.entities.pop();
    for _ in 0..3 {
        let drawn = studio.draw(&scene, View::Composite);
        assert_eq!((drawn.transport_dispatches, drawn.passes.compute), (0, 0));
    }
}

// ---- whatever the author says

#[test]
fn everything_forced_in_gives_the_same_picture() {
    let transport = transport();
    let mut scene = plain(&transport);
    scene.entities.push(lamp(true));
    scene.entities.push(mirror(800, DVec3::new(0.0, 1.0, 0.0), 1.0));
    let all: Vec<(Feature, Forced)> = Feature::ALL.into_iter().map(|feature| (feature, Forced::In)).collect();
    let shown = |said: &[(Feature, Forced)]| {
        let mut studio = studio(gpu()?, &transport, said);
        for _ in 0..60 {
            studio.draw(&scene, View::Composite);
        }
        let last = studio.draw(&scene, View::Composite);
        let kinds = ["light of probes", "rows of probes", "cubemaps"];
        let there = kinds.map(|kind| studio.bytes(kind) > 0);
        Some((studio.radiance(), there, last.captures, compiled(&studio, "normal map, mask, blend, unlit")))
    };
    let Some((picture, there, captures, alike)) = shown(&[]) else { return };
    assert_eq!((there, captures, alike), ([false; 3], 0, false));
    let (forced, there, captures, alike) = shown(&all).expect("a GPU");
    assert!(there == [true; 3] && captures == 6 && alike, "{there:?} {captures}");
    assert!(apart(&forced, &picture) < 1e-3, "{}", apart(&forced, &picture));
}

#[test]
fn what_is_forced_out_is_not_there_though_somebody_needs_it() {
    let Some(gpu) = gpu() else { return };
    let transport = transport();
    let mut scene = plain(&transport);
    scene.materials[1].roughness = 0.1;
    scene.materials[4].alpha = Alpha::Mask { cutoff: 0.5 };
    scene.sky = Sky { kind: SkyKind::Constant { radiance: Vec3::ONE }, ..Sky::default() };
    scene.entities.extend([lamp(true), ball(DVec3::new(0.0, 0.9, 0.0)), mirror(800, DVec3::Y, 1.0)]);
    assert!(scene.materials.iter().any(|material| material.id == MaterialId(0)));
    let all: Vec<(Feature, Forced)> =
        Feature::ALL.into_iter().map(|feature| (feature, Forced::Out)).collect();
    let mut studio = studio(gpu, &transport, &all);
    settle(&mut studio, &scene);
    let kinds = ["rows of probes", "cubemaps", "shadow maps", "coarse correction"];
    assert_eq!(kinds.map(|kind| studio.bytes(kind)), [0; 4]);
    let words = ["sky", "mask", "holes", "shadow", "blur", "restrict_change", "dering"];
    assert!(words.iter().all(|word| !compiled(&studio, word)), "{:?}", studio.renderer.gpu().pipelines());
}
