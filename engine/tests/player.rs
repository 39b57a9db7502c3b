//! The player as a program: pictures, statistics, exit codes.

use std::path::Path;
use std::process::{Command, Output};

use engine::scene::file::{Project, save_project, save_scene};
use engine::scene::shape::Shape;
use engine::scene::{
    Camera, Entity, EntityId, Light, LightKind, Material, MaterialId, MeshRenderer, MeshSource, Motion,
    Scene, Transform,
};
use engine::transport::key::{BakeWith, transport_key};
use engine::transport::surface::{Blend, Surface};
use engine::transport::{Batch, NONE, Patch, Receiver, Rows, Sample, Transport, Vertex, file};
use glam::{DQuat, DVec3, Vec2, Vec3};

fn play(project: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hohlraum-play")).arg(project).args(args).output().unwrap()
}

/// Says so and gives false where the machine has no GPU adapter at all.
fn can_draw() -> bool {
    let can = !matches!(engine::gpu::Gpu::headless(), Err(engine::gpu::GpuError::NoAdapter));
    if !can {
        println!("not run: no GPU adapter");
    }
    can
}

/// A floor of 4 x 4 m as one patch that nothing else is near.
fn floor() -> Transport {
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

fn entity(id: u64, name: &str) -> Entity {
    Entity { id: EntityId(id), name: name.to_owned(), ..Entity::default() }
}

fn mesh(shape: Shape) -> Option<MeshRenderer> {
    Some(MeshRenderer {
        mesh: MeshSource::Shape(shape),
        materials: vec![MaterialId(0)],
        casts_shadows: true,
        density: Default::default(),
        reflection: Default::default(),
    })
}

/// A floor, a lamp, a cube that turns.
fn scene() -> Scene {
    let spin = Motion::Spin { axis: DVec3::Y, radians_per_second: 3.0 };
    let lamp = Light { kind: LightKind::Point, intensity: 10.0, ..Light::default() };
    Scene {
        materials: vec![Material { albedo: grey(), ..Material::default() }],
        entities: vec![
            Entity { is_static: true, mesh: mesh(Shape::Plane), ..entity(1, "floor") },
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

fn grey() -> engine::scene::Albedo {
    engine::scene::Albedo { color: Vec3::splat(0.5), ..Default::default() }
}

fn project(scene: &Scene, bake: Option<&Transport>) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    save_project(folder.path(), &Project::default()).unwrap();
    save_scene(folder.path(), "main", scene).unwrap();
    if let Some(transport) = bake {
        let with = BakeWith { quality: Default::default(), rays: 1, length: 1.0 };
        let mut transport = transport.clone();
        transport.certificate.rays_per_row = with.rays;
        transport.certificate.base_length = with.length;
        transport.certificate.key = transport_key(folder.path(), scene, &with);
        file::save(&file::path(folder.path(), "main"), &transport).unwrap();
    }
    folder
}

fn error_of(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn a_bake_of_another_geometry_is_refused_with_the_remedy() {
    if !can_draw() {
        return;
    }
    let mut scene = scene();
    let folder = project(&scene, Some(&floor()));
    scene.entities[0].transform.translation.x += 1.0;
    save_scene(folder.path(), "main", &scene).unwrap();
    let output = play(folder.path(), &["--headless"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(error_of(&output).contains("stale") && error_of(&output).contains("hohlraum-bake"));
}

#[test]
fn the_same_scene_gives_the_same_pictures_and_motion_gives_others() {
    if !can_draw() {
        return;
    }
    let folder = project(&scene(), Some(&floor()));
    let draw = |out: &str| {
        let out = folder.path().join(out);
        let stats = out.with_extension("json");
        let args = ["--headless", "--frames", "5", "--size", "96x64", "--every", "2", "--fixed-dt", "0.1"];
        let places = ["--out", out.to_str().unwrap(), "--stats", stats.to_str().unwrap()];
        let output = play(folder.path(), &[&args[..], &places[..]].concat());
        assert!(output.status.success(), "{}", error_of(&output));
        let names: Vec<String> = ["00000", "00002", "00004"].map(|n| format!("frame_{n}.png")).to_vec();
        let pictures: Vec<Vec<u8>> = names.iter().map(|n| std::fs::read(out.join(n)).unwrap()).collect();
        assert_eq!(std::fs::read_dir(&out).unwrap().count(), 3);
        (pictures, std::fs::read_to_string(stats).unwrap())
    };
    let (once, stats) = draw("once");
    let (again, _) = draw("again");
    assert_eq!(once, again);
    assert_ne!(once[0], once[1]);

    let stats: serde_json::Value = serde_json::from_str(&stats).unwrap();
    assert_eq!(stats["frames"], 5);
    assert_eq!(stats["patches"], 1);
    assert_eq!(stats["dispatches"].as_array().unwrap().len(), 5);
    assert!(stats["passes"]["surface"]["median_ms"].as_f64().unwrap() > 0.0);
    assert!(stats["bytes"]["shadow maps"].as_u64().unwrap() > 0);
    let lit = image::load_from_memory(&once[0]).unwrap().to_rgb8();
    assert!(lit.pixels().any(|pixel| pixel.0[0] > 60), "the floor is lit");
}

#[test]
fn what_stands_still_costs_no_transport_after_it_is_solved() {
    if !can_draw() {
        return;
    }
    let mut still = scene();
    still.entities[2].motion = None;
    let folder = project(&still, Some(&floor()));
    let stats = folder.path().join("stats.json");
    let args = ["--headless", "--frames", "4", "--size", "32x32", "--stats", stats.to_str().unwrap()];
    assert!(play(folder.path(), &args).status.success());
    let stats: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(stats).unwrap()).unwrap();
    assert_eq!(stats["dispatches"][3], 0, "{stats:#}");
    assert_eq!(stats["shadow_draws"][3], 0);
}

#[test]
fn scenes_without_light_camera_or_geometry_are_played() {
    if !can_draw() {
        return;
    }
    let mut dark = scene();
    dark.entities.retain(|entity| entity.light.is_none() && entity.camera.is_none());
    for (scene, bake) in [(Scene::default(), None), (dark, Some(floor()))] {
        let folder = project(&scene, bake.as_ref());
        let output = play(folder.path(), &["--headless", "--frames", "2", "--size", "32x32"]);
        assert!(output.status.success(), "{}", error_of(&output));
    }
}

#[test]
fn a_scene_without_a_bake_is_refused_with_the_remedy() {
    let folder = project(&scene(), None);
    let output = play(folder.path(), &["--headless"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(error_of(&output).contains("run `hohlraum-bake"), "{}", error_of(&output));
}

#[test]
fn wrong_usage_is_2_and_says_what_is_right() {
    let nowhere = Path::new("nowhere");
    let wrong: [(&[&str], &str); 6] = [
        (&["--view", "wonderful"], "composite, direct"),
        (&["--size", "0x10"], "1280x720"),
        (&["--frames", "0"], "frames"),
        (&["--every", "0"], "every"),
        (&["--fixed-dt", "-1"], "0 or more"),
        (&["--wings"], "--wings"),
    ];
    for (args, said) in wrong {
        let output = play(nowhere, args);
        assert_eq!(output.status.code(), Some(2), "{args:?}");
        assert!(error_of(&output).contains(said), "{args:?}: {}", error_of(&output));
    }
    let output = play(nowhere, &["--headless"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(error_of(&output).contains("nowhere"));
}
