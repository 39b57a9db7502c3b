//! What is done to a component as a whole, from the menu at its head: copied, pasted over, reset, removed.

use eframe::egui;
use egui::{Button, Popup, Ui};

use super::fields::{folded, small_button};
use crate::edit::Field;
use crate::icons::Icon;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wish {
    Copy,
    /// Over the values of those that are selected.
    Paste,
    Reset,
    Remove,
}

/// What of the menu can be chosen.
#[derive(Clone, Copy, Debug)]
pub struct Can {
    pub paste: bool,
    pub reset: bool,
    /// A transform cannot.
    pub remove: bool,
}

impl Can {
    pub fn all(paste: bool) -> Self {
        Self { paste, reset: true, remove: true }
    }
}

/// A component with its fields, which can be folded.
pub fn component(
    ui: &mut Ui,
    icon: Icon,
    name: &str,
    can: Can,
    fields: impl FnOnce(&mut Ui),
) -> Option<Wish> {
    let thing = name.to_lowercase();
    let room = if can.remove { 46.0 } else { 24.0 };
    let buttons = |ui: &mut Ui| {
        let chosen = menu(ui, &thing, can);
        let is_removed =
            can.remove && small_button(ui, Icon::Close, &format!("Remove the {thing}")).clicked();
        chosen.or(is_removed.then_some(Wish::Remove))
    };
    folded(ui, icon, name, room, buttons, fields)
}

fn menu(ui: &mut Ui, thing: &str, can: Can) -> Option<Wish> {
    let button = small_button(ui, Icon::More, &format!("More for the {thing}"));
    let entries = [
        (Wish::Copy, format!("Copy the {thing}"), true),
        (Wish::Paste, "Paste its values".to_owned(), can.paste),
        (Wish::Reset, "Reset all of it".to_owned(), can.reset),
    ];
    let mut chosen = None;
    Popup::menu(&button).show(|ui| {
        for (wish, name, is_enabled) in entries {
            if ui.add_enabled(is_enabled, Button::new(name)).clicked() {
                chosen = Some(wish);
            }
        }
    });
    chosen
}

/// What was copied lies in the window's own memory, so that it outlives what is selected and the document.
fn place() -> egui::Id {
    egui::Id::unique("copied component")
}

pub fn copy(ui: &Ui, field: Option<Field>) {
    ui.data_mut(|data| field.map(|field| data.insert_temp(place(), field)));
}

pub fn copied(ui: &Ui) -> Option<Field> {
    ui.data(|data| data.get_temp(place()))
}
