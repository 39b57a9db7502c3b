//! What a person does first: make something, move it, take that back, find it again.

use crate::window::{Window, open};
use editor::intents::Intent;
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;
use engine::scene::file::text_of_scene;
use glam::DVec3;
use std::path::Path;

fn cube(window: &mut Window) -> engine::scene::EntityId {
    window.made(|window| window.choose("Create", "Create cube"))
}

#[test]
fn a_cube_is_created_moved_by_its_handle_taken_back_and_done_again() {
    let Some(mut window) = open() else { return };
    let id = cube(&mut window);
    window.press(Modifiers::NONE, Key::F);
    let before = window.entity(id).transform;
    let steps = window.editor().session.document.history().undo_names().count();

    let reach = window.lens().metres_per_point(window.stand().origin) * 60.0;
    let handle = window.stand().origin + DVec3::X * reach;
    let (from, to) = (window.seen_at(handle), window.seen_at(handle + DVec3::X * reach));
    window.drag(from, to);
    let moved = window.entity(id).transform.translation - before.translation;
    assert!((moved.x - reach).abs() < 0.1 * reach && moved.y == 0.0 && moved.z == 0.0, "{moved} for {reach}");
    assert_eq!(window.editor().session.document.history().undo_names().count(), steps + 1, "one step a drag");
    assert!(window.editor().title().contains('*'));

    let after = window.entity(id).transform;
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(window.entity(id).transform, before);
    window.press(Modifiers::COMMAND, Key::Y);
    assert_eq!(window.entity(id).transform, after);
}

#[test]
fn escape_gives_a_drag_up() {
    let Some(mut window) = open() else { return };
    let id = cube(&mut window);
    window.press(Modifiers::NONE, Key::F);
    let before = window.entity(id).transform;
    let from = window.seen_at(window.stand().origin);
    window.harness.hover_at(from);
    window.harness.step();
    window.harness.drag_at(from);
    window.harness.step();
    window.harness.hover_at(from + egui::vec2(60.0, 10.0));
    window.settle();
    assert_ne!(window.entity(id).transform, before);
    window.press(Modifiers::NONE, Key::Escape);
    assert_eq!(window.entity(id).transform, before);
    window.harness.drop_at(from);
    window.settle();
    assert_eq!(window.entity(id).transform, before);
}

#[test]
fn a_click_selects_what_is_seen_there_and_one_beside_it_nothing() {
    let Some(mut window) = open() else { return };
    let id = cube(&mut window);
    window.press(Modifiers::NONE, Key::F);
    let on_it = DVec3::new(0.3, 0.3, 0.5) * window.entity(id).transform.scale;
    let place = window.seen_at(window.stand().origin + on_it);
    window.editor_mut().session.carry_out([Intent::Select(Vec::new())]);
    window.settle();
    window.harness.hover_at(place);
    window.harness.step();
    window.harness.drag_at(place);
    window.harness.step();
    window.harness.drop_at(place);
    window.settle();
    assert_eq!(window.selected(), [id]);
}

#[test]
fn what_is_renamed_in_the_tree_is_found_by_searching() {
    let Some(mut window) = open() else { return };
    let id = cube(&mut window);
    window.press(Modifiers::NONE, Key::F2);
    window.press(Modifiers::COMMAND, Key::A);
    window.harness.event(egui::Event::Text("pedestal".to_owned()));
    window.press(Modifiers::NONE, Key::Enter);
    assert_eq!(window.entity(id).name, "pedestal");
    window.node("Search the hierarchy").focus();
    window.settle();
    window.harness.event(egui::Event::Text("PEDE".to_owned()));
    window.settle();
    assert_eq!(window.harness.query_all_by_label("pedestal").count(), 1);
}

#[test]
fn the_palette_gives_commands_by_a_few_letters() {
    let Some(mut window) = open() else { return };
    let id = window.made(|window| {
        window.press(Modifiers::COMMAND, Key::P);
        window.harness.event(egui::Event::Text("spot".to_owned()));
        window.settle();
        window.press(Modifiers::NONE, Key::Enter);
    });
    assert!(window.entity(id).light.is_some());
}

#[test]
fn playing_and_stopping_brings_back_the_authored_scene_exactly() {
    let Some(mut window) = open() else { return };
    cube(&mut window);
    let text = |window: &Window| {
        text_of_scene(Path::new("scene"), window.editor().session.document.scene()).unwrap()
    };
    let before = text(&window);
    window.press(Modifiers::NONE, Key::F5);
    assert!(window.harness.query_by_label("Game view").is_some());
    window.harness.run_steps(12);
    // What would change the scene is not taken while it plays.
    window.press(Modifiers::NONE, Key::Delete);
    window.press(Modifiers::NONE, Key::F7);
    window.press(Modifiers::NONE, Key::F5);
    assert!(window.harness.query_by_label("Scene view").is_some());
    assert_eq!(text(&window), before);
}
