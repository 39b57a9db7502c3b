//! Shadows at their borders: no light comes through where walls meet, none is missing where lit ones do, nothing
//! shades itself; and what many lights cost.

use std::f32::consts::PI;

use engine::gpu::Gpu;
use engine::render::{Eye, Settings, View};
use engine::scene::shape::Shape;
use engine::scene::{Alpha, Entity, EntityId, LightKind, MeshSource, Projection, Scene};
use engine::transport::Transport;
use glam::{DVec3, Vec3};
use tests::picture::{Studio, gpu};
use tests::room::{self, Rectangle};

fn save(studio: &Studio, name: &str) {
    if let Some(folder) = std::env::var_os("SHADOW_PICTURES") {
        studio.save(&std::path::Path::new(&folder).join(format!("{name}.png")));
    }
}

/// Quads of a closed room that look inside; with a thickness, as many more that look outside.
fn house(thickness: f32) -> Transport {
    let (low, high) = (Vec3::new(-1.5, 0.0, -1.0), Vec3::new(1.5, 2.0, 1.0));
    let mut walls: Vec<Rectangle> = room::walls(low, high).into();
    if thickness > 0.0 {
        let outside = room::walls(low - thickness, high + thickness);
        let turned =
            |wall: &Rectangle| Rectangle { corner: wall.corner, edges: [wall.edges[1], wall.edges[0]] };
        walls.extend(outside.iter().map(turned));
    }
    room::with_empty_rows(room::surfaces(&walls, 1))
}

#[test]
fn no_sun_comes_through_where_walls_meet() {
    let Some(gpu) = gpu() else { return };
    let mut gpu = Some(gpu);
    for thickness in [0.0, 0.02] {
        let transport = house(thickness);
        let mut scene = room::scene_of(&transport, |_| Vec3::ONE);
        let from = DVec3::new(1.0, 2.0, 0.5);
        scene.entities.push(room::light(100, LightKind::Sun, 1000.0, from, DVec3::ZERO));
        let this = gpu.take().unwrap_or_else(|| Gpu::headless().unwrap());
        let mut studio = Studio::new(this, transport, Eye::looking(DVec3::Y, DVec3::ZERO), [320, 320]);
        for (k, eye) in inside().into_iter().enumerate() {
            studio.eye = eye;
            for (n, from) in suns().into_iter().enumerate() {
                let sun = room::light(100, LightKind::Sun, 1000.0, from, DVec3::ZERO);
                *scene.entities.last_mut().unwrap() = sun;
                studio.draw(&scene, View::Direct);
                let radiance = studio.radiance();
                let lit = radiance.iter().filter(|radiance| radiance.x > 1e-3).count();
                let most = radiance.iter().fold(0.0, |most: f32, radiance| most.max(radiance.x));
                // A light's share of a corner's pixel: what a texel's rounding leaves.
                let allowed = 1000.0 / PI * if from.y > 0.1 { 0.005 } else { 0.03 };
                save(&studio, &format!("leak_{thickness}_{k}_{n}"));
                assert!(
                    most <= allowed,
                    "thickness {thickness}, eye {k}, sun {from}: {lit} lit, up to {most}"
                );
            }
        }
    }
}

/// Into the corners of the house.
fn inside() -> Vec<Eye> {
    let corners = [(1.5, 0.0, 1.0), (-1.5, 0.0, 1.0), (1.5, 2.0, -1.0), (-1.5, 2.0, -1.0), (0.0, 0.0, 1.0)];
    let looking = |(x, y, z): (f64, f64, f64)| {
        let mut eye = Eye::looking(DVec3::new(-0.4 * x, 1.0, -0.4 * z), DVec3::new(x, y, z));
        eye.projection = Projection::Perspective { fov_y: 1.5 };
        eye
    };
    corners.into_iter().map(looking).collect()
}

/// Where the sun is.
fn suns() -> [DVec3; 6] {
    [
        DVec3::new(1.0, 2.0, 0.5),
        DVec3::new(-3.0, 1.0, 1.7),
        DVec3::new(0.0, 1.0, 0.0),
        DVec3::new(0.02, 1.0, 0.03),
        DVec3::new(1.0, 0.05, 0.4),
        DVec3::new(-1.0, 1.3, -1.2),
    ]
}

