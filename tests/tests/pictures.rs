//! Closed forms first, read from the radiance before the tonemap; then what must change and what must not.

use std::f32::consts::PI;

use engine::gpu::Gpu;
use engine::render::{Eye, View};
use engine::scene::{Alpha, EntityId, LightKind, Projection, Scene, Sky, SkyKind};
use engine::transport::Transport;
use glam::{DQuat, DVec3, Vec3};
use tests::picture::{Studio, gpu};
use tests::room;

/// Straight down on the floor: one pixel is 0.1 m, the middle of the picture is the origin.
fn above() -> Eye {
    let mut eye = Eye::looking(DVec3::new(0.0, 8.0, 0.0), DVec3::ZERO);
    eye.rotation = DQuat::from_rotation_x(-std::f64::consts::FRAC_PI_2);
    eye.projection = Projection::Orthographic { half_height: 1.6 };
    eye
}

/// The point of the floor in the middle of a pixel of 32 x 32.
fn floor_point(x: u32, y: u32) -> Vec3 {
    Vec3::new((x as f32 + 0.5) * 0.1 - 1.6, 0.0, (y as f32 + 0.5) * 0.1 - 1.6)
}

fn floor_studio(gpu: Gpu) -> (Studio, Scene) {
    let transport = room::floor(4.0, 4);
    let scene = room::scene_of(&transport, |_| Vec3::splat(0.6));
    (Studio::new(gpu, transport, above(), [32, 32]), scene)
}

fn close(found: f32, wanted: f32, share: f32) {
    assert!((found - wanted).abs() <= share * wanted.abs() + 1e-5, "{found} instead of {wanted}");
}

#[test]
fn a_floor_under_a_point_light_is_rho_over_pi_times_intensity_cos_over_distance_squared() {
    let Some(gpu) = gpu() else { return };
    let (mut studio, mut scene) = floor_studio(gpu);
    let at = DVec3::new(0.4, 1.5, -0.3);
    scene.entities.push(room::light(100, LightKind::Point, 7.0, at, DVec3::ZERO));
    studio.draw(&scene, View::Composite);
    let radiance = studio.radiance();
    for (x, y) in [(16, 16), (2, 2), (30, 5), (20, 12)] {
        let irradiance = room::point_irradiance(7.0, at.as_vec3(), floor_point(x, y), Vec3::Y);
        close(radiance[(y * 32 + x) as usize].y, room::radiance(0.6, irradiance), 2e-3);
    }
}

#[test]
fn a_floor_under_a_slanting_sun_has_its_cosine() {
    let Some(gpu) = gpu() else { return };
    let (mut studio, mut scene) = floor_studio(gpu);
    let sun = room::light(100, LightKind::Sun, 3.0, DVec3::new(3.0, 4.0, 0.0), DVec3::ZERO);
    scene.entities.push(sun);
    studio.draw(&scene, View::Composite);
    for radiance in studio.radiance() {
        close(radiance.x, 0.6 / PI * 3.0 * 0.8, 2e-3);
    }
}

#[test]
fn a_spot_ends_at_its_cone() {
    let Some(gpu) = gpu() else { return };
    let (mut studio, mut scene) = floor_studio(gpu);
    let kind = LightKind::Spot { inner: 0.2, outer: 0.4 };
    let at = DVec3::new(0.0, 2.0, 0.0);
    scene.entities.push(room::light(100, kind, 5.0, at, DVec3::ZERO));
    studio.draw(&scene, View::Composite);
    let radiance = studio.radiance();
    let row = |x: u32| radiance[(16 * 32 + x) as usize].x;
    let inside = floor_point(17, 16);
    close(row(17), 0.6 / PI * room::point_irradiance(5.0, at.as_vec3(), inside, Vec3::Y), 3e-3);
    // tan 0.4 * 2 m = 0.85 m
    assert_eq!(row(16 + 10), 0.0);
    assert!(row(16 + 6) < row(16 + 2));
}

