//! Panels: named, many, and cheap.

use crate::window::{Window, open};
use editor::command::Command;
use editor::edit::Edit;
use editor::layout::{self, Pane};
use editor::log::Source;
use egui::accesskit::{Role, Toggled};
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
fn panels_are_closed_by_commands_of_their_names_which_take_shortcuts() {
    let Some(mut window) = open() else { return };
    let give = |window: &mut Window, name: &str| {
        window.press(Modifiers::COMMAND, Key::P);
        window.harness.event(egui::Event::Text(name.to_owned()));
        window.settle();
        window.press(Modifiers::NONE, Key::Enter);
    };
    for pane in Pane::ALL.into_iter().filter(|pane| layout::can_close(*pane)) {
        let command = Command::by_id(&format!("window.close_{}", pane.name().to_lowercase())).unwrap();
        give(&mut window, command.name());
        assert!(!layout::is_open(&window.editor().layout, pane), "{}", command.name());
    }
    assert!(layout::is_open(&window.editor().layout, Pane::Scene));
    assert!(Command::by_id("window.close_scene").is_none(), "the pictures of the scene stay");
    give(&mut window, "Show inspector");
    assert!(layout::is_open(&window.editor().layout, Pane::Inspector));
}

#[test]
fn the_window_menu_marks_the_panels_that_are_seen_and_closes_and_shows_them() {
    let Some(mut window) = open() else { return };
    let is_marked = |window: &mut Window, entry: &str| {
        window.click("Window");
        let mark = window.node(entry).accesskit_node().toggled();
        window.press(Modifiers::NONE, Key::Escape);
        mark == Some(Toggled::True)
    };
    assert!(is_marked(&mut window, "Show assets") && !is_marked(&mut window, "Show console"));
    window.choose("Window", "Show console");
    assert!(window.is_shown("Filter the console"));
    assert!(is_marked(&mut window, "Show console") && !is_marked(&mut window, "Show assets"));
    window.choose("Window", "Show console");
    assert!(!window.is_shown("Console panel") && !is_marked(&mut window, "Show console"));
    window.choose("Window", "Show console");
    assert!(window.is_shown("Filter the console"));
    window.choose("Window", "Show scene view");
    assert!(window.is_shown("Scene view"), "the pictures of the scene stay");
}

#[test]
fn what_is_switched_on_is_marked_in_its_menu() {
    let Some(mut window) = open() else { return };
    let marks = |window: &mut Window, menu: &str, entries: &[&str]| -> Vec<bool> {
        window.click(menu);
        let marked = |entry: &&str| {
            let nodes: Vec<_> = window.harness.query_all_by_label(entry).collect();
            nodes.iter().any(|node| {
                let node = node.accesskit_node();
                node.role() == Role::MenuItemCheckBox && node.toggled() == Some(Toggled::True)
            })
        };
        let marks = entries.iter().map(marked).collect();
        window.press(Modifiers::NONE, Key::Escape);
        marks
    };
    let views = ["Composite", "Albedo", "Grid"];
    assert_eq!(marks(&mut window, "View", &views), [true, false, true]);
    window.press(Modifiers::ALT, Key::Num5);
    window.press(Modifiers::NONE, Key::G);
    assert_eq!(marks(&mut window, "View", &views), [false, true, false]);
    window.press(Modifiers::NONE, Key::E);
    assert_eq!(marks(&mut window, "Tool", &["Move", "Rotate"]), [false, true]);
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

#[test]
fn a_line_of_the_console_leads_to_its_file() {
    let Some(mut window) = open() else { return };
    assert!(!window.editor().state().asset_selected);
    let file = window.project().join("assets/cornell.obj");
    window.editor().session.log.warning(Source::File(file), "this file looks odd");
    window.press(Modifiers::COMMAND, Key::Num6);
    let line = window.harness.query_all_by_label("this file looks odd").last().unwrap().rect().center();
    window.click_at(line, Modifiers::NONE);
    assert!(window.editor().state().asset_selected && window.is_shown("Search the assets"));
}
