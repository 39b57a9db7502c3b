//! Ten scenes, each without something: what each may leave out is known by heart.
//!
//! Most are a room of 4 x 3 x 4 m with a block in it, seen by a camera in a corner, with light probes and a reflection
//! probe whether somebody reads them or not.

use engine::scene::shape::Shape;
use engine::scene::{
    Albedo, Alpha, Camera, Changes, Density, Emission, Entity, Light, LightKind, LightProbeGroup, Material,
    MaterialId, MeshRenderer, MeshSource, Motion, Reflection, ReflectionProbe, Refresh, Scene, Sky, SkyKind,
    Switching, Transform,
};
use glam::{DQuat, DVec3, Vec3};

/// A scene under construction: ids count up.
#[derive(Default)]
pub struct Builder {
    pub scene: Scene,
}

impl Builder {
    pub fn material(&mut self, name: &str, color: Vec3) -> &mut Material {
        let id = MaterialId(self.scene.materials.len() as u32);
        let albedo = Albedo { color, ..Albedo::default() };
        self.scene.materials.push(Material { id, name: name.to_owned(), albedo, ..Material::default() });
        self.scene.materials.last_mut().expect("it was just put there")
    }

    pub fn entity(&mut self, name: &str, transform: Transform) -> &mut Entity {
        let id = self.scene.free_entity_id();
        self.scene.entities.push(Entity { id, name: name.to_owned(), transform, ..Entity::default() });
        self.scene.entities.last_mut().expect("it was just put there")
    }

    pub fn mesh(&mut self, name: &str, shape: Shape, transform: Transform, material: u32) -> &mut Entity {
        let entity = self.entity(name, transform);
        entity.is_static = true;
        entity.mesh = Some(MeshRenderer {
            mesh: MeshSource::Shape(shape),
            materials: vec![MaterialId(material)],
            casts_shadows: true,
            density: Density::default(),
            reflection: Reflection::default(),
        });
        entity
    }

    /// Six planes that face the inside.
    pub fn room(&mut self, name: &str, middle: DVec3, size: DVec3, material: u32) {
        let sides = [
            ("floor", DVec3::Y),
            ("ceiling", DVec3::NEG_Y),
            ("left", DVec3::X),
            ("right", DVec3::NEG_X),
            ("back", DVec3::Z),
            ("front", DVec3::NEG_Z),
        ];
        for (side, inwards) in sides {
            let rotation = DQuat::from_rotation_arc(DVec3::Y, inwards);
            let across = (rotation.inverse() * size).abs();
            let translation = middle - inwards * (size * 0.5).dot(inwards.abs());
            let scale = DVec3::new(across.x, 1.0, across.z);
            let transform = Transform { translation, rotation, scale };
            self.mesh(&format!("{name} {side}"), Shape::Plane, transform, material);
        }
    }

    pub fn light(&mut self, name: &str, at: DVec3, changes: Changes) -> &mut Entity {
        let entity = self.entity(name, Transform { translation: at, ..Transform::default() });
        entity.light = Some(Light { kind: LightKind::Point, intensity: 3.0, changes, ..Light::default() });
        entity
    }

    fn camera(&mut self, from: DVec3, to: DVec3) {
        let forward = (to - from).normalize();
        let right = forward.cross(DVec3::Y).normalize();
        let rotation = DQuat::from_mat3(&glam::DMat3::from_cols(right, right.cross(forward), -forward));
        let entity = self.entity("camera", Transform { translation: from, rotation, ..Transform::default() });
        entity.camera = Some(Camera::default());
    }
}

