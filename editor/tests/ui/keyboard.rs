//! Without a mouse.

use std::collections::HashSet;

use crate::window::open;
use egui::{Key, Modifiers};
use engine::scene::EntityId;

#[test]
fn arrows_go_through_the_tree_fold_and_unfold() {
    let Some(mut window) = open() else { return };
    let parent = window.made(|window| window.choose("Create", "Create empty"));
    let child = window.made(|window| window.choose("Create", "Create cube"));
    let row = window.row("Empty").center();
    let cube = window.row("Cube").center();
    window.drag(cube, row);
    assert_eq!(window.entity(child).parent, Some(parent));
    let row = window.row("Empty").center();
    window.click_at(row, Modifiers::NONE);
    window.press(Modifiers::NONE, Key::ArrowDown);
    assert_eq!(window.selected(), [child]);
    window.press(Modifiers::NONE, Key::ArrowLeft);
    assert_eq!(window.selected(), [parent]);
    window.press(Modifiers::NONE, Key::ArrowLeft);
    assert!(!window.is_shown("Cube"), "folded");
    window.press(Modifiers::NONE, Key::ArrowRight);
    assert!(window.is_shown("Cube"));
    window.press(Modifiers::NONE, Key::ArrowRight);
    assert_eq!(window.selected(), [child]);
    window.press(Modifiers::NONE, Key::ArrowUp);
    window.press(Modifiers::SHIFT, Key::ArrowUp);
    let [first, second]: [EntityId; 2] = window.selected().try_into().unwrap();
    let name = window.entity(second).name.clone();
    assert!(first == parent && second != child, "Shift takes it along");
    assert!((window.row(&name).bottom() - window.row("Empty").top()).abs() < 1.0, "{name} is the row above");
}

#[test]
fn the_keyboard_reaches_every_panel() {
    let Some(mut window) = open() else { return };
    window.press(Modifiers::COMMAND, Key::Num7);
    assert!(window.is_shown("GPU memory"));
    window.press(Modifiers::COMMAND, Key::Num6);
    assert!(window.is_shown("Filter the console"));
    window.press(Modifiers::COMMAND, Key::Num3);
    assert!(window.is_shown("Game view"));
    window.press(Modifiers::COMMAND, Key::Num2);
    assert!(window.is_shown("Scene view"));
    // From field to field with Tab, and Space presses what it stands on.
    window.press(Modifiers::COMMAND, Key::F);
    window.type_text("light");
    let mut stops = HashSet::new();
    for _ in 0..40 {
        window.press(Modifiers::NONE, Key::Tab);
        stops.extend(window.harness.ctx.memory(|memory| memory.focused()));
    }
    assert!(stops.len() > 20, "{}", stops.len());
}
