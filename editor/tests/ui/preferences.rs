//! Theme, size, shortcuts: chosen once, remembered.

use crate::window::{Window, cornell, open, open_project};
use editor::layout::{self, Pane};
use egui::{Key, Modifiers, Vec2};
use egui_kittest::kittest::Queryable;

const SIZE: Vec2 = Vec2::new(1280.0, 720.0);

#[test]
fn theme_size_keys_and_layout_are_there_at_the_next_start() {
    let folder = tempfile::tempdir().unwrap();
    let (project, home) = (cornell(folder.path()), folder.path().join("home"));
    let Some(mut window) = open_project(&project, Some(&home), SIZE) else { return };
    window.press(Modifiers::COMMAND, Key::Comma);
    window.click("Theme");
    window.click("Light");
    window.click("Close");
    bind(&mut window, "Bake", Modifiers::CTRL | Modifiers::COMMAND, Key::F9);
    window.click("Close");
    window.press(Modifiers::COMMAND, Key::Equals);
    drop(window);
    let again = open_project(&project, Some(&home), SIZE).unwrap();
    assert!(!again.harness.ctx.global_style().visuals.dark_mode);
    assert!((again.harness.ctx.zoom_factor() - 1.1).abs() < 1e-4);
    let bound = again.editor().bindings().shortcuts(editor::command::Command::Bake);
    assert_eq!(bound.iter().map(ToString::to_string).collect::<Vec<_>>(), ["Ctrl+F9"]);
}

fn bind(window: &mut Window, command: &str, modifiers: Modifiers, key: Key) {
    if !window.is_shown("Search the shortcuts") {
        window.press(Modifiers::NONE, Key::F1);
    }
    window.node("Search the shortcuts").focus();
    window.settle();
    window.press(Modifiers::COMMAND, Key::A);
    window.type_text(command);
    window.click(&format!("Keys of {command}"));
    window.press(modifiers, key);
}

#[test]
fn keys_that_another_command_has_are_told_and_taken_over_only_when_asked() {
    let Some(mut window) = open() else { return };
    bind(&mut window, "Grid", Modifiers::COMMAND, Key::D);
    assert!(window.is_shown("Ctrl+D is bound to `Duplicate` already"));
    window.click("Leave it");
    bind(&mut window, "Grid", Modifiers::COMMAND, Key::D);
    window.click("Take over");
    window.click("Close");
    let hidden = window.editor().scene.hide_grid;
    window.press(Modifiers::COMMAND, Key::D);
    assert_ne!(window.editor().scene.hide_grid, hidden);
    window.press(Modifiers::NONE, Key::F1);
    window.click("Reset all");
    window.click("Close");
    window.press(Modifiers::COMMAND, Key::D);
    assert_ne!(window.editor().scene.hide_grid, hidden, "it is not the grid's any more");
    window.press(Modifiers::NONE, Key::G);
    assert_eq!(window.editor().scene.hide_grid, hidden);
}

#[test]
fn escape_leaves_keys_as_they_are_and_one_command_gets_its_usual_ones_back() {
    let Some(mut window) = open() else { return };
    bind(&mut window, "Grid", Modifiers::NONE, Key::Escape);
    assert!(window.is_shown("Search the shortcuts"), "the window stays");
    assert!(!window.is_shown("Usual keys of Grid"));
    bind(&mut window, "Grid", Modifiers::SHIFT, Key::G);
    window.click("Usual keys of Grid");
    assert!(!window.is_shown("Usual keys of Grid"));
    window.click("No keys for Grid");
    window.click("Close");
    let hidden = window.editor().scene.hide_grid;
    window.press(Modifiers::NONE, Key::G);
    assert_eq!(window.editor().scene.hide_grid, hidden, "it has no keys now");
}

#[test]
fn shortcuts_are_found_by_their_keys_and_every_command_is_listed() {
    let Some(mut window) = open() else { return };
    window.press(Modifiers::NONE, Key::F1);
    window.node("Search the shortcuts").focus();
    window.settle();
    window.type_text("ctrl+shift+z");
    assert!(window.is_shown("Keys of Redo") && !window.is_shown("Keys of Undo"));
}

#[test]
fn a_panel_that_was_closed_by_its_tab_stays_closed_until_it_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let (project, home) = (cornell(folder.path()), folder.path().join("home"));
    let Some(mut window) = open_project(&project, Some(&home), SIZE) else { return };
    window.node("Console panel").click_secondary();
    window.settle();
    window.click("Close console");
    assert!(!window.is_shown("Console panel"));
    window.press(Modifiers::COMMAND, Key::Equals); // preferences are kept
    drop(window);
    let mut again = open_project(&project, Some(&home), SIZE).unwrap();
    assert!(!again.is_shown("Console panel"));
    again.press(Modifiers::COMMAND, Key::Num6);
    assert!(again.is_shown("Console panel"));
    assert!(layout::is_open(&layout::default_layout(1280.0), Pane::Console));
    assert!(again.harness.query_by_label("Filter the console").is_some());
}
