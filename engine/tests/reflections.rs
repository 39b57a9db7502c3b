//! Reflection probes as the player has them: baked ones on disk, and ones that stand inside a solid.

mod program;

use std::path::Path;

use engine::scene::{Entity, ReflectionProbe, Refresh, Scene, Transform};
use glam::{DVec3, Vec3};
use program::*;

/// The floor mirrors, and a probe that is baked stands over it.
fn mirroring(at: DVec3) -> Scene {
    let mut scene = scene();
    scene.materials[0].roughness = 0.1;
    scene.entities[2].motion = None;
    let half_size = Vec3::splat(3.0);
    let probe = ReflectionProbe { refresh: Refresh::Baked, resolution: 16, half_size, ..Default::default() };
    scene.entities.push(Entity {
        reflection_probe: Some(probe),
        transform: Transform::at(at),
        ..entity(7, "mirror ball")
    });
    scene
}

/// Faces captured while it plays, and the last picture.
fn played(project: &Path) -> (u64, image::RgbImage) {
    let args = ["--frames", "6", "--size", "48x32", "--fixed-dt", "0.1"];
    let stats = statistics(project, &args);
    let faces = stats["captures"].as_array().unwrap().iter().map(|faces| faces.as_u64().unwrap()).sum();
    (faces, picture(project, &args))
}

#[test]
fn a_baked_probe_is_captured_once_and_kept_on_disk() {
    if !can_draw() {
        return;
    }
    let mut scene = mirroring(DVec3::Y * 1.5);
    let folder = project(&scene, Some(&floor()));
    let file = folder.path().join("baked/main/reflections/7.exr");
    assert!(!file.exists());
    let (faces, first) = played(folder.path());
    assert_eq!(faces, 0, "it is captured before anything is played");
    let kept = std::fs::read(&file).expect("the cubemap");
    assert_eq!(played(folder.path()), (0, first), "the same pictures whether it was there or not");
    assert_eq!(std::fs::read(&file).unwrap(), kept);
    // A broken one, and one of another scene, are taken anew.
    std::fs::write(&file, &kept[..kept.len() / 2]).unwrap();
    played(folder.path());
    assert_eq!(std::fs::read(&file).unwrap(), kept);
    scene.materials[0].albedo.color = Vec3::new(0.9, 0.1, 0.1);
    engine::scene::file::save_scene(folder.path(), "main", &scene).unwrap();
    played(folder.path());
    assert_ne!(std::fs::read(&file).unwrap(), kept);
}

#[test]
fn a_probe_inside_a_solid_is_named_and_shows_nothing() {
    if !can_draw() {
        return;
    }
    // A probe that looks at the floor from below sees backs.
    let below = project(&mirroring(DVec3::new(0.0, -0.01, 0.0)), Some(&floor()));
    let said = plays(below.path(), &["--frames", "2", "--size", "16x16"]);
    let named = said.contains("reflection probe `mirror ball` shows nothing") && said.contains("move it");
    assert!(named, "{said}");
    let above = project(&mirroring(DVec3::Y), Some(&floor()));
    let said = plays(above.path(), &["--frames", "2", "--size", "16x16"]);
    assert!(!said.contains("mirror ball"), "{said}");
}

#[test]
fn with_nothing_moving_there_are_no_dispatches_and_no_captures() {
    if !can_draw() {
        return;
    }
    let mut scene = mirroring(DVec3::Y * 1.5);
    for refresh in [Refresh::OnChange, Refresh::EveryFrame] {
        let probe = scene.entities.last_mut().unwrap().reflection_probe.as_mut().unwrap();
        probe.refresh = refresh;
        let folder = project(&scene, Some(&floor()));
        let stats = statistics(folder.path(), &["--frames", "16", "--size", "48x32", "--fixed-dt", "0.1"]);
        let counts = |name: &str| -> Vec<u64> {
            stats[name].as_array().unwrap().iter().map(|count| count.as_u64().unwrap()).collect()
        };
        assert_eq!(counts("captures")[0], 6, "{refresh:?}");
        assert_eq!((&counts("captures")[8..], &counts("dispatches")[8..]), (&[0; 8][..], &[0; 8][..]));
    }
}