#[test]
fn a_floor_under_a_constant_sky_gets_pi_times_its_radiance() {
    let Some(gpu) = gpu() else { return };
    let (mut studio, mut scene) = floor_studio(gpu);
    scene.sky = Sky { kind: SkyKind::Constant { radiance: Vec3::new(0.5, 1.0, 2.0) }, ..Sky::default() };
    studio.settle(&scene, View::Composite);
    let middle = studio.radiance_at(16, 16);
    for (found, sky) in middle.to_array().into_iter().zip([0.5, 1.0, 2.0]) {
        close(found, 0.6 * sky, 2e-3);
    }
    studio.draw(&scene, View::Indirect);
    assert_eq!(studio.radiance_at(16, 16), Vec3::ZERO, "seen directly, not bounced");
}

/// White light in a closed grey room: B = E / (1 - rho) where E is the same everywhere.
#[test]
fn a_furnace_glows_as_e_over_1_less_rho() {
    let Some(gpu) = gpu() else { return };
    let transport = room::closed_box(Vec3::splat(-1.0), Vec3::splat(1.0), 4);
    let mut scene = room::scene_of(&transport, |_| Vec3::splat(0.9));
    for material in &mut scene.materials {
        material.emission.color = Vec3::splat(0.25);
    }
    let eye = Eye::looking(DVec3::ZERO, DVec3::NEG_Z);
    let mut studio = Studio::new(gpu, transport, eye, [32, 32]);
    studio.settle(&scene, View::Composite);
    for radiance in studio.radiance() {
        close(radiance.x, 0.25 / (1.0 - 0.9), 2e-3);
    }
}

/// A room with one lamp, its walls red and green.
fn room_scene(transport: &Transport) -> Scene {
    let mut scene = room::scene_of(transport, |wall| match wall {
        0 => Vec3::new(0.7, 0.1, 0.1),
        1 => Vec3::new(0.1, 0.7, 0.1),
        _ => Vec3::splat(0.7),
    });
    let at = DVec3::new(0.3, 1.5, 0.2);
    scene.entities.push(room::light(100, LightKind::Point, 2.0, at, DVec3::ZERO));
    scene
}

fn room_studio(gpu: Gpu) -> (Studio, Scene) {
    let transport = room::closed_box(Vec3::new(-1.0, 0.0, -1.0), Vec3::new(1.0, 2.0, 1.0), 6);
    let positions = [0.4, 1.6].map(|y| [-0.6, 0.6].map(|x| [-0.6, 0.6].map(|z| Vec3::new(x, y, z))));
    let positions = positions.as_flattened().as_flattened();
    let transport =
        room::with_probes(transport, Vec3::new(-1.0, 0.0, -1.0), Vec3::new(1.0, 2.0, 1.0), positions);
    let scene = room_scene(&transport);
    let eye = Eye::looking(DVec3::new(0.0, 1.0, 3.4), DVec3::new(0.0, 1.0, 0.0));
    (Studio::new(gpu, transport, eye, [64, 64]), scene)
}

fn mean(studio: &Studio) -> Vec3 {
    let radiance = studio.radiance();
    radiance.iter().sum::<Vec3>() / radiance.len() as f32
}

#[test]
fn edits_show_without_a_bake() {
    let Some(gpu) = gpu() else { return };
    let (mut studio, mut scene) = room_studio(gpu);
    studio.settle(&scene, View::Composite);
    let lit = mean(&studio);
    assert!(lit.min_element() > 0.01, "{lit}");

    scene.materials[0].albedo.color = Vec3::new(0.1, 0.1, 0.7);
    let drawn = studio.settle(&scene, View::Indirect);
    assert_eq!(drawn.transport_dispatches, 0);
    studio.settle(&scene, View::Composite);
    let repainted = mean(&studio);
    assert!(repainted.z > lit.z * 1.05 && repainted.x < lit.x * 0.95, "{lit} {repainted}");

    scene.entities.last_mut().unwrap().light.as_mut().unwrap().on = false;
    studio.settle(&scene, View::Composite);
    assert_eq!(mean(&studio), Vec3::ZERO, "dark");

    scene.materials[3].emission.color = Vec3::ONE;
    studio.settle(&scene, View::Composite);
    assert!(mean(&studio).min_element() > 0.01);
}

#[test]
fn direct_and_indirect_add_up_to_the_composite() {
    let Some(gpu) = gpu() else { return };
    let (mut studio, mut scene) = room_studio(gpu);
    scene.materials[3].emission.color = Vec3::splat(0.3);
    studio.settle(&scene, View::Composite);
    let composite = studio.radiance();
    studio.draw(&scene, View::Direct);
    let direct = studio.radiance();
    studio.draw(&scene, View::Indirect);
    let indirect = studio.radiance();
    for ((c, d), i) in composite.iter().zip(&direct).zip(&indirect) {
        assert!((*c - *d - *i).abs().max_element() <= 2e-3 * c.max_element() + 1e-4, "{c} {d} {i}");
    }
}

