//! The menus, made of the table of commands: what can be given now, with its shortcut.

use eframe::egui;
use egui::accesskit::{Role, Toggled};
use egui::{Atom, Button, IntoAtoms, MenuBar, Ui, vec2};

use crate::ask::Asks;
use crate::command::{Bindings, Category, Command, ROWS, Row, State};
use crate::icons::{self, Icon};
use crate::{layout, run};

/// Whether a command is switched on; `None`: it is no switch.
type Checks<'a> = &'a dyn Fn(Command) -> Option<bool>;

/// A menu and what of the table it shows, group by group.
const MENUS: [(&str, &[Category]); 9] = [
    ("File", &[Category::File]),
    ("Edit", &[Category::Edit]),
    ("Create", &[Category::Create]),
    ("Object", &[Category::Hierarchy]),
    ("Assets", &[Category::Assets]),
    ("Tool", &[Category::Tool]),
    ("View", &[Category::View, Category::Draw]),
    ("Play", &[Category::Play, Category::Light]),
    ("Window", &[Category::Window, Category::Console]),
];

/// Commands before which a line is drawn.
const GROUPS: [Command; 18] = [
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
    Command::ToggleSpace,
    Command::ToggleSnapping,
    Command::ViewFront,
    Command::ToggleGrid,
    Command::ShowHierarchy,
    Command::ResetLayout,
];

pub fn show(ui: &mut Ui, state: &State, bindings: &Bindings, checks: Checks<'_>, asks: &mut Asks) {
    MenuBar::new().ui(ui, |ui| {
        ui.spacing_mut().button_padding = egui::vec2(8.0, 3.0);
        for (name, categories) in MENUS {
            ui.menu_button(name, |ui| {
                ui.set_min_width(220.0);
                entries(ui, categories, state, bindings, checks, asks);
            });
        }
    });
}

fn entries(
    ui: &mut Ui,
    categories: &[Category],
    state: &State,
    bindings: &Bindings,
    checks: Checks<'_>,
    asks: &mut Asks,
) {
    let mut is_first = true;
    let has_checks =
        ROWS.iter().any(|row| categories.contains(&row.category) && checks(row.command).is_some());
    for (number, category) in categories.iter().enumerate() {
        let rows = ROWS.iter().filter(|row| row.category == *category);
        for (at, row) in rows.enumerate() {
            let begins = GROUPS.contains(&row.command) || at == 0 && number > 0;
            if begins && !is_first {
                ui.separator();
            }
            is_first = false;
            let gutter = has_checks.then(|| checks(row.command));
            entry(ui, row, gutter, (state, bindings), asks);
        }
    }
}

/// `gutter`: there is room for a check mark, and what it says.
fn entry(
    ui: &mut Ui,
    row: &Row,
    gutter: Option<Option<bool>>,
    (state, bindings): (&State, &Bindings),
    asks: &mut Asks,
) {
    let mut button = Button::new(words(row, gutter));
    if let Some(shortcut) = bindings.shortcuts(row.command).first() {
        button = button.shortcut_text(shortcut.shown());
    }
    let response = ui.add_enabled(row.command.is_enabled(state), button);
    let is_on = gutter.flatten();
    response.ctx.accesskit_node_builder(response.id, |node| {
        node.set_label(row.name);
        if let Some(is_on) = is_on {
            node.set_role(Role::MenuItemCheckBox);
            node.set_toggled(Toggled::from(is_on));
        }
    });
    if response.clicked() {
        // The check mark of a panel is taken away by a click, as others are.
        match run::pane(row.command).filter(|pane| is_on == Some(true) && layout::can_close(*pane)) {
            Some(pane) => asks.push(pane),
            None => asks.push(row.command),
        }
        ui.close();
    }
}

/// A check mark where it is switched on, and its name: under `Create`, and where a mark says `Show`, without the verb.
fn words(row: &Row, gutter: Option<Option<bool>>) -> egui::Atoms<'static> {
    let verb = if row.category == Category::Create { "Create " } else { "Show " };
    let is_told = row.category == Category::Create || run::pane(row.command).is_some();
    let name = row.name.strip_prefix(verb).filter(|_| is_told).map_or(row.name.to_owned(), capital);
    let Some(is_on) = gutter else { return name.into_atoms() };
    let mark = Atom::paint(vec2(14.0, 14.0), move |ui, place| {
        if is_on == Some(true) {
            icons::paint(ui.painter(), place.rect, Icon::Check, place.fallback_text_color);
        }
    });
    (mark, name).into_atoms()
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
            entry(ui, command.row(), None, (state, bindings), asks);
        }
    }
    ui.separator();
    ui.menu_button("Create", |ui| entries(ui, &[Category::Create], state, bindings, &|_| None, asks));
}
