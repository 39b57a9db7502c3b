//! Projects for the player, and the player itself; each test program uses some of it.
#![allow(dead_code)]

use std::path::Path;
use std::process::{Command, Output};
use std::sync::OnceLock;

use engine::scene::file::{Project, save_project, save_scene};
use engine::scene::import::load_assets;
use engine::scene::shape::Shape;
use engine::scene::{
    Camera, Entity, EntityId, Light, LightKind, Material, MaterialId, MeshRenderer, MeshSource, Motion,
    Projection, Scene, Transform,
};
use engine::transport::key::{BakeWith, inputs, transport_key};
use engine::transport::surface::{Blend, Surface};
use engine::transport::{Batch, NONE, Patch, Receiver, Rows, Sample, Transport, Vertex, file};
use glam::{DQuat, DVec3, Vec2, Vec3};

pub fn play(project: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hohlraum-play")).arg(project).args(args).output().unwrap()
}

/// Says so and gives false where the machine has no GPU adapter at all.
pub fn can_draw() -> bool {
    static CAN: OnceLock<bool> = OnceLock::new();
    let can =
        *CAN.get_or_init(|| !matches!(engine::gpu::Gpu::headless(), Err(engine::gpu::GpuError::NoAdapter)));
    if !can {
        println!("not run: no GPU adapter");
    }
    can
}

/// A floor of 4 x 4 m as one patch that nothing else is near.
pub fn floor() -> Transport {
    let corner = |x: f32, z: f32| Vec3::new(x, 0.0, z);
    let positions = [corner(-2.0, -2.0), corner(-2.0, 2.0), corner(2.0, 2.0), corner(2.0, -2.0)];
    let normal = Vec3::Y;
    let vertex =
        |position| Vertex { position, normal, tangent: [0.0; 4], uv: [Vec2::ZERO; 2], color: [1.0; 4] };
    let empty = Rows { starts: vec![0, 0], ..Rows::default() };
    Transport {
        surface: Surface {
            vertices: positions.map(vertex).to_vec(),
            blends: vec![Blend::one(0); 4],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            patches: vec![[0, NONE]; 2],
            batches: vec![Batch { entity: [1, 0], material: 0, double_sided: 0, first: 0, count: 2 }],
            ..Surface::default()
        },
        patches: vec![Patch { area: 16.0, normal, triangle_count: 2, sample_count: 1, ..Patch::default() }],
        samples: vec![Sample { normal, ..Sample::default() }],
        receivers: vec![Receiver { normal, valid: 1.0, ..Receiver::default() }],
        patch_from_patch: empty.clone(),
        receiver_from_patch: empty,
        ..Transport::default()
    }
}

pub fn entity(id: u64, name: &str) -> Entity {
    Entity { id: EntityId(id), name: name.to_owned(), ..Entity::default() }
}

pub fn mesh(shape: Shape) -> Option<MeshRenderer> {
    Some(MeshRenderer {
        mesh: MeshSource::Shape(shape),
        materials: vec![MaterialId(0)],
        casts_shadows: true,
        density: Default::default(),
        reflection: Default::default(),
    })
}

/// A floor, a lamp, a cube that turns.
pub fn scene() -> Scene {
    let spin = Motion::Spin { axis: DVec3::Y, radians_per_second: 3.0 };
    let wide = Transform { scale: DVec3::splat(4.0), ..Transform::default() };
    let lamp = Light { kind: LightKind::Point, intensity: 10.0, ..Light::default() };
    Scene {
        materials: vec![Material { albedo: grey(), ..Material::default() }],
        entities: vec![
            Entity { is_static: true, mesh: mesh(Shape::Plane), transform: wide, ..entity(1, "floor") },
            Entity {
                light: Some(lamp),
                transform: Transform::at(DVec3::new(1.0, 2.0, 1.0)),
                ..entity(2, "lamp")
            },
            Entity {
                mesh: mesh(Shape::Cube),
                transform: Transform::at(DVec3::Y * 0.8),
                motion: Some(spin),
                ..entity(3, "cube")
            },
            Entity {
                camera: Some(Camera::default()),
                transform: Transform {
                    translation: DVec3::new(0.0, 3.0, 5.0),
                    rotation: DQuat::from_rotation_x(-0.5),
                    ..Transform::default()
                },
                ..entity(4, "camera")
            },
        ],
        ..Scene::default()
    }
}

pub fn grey() -> engine::scene::Albedo {
    engine::scene::Albedo { color: Vec3::splat(0.5), ..Default::default() }
}

pub fn project(scene: &Scene, bake: Option<&Transport>) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    save_project(folder.path(), &Project::default()).unwrap();
    save_scene(folder.path(), "main", scene).unwrap();
    if let Some(transport) = bake {
        let with = BakeWith { quality: Default::default(), rays: 1, length: 1.0 };
        let mut transport = transport.clone();
        transport.certificate.rays_per_row = with.rays;
        transport.certificate.base_length = with.length;
        let (assets, _) = load_assets(folder.path(), scene).unwrap();
        transport.certificate.inputs = inputs(scene, &assets, &with, &Project::default().features);
        transport.certificate.key = transport_key(&transport.certificate.inputs);
        file::save(&file::path(folder.path(), "main"), &transport).unwrap();
    }
    folder
}

pub fn error_of(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Plays without a window and expects it to go well. Gives what it said.
pub fn plays(project: &Path, args: &[&str]) -> String {
    let output = play(project, &[&["--headless"], args].concat());
    assert!(output.status.success(), "{}", error_of(&output));
    error_of(&output)
}

/// The statistics of a run.
pub fn statistics(project: &Path, args: &[&str]) -> serde_json::Value {
    let file = project.join("stats.json");
    plays(project, &[args, &["--stats", file.to_str().unwrap()]].concat());
    serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap()
}

/// The last picture of a run.
pub fn picture(project: &Path, args: &[&str]) -> image::RgbImage {
    let out = project.join("out");
    plays(project, &[args, &["--every", "1000", "--out", out.to_str().unwrap()]].concat());
    let pictures = std::fs::read_dir(&out).unwrap().map(|entry| entry.unwrap().path());
    image::open(pictures.max().unwrap()).unwrap().to_rgb8()
}

/// Straight down on the floor: 4.2 m from edge to edge.
pub fn from_above() -> Entity {
    let camera = Camera { projection: Projection::Orthographic { half_height: 2.1 }, ..Camera::default() };
    let rotation = DQuat::from_rotation_x(-std::f64::consts::FRAC_PI_2);
    let transform = Transform { translation: DVec3::Y * 5.0, rotation, ..Transform::default() };
    Entity { camera: Some(camera), transform, ..entity(4, "camera") }
}

/// The pixel over a point of the floor, in a picture of [`from_above`].
pub fn over(picture: &image::RgbImage, x: f64, z: f64) -> [u8; 3] {
    let at = |metres: f64, side: u32| ((metres / 4.2 + 0.5) * f64::from(side)) as u32;
    picture.get_pixel(at(x, picture.width()), at(z, picture.height())).0
}