#[test]
fn colour_bleeds_from_the_red_wall() {
    let Some(gpu) = gpu() else { return };
    let (mut studio, scene) = room_studio(gpu);
    studio.settle(&scene, View::Indirect);
    // On the back wall, near the red and near the green one.
    let (red, green) = (studio.radiance_at(20, 32), studio.radiance_at(43, 32));
    assert!(red.x > red.y * 1.05, "{red}");
    assert!(green.y > green.x * 1.05, "{green}");
}

#[test]
fn a_moving_box_casts_its_shadow_on_patches_and_pixels() {
    let Some(gpu) = gpu() else { return };
    let (mut studio, mut scene) = floor_studio(gpu);
    let cube = engine::scene::shape::Shape::Cube;
    let source = engine::scene::MeshSource::Shape(cube);
    studio.assets.meshes.insert(source, engine::scene::shape::mesh(cube).into());
    let sun = room::light(100, LightKind::Sun, 3.0, DVec3::new(3.0, 3.0, 0.0), DVec3::ZERO);
    scene.entities.push(sun);
    studio.draw(&scene, View::Direct);
    let free = studio.radiance_at(10, 16);
    let mut entity =
        engine::scene::Entity { id: EntityId(200), mesh: Some(room::mesh(cube, 0)), ..Default::default() };
    entity.transform.translation = DVec3::new(0.0, 0.6, 0.0);
    scene.entities.push(entity);
    let drawn = studio.draw(&scene, View::Direct);
    assert!(drawn.shadow_draws > 0 && drawn.transport_dispatches > 0);
    // The light comes from +x at 45 degrees: the shadow falls towards -x, up to -1.6 m.
    assert_eq!(studio.radiance_at(6, 16), Vec3::ZERO);
    assert!((studio.radiance_at(24, 16) - free).length() < 1e-3);
    // Nothing moves on: nothing is drawn into shadow maps again.
    assert_eq!(studio.draw(&scene, View::Direct).shadow_draws, 0);
    // A blocker that casts no shadow.
    scene.entities.last_mut().unwrap().mesh.as_mut().unwrap().casts_shadows = false;
    studio.draw(&scene, View::Direct);
    assert!((studio.radiance_at(6, 16) - free).length() < 1e-3);
}

#[test]
fn a_half_transparent_floor_shows_half_of_itself() {
    let Some(gpu) = gpu() else { return };
    let (mut studio, mut scene) = floor_studio(gpu);
    scene.entities.push(room::light(100, LightKind::Sun, 3.0, DVec3::Y, DVec3::ZERO));
    scene.entities.last_mut().unwrap().light.as_mut().unwrap().casts_shadows = false;
    studio.draw(&scene, View::Direct);
    let opaque = studio.radiance_at(16, 16).x;
    scene.materials[0].alpha = Alpha::Blend;
    scene.materials[0].opacity = 0.5;
    studio.draw(&scene, View::Direct);
    close(studio.radiance_at(16, 16).x, opaque * 0.5, 5e-3);
    scene.materials[0].alpha = Alpha::Mask { cutoff: 0.6 };
    studio.draw(&scene, View::Direct);
    assert_eq!(studio.radiance_at(16, 16).x, 0.0);
}

#[test]
fn a_hidden_wall_is_not_drawn_and_a_back_face_is_culled() {
    let Some(gpu) = gpu() else { return };
    let (mut studio, mut scene) = floor_studio(gpu);
    studio.draw(&scene, View::Albedo);
    close(studio.radiance_at(16, 16).x, 0.6, 1e-3);
    scene.entities[0].hidden = true;
    studio.draw(&scene, View::Albedo);
    assert_eq!(studio.radiance_at(16, 16).x, 0.0);
    scene.entities[0].hidden = false;
    studio.eye.position.y = -8.0;
    studio.eye.rotation = DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2);
    studio.draw(&scene, View::Albedo);
    assert_eq!(studio.radiance_at(16, 16).x, 0.0);
}

