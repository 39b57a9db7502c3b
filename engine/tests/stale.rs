//! What the player makes of a bake that is missing, old, damaged, or of another scene.

mod program;

use engine::scene::file::save_scene;
use engine::scene::shape::Shape;
use engine::scene::{Albedo, Entity, Material, MaterialId, Scene, Transform};
use engine::transport::{Batch, Transport, file};
use glam::{DVec3, Vec3};
use program::*;

const RED: MaterialId = MaterialId(1);

/// The floor, and a red box beside its middle; looked at from above.
fn floor_and_box(x: f64) -> Scene {
    let mut scene = scene();
    let albedo = Albedo { color: Vec3::new(0.8, 0.1, 0.1), ..Albedo::default() };
    scene.materials.push(Material { id: RED, albedo, ..Material::default() });
    let mut renderer = mesh(Shape::Cube);
    renderer.as_mut().unwrap().materials = vec![RED];
    let transform = Transform { scale: DVec3::splat(0.6), ..Transform::at(DVec3::new(x, 0.3, 0.0)) };
    scene.entities[2] = Entity { is_static: true, mesh: renderer, transform, ..entity(3, "box") };
    scene.entities[3] = from_above();
    scene
}

/// Of [`floor_and_box`] with the box at -1 m: of the box, a sheet in the place of its lid.
fn bake() -> Transport {
    let mut bake = floor();
    let surface = &mut bake.surface;
    for corner in 0..4 {
        let mut vertex = surface.vertices[corner];
        vertex.position = vertex.position * 0.15 + Vec3::new(-1.0, 0.6, 0.0);
        surface.vertices.push(vertex);
        surface.blends.push(surface.blends[corner]);
    }
    surface.triangles.extend([[4, 5, 6], [4, 6, 7]]);
    surface.patches.extend([[1, engine::transport::NONE]; 2]);
    surface.batches.push(Batch { entity: [3, 0], material: RED.0, first: 2, count: 2, ..Batch::default() });
    bake.patches.push(engine::transport::Patch {
        area: 0.36,
        batch: 1,
        first_triangle: 2,
        first_sample: 1,
        ..bake.patches[0]
    });
    bake.samples.push(engine::transport::Sample {
        patch: 1,
        position: Vec3::new(-1.0, 0.6, 0.0),
        ..bake.samples[0]
    });
    bake.patch_from_patch.starts.push(0);
    bake
}

fn is_red([r, g, _]: [u8; 3]) -> bool {
    u32::from(r) > 2 * u32::from(g) && r > 40
}

const ALBEDO: [&str; 4] = ["--view", "albedo", "--size", "84x84"];

#[test]
fn a_box_that_moved_since_the_bake_is_named_and_drawn_where_it_now_stands() {
    if !can_draw() {
        return;
    }
    let folder = project(&floor_and_box(-1.0), Some(&bake()));
    let said = plays(folder.path(), &["--size", "8x8"]);
    assert!(!said.contains("warning"), "{said}");
    let fresh = picture(folder.path(), &ALBEDO);
    assert!(is_red(over(&fresh, -1.0, 0.0)) && !is_red(over(&fresh, 1.0, 0.0)));

    save_scene(folder.path(), "main", &floor_and_box(1.0)).unwrap();
    let said = plays(folder.path(), &["--size", "8x8"]);
    let told = said.lines().filter(|line| line.contains("stale")).collect::<Vec<_>>();
    assert_eq!(told.len(), 1, "{said}");
    assert!(told[0].contains("changed `box`") && told[0].contains("hohlraum-bake"), "{said}");
    assert!(!told[0].contains("floor"));
    let moved = picture(folder.path(), &ALBEDO);
    assert!(!is_red(over(&moved, -1.0, 0.0)) && is_red(over(&moved, 1.0, 0.0)));
    let lit = picture(folder.path(), &["--size", "84x84", "--exposure", "1"]);
    assert!(is_red(over(&lit, 1.0, 0.0)), "direct light is on it: {:?}", over(&lit, 1.0, 0.0));
    let stats = statistics(folder.path(), &["--size", "8x8"]);
    assert!(stats["left_out"].to_string().contains("box"), "{stats:#}");
}

