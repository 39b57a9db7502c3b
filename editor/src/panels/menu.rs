//! The menus, made of the table of commands: what can be given now, with its shortcut.

use eframe::egui;
use egui::{Button, MenuBar, Ui};

use crate::ask::Asks;
use crate::command::{Bindings, Category, Command, ROWS, Row, State};

/// A menu and what of the table it shows, group by group.
const MENUS: [(&str, &[Category]); 8] = [
    ("File", &[Category::File]),
    ("Edit", &[Category::Edit]),
    ("Create", &[Category::Create]),
    ("Object", &[Category::Hierarchy]),
    ("Assets", &[Category::Assets]),
    ("View", &[Category::View, Category::Draw, Category::Tool]),
    ("Play", &[Category::Play, Category::Light]),
    ("Window", &[Category::Window, Category::Console]),
];

/// Commands before which a line is drawn.
const GROUPS: [Command; 16] = [
    Command::NewScene,
    Command::Save,
    Command::Reload,
    Command::Preferences,
    Command::Quit,
    Command::Cut,
    Command::SelectAll,
    Command::CreateCube,
    Command::CreateSun,
    Command::CreateCamera,
    Command::CreateSky,
    Command::ToggleHidden,
    Command::ViewFront,
    Command::ToggleGrid,
    Command::ShowHierarchy,
    Command::ResetLayout,
];

pub fn show(ui: &mut Ui, state: &State, bindings: &Bindings, asks: &mut Asks) {
    MenuBar::new().ui(ui, |ui| {
        ui.spacing_mut().button_padding = egui::vec2(8.0, 3.0);
        for (name, categories) in MENUS {
            ui.menu_button(name, |ui| {
                ui.set_min_width(220.0);
                entries(ui, categories, state, bindings, asks);
            });
        }
    });
}

fn entries(ui: &mut Ui, categories: &[Category], state: &State, bindings: &Bindings, asks: &mut Asks) {
    let mut is_first = true;
    for (number, category) in categories.iter().enumerate() {
        let rows = ROWS.iter().filter(|row| row.category == *category);
        for (at, row) in rows.enumerate() {
            let begins = GROUPS.contains(&row.command) || at == 0 && number > 0;
            if begins && !is_first {
                ui.separator();
            }
            is_first = false;
            entry(ui, row, state, bindings, asks);
        }
    }
}

fn entry(ui: &mut Ui, row: &Row, state: &State, bindings: &Bindings, asks: &mut Asks) {
    // Under `Create` the verb is said already.
    let shown = row.name.strip_prefix("Create ").filter(|_| row.category == Category::Create);
    let mut button = Button::new(shown.map_or(row.name.to_owned(), capital));
    if let Some(shortcut) = bindings.shortcuts(row.command).first() {
        button = button.shortcut_text(shortcut.to_string());
    }
    let response = ui.add_enabled(row.command.is_enabled(state), button);
    response.ctx.accesskit_node_builder(response.id, |node| node.set_label(row.name));
    if response.clicked() {
        asks.push(row.command);
        ui.close();
    }
}

fn capital(name: &str) -> String {
    let mut letters = name.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// What a right click on an entity, or beside all of them, offers.
pub fn context(ui: &mut Ui, state: &State, bindings: &Bindings, asks: &mut Asks) {
    ui.set_min_width(200.0);
    let known: [&[Command]; 5] = [
        &[Command::Cut, Command::Copy, Command::Paste, Command::Duplicate, Command::Delete, Command::Rename],
        &[Command::ParentToActive, Command::Unparent],
        &[Command::ToggleHidden, Command::Isolate, Command::ShowAll, Command::ToggleLocked],
        &[Command::ToggleStatic, Command::ToggleStaticWithChildren],
        &[Command::Frame],
    ];
    for (number, group) in known.into_iter().enumerate() {
        if number > 0 {
            ui.separator();
        }
        for command in group {
            entry(ui, command.row(), state, bindings, asks);
        }
    }
    ui.separator();
    ui.menu_button("Create", |ui| entries(ui, &[Category::Create], state, bindings, asks));
}
