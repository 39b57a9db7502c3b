//! Scenes whose light is known in closed form: rooms, spheres, wells and bare floors, each wall with an albedo and
//! an exitance of its own.

use std::f32::consts::{PI, TAU};

use engine::scene::file::{load_project, save_project};
use engine::scene::{Scene, SkyKind};
use glam::Vec3;

use crate::project::TestProject;
use crate::room::walls;
use crate::surfaces::{self, Faces, face, quad, turned};

/// A surface, and so a static entity with a material of its own.
#[derive(Clone, Debug)]
pub struct Wall {
    pub name: &'static str,
    pub faces: Faces,
    pub albedo: Vec3,
    /// M, emitted [W/m2].
    pub exitance: Vec3,
}

impl Wall {
    /// Grey, and dark.
    pub fn new(name: &'static str, faces: Faces) -> Self {
        Self { name, faces, albedo: Vec3::splat(0.5), exitance: Vec3::ZERO }
    }
}

/// Entities have ids from 1 in this order, materials from 0.
pub fn project(walls: &[Wall]) -> TestProject {
    let surfaces: Vec<(&str, Faces)> = walls.iter().map(|wall| (wall.name, wall.faces.clone())).collect();
    let project = surfaces::project(&surfaces);
    change(&project, |scene| {
        for (wall, material) in walls.iter().zip(&mut scene.materials) {
            material.albedo.color = wall.albedo;
            material.emission.color = wall.exitance / PI;
        }
    });
    project
}

pub fn change(project: &TestProject, change: impl FnOnce(&mut Scene)) {
    let mut scene = project.scene();
    change(&mut scene);
    project.save(&scene);
}

/// Closed rooms keep the albedo that they were given, however long light bounces in them.
pub fn lift_the_gain_limit(project: &TestProject) {
    let mut settings = load_project(project.path()).expect("project.ron");
    settings.bake.unlimited_gain = true;
    save_project(project.path(), &settings).expect("project.ron");
}

/// Every wall the same.
pub fn paint(scene: &mut Scene, albedo: f32, exitance: f32) {
    for material in &mut scene.materials {
        material.albedo.color = Vec3::splat(albedo);
        material.emission.color = Vec3::splat(exitance / PI);
    }
}

/// The same radiance from everywhere.
pub fn under_a_sky(scene: &mut Scene, radiance: f32) {
    scene.sky.kind = SkyKind::Constant { radiance: Vec3::splat(radiance) };
}

/// The inside of a box, closed.
pub fn room(low: Vec3, high: Vec3) -> Vec<Wall> {
    let names = ["-x", "+x", "floor", "ceiling", "-z", "+z"];
    names.into_iter().zip(&walls(low, high)).map(|(name, wall)| Wall::new(name, face(wall))).collect()
}

pub fn cube() -> Vec<Wall> {
    room(Vec3::ZERO, Vec3::ONE)
}

/// The outside of a box.
pub fn block(name: &'static str, low: Vec3, high: Vec3) -> Wall {
    Wall::new(name, walls(low, high).iter().flat_map(|wall| turned(face(wall))).collect())
}

/// A room with two blocks that touch nothing: no surface is covered, no light is lost.
pub fn furnished() -> Vec<Wall> {
    let mut walls = room(Vec3::ZERO, Vec3::ONE);
    walls.push(block("tall", Vec3::new(0.15, 0.05, 0.2), Vec3::new(0.4, 0.7, 0.45)));
    walls.push(block("low", Vec3::new(0.55, 0.1, 0.5), Vec3::new(0.85, 0.35, 0.8)));
    walls
}

/// 20:1:1.
pub fn corridor() -> Vec<Wall> {
    room(Vec3::ZERO, Vec3::new(20.0, 1.0, 1.0))
}

/// Two rooms that a slab parts, but for a slit above and one below.
pub fn rooms_joined_by_slits() -> Vec<Wall> {
    let mut walls = room(Vec3::ZERO, Vec3::new(4.0, 2.0, 2.0));
    walls.push(block("slab", Vec3::new(1.9, 0.1, 0.05), Vec3::new(2.1, 1.9, 1.95)));
    walls
}

/// Two rooms parted at x = 2 by a wall without thickness: the faces of either room in the same place.
pub fn rooms_apart() -> Vec<Wall> {
    let mut walls = room(Vec3::ZERO, Vec3::new(4.0, 2.0, 2.0));
    let towards_b = quad(Vec3::X * 2.0, Vec3::Y * 2.0, Vec3::Z * 2.0);
    walls.push(Wall::new("towards a", turned(towards_b.clone())));
    walls.push(Wall::new("towards b", towards_b));
    walls
}

/// A room of this depth without a ceiling.
pub fn well(depth: f32) -> Vec<Wall> {
    let mut walls = room(Vec3::ZERO, Vec3::new(1.0, depth, 1.0));
    walls.remove(3);
    walls
}

/// The upper half of a ball's inside, looking down.
pub fn dome(around: usize, down: usize) -> Vec<Wall> {
    let above = |face: &Vec<Vec3>| face.iter().map(|p| p.y).sum::<f32>() > 0.0;
    vec![Wall::new("dome", ball_inside(1.0, around, down).into_iter().filter(above).collect())]
}

/// The inside of a ball in three parts of a third each.
pub fn sphere(around: usize, down: usize) -> Vec<Wall> {
    let faces = ball_inside(1.0, around, down);
    let third = faces.len() / 3;
    let parts = ["first", "second", "third"].into_iter().zip(faces.chunks(third));
    parts.map(|(name, faces)| Wall::new(name, faces.to_vec())).collect()
}

/// Flat trapezoids that look at the middle, meridian after meridian; `around` is a multiple of 3.
pub fn ball_inside(radius: f32, around: usize, down: usize) -> Faces {
    let at = |i: usize, j: usize| {
        let (sin, cos) = (TAU * (i % around) as f32 / around as f32).sin_cos();
        let (ring, height) = (TAU * 0.5 * j as f32 / down as f32).sin_cos();
        let ring = if j == 0 || j == down { 0.0 } else { ring };
        Vec3::new(ring * cos, height, ring * sin) * radius
    };
    let trapezoid = |i: usize, j: usize| {
        let mut face = vec![at(i, j + 1), at(i + 1, j + 1), at(i + 1, j), at(i, j)];
        face.dedup();
        if face.first() == face.last() {
            face.pop();
        }
        face
    };
    (0..around).flat_map(|i| (0..down).map(move |j| (i, j))).map(|(i, j)| trapezoid(i, j)).collect()
}
