//! What screen readers are told: everything that can be pressed or filled in has a name.

use crate::window::{Window, open};
use editor::intents::Intent;
use egui::accesskit::{Action, Role};
use egui::{Key, Modifiers};
use egui_kittest::kittest::{NodeT, Queryable};
use engine::scene::EntityId;

/// What can be pressed or filled in and says nothing of itself.
fn nameless(window: &Window) -> Vec<String> {
    let mut found = Vec::new();
    for node in window.harness.root().children_recursive() {
        let node = node.accesskit_node();
        // A scroll bar is its list's; docked panels are pulled by the gaps between them and the room beside their tabs.
        let is_bar = node.role() == Role::ScrollBar || node.role() == Role::Unknown && is_of_docks(&node);
        let is_pressed = node.data().supports_action(Action::Click) && !is_bar;
        let has_name = [node.label(), node.value()].into_iter().flatten().any(|text| !text.trim().is_empty());
        if is_pressed && !has_name && !node.is_hidden() {
            found.push(format!("{:?} at {:?}", node.role(), node.bounding_box()));
        }
    }
    found
}

/// In pixels, of which two points make one.
fn is_of_docks(node: &egui_kittest::kittest::AccessKitNode<'_>) -> bool {
    let Some(place) = node.bounding_box() else { return true };
    let (width, height) = (place.width(), place.height());
    width.min(height) <= 4.0 || (height - 12.5).abs() < 0.6 && width > 90.0
}

fn interactive(window: &Window) -> usize {
    let nodes = window.harness.root();
    nodes
        .children_recursive()
        .filter(|node| node.accesskit_node().data().supports_action(Action::Click))
        .count()
}

fn check(window: &Window, what: &str) {
    let nameless = nameless(window);
    assert!(nameless.is_empty(), "{what}: {nameless:?}");
    assert!(interactive(window) > 30, "{what}: {} can be pressed", interactive(window));
}

#[test]
fn everything_that_can_be_pressed_has_a_name() {
    let Some(mut window) = open() else { return };
    check(&window, "nothing selected");
    let all: Vec<EntityId> =
        window.editor().session.document.scene().entities.iter().map(|entity| entity.id).collect();
    for id in &all {
        window.editor_mut().session.carry_out([Intent::Select(vec![*id])]);
        window.settle();
        check(&window, &window.entity(*id).name.clone());
    }
    window.editor_mut().session.carry_out([Intent::Select(all)]);
    window.settle();
    check(&window, "all selected");
    let id = window.made(|window| window.choose("Create", "Create reflection probe"));
    check(&window, "a reflection probe");
    assert!(window.entity(id).reflection_probe.is_some());
    for panel in [Key::Num3, Key::Num5, Key::Num6, Key::Num7, Key::Num2] {
        window.press(Modifiers::COMMAND, panel);
        check(&window, &format!("panel {panel:?}"));
    }
    for menu in ["File", "Edit", "Create", "Object", "Assets", "Tool", "View", "Play", "Window"] {
        window.harness.query_all_by_label(menu).next().unwrap().click();
        window.settle();
        check(&window, menu);
        window.press(Modifiers::NONE, Key::Escape);
    }
    let import = Modifiers::COMMAND | Modifiers::SHIFT;
    for (keys, key) in [
        (Modifiers::COMMAND, Key::P),
        (Modifiers::NONE, Key::F1),
        (Modifiers::COMMAND, Key::O),
        (import, Key::I),
    ] {
        window.press(keys, key);
        check(&window, &format!("{key:?}"));
        window.press(Modifiers::NONE, Key::Escape);
    }
}
