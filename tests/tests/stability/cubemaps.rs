//! Reflection probes in rooms that were baked: inside walls, close to them, in one light from everywhere, between
//! mirrors, and side by side.

use std::sync::Arc;

use engine::gpu::{Gpu, buffer, texture};
use engine::render::reflections::baked::upload;
use engine::render::reflections::prefilter::{Prefilter, faces, levels};
use engine::render::reflections::sight::look_around;
use engine::render::{Eye, Settings, View, shaders};
use engine::scene::{Entity, EntityId, Feature, Forced, ReflectionProbe, Refresh, Scene, Transform};
use engine::transport::reflection::influence::{ranked, weights};
use engine::transport::reflection::{Cube, Influence, MOST_IN_CAPTURES, ggx};
use engine::transport::{Occluders, Transport};
use glam::{DAffine3, DVec3, Vec3};
use tests::picture::{Studio, gpu};
use tests::project::TestProject;
use tests::room::directions;
use tests::solved::{WALLS, baked, block, paint, settings, shell};
use tests::surfaces;

const HIGH: Vec3 = Vec3::new(4.0, 2.0, 3.0);
const MIDDLE: DVec3 = DVec3::new(2.0, 1.0, 1.5);

/// A room whose walls give off so much, by name; what else stands in it is grey.
fn room(solids: &[[Vec3; 2]], glow: impl Fn(&str) -> f32) -> TestProject {
    let mut all = shell(Vec3::ZERO, HIGH, WALLS);
    all.extend(["solid"].into_iter().zip(solids.iter().map(|[low, high]| block(*low, *high))));
    let project = surfaces::project(&all);
    paint(&project, |name, material| {
        material.albedo.color = Vec3::splat(0.5);
        material.emission.color = Vec3::splat(glow(name));
    });
    project
}

fn probe(id: u64, at: DVec3, refresh: Refresh) -> Entity {
    let half_size = HIGH * 0.5;
    let offset = (MIDDLE - at).as_vec3();
    let probe = ReflectionProbe { resolution: 16, half_size, offset, refresh, ..ReflectionProbe::default() };
    Entity {
        id: EntityId(id),
        name: format!("probe {id}"),
        transform: Transform::at(at),
        reflection_probe: Some(probe),
        ..Entity::default()
    }
}

/// The floor becomes a mirror.
fn polish(scene: &mut Scene, wall: &str) {
    let material = scene.materials.iter_mut().find(|material| material.name == wall).expect("a wall");
    (material.metallic, material.roughness, material.albedo.color) = (1.0, 0.0, Vec3::ONE);
}

fn studio(transport: &Transport) -> Option<Studio> {
    let eye = Eye::looking(MIDDLE + DVec3::new(0.4, 0.3, 1.2), DVec3::new(2.0, 0.0, 1.0));
    let settings = Settings { samples: Some(1), ..Settings::default() };
    // Also where nothing is smooth.
    let said = [(Feature::Reflections, Forced::In)];
    Some(Studio::asked(gpu()?, transport.clone(), eye, [24, 24], settings, &said))
}

/// Until nothing is dispatched or captured any more.
fn settle(studio: &mut Studio, scene: &Scene, view: View) {
    for _ in 0..200 {
        let drawn = studio.draw(scene, view);
        if drawn.transport_dispatches == 0 && drawn.captures == 0 {
            return;
        }
    }
    panic!("does not settle");
}

/// The radiance in the cubemap of a probe that is taken once.
fn captured(transport: &Transport, scene: &Scene) -> Option<Cube> {
    let mut studio = studio(transport)?;
    settle(&mut studio, scene, View::Composite);
    let mut finished = studio.renderer.finished_cubemaps().expect("cubemaps");
    assert_eq!(finished.len(), 1);
    finished.pop().map(|(_, cube)| cube)
}

// ---- case 53

