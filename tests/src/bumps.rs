//! Normal maps made by the tests that need them, and a room whose walls can wear them.

use std::f32::consts::PI;
use std::fmt::Write;
use std::path::Path;

use engine::scene::{ImageSource, Scene, Texture};
use engine::transport::surface::Blend;
use engine::transport::{Rows, Transport};
use glam::{DVec3, Vec3};

use crate::enclosure::block;
use crate::project::TestProject;
use crate::room::{Rectangle, walls};
use crate::surfaces::from_obj;

/// Materials and entities of [`room`], which have ids from 0 and from 1 in this order.
pub const WALLS: [&str; 7] = ["left", "right", "floor", "ceiling", "behind", "front", "lamp"];
pub const FLOOR: usize = 2;
pub const BEHIND: usize = 4;
pub const LAMP: usize = 6;

/// The inside of a cube of 1 m, each wall with texture coordinates from edge to edge;
/// a lamp hangs at the right side.
pub fn room() -> TestProject {
    let mut obj = String::from("vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n");
    let mut next = 1;
    let mut add = |name: &str, faces: &[Vec<Vec3>]| {
        writeln!(obj, "o {name}\nusemtl {name}").expect("text");
        for face in faces {
            face.iter().for_each(|p| writeln!(obj, "v {} {} {}", p.x, p.y, p.z).expect("text"));
            let corners: Vec<String> = (0..4).map(|k| format!("{}/{}", next + k, k + 1)).collect();
            writeln!(obj, "f {}", corners.join(" ")).expect("text");
            next += 4;
        }
    };
    let corners =
        |wall: &Rectangle| [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(u, v)| wall.at(u, v));
    for (name, wall) in WALLS.iter().zip(walls(Vec3::ZERO, Vec3::ONE)) {
        add(name, &[corners(&wall).to_vec()]);
    }
    add(WALLS[LAMP], &block("lamp", Vec3::new(0.9, 0.4, 0.4), Vec3::new(0.94, 0.6, 0.6)).faces);
    let project = from_obj(&obj);
    let mut scene = project.scene();
    for (index, material) in scene.materials.iter_mut().enumerate() {
        material.albedo.color = Vec3::splat(0.5);
        material.emission.color = Vec3::splat(if index == LAMP { 20.0 } else { 0.0 } / PI);
    }
    project.save(&scene);
    project
}

/// Paints a square picture of normals in the frame of tangent, bitangent and normal, into the project.
pub fn paint(project: &Path, file: &str, size: u32, normal: impl Fn(f32, f32) -> Vec3) -> Texture {
    let picture = image::RgbImage::from_fn(size, size, |x, y| {
        let at = |k: u32| (k as f32 + 0.5) / size as f32;
        let color = (normal(at(x), at(y)) * 0.5 + 0.5) * 255.0;
        image::Rgb(color.to_array().map(|channel| channel.round() as u8))
    });
    picture.save(project.join(file)).expect("a picture");
    Texture::new(ImageSource { file: file.to_owned(), image: None })
}

/// What eight bits leave of a normal.
pub fn as_stored(normal: Vec3) -> Vec3 {
    (((normal * 0.5 + 0.5) * 255.0).round() / 255.0 * 2.0 - 1.0).normalize()
}

/// Round bumps side by side, up to about 45 degrees steep.
pub fn bumps(u: f32, v: f32) -> Vec3 {
    const COUNT: f32 = 6.0;
    let slope = |x: f32| 0.9 * (2.0 * PI * COUNT * x).sin();
    Vec3::new(slope(u), slope(v), 1.0).normalize()
}

/// Wears a map on one of the walls.
pub fn wear(project: &TestProject, wall: usize, map: Texture) -> Scene {
    let mut scene = project.scene();
    scene.materials[wall].normal_texture = Some(map);
    project.save(&scene);
    scene
}

/// E and V of receivers under light by column: rows times values. Each of a sum of lights is tilted by itself.
pub fn irradiance(transport: &Transport, values: &[DVec3]) -> Vec<(DVec3, [DVec3; 3])> {
    let sum = |rows: &Rows, row: usize| -> DVec3 {
        rows.row(row).map(|(column, weight)| values[column as usize] * f64::from(weight)).sum()
    };
    let of = |receiver: usize| {
        let terms = [0, 1, 2].map(|axis| sum(&transport.directional_from_patch, 3 * receiver + axis));
        (sum(&transport.receiver_from_patch, receiver), terms)
    };
    (0..transport.directional_receivers()).map(of).collect()
}

/// E and V at a point of one side of a wall, as its vertices blend them.
pub fn at(
    transport: &Transport,
    known: &[(DVec3, [DVec3; 3])],
    (wall, back): (usize, bool),
    point: Vec3,
) -> Option<(DVec3, [DVec3; 3])> {
    let surface = &transport.surface;
    let batch = surface.batches.iter().find(|batch| batch.material as usize == wall)?;
    let triangles = batch.first as usize..(batch.first + batch.count) as usize;
    let point = point - transport.origin.as_vec3();
    let weights = |triangle: usize| {
        let [a, b, c] = surface.positions(triangle);
        let cross = (b - a).cross(c - a);
        let share = |p: Vec3, q: Vec3| (p - point).cross(q - point).dot(cross) / cross.length_squared();
        [share(b, c), share(c, a), share(a, b)]
    };
    let inside = |triangle: &usize| weights(*triangle).into_iter().all(|weight| weight >= -1e-5);
    let triangle = { triangles }.find(inside)?;
    let blends = if back { &surface.back_blends } else { &surface.blends };
    let mut sum = (DVec3::ZERO, [DVec3::ZERO; 3]);
    for (vertex, share) in surface.triangles[triangle].into_iter().zip(weights(triangle)) {
        let Blend { receivers, weights } = blends[vertex as usize];
        for (receiver, weight) in receivers.into_iter().zip(weights).filter(|used| used.1 > 0.0) {
            let (e, v) = known.get(receiver as usize)?;
            let share = f64::from(weight * share);
            sum.0 += *e * share;
            sum.1.iter_mut().zip(v).for_each(|(sum, v)| *sum += *v * share);
        }
    }
    Some(sum)
}
