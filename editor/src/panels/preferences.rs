//! How the editor looks and which keys give what: the user's own, whatever project is open.

use std::time::Duration;

use eframe::egui;
use egui::{
    Align, Button, ComboBox, Event, EventFilter, Grid, Key, Layout, RichText, ScrollArea, Slider, TextEdit,
    Ui, vec2,
};

use crate::command::{Bindings, Command, Conflict, ROWS, Row, Shortcut, search};
use crate::icons::{self, Icon};
use crate::recent::{Preferences, Theme};
use crate::{keys, theme};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tab {
    Appearance,
    Shortcuts,
}

/// The window that shows them.
#[derive(Default)]
pub struct Settings {
    shown: Option<Shown>,
}

struct Shown {
    tab: Tab,
    /// While the slider is pulled: all that is seen would move under the mouse.
    scale: Option<f32>,
    search: String,
    /// The command that waits for keys.
    listening: Option<Command>,
    /// Keys that another command has.
    conflict: Option<(Command, Conflict)>,
}

const SIZE: egui::Vec2 = vec2(600.0, 420.0);
/// Room for the keys of a command; points.
const KEYS: f32 = 170.0;

impl Settings {
    pub fn open(&mut self, tab: Tab) {
        let (scale, search, listening, conflict) = Default::default();
        self.shown = Some(Shown { tab, scale, search, listening, conflict });
    }

    pub fn is_open(&self) -> bool {
        self.shown.is_some()
    }

    /// Whether something changed.
    pub fn show(&mut self, ui: &Ui, preferences: &mut Preferences, bindings: &mut Bindings) -> bool {
        let Some(shown) = &mut self.shown else { return false };
        // Before any field sees the keys.
        let mut is_changed = shown.listen(ui, bindings);
        let is_listening = shown.listening.is_some();
        let modal = theme::dialog(ui, "preferences").show(ui.ctx(), |ui| {
            ui.set_min_size(SIZE);
            ui.set_max_size(SIZE);
            let is_closed = shown.head(ui);
            ui.separator();
            is_changed |= match shown.tab {
                Tab::Appearance => shown.appearance(ui, preferences),
                Tab::Shortcuts => shown.shortcuts(ui, bindings),
            };
            is_closed
        });
        if modal.inner || (!is_listening && modal.should_close()) {
            self.shown = None;
        }
        is_changed
    }
}