#[test]
fn a_cubemap_inside_a_solid_is_told_read_by_nothing_and_leaves_no_black() {
    let solid = [Vec3::new(1.5, 0.25, 1.0), Vec3::new(2.0, 0.75, 1.5)];
    let project = room(&[solid], |_| 0.5);
    let transport = baked(&project, &settings(1.0, 256));
    let mut scene = project.scene();
    polish(&mut scene, "-y");
    let (inside, outside) = (DVec3::new(1.75, 0.5, 1.25), MIDDLE);
    let shown = |probes: &[DVec3]| {
        let mut scene = scene.clone();
        scene.entities.extend((800..).zip(probes).map(|(id, &at)| probe(id, at, Refresh::OnChange)));
        let mut studio: Studio = studio(&transport)?;
        settle(&mut studio, &scene, View::Reflection);
        Some((studio.radiance(), studio.renderer.misplaced_probes()))
    };
    let Some((good, told)) = shown(&[outside]) else { return };
    assert!(told.is_empty());
    let (both, told) = shown(&[outside, inside]).expect("a GPU");
    assert!(
        told.len() == 1 && told[0].0 == EntityId(801) && told[0].1.contains("inside a solid"),
        "{told:?}"
    );
    assert!(both == good, "its weight is 0");
    let (alone, _) = shown(&[inside]).expect("a GPU");
    let mirrored = good.iter().zip(&alone).filter(|(good, _)| good.x > 0.0);
    let darkest = mirrored.map(|(good, alone)| alone.x / good.x).fold(f32::INFINITY, f32::min);
    println!(
        "with nothing but the probe in the solid, the mirror shows at least {darkest:.2} of what it should"
    );
    assert!(darkest > 0.5 && good.iter().any(|radiance| radiance.x > 0.0), "{darkest}");
}

// ---- case 54

#[test]
fn a_wall_a_millimetre_from_a_cubemap_has_no_hole() {
    let project = room(&[], |wall| if wall == "-x" { 1.0 } else { 0.0 });
    let transport = baked(&project, &settings(1.0, 256));
    let mut scene = project.scene();
    // What is not the wall is black.
    scene.materials.iter_mut().for_each(|material| material.albedo.color = Vec3::ZERO);
    polish(&mut scene, "-y");
    let at = DVec3::new(1e-3, 1.0, 1.5);
    scene.entities.push(probe(800, at, Refresh::Baked));
    let sight = look_around(&transport, &Occluders::new(&transport), (at - transport.origin).as_vec3());
    assert!(!sight.is_inside() && (sight.nearest / 1e-3 - 1.0).abs() < 0.1, "{sight:?}");
    // The probe's own near plane, 5 cm, would cut the wall away; half of what rays find does not.
    let near =
        scene.entities.last().and_then(|entity| entity.reflection_probe.as_ref()).expect("a probe").near;
    assert!(near > 10.0 * sight.nearest);
    let Some(cube) = captured(&transport, &scene) else { return };
    let side = cube.size() * cube.size();
    // The face towards the wall sees nothing else; a millimetre from it, so do the halves of four more.
    let towards = &cube.texels()[side..2 * side];
    let off = towards.iter().map(|texel| (*texel - 1.0).abs().max_element()).fold(0.0, f32::max);
    println!("the face towards the wall is off by at most {off:.1e}");
    assert!(off < 2e-3, "{off}");
    let bright = cube.texels().iter().filter(|texel| texel.x > 0.99).count();
    assert!(bright >= side + 4 * (side / 2 - cube.size()), "{bright} of {}", 6 * side);
}

// ---- case 55, and what 45 says of cubemaps

