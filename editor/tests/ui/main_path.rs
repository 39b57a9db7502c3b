//! The way of everybody's first hour, in one piece.

use crate::window::{cornell, open_project};
use egui::{Key, Modifiers, Vec2};
use egui_kittest::kittest::Queryable;
use engine::scene::{EntityId, MaterialId};
use glam::{DVec3, Vec3};

#[test]
fn a_scene_is_made_changed_saved_reopened_and_played() {
    let folder = tempfile::tempdir().unwrap();
    let project = cornell(folder.path());
    let Some(mut window) = open_project(&project, None, Vec2::new(1280.0, 720.0)) else { return };

    // A cube, pulled along x by its handle, taken back and done again.
    let cube = window.made(|window| window.choose("Create", "Create cube"));
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

    // Under an empty, by dragging its row there: it stays where it is in the world.
    let group = window.made(|window| window.choose("Create", "Create empty"));
    let stands =
        |window: &crate::window::Window| window.editor().session.document.world_from_local(cube).translation;
    let before = stands(&window);
    let (row, target) = (window.row("Cube").center(), window.row("Empty").center());
    window.drag(row, target);
    assert_eq!(window.entity(cube).parent, Some(group));
    assert!(stands(&window).abs_diff_eq(before, 1e-9));

    // Twice more.
    let first = window.row("Cube").center();
    window.click_at(first, Modifiers::NONE);
    assert_eq!(window.selected(), [cube]);
    let mut cubes = vec![cube];
    for _ in 0..2 {
        cubes.push(window.made(|window| window.press(Modifiers::COMMAND, Key::D)));
    }
    assert!(cubes.iter().all(|id| window.entity(*id).parent == Some(group)));

    // All three at once get a color.
    window.click_at(first, Modifiers::NONE);
    for name in ["Cube 2", "Cube 3"] {
        let row = window.row(name).center();
        window.click_at(row, Modifiers::COMMAND);
    }
    assert_eq!(window.selected().len(), 3);
    let steps = window.editor().session.document.history().undo_names().count();
    window.enter("Color green", "1/4");
    assert_eq!(window.editor().session.document.history().undo_names().count(), steps + 1);
    let color = |window: &crate::window::Window, id: EntityId| -> Vec3 {
        let material: MaterialId = window.entity(id).mesh.as_ref().unwrap().materials[0];
        window.editor().session.document.material(material).unwrap().albedo.color
    };
    assert!(cubes.iter().all(|id| color(&window, *id).y == 0.25));

    // Saved, and opened again as it was.
    assert!(window.editor().title().contains('*'));
    window.press(Modifiers::COMMAND, Key::S);
    window.until("it is saved", |window| !window.editor().title().contains('*'));
    let saved = window.scene_text();
    let file = window.editor().session.document.path();
    assert_eq!(std::fs::read_to_string(file).unwrap(), saved);
    let again = open_project(&project, None, Vec2::new(1280.0, 720.0)).unwrap();
    assert_eq!(again.scene_text(), saved);
    drop(again);

    // Played and stopped: exactly what was authored.
    window.press(Modifiers::NONE, Key::F5);
    assert!(window.harness.query_by_label("Game view").is_some());
    window.harness.run_steps(10);
    window.press(Modifiers::NONE, Key::F5);
    assert_eq!(window.scene_text(), saved);
    assert!(!window.editor().title().contains('*'));
}