/// Floor and wall meet at an edge that a lamp in front of them lights: neither shades the other.
#[test]
fn an_inner_edge_has_no_dark_line() {
    let Some(gpu) = gpu() else { return };
    let transport = house(0.0);
    let mut scene = room::scene_of(&transport, |_| Vec3::splat(0.5));
    scene.entities.push(room::light(100, LightKind::Point, 20.0, DVec3::Y, DVec3::ZERO));
    let mut studio = Studio::new(gpu, transport, Eye::looking(DVec3::Y, DVec3::ZERO), [256, 256]);
    for (k, lamp) in
        [(0.2, 1.2, 0.1), (-1.1, 1.7, 0.6), (1.2, 0.4, -0.5), (0.0, 0.15, 0.0)].into_iter().enumerate()
    {
        let lamp = DVec3::from(lamp);
        for (n, kind) in
            [LightKind::Point, LightKind::Spot { inner: 1.0, outer: 1.3 }].into_iter().enumerate()
        {
            let at = DVec3::new(0.3, 0.0, -0.2);
            *scene.entities.last_mut().unwrap() = room::light(100, kind, 20.0, lamp, at);
            for (m, mut eye) in inside().into_iter().enumerate() {
                eye.projection = Projection::Perspective { fov_y: 0.5 };
                studio.eye = eye;
                studio.draw(&scene, View::Direct);
                let worst = darkest(&studio, &scene, kind, lamp.as_vec3());
                save(&studio, &format!("edge_{k}_{n}_{m}"));
                assert!(worst > 0.97, "lamp {lamp}, kind {n}, eye {m}: {worst}");
            }
        }
    }
}

/// The least share of what should be lit in a pixel, by casting its ray into the house.
fn darkest(studio: &Studio, scene: &Scene, kind: LightKind, lamp: Vec3) -> f32 {
    let (eye, [forward, right, up]) = studio.eye.rays(DVec3::ZERO, 1.0);
    let light = scene.entities.last().unwrap();
    let way = (light.transform.rotation * DVec3::NEG_Z).as_vec3();
    let n = studio.display.width();
    let radiance = studio.radiance();
    let mut worst = 1.0f32;
    for y in 0..n {
        for x in 0..n {
            let at = |k: u32| (k as f32 + 0.5) / n as f32 * 2.0 - 1.0;
            let ray = forward + right * at(x) - up * at(y);
            let (point, normal) = hit(eye.truncate(), ray);
            let mut wanted = room::point_irradiance(20.0, lamp, point, normal) * 0.5 / PI;
            if let LightKind::Spot { .. } = kind {
                let (scale, offset) = light.light.as_ref().unwrap().cone();
                let cone = (scale * way.dot((point - lamp).normalize()) + offset).clamp(0.0, 1.0);
                wanted *= cone * cone;
            }
            if wanted > 0.05 {
                worst = worst.min(radiance[(y * n + x) as usize].x / wanted);
            }
        }
    }
    worst
}

/// 256 lights of small range over a floor with blocks on it: the grid changes nothing but the cost.
#[test]
fn many_lights_by_the_grid_are_the_same_as_in_one_list() {
    let Some(gpu) = gpu() else { return };
    let mut scene = blocks(&room::floor(16.0, 2));
    for k in 0..256 {
        let at = DVec3::new(f64::from(k % 16) - 7.5, 0.7, f64::from(k / 16) - 7.5);
        let kind = match k % 2 {
            0 => LightKind::Point,
            _ => LightKind::Spot { inner: 0.3, outer: 0.8 },
        };
        let mut lamp = room::light(1000 + k as u64, kind, 0.3, at, at - DVec3::new(0.3, 1.0, 0.1));
        lamp.light.as_mut().unwrap().range = Some(1.6);
        scene.entities.push(lamp);
    }
    let draw = |gpu: Gpu, no_light_grid: bool| {
        let settings = Settings { samples: Some(1), no_light_grid, ..Settings::default() };
        let mut eye = Eye::looking(DVec3::new(0.0, 6.0, 9.0), DVec3::ZERO);
        eye.exposure = 2.0;
        let mut studio = Studio::with(gpu, room::floor(16.0, 2), eye, [160, 120], settings);
        add_cube(&mut studio);
        let first = studio.draw(&scene, View::Direct);
        save(&studio, &format!("many_{no_light_grid}"));
        assert!(first.shadow_draws > 256, "{}", first.shadow_draws);
        let radiance = studio.radiance();
        assert_eq!(studio.draw(&scene, View::Direct).shadow_draws, 0);
        assert!(!studio.renderer.left_out().iter().any(|line| line.starts_with("shadows of")));
        let shadows = studio.renderer.bytes().into_iter().find(|(kind, _)| *kind == "shadow maps").unwrap();
        assert!(shadows.1 <= 256 << 20, "{} bytes", shadows.1);
        (radiance, studio.renderer.mean_lights())
    };
    let (by_grid, mean) = draw(gpu, false);
    let (in_one_list, all) = draw(Gpu::headless().unwrap(), true);
    assert_eq!(all, 256.0);
    assert!(mean < 16.0, "{mean} lights a cell");
    assert!(by_grid.iter().any(|radiance| radiance.x > 0.01));
    for (a, b) in by_grid.iter().zip(&in_one_list) {
        assert!((*a - *b).abs().max_element() <= 1e-5, "{a} {b}");
    }
}

