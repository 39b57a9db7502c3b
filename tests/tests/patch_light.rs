//! Direct light at patches: the GPU against the plain twin on the CPU, and both against what is known.

use std::f32::consts::PI;

use engine::gpu::{Gpu, buffer};
use engine::render::{Eye, PatchShadows, Settings, View};
use engine::scene::assets::{Picture, Pixels};
use engine::scene::shape::{self, Shape};
use engine::scene::{
    Alpha, Entity, EntityId, ImageSource, LightKind, MeshSource, Scene, Texture, Transform, world_from_local,
};
use engine::transport::direct::{irradiance_of_patches, placed_lights};
use engine::transport::surface::Blend;
use engine::transport::{Batch, NONE, Occluders, Patch, Sample, Transport, Vertex};
use glam::{DQuat, DVec3, Vec3, Vec4};
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
    behind(&Occluders::new(transport), transport, scene)
}

fn behind(occluders: &Occluders, transport: &Transport, scene: &Scene) -> Vec<Vec3> {
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
fn lamp(kind: LightKind, height: f64) -> Entity {
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
        let at = DVec3::new(1.6 * turn.cos(), 1.9 - 0.05 * (k % 20) as f64, 1.2 * turn.sin());
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
        // One lamp at a time.
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

/// A block that moves: turned, stretched, of a shape.
fn mover(shape: Shape, at: DVec3) -> Entity {
    let rotation = DQuat::from_axis_angle(DVec3::new(0.3, 0.5, 0.8).normalize(), 0.7);
    Entity {
        id: EntityId(500),
        mesh: Some(room::mesh(shape, 0)),
        transform: Transform { translation: at, rotation, scale: DVec3::new(0.9, 0.3, 0.5) },
        ..Entity::default()
    }
}

/// The static surface and the mover, for rays alone.
fn with_mover(transport: &Transport, scene: &Scene, shape: Shape) -> Occluders {
    let mut all = transport.clone();
    let index = scene.entities.iter().position(|entity| entity.id == EntityId(500)).unwrap();
    let world = world_from_local(scene)[index];
    let mesh = shape::mesh(shape);
    let first = all.surface.vertices.len() as u32;
    all.surface.vertices.extend(mesh.positions.iter().map(|position| Vertex {
        position: world.transform_point3(position.as_dvec3()).as_vec3(),
        ..Vertex::default()
    }));
    all.surface.triangles.extend(mesh.triangles().map(|triangle| triangle.map(|index| first + index)));
    Occluders::new(&all)
}

#[test]
fn what_moves_darkens_the_patches_behind_it_off_screen_by_rays_and_by_maps() {
    for shadows in [PatchShadows::Rays, PatchShadows::Maps] {
        let Some(gpu) = gpu() else { return };
        let transport = furnished();
        let mut studio = studio(gpu, transport.clone(), shadows);
        // The eye looks away from everything.
        studio.eye = Eye::looking(DVec3::new(0.0, 1.0, 20.0), DVec3::new(0.0, 1.0, 40.0));
        for shape in [Shape::Cube, Shape::Sphere] {
            studio.assets.meshes.insert(MeshSource::Shape(shape), shape::mesh(shape).into());
            for at in [DVec3::new(0.9, 1.2, 0.3), DVec3::new(0.3, 1.0, -0.6)] {
                let mut scene = white(&transport);
                lamps(&mut scene, 1);
                let without = on_gpu(&mut studio, &scene);
                scene.entities.push(mover(shape, at));
                let truth = behind(&with_mover(&transport, &scene, shape), &transport, &scene);
                let found = on_gpu(&mut studio, &scene);
                let darker = truth.iter().zip(&without).filter(|(now, then)| now.x < 0.5 * then.x).count();
                assert!(darker > 10, "{shape:?} {at}: {darker} patches are darker");
                let sum = |light: &[Vec3]| flux_into(&transport, light);
                let (wrong, off) = (count_apart(&found, &truth), sum(&found) / sum(&truth) - 1.0);
                let blocked = 1.0 - sum(&truth) / sum(&without);
                println!("{shadows:?} {shape:?}: {blocked} blocked, {wrong} patches differ, in all {off}");
                match shadows {
                    PatchShadows::Rays => assert!(wrong * 250 <= truth.len(), "{wrong}"),
                    // Maps blur what is finer than their texels.
                    PatchShadows::Maps => assert!(off.abs() < 0.01, "{off}"),
                }
            }
        }
    }
}

#[test]
fn maps_and_rays_agree() {
    let transport = furnished();
    let mut scene = white(&transport);
    lamps(&mut scene, 4);
    let of = |shadows| Some(on_gpu(&mut studio(gpu()?, transport.clone(), shadows), &scene));
    let Some(rays) = of(PatchShadows::Rays) else { return };
    let maps = of(PatchShadows::Maps).unwrap();
    let difference = maps.iter().zip(&rays).zip(&transport.patches);
    let mean: f32 = difference.map(|((a, b), patch)| (a.x - b.x).abs() * patch.area).sum();
    let mean = mean / flux_into(&transport, &rays);
    println!("mean difference {mean} of the mean");
    assert!(mean < 0.01, "{mean}");
}

/// A mask's picture that is there everywhere, or nowhere.
fn mask(alpha: u8) -> Picture {
    Picture { width: 4, height: 4, pixels: Pixels::Rgba8(vec![[255, 255, 255, alpha]; 16]) }
}

#[test]
fn rays_ask_the_map_where_a_picture_has_holes_and_only_there() {
    let Some(gpu) = gpu() else { return };
    let transport = furnished();
    let mut studio = studio(gpu, transport.clone(), PatchShadows::Rays);
    let mut scene = white(&transport);
    lamps(&mut scene, 4);
    let solid = on_gpu(&mut studio, &scene);
    // The table, rectangles 12 to 17.
    let mut without = scene.clone();
    let table = without.entities[12..18].iter_mut();
    table.for_each(|entity| entity.mesh.as_mut().unwrap().casts_shadows = false);
    let open = on_gpu(&mut studio, &without);
    let behind_table = open.iter().zip(&solid).filter(|(open, solid)| open != solid).count();
    assert!((20..solid.len() / 2).contains(&behind_table), "{behind_table}");
    for (alpha, truth) in [(0, &open), (255, &solid)] {
        // A picture is read once: each has its own file.
        let image = ImageSource { file: format!("mask {alpha}.png"), image: None };
        studio.assets.images.insert(image.clone(), mask(alpha).into());
        for material in &mut scene.materials[12..18] {
            material.albedo.texture = Some(Texture::new(image.clone()));
            material.alpha = Alpha::Mask { cutoff: 0.5 };
        }
        let found = on_gpu(&mut studio, &scene);
        // Nothing stands between the others and the lamps but what is solid.
        let elsewhere = (0..found.len()).filter(|&i| open[i] == solid[i] && found[i] != solid[i]).count();
        let off = flux_into(&transport, &found) / flux_into(&transport, truth) - 1.0;
        println!(
            "alpha {alpha}: {behind_table} patches behind the table, {elsewhere} others differ, in all {off}"
        );
        assert_eq!(elsewhere, 0);
        assert!(off.abs() < 0.01, "{off}");
    }
}

#[test]
fn lights_beyond_those_that_have_maps_cast_shadows_on_patches_all_the_same() {
    let Some(gpu) = gpu() else { return };
    let transport = furnished();
    let mut scene = white(&transport);
    // More than there are layers for maps, of which a point light takes six; all but the last, a point light, are
    // dark.
    let count = 2 * (u64::from(gpu.device.limits().max_texture_array_layers) / 6 + 2) + 1;
    lamps(&mut scene, count);
    for entity in scene.entities.iter_mut().filter(|entity| (100..99 + count).contains(&entity.id.0)) {
        entity.light.as_mut().unwrap().on = false;
    }
    let mut studio = studio(gpu, transport.clone(), PatchShadows::Maps);
    let found = on_gpu(&mut studio, &scene);
    assert!(!studio.renderer.left_out().is_empty());
    let wrong = count_apart(&found, &on_cpu(&transport, &scene));
    assert!(wrong * 250 <= found.len(), "{wrong}");
}

/// A ball in the room, all of it one patch of 4 fine^2 triangles, less those at the poles.
fn room_with_a_ball(fine: u32) -> Transport {
    let mut transport = empty_room();
    let centre = Vec3::new(0.4, 1.0, 0.1);
    let surface = &mut transport.surface;
    let (first_vertex, first) = (surface.vertices.len() as u32, surface.triangles.len() as u32);
    let direction = |ring: u32, segment: u32| {
        let (r, y) = (PI * ring as f32 / fine as f32).sin_cos();
        let turn = PI * (segment % (2 * fine)) as f32 / fine as f32;
        Vec3::new(r * turn.sin(), y, r * turn.cos())
    };
    for ring in 0..=fine {
        for segment in 0..2 * fine {
            let normal = direction(ring, segment);
            let position = normal * 0.3 + centre;
            surface.vertices.push(Vertex { position, normal, color: [1.0; 4], ..Vertex::default() });
        }
    }
    for ring in 0..fine {
        for segment in 0..2 * fine {
            let at = |ring: u32, segment: u32| first_vertex + ring * 2 * fine + segment % (2 * fine);
            let [a, b] = [at(ring, segment), at(ring, segment + 1)];
            let [c, d] = [at(ring + 1, segment), at(ring + 1, segment + 1)];
            let sides = [(ring > 0).then_some([a, c, b]), (ring + 1 < fine).then_some([b, c, d])];
            surface.triangles.extend(sides.into_iter().flatten());
        }
    }
    surface.blends.resize(surface.vertices.len(), Blend::one(0));
    let (patch, count) = (transport.patches.len() as u32, surface.triangles.len() as u32 - first);
    surface.patches.resize(surface.triangles.len(), [patch, NONE]);
    let batch = surface.batches.len() as u32;
    surface.batches.push(Batch { entity: [batch + 1, 0], material: batch, double_sided: 0, first, count });
    let first_sample = transport.samples.len() as u32;
    for k in 0..16 {
        let (z, turn) = (1.0 - (2.0 * k as f32 + 1.0) / 16.0, k as f32 * 2.4);
        let normal = Vec3::new(turn.cos() * (1.0 - z * z).sqrt(), turn.sin() * (1.0 - z * z).sqrt(), z);
        transport.samples.push(Sample { position: normal * 0.3 + centre, patch, normal, padding: 0 });
    }
    transport.patches.push(Patch {
        centre,
        area: 4.0 * PI * 0.09,
        normal: Vec3::Y,
        batch,
        first_triangle: first,
        triangle_count: count,
        first_sample,
        sample_count: 16,
        ..Patch::default()
    });
    room::with_empty_rows(transport)
}

/// A ball's share of a light 1e-4 .. 1 m from it, which is known; `off`: how far the share may be from it.
fn a_light_close_to_a_ball(fine: u32, off: f32, kinds: &[LightKind]) {
    let Some(gpu) = gpu() else { return };
    let transport = room_with_a_ball(fine);
    let mut studio = studio(gpu, transport.clone(), PatchShadows::Rays);
    let ball = transport.patches.len() - 1;
    let sample = transport.samples[transport.patches[ball].first_sample as usize + 5];
    for distance in [1e-4, 0.01, 0.05, 0.2, 0.5, 1.0] {
        let at = (sample.position + sample.normal * distance).as_dvec3();
        for &kind in kinds {
            let mut scene = white(&transport);
            scene.entities.push(room::light(100, kind, 1.0, at, transport.patches[ball].centre.as_dvec3()));
            let (truth, found) = (on_cpu(&transport, &scene), on_gpu(&mut studio, &scene));
            // Rays that graze the ball may go either way.
            let wrong = count_apart(&found, &truth);
            assert!(wrong * 100 <= found.len(), "{distance}: {wrong}");
            let taken = found[ball].x * transport.patches[ball].area / flux(kind);
            let all = flux_into(&transport, &found) / flux(kind);
            println!("{fine}, {kind:?} {distance} m from the ball: it takes {taken}; all take {all}");
            assert!(all <= 1.005 + off, "{distance}: {all}");
            if kind == LightKind::Point {
                // What a ball covers of the sphere around the light.
                let known = 0.5 * (1.0 - (1.0 - (0.3 / (0.3 + distance)).powi(2)).sqrt());
                assert!((taken - known).abs() < off, "{distance}: {taken}, {known}");
            }
        }
    }
}

#[test]
fn a_light_close_to_a_statue_is_not_multiplied() {
    // Its triangles lie up to 3 mm below the ball.
    a_light_close_to_a_ball(12, 0.06, &[LightKind::Point, SPOT]);
}

#[test]
fn close_to_a_statue_of_too_many_triangles_it_is_multiplied_by_a_fifth_at_most() {
    a_light_close_to_a_ball(24, 0.2, &[LightKind::Point, SPOT]);
}

#[test]
fn what_is_hidden_or_casts_no_shadow_lets_light_through_and_glass_a_part_of_it() {
    for shadows in [PatchShadows::Rays, PatchShadows::Maps] {
        let Some(gpu) = gpu() else { return };
        let transport = furnished();
        let mut studio = studio(gpu, transport.clone(), shadows);
        // From above the table (rectangles 12 to 17) to the floor below it.
        let mut scene = white(&transport);
        scene.entities.push(room::light(
            100,
            LightKind::Point,
            1.0,
            DVec3::new(0.85, 2.2, 0.45),
            DVec3::ZERO,
        ));
        let floor: Vec<usize> = (0..transport.patches.len())
            .filter(|&i| {
                let patch = &transport.patches[i];
                patch.batch == 2 && (patch.centre - Vec3::new(0.85, 0.0, 0.45)).length() < 0.25
            })
            .collect();
        assert!(!floor.is_empty());
        let mut below = |scene: &Scene| -> f32 {
            let light = on_gpu(&mut studio, scene);
            floor.iter().map(|&i| light[i].x).sum::<f32>() / floor.len() as f32
        };
        let blocked = below(&scene);
        assert!(blocked < 1e-3, "{shadows:?}: {blocked}");
        let mut glass = scene.clone();
        for material in &mut glass.materials[12..18] {
            material.alpha = engine::scene::Alpha::Blend;
            material.opacity = 0.5;
        }
        let dimmed = below(&glass);
        scene.entities[12..15].iter_mut().for_each(|entity| entity.hidden = true);
        let table = scene.entities[15..18].iter_mut();
        table.for_each(|entity| entity.mesh.as_mut().unwrap().casts_shadows = false);
        let open = below(&scene);
        // Two sheets of half-transparent glass.
        println!("{shadows:?}: {blocked} {dimmed} {open}");
        let share = dimmed / open;
        let tolerance = if shadows == PatchShadows::Rays { 1e-3 } else { 0.26 };
        assert!(open > 0.1 && (share - 0.25).abs() < tolerance, "{shadows:?}: {share}");
    }
}
