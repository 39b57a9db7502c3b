//! The way of everybody's first hour, in one piece, with mouse and keyboard.

use std::path::Path;

use crate::models::{glb, two_triangles};
use crate::window::{Window, cornell, open_project};
use egui::{Key, Modifiers, Vec2};
use egui_kittest::kittest::Queryable;
use engine::scene::{Entity, EntityId, MaterialId};
use glam::{DVec3, Vec3};

const SIZE: Vec2 = Vec2::new(1280.0, 720.0);

#[test]
fn a_scene_is_made_changed_imported_into_saved_reopened_and_played() {
    let folder = tempfile::tempdir().unwrap();
    let project = cornell(folder.path());
    let Some(mut window) = open_project(&project, None, SIZE) else { return };
    let cube = cube_that_was_moved(&mut window);
    let group = group_over(&mut window, cube);
    let cubes = twice_more(&mut window, cube, group);
    color_all(&mut window, &cubes);
    import_by_keyboard(&mut window, folder.path());
    import_by_mouse(&mut window, folder.path());
    let saved = save_and_open_again(&mut window, &project);
    play_and_stop(&mut window, &saved);
}

/// Pulled along x by its handle, taken back and done again.
fn cube_that_was_moved(window: &mut Window) -> EntityId {
    let cube = window.made(|window| window.choose("Create", "Create cube"));
    // Of a size that leaves the room to be seen.
    let (low, high) = window.editor().scenery().extent(|entity| entity.id == cube).unwrap();
    assert!((high - low).max_element() < 0.3, "{}", high - low);
    window.press(Modifiers::NONE, Key::F);
    let created = window.entity(cube).transform;
    let reach = window.lens().metres_per_point(window.stand().origin) * 60.0;
    let handle = window.stand().origin + DVec3::X * reach;
    let (from, to) = (window.seen_at(handle), window.seen_at(handle + DVec3::X * reach));
    window.drag(from, to);
    let moved = window.entity(cube).transform;
    assert!((moved.translation.x - created.translation.x - reach).abs() < 0.1 * reach);
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(window.entity(cube).transform, created);
    window.press(Modifiers::COMMAND, Key::Y);
    assert_eq!(window.entity(cube).transform, moved);
    cube
}

/// An empty; the cube comes under it by dragging its row there, and stays where it is in the world.
fn group_over(window: &mut Window, cube: EntityId) -> EntityId {
    let group = window.made(|window| window.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::N));
    let stands = |window: &Window| window.editor().session.document.world_from_local(cube).translation;
    let before = stands(window);
    let (row, target) = (window.row("Cube").center(), window.row("Empty").center());
    window.drag(row, target);
    assert_eq!(window.entity(cube).parent, Some(group));
    assert!(stands(window).abs_diff_eq(before, 1e-9));
    group
}

fn twice_more(window: &mut Window, cube: EntityId, group: EntityId) -> Vec<EntityId> {
    let row = window.row("Cube").center();
    window.click_at(row, Modifiers::NONE);
    assert_eq!(window.selected(), [cube]);
    let mut cubes = vec![cube];
    for _ in 0..2 {
        cubes.push(window.made(|window| window.press(Modifiers::COMMAND, Key::D)));
    }
    assert!(cubes.iter().all(|id| window.entity(*id).parent == Some(group)));
    cubes
}

/// All three at once, in one step.
fn color_all(window: &mut Window, cubes: &[EntityId]) {
    for (name, keys) in
        [("Cube", Modifiers::NONE), ("Cube 2", Modifiers::COMMAND), ("Cube 3", Modifiers::COMMAND)]
    {
        let row = window.row(name).center();
        window.click_at(row, keys);
    }
    assert_eq!(window.selected().len(), 3);
    let steps = window.steps();
    window.enter("Color green", "1/4");
    assert_eq!(window.steps(), steps + 1);
    let color = |id: &EntityId| -> Vec3 {
        let material: MaterialId = window.entity(*id).mesh.as_ref().unwrap().materials[0];
        window.editor().session.document.material(material).unwrap().albedo.color
    };
    assert!(cubes.iter().all(|id| color(id).y == 0.25));
}

fn entities(window: &Window) -> usize {
    window.editor().session.document.scene().entities.len()
}

/// An OBJ: its path is typed where the import asks for it.
fn import_by_keyboard(window: &mut Window, folder: &Path) {
    let file = folder.join("two.obj");
    two_triangles(&file, 1.0);
    let before = entities(window);
    window.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::I);
    assert!(window.is_shown("Import files"));
    window.type_text(&file.display().to_string());
    assert!(window.is_shown("Import `two.obj`"));
    window.press(Modifiers::NONE, Key::Enter);
    window.until("the OBJ", |window| entities(window) == before + 3);
    let root = window.selected()[0];
    assert_eq!(window.entity(root).name, "two");
    assert_eq!(window.editor().session.document.children(Some(root)).len(), 2);
    // It is larger than what the picture showed, and seen nevertheless.
    window.settle();
    let is_below = |entity: &Entity| entity.parent == Some(root);
    let (low, high) = window.editor().scenery().extent(is_below).unwrap();
    assert!(
        window.scene_view().contains(window.seen_at(low))
            && window.scene_view().contains(window.seen_at(high))
    );
}

/// A GLB, dropped on the picture.
fn import_by_mouse(window: &mut Window, folder: &Path) {
    let file = folder.join("chain.glb");
    glb(&file, &["body", "arm"]);
    let (before, at) = (entities(window), window.scene_view().center());
    window.drop_files(&[file], at);
    window.until("the GLB", |window| entities(window) == before + 2);
    assert_eq!(window.entity(window.selected()[0]).name, "body");
    assert!(window.errors().is_empty(), "{:?}", window.errors());
}

/// As it is then, with all that it refers to.
fn save_and_open_again(window: &mut Window, project: &Path) -> String {
    assert!(window.editor().title().contains('*'));
    window.press(Modifiers::COMMAND, Key::S);
    window.until("it is saved", |window| !window.editor().title().contains('*'));
    let saved = window.scene_text();
    let file = window.editor().session.document.path();
    assert_eq!(std::fs::read_to_string(file).unwrap(), saved);
    let again = open_project(project, None, SIZE).unwrap();
    assert_eq!(again.scene_text(), saved);
    assert!(again.errors().is_empty(), "{:?}", again.errors());
    let extent = |window: &Window| window.editor().scenery().extent(|entity| entity.mesh.is_some());
    assert_eq!(extent(&again), extent(window));
    saved
}

/// Exactly what was authored is there again.
fn play_and_stop(window: &mut Window, saved: &str) {
    window.press(Modifiers::NONE, Key::F5);
    assert!(window.harness.query_by_label("Game view").is_some());
    window.harness.run_steps(10);
    window.press(Modifiers::NONE, Key::F5);
    assert_eq!(window.scene_text(), saved);
    assert!(!window.editor().title().contains('*'));
}
