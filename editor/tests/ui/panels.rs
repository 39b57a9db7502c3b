//! Panels: named, many, and cheap.

use crate::window::{Window, open};
use editor::edit::Edit;
use egui::{Key, Modifiers};
use egui_kittest::kittest::{NodeT, Queryable};
use engine::scene::{Entity, EntityId};

#[test]
fn a_tree_of_five_thousand_draws_the_rows_that_are_seen() {
    let Some(mut window) = open() else { return };
    let many = |n: u64| Entity { id: EntityId(1000 + n), name: format!("stone {n}"), ..Entity::default() };
    let at = window.editor().session.document.scene().entities.len();
    let new = (0..5000).map(|n| (at + n as usize, many(n))).collect();
    assert!(window.editor_mut().session.commit(Edit::Insert(new)));
    window.settle();
    let rows = |window: &Window| {
        let named = |node: &egui_kittest::Node<'_>| {
            node.accesskit_node().label().is_some_and(|label| label.starts_with("stone "))
        };
        window.harness.root().children_recursive().filter(named).count()
    };
    assert!((1..200).contains(&rows(&window)), "{}", rows(&window));
    window.node("Search the hierarchy").focus();
    window.settle();
    window.harness.event(egui::Event::Text("stone 4321".to_owned()));
    window.settle();
    assert_eq!(rows(&window), 1);
}

#[test]
fn panels_come_and_go_by_menu_and_the_layout_is_reset() {
    let Some(mut window) = open() else { return };
    window.press(Modifiers::COMMAND, Key::Num7);
    assert!(window.harness.query_by_label("GPU memory").is_some());
    window.choose("Window", "Reset layout");
    assert!(window.harness.query_by_label("GPU memory").is_none());
    assert!(window.harness.query_by_label("Scene view").is_some());
}

#[test]
fn both_themes_and_other_sizes_draw_every_panel() {
    let Some(mut window) = open() else { return };
    window.choose("Window", "Light or dark theme");
    assert!(!window.harness.ctx.global_style().visuals.dark_mode);
    window.press(Modifiers::COMMAND, Key::Plus);
    window.settle();
    for panel in ["Scene view", "Search the hierarchy", "Search the assets"] {
        let rect = window.node(panel).rect();
        assert!(rect.width() > 20.0 && rect.height() > 10.0, "{panel} {rect}");
    }
}