fn at(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

fn placed(translation: DVec3, scale: f64) -> Transform {
    Transform { translation, scale: DVec3::splat(scale), ..Transform::default() }
}

/// A room in colours with a block, without any light.
fn room(wall: Vec3, block: Vec3) -> Builder {
    let mut built = Builder::default();
    built.material("wall", wall);
    built.material("block", block);
    built.room("room", at(0.0, 1.5, 0.0), at(4.0, 3.0, 4.0), 0);
    // Off the floor, so that light comes to all of it.
    built.mesh("block", Shape::Cube, placed(at(0.6, 0.8, -0.5), 1.0), 1);
    built.camera(at(-1.7, 1.8, 1.7), at(0.3, 0.9, -0.4));
    built.probes();
    built.reflection_probe();
    built
}

const WARM: Vec3 = Vec3::new(0.8, 0.7, 0.6);
const BLUE: Vec3 = Vec3::new(0.2, 0.3, 0.7);

/// Name and scene, in the order of README's table.
pub fn all() -> Vec<(&'static str, Scene)> {
    vec![
        ("lights that never change", never()),
        ("a lamp that moves", moving_lamp()),
        ("a ball that moves", moving_ball()),
        ("grey", grey()),
        ("a mirror", mirror()),
        ("sky alone", sky_alone()),
        ("black", black()),
        ("two rooms, one lit", two_rooms()),
        ("a normal map", normal_mapped()),
        ("everything", everything()),
    ]
}

pub fn never() -> Scene {
    let mut built = room(WARM, BLUE);
    built.light("lamp", at(-0.8, 2.2, 0.3), Changes::Never);
    built.scene
}

pub fn moving_lamp() -> Scene {
    let mut built = room(WARM, BLUE);
    let points = vec![at(-1.5, 2.2, 0.3), at(1.2, 2.4, 0.9)];
    let lamp = built.light("lamp", points[0], Changes::Anything);
    lamp.motion = Some(Motion::PingPong { points, seconds: 4.0, look: false });
    built.scene
}

pub fn moving_ball() -> Scene {
    let mut built = room(WARM, BLUE);
    built.light("lamp", at(-0.8, 2.2, 0.3), Changes::Anything);
    built.ball(at(-0.6, 0.6, 0.2));
    built.scene
}

pub fn grey() -> Scene {
    let mut built = room(Vec3::splat(0.7), Vec3::splat(0.3));
    built.scene.materials.iter_mut().for_each(|material| material.albedo.changes = Changes::Never);
    built.scene.materials.iter_mut().for_each(|material| material.emission.changes = Changes::Never);
    // Its brightness alone is free: one response, in one channel.
    built.light("lamp", at(-0.8, 2.2, 0.3), Changes::Intensity);
    built.scene
}

pub fn mirror() -> Scene {
    let mut built = room(WARM, BLUE);
    built.light("lamp", at(-0.8, 2.2, 0.3), Changes::Anything);
    let chrome = built.material("chrome", Vec3::splat(0.9));
    (chrome.metallic, chrome.roughness) = (1.0, 0.1);
    let id = chrome.id.0;
    built.mesh("mirror ball", Shape::Sphere, placed(at(-0.5, 0.6, -0.9), 1.0), id);
    built.scene
}

/// Two planes under an even sky.
pub fn sky_alone() -> Scene {
    let mut built = Builder::default();
    built.material("ground", WARM);
    built.material("block", BLUE);
    built.mesh("ground", Shape::Plane, placed(DVec3::ZERO, 6.0), 0);
    built.mesh("block", Shape::Cube, placed(at(0.6, 0.8, -0.5), 1.0), 1);
    built.camera(at(-2.0, 1.8, 2.4), at(0.3, 0.4, -0.4));
    let kind = SkyKind::Constant { radiance: Vec3::new(0.4, 0.6, 1.0) };
    built.scene.sky = Sky { kind, changes: Changes::Intensity };
    built.scene
}

/// The block is black, and so is the floor.
pub fn black() -> Scene {
    let mut built = room(WARM, Vec3::ZERO);
    built.light("lamp", at(-0.8, 2.2, 0.3), Changes::Anything);
    built.scene.entities[0].mesh.iter_mut().for_each(|mesh| mesh.materials = vec![MaterialId(1)]);
    built.scene
}

pub fn two_rooms() -> Scene {
    let mut built = room(WARM, BLUE);
    built.room("cellar", at(0.0, -3.0, 0.0), at(4.0, 3.0, 4.0), 0);
    built.light("lamp", at(-0.8, 2.2, 0.3), Changes::Anything);
    built.scene
}

/// Not one of the ten: behind the viewer a lamp wanders in a closet about a mirror whose probe is
/// captured in every frame.
pub fn hidden_mirror() -> Scene {
    let mut built = room(WARM, BLUE);
    built.light("lamp", at(-0.8, 2.2, 0.3), Changes::Anything);
    built.room("closet", at(-9.0, 1.5, 9.0), at(4.0, 3.0, 4.0), 0);
    let points = vec![at(-10.0, 2.2, 9.3), at(-8.0, 2.4, 9.9)];
    let lamp = built.light("closet lamp", points[0], Changes::Anything);
    lamp.motion = Some(Motion::PingPong { points, seconds: 4.0, look: false });
    let chrome = built.material("chrome", Vec3::splat(0.9));
    (chrome.metallic, chrome.roughness) = (0.9, 0.1);
    let chrome = chrome.id.0;
    built.mesh("mirror ball", Shape::Sphere, placed(at(-10.0, 0.8, 10.0), 1.0), chrome);
    let probe = ReflectionProbe {
        resolution: 16,
        refresh: Refresh::EveryFrame,
        half_size: Vec3::new(2.0, 1.5, 2.0),
        ..ReflectionProbe::default()
    };
    built.entity("closet reflections", placed(at(-9.0, 1.5, 9.0), 1.0)).reflection_probe = Some(probe);
    built.scene
}

/// The wall behind the block has bumps: `bumps.png` of the project, see [`bumps`].
pub fn normal_mapped() -> Scene {
    let mut built = room(WARM, BLUE);
    built.light("lamp", at(-0.8, 2.2, 0.3), Changes::Anything);
    let bumpy = built.material("bumpy", WARM);
    bumpy.normal_texture = Some(engine::scene::Texture::new(bumps_source()));
    let id = bumpy.id;
    built.scene.entities[4].mesh.iter_mut().for_each(|mesh| mesh.materials = vec![id]);
    built.scene
}

/// Whatever a scene can have, free to change.
pub fn everything() -> Scene {
    let mut built = room(WARM, BLUE);
    let lamp = built.light("lamp", at(-0.8, 2.2, 0.3), Changes::Anything);
    let switching = Some(Switching { period: 3.0, on_share: 0.5, offset: 0.0 });
    lamp.light.iter_mut().for_each(|light| light.switching = switching);
    let chrome = built.material("chrome", Vec3::splat(0.9));
    // Not quite black to diffuse light.
    (chrome.metallic, chrome.roughness) = (0.9, 0.1);
    let chrome = chrome.id.0;
    built.mesh("mirror ball", Shape::Sphere, placed(at(-0.5, 0.6, -0.9), 1.0), chrome);
    let bumpy = built.material("bumpy", WARM);
    bumpy.normal_texture = Some(engine::scene::Texture::new(bumps_source()));
    let bumpy = bumpy.id;
    built.scene.entities[4].mesh.iter_mut().for_each(|mesh| mesh.materials = vec![bumpy]);
    let glass = built.material("screen", Vec3::new(0.2, 0.6, 0.3));
    (glass.alpha, glass.opacity) = (Alpha::Blend, 0.5);
    let glass = glass.id.0;
    built.mesh("screen", Shape::Quad, placed(at(-0.9, 0.6, 0.6), 0.8), glass);
    let glowing = built.material("glowing", Vec3::splat(0.5));
    glowing.emission = Emission { color: Vec3::new(1.0, 0.5, 0.2), strength: 2.0, ..Emission::default() };
    let glowing = glowing.id.0;
    built.mesh("glow", Shape::Cube, placed(at(1.5, 0.3, 1.4), 0.3), glowing);
    // Out through the ceiling's place.
    built.scene.entities.retain(|entity| entity.name != "room ceiling");
    built.scene.sky = Sky {
        kind: SkyKind::Gradient {
            zenith: Vec3::new(0.2, 0.4, 0.9),
            horizon: Vec3::new(0.7, 0.8, 1.0),
            ground: Vec3::splat(0.2),
            sun: None,
            sun_diameter: 0.0093,
        },
        changes: Changes::Anything,
    };
    built.ball(at(-0.6, 1.6, 0.2));
    built.scene
}

impl Builder {
    /// Goes to and fro.
    fn ball(&mut self, from: DVec3) {
        let material = self.material("ball", Vec3::new(0.7, 0.2, 0.2)).id.0;
        let ball = self.mesh("ball", Shape::Sphere, placed(from, 0.4), material);
        ball.is_static = false;
        let points = vec![from, from + at(0.8, 0.3, 0.6)];
        ball.motion = Some(Motion::PingPong { points, seconds: 4.0, look: false });
    }

    fn probes(&mut self) {
        let corner = |k: u32| {
            let side = |bit: u32| if k >> bit & 1 == 1 { 1.0 } else { -1.0 };
            Vec3::new(1.7 * side(0), side(1), 1.7 * side(2))
        };
        let positions = (0..8).map(corner);
        let group = LightProbeGroup { positions: positions.collect() };
        self.entity("probes", placed(at(0.0, 1.5, 0.0), 1.0)).light_probes = Some(group);
    }

    fn reflection_probe(&mut self) {
        let probe = ReflectionProbe {
            resolution: 32,
            half_size: Vec3::new(2.0, 1.5, 2.0),
            ..ReflectionProbe::default()
        };
        self.entity("reflections", placed(at(-0.5, 1.6, 0.5), 1.0)).reflection_probe = Some(probe);
    }
}

fn bumps_source() -> engine::scene::ImageSource {
    engine::scene::ImageSource { file: BUMPS.to_owned(), image: None }
}

/// Relative to the project.
pub const BUMPS: &str = "assets/bumps.png";

/// Waves of 30 degrees along both sides.
pub fn bumps() -> image::RgbImage {
    image::RgbImage::from_fn(64, 64, |x, y| {
        let slope = |at: u32| 0.5 * (at as f32 / 64.0 * 4.0 * std::f32::consts::TAU).sin();
        let normal = Vec3::new(slope(x), slope(y), 1.0).normalize() * 0.5 + 0.5;
        image::Rgb([normal.x, normal.y, normal.z].map(|c| (c * 255.0).round() as u8))
    })
}
