//! The palette: type a few letters of any command, and Enter gives it.

use eframe::egui;
use egui::{Align2, Area, Button, Frame, Id, Key, Modifiers, Order, ScrollArea, TextEdit, Ui, vec2};

use crate::ask::Asks;
use crate::command::{Bindings, Row, Shortcut, State, search};
use crate::theme;

#[derive(Default)]
pub struct Palette {
    open: Option<Typed>,
}

#[derive(Default)]
struct Typed {
    text: String,
    chosen: usize,
    /// Not before the first picture of it.
    shown: bool,
}

const WIDTH: f32 = 460.0;

impl Palette {
    pub fn toggle(&mut self) {
        self.open = if self.open.is_some() { None } else { Some(Typed::default()) };
    }

    pub fn is_open(&self) -> bool {
        self.open.is_some()
    }

    pub fn show(&mut self, ui: &Ui, state: &State, bindings: &Bindings, asks: &mut Asks) {
        let Some(typed) = &mut self.open else { return };
        let (up, down, enter, escape) = ui.input_mut(|input| {
            let mut pressed = |key| input.consume_key(Modifiers::NONE, key);
            (pressed(Key::ArrowUp), pressed(Key::ArrowDown), pressed(Key::Enter), pressed(Key::Escape))
        });
        let rows: Vec<&Row> = search(&typed.text);
        typed.chosen = match (up, down) {
            (true, _) => typed.chosen.saturating_sub(1),
            (_, true) => typed.chosen + 1,
            _ => typed.chosen,
        };
        typed.chosen = typed.chosen.min(rows.len().saturating_sub(1));
        let area = Area::new(Id::unique("palette"))
            .order(Order::Foreground)
            .anchor(Align2::CENTER_TOP, vec2(0.0, 76.0));
        let shown = area.show(ui.ctx(), |ui| {
            Frame::popup(ui.style()).inner_margin(8).show(ui, |ui| {
                ui.set_width(WIDTH);
                typed.field(ui);
                ui.add_space(4.0);
                typed.list(ui, &rows, (up || down, enter), state, bindings)
            })
        });
        let given = shown.inner.inner;
        let beside = shown.response.clicked_elsewhere() && typed.shown;
        typed.shown = true;
        if let Some(row) = given {
            asks.push(row.command);
        }
        if given.is_some() || escape || beside {
            self.open = None;
        }
    }
}

impl Typed {
    fn field(&mut self, ui: &mut Ui) {
        let field =
            TextEdit::singleline(&mut self.text).hint_text("Type a command").desired_width(f32::INFINITY);
        let response = ui.add(field);
        response.ctx.accesskit_node_builder(response.id, |node| node.set_label("Command"));
        response.request_focus();
        if response.changed() {
            self.chosen = 0;
        }
    }

    fn list<'a>(
        &mut self,
        ui: &mut Ui,
        rows: &[&'a Row],
        (moved, enter): (bool, bool),
        state: &State,
        bindings: &Bindings,
    ) -> Option<&'a Row> {
        let mut given = None;
        ui.spacing_mut().item_spacing.y = 0.0;
        ScrollArea::vertical().max_height(320.0).auto_shrink([false, true]).show(ui, |ui| {
            for (at, row) in rows.iter().enumerate() {
                let keys = bindings.shortcuts(row.command).first().map_or(String::new(), Shortcut::shown);
                let category = row.category.name();
                // `Create cube` says what it belongs to.
                let name = match row.name.starts_with(category) {
                    true => row.name.to_owned(),
                    false => format!("{category}: {}", row.name),
                };
                let button = Button::selectable(at == self.chosen, name).shortcut_text(keys);
                let button = button.min_size(vec2(ui.available_width(), theme::ROW));
                let response = ui.add_enabled(row.command.is_enabled(state), button);
                if at == self.chosen && moved {
                    response.scroll_to_me(None);
                }
                if response.clicked() || enter && at == self.chosen && row.command.is_enabled(state) {
                    given = Some(*row);
                }
            }
            if rows.is_empty() {
                ui.weak("No such command");
            }
        });
        given
    }
}