#[test]
fn what_is_new_is_drawn_and_what_is_gone_is_not() {
    if !can_draw() {
        return;
    }
    let mut without = floor_and_box(-1.0);
    let there = without.entities.remove(2);
    let folder = project(&floor_and_box(-1.0), Some(&bake()));
    save_scene(folder.path(), "main", &without).unwrap();
    let said = plays(folder.path(), &["--size", "8x8"]);
    assert!(said.contains("gone `box`"), "{said}");
    assert!(!is_red(over(&picture(folder.path(), &ALBEDO), -1.0, 0.0)));

    let mut more = floor_and_box(-1.0);
    let transform = Transform { translation: DVec3::new(1.0, 0.3, 1.0), ..there.transform };
    more.entities.push(Entity {
        id: engine::scene::EntityId(9),
        name: "crate".to_owned(),
        transform,
        ..there
    });
    save_scene(folder.path(), "main", &more).unwrap();
    assert!(plays(folder.path(), &["--size", "8x8"]).contains("new `crate`"));
    let shown = picture(folder.path(), &ALBEDO);
    assert!(is_red(over(&shown, 1.0, 1.0)) && is_red(over(&shown, -1.0, 0.0)));
}

#[test]
fn without_a_bake_direct_light_is_shown_and_the_remedy_is_said_in_one_line() {
    if !can_draw() {
        return;
    }
    let folder = project(&floor_and_box(0.5), None);
    let said = plays(folder.path(), &["--size", "8x8"]);
    let told: Vec<&str> = said.lines().filter(|line| line.contains("no bake")).collect();
    assert_eq!(told.len(), 1, "{said}");
    assert!(told[0].contains("run `hohlraum-bake") && told[0].contains("--scene main"), "{said}");
    let lit = picture(folder.path(), &["--size", "84x84", "--exposure", "1"]);
    assert!(is_red(over(&lit, 0.5, 0.0)), "{:?}", over(&lit, 0.5, 0.0));
    let floor = over(&lit, 1.2, 1.2);
    assert!(floor[0] > 60 && floor[0] == floor[1], "{floor:?}");
    let dark = picture(folder.path(), &["--size", "84x84", "--view", "indirect"]);
    assert!(dark.pixels().all(|pixel| pixel.0 == [0; 3]));
}

#[test]
fn a_bake_from_before_it_said_what_it_was_made_of_counts_as_stale() {
    if !can_draw() {
        return;
    }
    let folder = project(&floor_and_box(-1.0), Some(&bake()));
    let path = file::path(folder.path(), "main");
    let mut old = file::load(&path).unwrap();
    old.certificate.inputs.clear();
    file::save(&path, &old).unwrap();
    let said = plays(folder.path(), &["--size", "8x8"]);
    assert!(said.contains("all of it is stale"), "{said}");
    assert!(is_red(over(&picture(folder.path(), &ALBEDO), -1.0, 0.0)));
}

#[test]
fn a_damaged_bake_is_refused_with_its_path() {
    if !can_draw() {
        return;
    }
    let folder = project(&floor_and_box(-1.0), Some(&bake()));
    let path = file::path(folder.path(), "main");
    let sound = std::fs::read(&path).unwrap();
    let mut flipped = sound.clone();
    flipped[sound.len() / 2] ^= 1;
    for damaged in [&flipped[..], &sound[..sound.len() - 40], &sound[..10], b""] {
        std::fs::write(&path, damaged).unwrap();
        let output = play(folder.path(), &["--headless", "--size", "8x8"]);
        assert_eq!(output.status.code(), Some(1));
        assert!(error_of(&output).contains("light.hohlraum"), "{}", error_of(&output));
    }
}

#[test]
fn a_bake_whose_certificate_does_not_hold_is_played_by_force_alone() {
    if !can_draw() {
        return;
    }
    let folder = project(&floor_and_box(-1.0), Some(&bake()));
    let path = file::path(folder.path(), "main");
    let mut broken = file::load(&path).unwrap();
    broken.certificate.asymmetry = 0.03;
    file::save(&path, &broken).unwrap();
    let output = play(folder.path(), &["--headless", "--size", "8x8"]);
    assert_eq!(output.status.code(), Some(1));
    let error = error_of(&output);
    assert!(error.contains("reciprocity is missed by 3.0e-2 (limit 1.0e-4)"), "{error}");
    assert!(error.contains("--force"), "{error}");
    let said = plays(folder.path(), &["--size", "8x8", "--force"]);
    assert!(said.contains("reciprocity is missed by"), "{said}");
}