/// Cubes that move not, but could, on a floor that they shade.
fn blocks(floor: &Transport) -> Scene {
    let mut scene = room::scene_of(floor, |_| Vec3::splat(0.6));
    for k in 0..9 {
        let mut entity =
            Entity { id: EntityId(200 + k), mesh: Some(room::mesh(Shape::Cube, 0)), ..Entity::default() };
        entity.transform.translation =
            DVec3::new((k % 3) as f64 * 4.0 - 4.0, 0.5, (k / 3) as f64 * 4.0 - 4.0);
        entity.transform.scale = DVec3::splat(0.7);
        scene.entities.push(entity);
    }
    scene
}

fn add_cube(studio: &mut Studio) {
    let source = MeshSource::Shape(Shape::Cube);
    studio.assets.meshes.insert(source, engine::scene::shape::mesh(Shape::Cube).into());
}

/// A large floor has cascades. They follow the camera without a change of the light, and shadows lie where they are
/// whatever the camera does.
#[test]
fn cascades_follow_the_camera_and_shadows_stay() {
    let Some(gpu) = gpu() else { return };
    let floor = room::floor(60.0, 2);
    let mut scene = blocks(&floor);
    let from = DVec3::new(3.0, 4.0, 0.0);
    scene.entities.push(room::light(100, LightKind::Sun, PI, from, DVec3::ZERO));
    let mut studio = Studio::new(gpu, floor, Eye::looking(DVec3::Y, DVec3::ZERO), [256, 192]);
    add_cube(&mut studio);
    for step in 0..6 {
        let at = DVec3::new(1.0 + 0.37 * f64::from(step), 2.5 + 0.2 * f64::from(step), 7.0);
        studio.eye = Eye::looking(at, DVec3::new(0.1 * f64::from(step), 0.0, 0.0));
        let drawn = studio.settle(&scene, View::Direct);
        let moved = studio.draw(&scene, View::Direct);
        assert_eq!((moved.shadow_draws, moved.transport_dispatches), (0, 0), "nothing moved");
        studio.eye.position.x += 0.8;
        let moved = studio.draw(&scene, View::Direct);
        assert!(moved.shadow_draws > 0 && moved.transport_dispatches == 0, "{moved:?} {drawn:?}");
        save(&studio, &format!("cascades_{step}"));
        let wrong = shadow_errors(&studio, from.as_vec3().normalize());
        assert!(wrong < 0.012, "{wrong} of the picture");
    }
    assert!(!studio.renderer.left_out().iter().any(|line| line.contains("cascades")));
}

/// The share of the pixels of the floor that are lit and should not be, or the other way round.
fn shadow_errors(studio: &Studio, to_sun: Vec3) -> f32 {
    let [width, height] = [studio.display.width(), studio.display.height()];
    let (eye, [forward, right, up]) = studio.eye.rays(DVec3::ZERO, width as f32 / height as f32);
    let eye = eye.truncate();
    let boxes: Vec<(Vec3, Vec3)> = (0..9)
        .map(|k| Vec3::new((k % 3) as f32 * 4.0 - 4.0, 0.5, (k / 3) as f32 * 4.0 - 4.0))
        .map(|centre| (centre - 0.35, centre + 0.35))
        .collect();
    let blocked = |from: Vec3, way: Vec3| boxes.iter().any(|&(low, high)| meets(from, way, low, high));
    let (mut wrong, mut all) = (0, 0);
    for (index, radiance) in (0..).zip(studio.radiance()) {
        let at = |k: u32, n: u32| (k as f32 + 0.5) / n as f32 * 2.0 - 1.0;
        let ray = forward + right * at(index % width, width) - up * at(index / width, height);
        let point = eye - ray * (eye.y / ray.y);
        if ray.y >= 0.0 || point.abs().max_element() > 29.0 || blocked(eye, ray) {
            continue;
        }
        all += 1;
        let lit = radiance.x > 0.5 * 0.6 * to_sun.y;
        wrong += u32::from(lit == blocked(point, to_sun));
    }
    wrong as f32 / all as f32
}

fn meets(from: Vec3, way: Vec3, low: Vec3, high: Vec3) -> bool {
    let (a, b) = ((low - from) / way, (high - from) / way);
    let (near, far) = (a.min(b).max_element(), a.max(b).min_element());
    near < far && far > 0.0
}