impl Shown {
    /// Whether the window is to close.
    fn head(&mut self, ui: &mut Ui) -> bool {
        ui.horizontal(|ui| {
            ui.label(RichText::new("Preferences").heading());
            ui.add_space(16.0);
            ui.selectable_value(&mut self.tab, Tab::Appearance, "Appearance");
            ui.selectable_value(&mut self.tab, Tab::Shortcuts, "Shortcuts");
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| ui.button("Close").clicked()).inner
        })
        .inner
    }

    fn appearance(&mut self, ui: &mut Ui, preferences: &mut Preferences) -> bool {
        let before = (preferences.theme, preferences.ui_scale);
        Grid::new("appearance").num_columns(2).spacing(vec2(24.0, 10.0)).show(ui, |ui| {
            let label = ui.label("Theme");
            let name = |theme| if theme == Theme::Dark { "Dark" } else { "Light" };
            let shown =
                ComboBox::from_id_salt("theme").selected_text(name(preferences.theme)).show_ui(ui, |ui| {
                    for theme in [Theme::Dark, Theme::Light] {
                        ui.selectable_value(&mut preferences.theme, theme, name(theme));
                    }
                });
            shown.response.labelled_by(label.id);
            ui.end_row();
            let label = ui.label("Size of text and controls");
            let mut scale = self.scale.unwrap_or(preferences.ui_scale);
            let slider = Slider::new(&mut scale, 0.6..=3.0)
                .step_by(0.05)
                .custom_formatter(|scale, _| format!("{scale:.2}"));
            let response = ui.add(slider).labelled_by(label.id);
            self.scale = response.dragged().then_some(scale);
            if !response.dragged() {
                preferences.ui_scale = scale;
            }
            ui.end_row();
            ui.label("");
            if ui.button("As it was at first").clicked() {
                (preferences.theme, preferences.ui_scale) = (Theme::default(), 1.0);
            }
            ui.end_row();
        });
        ui.add_space(10.0);
        ui.weak("Panels are moved by their tabs, and closed by a right click on one. Window > Reset layout puts them back.");
        before != (preferences.theme, preferences.ui_scale)
    }

    fn shortcuts(&mut self, ui: &mut Ui, bindings: &mut Bindings) -> bool {
        let mut is_changed = false;
        ui.horizontal(|ui| {
            let field = TextEdit::singleline(&mut self.search).hint_text("Search by name or keys");
            let field = field.align(egui::Align2::LEFT_CENTER);
            let field = ui.add_sized(vec2(260.0, 22.0), field);
            field.ctx.accesskit_node_builder(field.id, |node| node.set_label("Search the shortcuts"));
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                let differs = *bindings != Bindings::default();
                if ui.add_enabled(differs, Button::new("Reset all")).clicked() {
                    bindings.reset_all();
                    is_changed = true;
                }
            });
        });
        is_changed |= self.told(ui, bindings);
        ui.add_space(4.0);
        let rows = found(&self.search, bindings);
        if rows.is_empty() {
            ui.weak("No such command");
        }
        ui.spacing_mut().item_spacing.y = 2.0;
        ScrollArea::vertical().auto_shrink(false).show_rows(ui, theme::ROW, rows.len(), |ui, range| {
            for row in &rows[range] {
                is_changed |= self.row(ui, row, bindings);
            }
        });
        is_changed
    }

    /// What is waited for, or why keys were not taken.
    fn told(&mut self, ui: &mut Ui, bindings: &mut Bindings) -> bool {
        let Some((command, conflict)) = self.conflict else {
            ui.weak(match self.listening {
                Some(command) => format!("Press the keys for `{}`. Esc: leave it as it is", command.name()),
                None => "Click on keys to change them".to_owned(),
            });
            return false;
        };
        let mut is_taken = false;
        ui.horizontal(|ui| {
            ui.label(RichText::new(conflict.to_string()).color(ui.visuals().warn_fg_color));
            is_taken = ui.button("Take over").clicked();
            if is_taken {
                bindings.take_over(command, vec![conflict.shortcut]);
            }
            if is_taken || ui.button("Leave it").clicked() {
                self.conflict = None;
            }
        });
        is_taken
    }

    fn row(&mut self, ui: &mut Ui, row: &Row, bindings: &mut Bindings) -> bool {
        let command = row.command;
        let shortcuts = bindings.shortcuts(command);
        let mut is_changed = false;
        ui.horizontal(|ui| {
            ui.set_min_height(theme::ROW);
            let width = ui.available_width() - KEYS - 64.0;
            ui.allocate_ui_with_layout(vec2(width, theme::ROW), Layout::left_to_right(Align::Center), |ui| {
                ui.set_min_width(width);
                ui.label(row.name);
                ui.weak(row.category.name());
            });
            self.keys_button(ui, row, &shortcuts);
            let none = format!("No keys for {}", row.name);
            if !shortcuts.is_empty() && icons::button(ui, Icon::Close, &none, "", false).clicked() {
                // Nothing can be in the way of nothing.
                is_changed = bindings.bind(command, Vec::new()).is_ok();
            }
            let reset = format!("Usual keys of {}", row.name);
            let is_usual = shortcuts == Bindings::default().shortcuts(command);
            if !is_usual && icons::button(ui, Icon::Reset, &reset, "", false).clicked() {
                is_changed |= self.take(bindings, command, Bindings::default().shortcuts(command));
            }
        });
        is_changed
    }

    /// Shows a command's keys; pressed, it waits for others.
    fn keys_button(&mut self, ui: &mut Ui, row: &Row, shortcuts: &[Shortcut]) {
        let is_listening = self.listening == Some(row.command);
        let said = if is_listening { "Press keys".to_owned() } else { told(shortcuts) };
        let button = Button::new(said).selected(is_listening).min_size(vec2(KEYS, theme::ROW - 2.0));
        let button = ui.add(button);
        let name = format!("Keys of {}", row.name);
        button.ctx.accesskit_node_builder(button.id, |node| node.set_label(name));
        if is_listening {
            let all = EventFilter { tab: true, horizontal_arrows: true, vertical_arrows: true, escape: true };
            ui.memory_mut(|memory| memory.set_focus_lock_filter(button.id, all));
        }
        if button.clicked() {
            (self.listening, self.conflict) = (Some(row.command), None);
            button.request_focus();
        }
    }

    /// Keys that are pressed while a command waits for them are its own, and nobody else's.
    fn listen(&mut self, ui: &Ui, bindings: &mut Bindings) -> bool {
        let Some(command) = self.listening else { return false };
        let pressed = ui.input_mut(|input| {
            let is_key = |event: &Event| {
                matches!(event, Event::Key { .. } | Event::Text(_)) || keys::shortcut(event).is_some()
            };
            let pressed = input.events.iter().find_map(keys::shortcut);
            input.events.retain(|event| !is_key(event));
            pressed
        });
        let Some(pressed) = pressed else {
            ui.ctx().request_repaint_after(Duration::from_millis(200));
            return false;
        };
        self.listening = None;
        let is_escape =
            pressed.key.name() == Key::Escape.name() && !pressed.ctrl && !pressed.shift && !pressed.alt;
        !is_escape && self.take(bindings, command, vec![pressed])
    }

    fn take(&mut self, bindings: &mut Bindings, command: Command, keys: Vec<Shortcut>) -> bool {
        let taken = bindings.bind(command, keys);
        self.conflict = taken.err().map(|conflict| (command, conflict));
        self.conflict.is_none()
    }
}

fn told(shortcuts: &[Shortcut]) -> String {
    let texts: Vec<String> = shortcuts.iter().map(Shortcut::shown).collect();
    if texts.is_empty() { "none".to_owned() } else { texts.join(", ") }
}

/// By name, or by what their keys are called.
fn found(text: &str, bindings: &Bindings) -> Vec<&'static Row> {
    let letters = text.trim().to_lowercase();
    let has_keys = |row: &Row| told(&bindings.shortcuts(row.command)).to_lowercase().contains(&letters);
    let mut rows = search(text);
    let named: Vec<Command> = rows.iter().map(|row| row.command).collect();
    rows.extend(ROWS.iter().filter(|row| !named.contains(&row.command) && has_keys(row)));
    rows
}