/// Blurred on the GPU, level by level.
fn prefiltered(gpu: &Arc<Gpu>, cube: &Cube, unit: f32) -> Vec<Cube> {
    let size = cube.size() as u32;
    let prefilter = Prefilter::new(gpu, &shaders::compiler(gpu).expect("shaders"));
    let harmonics = buffer::empty(gpu, "harmonics", 144, wgpu::BufferUsages::STORAGE);
    let source = prefilter.source(gpu, size, levels(size), &harmonics, 0);
    upload(gpu, &source.texture, cube, unit);
    let blurred = texture::cubes(gpu, "blurred", size, 1, levels(size));
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let mut timer = engine::gpu::timing::Timer::new(gpu);
    prefilter.run(&mut encoder, &mut timer, &source, &faces(&blurred, 0));
    gpu.queue.submit([encoder.finish()]);
    (0..levels(size)).map(|level| prefilter.read(gpu, &blurred, level).expect("a level")).collect()
}

/// Every texel, as a share of what it should be.
fn assert_constant(cube: &Cube, wanted: f32, what: &str) {
    let off = cube.texels().iter().map(|texel| (*texel / wanted - 1.0).abs().max_element());
    let off = off.fold(0.0, |most: f32, off| if off.is_nan() { f32::NAN } else { most.max(off) });
    println!("{what}: off by at most {off:.1e}");
    assert!(off <= 1e-3, "{what}: {off}");
}

#[test]
fn one_light_from_everywhere_stays_one_light_at_every_roughness_and_brightness() {
    // The second is what half floats could not hold.
    for glow in [0.5_f32, 1e7] {
        let project = room(&[], |_| glow);
        let transport = baked(&project, &settings(1.0, 1024));
        let mut scene = project.scene();
        scene.entities.push(probe(800, MIDDLE, Refresh::Baked));
        let Some(cube) = captured(&transport, &scene) else { return };
        let radiance = glow / (1.0 - 0.5);
        assert_constant(&cube, radiance, "captured");
        for roughness in [0.0, 0.25, 0.5, 1.0] {
            let samples = ggx::samples(roughness, 64, cube.size() as u32);
            let off = directions(50).map(|way| (cube.blurred(way, &samples) / radiance - 1.0).x.abs());
            assert!(off.fold(0.0, f32::max) <= 1e-3, "roughness {roughness}");
        }
        // A level has the unit that it was written with.
        let gpu = Arc::new(Gpu::headless().expect("an adapter"));
        for (level, blurred) in prefiltered(&gpu, &cube, radiance).iter().enumerate() {
            assert_constant(blurred, 1.0, &format!("level {level}"));
        }
    }
}

#[test]
fn reflections_in_a_box_have_a_direction_whichever_way_they_go() {
    let transform = DAffine3::from_translation(MIDDLE);
    let influence = Influence::new(
        &ReflectionProbe { half_size: HIGH * 0.5, ..ReflectionProbe::default() },
        &transform,
        DVec3::ZERO,
    );
    let influence = influence.expect("a box");
    let axes = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z];
    let ways: Vec<Vec3> = axes
        .into_iter()
        .chain(directions(30))
        .chain([Vec3::new(1.0, 0.0, -0.0), Vec3::new(0.0, 1e-30, 1.0)])
        .collect();
    for k in 0..125 {
        let share = |k: u32| k as f32 * 0.25;
        let at = Vec3::new(share(k % 5), share(k / 5 % 5), share(k / 25)) * HIGH;
        for way in &ways {
            let seen = influence.projected(at, *way);
            assert!(seen.is_finite() && (seen.length() - 1.0).abs() < 1e-5, "{at} {way}: {seen}");
        }
    }
}

// ---- case 56