/// A mover with holes: light comes through them and only there.
#[test]
fn a_masked_mover_casts_the_shadow_of_what_is_left() {
    let Some(gpu) = gpu() else { return };
    let mut scene = blocks(&room::floor(8.0, 2));
    scene.entities.truncate(2);
    scene.entities[1].transform.translation = DVec3::new(0.0, 1.5, 0.0);
    let mut paint = scene.materials[0].clone();
    paint.id = engine::scene::MaterialId(7);
    scene.entities[1].mesh = Some(room::mesh(Shape::Cube, 7));
    scene.materials.push(paint);
    scene.entities.push(room::light(100, LightKind::Point, 5.0, DVec3::new(0.0, 3.5, 0.0), DVec3::ZERO));
    let mut eye = Eye::looking(DVec3::new(0.0, 3.0, 3.0), DVec3::ZERO);
    eye.projection = Projection::Perspective { fov_y: 0.1 };
    let mut studio = Studio::new(gpu, room::floor(8.0, 2), eye, [16, 16]);
    add_cube(&mut studio);
    let mut seen = |kind: LightKind, alpha: Alpha, opacity: f32| {
        scene.materials[1].alpha = alpha;
        scene.materials[1].opacity = opacity;
        let at = DVec3::new(0.0, 3.5, 0.01);
        *scene.entities.last_mut().unwrap() = room::light(100, kind, 5.0, at, DVec3::ZERO);
        studio.draw(&scene, View::Direct);
        studio.radiance().iter().map(|radiance| radiance.x).sum::<f32>() / 256.0
    };
    for kind in [LightKind::Sun, LightKind::Point, LightKind::Spot { inner: 0.5, outer: 0.9 }] {
        let through = seen(kind, Alpha::Mask { cutoff: 0.5 }, 0.3);
        assert!(through > 0.05, "{through}");
        assert_eq!(seen(kind, Alpha::Mask { cutoff: 0.5 }, 0.6), 0.0);
        assert_eq!(seen(kind, Alpha::Opaque, 1.0), 0.0);
        // Both sides of the cube dim the light.
        let dimmed = seen(kind, Alpha::Blend, 0.4) / through;
        assert!((dimmed - 0.36).abs() < 0.015, "{kind:?}: {dimmed}");
    }
}

/// Each side lets 0.6 through, whatever the others do.
#[test]
fn light_through_two_blended_movers_of_one_mesh_is_the_product_of_what_they_let_through() {
    let Some(gpu) = gpu() else { return };
    let mut scene = blocks(&room::floor(8.0, 2));
    scene.entities.truncate(2);
    let mut glass = scene.materials[0].clone();
    (glass.id, glass.alpha) = (engine::scene::MaterialId(7), Alpha::Blend);
    scene.materials.push(glass);
    scene.entities[1].mesh = Some(room::mesh(Shape::Cube, 7));
    scene.entities[1].transform.translation = DVec3::new(0.0, 1.2, 0.0);
    let mut second = scene.entities[1].clone();
    second.id = engine::scene::EntityId(77);
    second.transform.translation.y = 2.4;
    scene.entities.push(second);
    scene.entities.push(room::light(100, LightKind::Sun, 5.0, DVec3::new(0.0, 3.5, 0.01), DVec3::ZERO));
    let mut eye = Eye::looking(DVec3::new(0.0, 3.0, 3.0), DVec3::ZERO);
    eye.projection = Projection::Perspective { fov_y: 0.1 };
    let mut studio = Studio::new(gpu, room::floor(8.0, 2), eye, [16, 16]);
    add_cube(&mut studio);
    let mut seen = |opacity: f32| {
        scene.materials[1].opacity = opacity;
        studio.draw(&scene, View::Direct);
        studio.radiance().iter().map(|radiance| radiance.x).sum::<f32>() / 256.0
    };
    let open = seen(0.0);
    for opacity in [0.2_f32, 0.4] {
        let (dimmed, product) = (seen(opacity) / open, (1.0 - opacity).powi(4));
        assert!((dimmed - product).abs() < 0.02, "{dimmed}, and not {product}");
    }
}

/// Where a ray leaves the house, and the wall's normal there.
fn hit(from: Vec3, ray: Vec3) -> (Vec3, Vec3) {
    let (low, high) = (Vec3::new(-1.5, 0.0, -1.0), Vec3::new(1.5, 2.0, 1.0));
    let distances = Vec3::select(ray.cmpgt(Vec3::ZERO), (high - from) / ray, (low - from) / ray);
    let axis = distances.min_position();
    let mut normal = Vec3::ZERO;
    normal[axis] = -ray[axis].signum();
    (from + ray * distances[axis], normal)
}