/// A quarter of it comes from everywhere.
#[test]
fn a_light_at_the_eye_shows_shapes_where_the_scene_has_none() {
    let Some(gpu) = gpu() else { return };
    let (mut studio, mut scene) = floor_studio(gpu);
    studio.draw(&scene, View::Composite);
    assert_eq!(studio.radiance_at(16, 16), Vec3::ZERO);
    studio.draw(&scene, View::Headlight);
    close(studio.radiance_at(16, 16).x, 0.6, 2e-3);
    let (sine, cosine) = 0.9_f32.sin_cos();
    let tilted = DVec3::new(f64::from(sine), f64::from(cosine), 0.0) * 8.0;
    studio.eye = Eye { projection: studio.eye.projection, ..Eye::looking(tilted, DVec3::ZERO) };
    studio.draw(&scene, View::Headlight);
    close(studio.radiance_at(16, 16).x, 0.6 * (0.25 + 0.75 * cosine), 2e-3);
    // The scene's own light changes nothing, and what glows is seen to.
    scene.entities.push(room::light(100, LightKind::Sun, PI, DVec3::Y, DVec3::ZERO));
    studio.draw(&scene, View::Headlight);
    close(studio.radiance_at(16, 16).x, 0.6 * (0.25 + 0.75 * cosine), 2e-3);
    scene.materials[0].emission.color = Vec3::new(5.0, 0.0, 0.0);
    studio.draw(&scene, View::Headlight);
    let seen = studio.radiance_at(16, 16);
    close(seen.x, 1.0 + seen.y, 2e-3);
}

#[test]
fn every_view_shows_something_and_all_differ() {
    let Some(gpu) = gpu() else { return };
    let (mut studio, mut scene) = room_studio(gpu);
    scene.materials[2].roughness = 0.2;
    scene.materials[2].metallic = 0.7;
    let mut seen: Vec<Vec<u8>> = Vec::new();
    for view in View::ALL {
        studio.settle(&scene, view);
        let pixels = studio.pixels();
        assert!(
            pixels.chunks_exact(4).any(|pixel| pixel[..3].iter().any(|&value| value > 40)),
            "{}",
            view.name()
        );
        assert!(!seen.contains(&pixels), "{}", view.name());
        seen.push(pixels);
    }
}

#[test]
fn exposure_is_a_power_of_two_and_the_display_is_srgb() {
    let Some(gpu) = gpu() else { return };
    let (mut studio, mut scene) = floor_studio(gpu);
    scene.sky = Sky { kind: SkyKind::Constant { radiance: Vec3::splat(0.25) }, ..Sky::default() };
    studio.settle(&scene, View::Composite);
    // 0.15 on the floor; sRGB of that is 0.425.
    let at = |studio: &Studio| studio.pixels()[(16 * 32 + 16) * 4];
    assert!(at(&studio).abs_diff(108) <= 1, "{}", at(&studio));
    studio.eye.exposure = 1.0;
    studio.draw(&scene, View::Composite);
    assert!(at(&studio).abs_diff(149) <= 1, "{}", at(&studio));
}

/// Where two walls meet, a shadow map's filter reads past the wall that blocks: thin lines would be lit.
#[test]
fn no_sun_comes_into_a_closed_room() {
    let Some(gpu) = gpu() else { return };
    let transport = room::closed_box(Vec3::new(-1.0, 0.0, -1.0), Vec3::new(1.0, 2.0, 1.0), 2);
    let mut scene = room::scene_of(&transport, |_| Vec3::ONE);
    let sun = room::light(100, LightKind::Sun, PI, DVec3::new(1.0, 1.6, 4.0), DVec3::ZERO);
    scene.entities.push(sun);
    let mut eye = Eye::looking(DVec3::new(0.0, 1.0, 0.9), DVec3::new(0.0, 1.0, 0.0));
    eye.projection = Projection::Perspective { fov_y: 1.9 };
    let mut studio = Studio::new(gpu, transport, eye, [256, 256]);
    studio.draw(&scene, View::Composite);
    let radiance = studio.radiance();
    let lit = radiance.iter().filter(|radiance| radiance.x > 0.01).count();
    assert!(lit <= 30, "{lit} pixels of {} are lit", radiance.len());
    let mean = radiance.iter().sum::<Vec3>() / radiance.len() as f32;
    assert!(mean.x < 1e-4, "{mean}");
}