#[test]
fn light_between_two_mirrors_stays_bounded_and_comes_to_rest() {
    let project = room(&[], |wall| if wall == "+y" { 1.0 } else { 0.0 });
    let transport = baked(&project, &settings(1.0, 256));
    let mut scene = project.scene();
    scene.materials.iter_mut().for_each(|material| material.albedo.color = Vec3::ZERO);
    ["-x", "+x"].into_iter().for_each(|wall| polish(&mut scene, wall));
    scene.entities.push(probe(800, MIDDLE, Refresh::OnChange));
    let Some(mut studio) = studio(&transport) else { return };
    studio.eye = Eye::looking(MIDDLE, MIDDLE + DVec3::new(-1.0, 0.1, 0.2));
    let mut frames: Vec<Vec<Vec3>> = Vec::new();
    for _ in 0..60 {
        studio.draw(&scene, View::Composite);
        frames.push(studio.radiance());
    }
    let most = frames.iter().flatten().map(|radiance| radiance.max_element()).fold(0.0, f32::max);
    assert!(frames.iter().flatten().all(|radiance| radiance.is_finite()));
    assert!(most <= 1.0 / (1.0 - MOST_IN_CAPTURES), "{most}");
    let apart = |a: &[Vec3], b: &[Vec3]| {
        a.iter().zip(b).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max)
    };
    let changes: Vec<f32> = frames.windows(2).map(|pair| apart(&pair[0], &pair[1])).collect();
    // Once the first capture is read, each change is at most 0.9 of the one before, to what half floats hold.
    let first = changes[..4].iter().copied().fold(0.0, f32::max);
    for (frame, change) in changes.iter().enumerate().skip(4) {
        let bound = first * MOST_IN_CAPTURES.powi(frame as i32 - 4) + 2e-3;
        assert!(*change <= bound, "frame {frame}: {change} is over {bound}");
    }
    println!("at most {most:.3}; changes {:.1e}, then {:.1e} after 20 frames", first, changes[20]);
    assert_eq!(changes[55..], [0.0; 4], "at rest");
}

// ---- case 57

/// A box with this middle and half size.
fn influence(middle: Vec3, half_size: Vec3, importance: i32) -> Influence {
    let probe = ReflectionProbe { half_size, importance, ..ReflectionProbe::default() };
    Influence::new(&probe, &DAffine3::from_translation(middle.as_dvec3()), DVec3::ZERO).expect("a box")
}

#[test]
fn shares_of_reflections_have_no_jumps_and_leave_the_sky_the_rest() {
    let boxes = [
        influence(Vec3::ZERO, Vec3::splat(4.0), 0),
        // Nested, overlapping, and beside it with a common face.
        influence(Vec3::new(1.0, 0.0, 0.0), Vec3::ONE, 0),
        influence(Vec3::new(2.5, 0.5, 0.0), Vec3::ONE, 0),
        influence(Vec3::new(-3.0, 0.0, 0.0), Vec3::ONE, 1),
        influence(Vec3::new(-1.0, 0.0, 0.0), Vec3::ONE, 1),
    ];
    let order = ranked(&boxes);
    let (mut largest, mut inside) = (0.0_f32, 0);
    let step = 1e-3;
    for (from, way) in [
        (Vec3::new(-6.0, 0.01, 0.02), Vec3::X),
        (Vec3::new(-5.0, -5.0, -5.0), Vec3::splat(3.0_f32.sqrt().recip())),
        (Vec3::new(-4.0, 0.99, 0.5), Vec3::X),
        (Vec3::new(2.0, 6.0, 1.0), Vec3::NEG_Y),
    ] {
        let mut last: Option<Vec<f32>> = None;
        for k in 0..12_000 {
            let at = from + way * (k as f32 * step);
            let now = weights(&boxes, &order, at);
            let sum: f32 = now.iter().sum();
            assert!(now.iter().all(|&weight| weight >= 0.0) && sum <= 1.0 + 1e-6, "{at}: {now:?}");
            let is_inside = boxes.iter().any(|one| one.depth(at) >= 0.0);
            assert!(!is_inside || (sum - 1.0).abs() < 1e-6, "{at}: {now:?}");
            inside += u32::from(is_inside);
            if let Some(last) = last {
                let change = now.iter().zip(&last).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                largest = largest.max(change);
            }
            last = Some(now);
        }
    }
    // The steepest is 1.5 over the blend distance, times one more where two groups meet.
    let bound = 2.0 * 1.5 * step / ReflectionProbe::default().blend_distance;
    println!("a millimetre changes a share by {largest:.1e} at most; {inside} places inside");
    assert!(largest <= bound && inside > 10_000, "{largest}");
}
