//! From keys to commands, as the table or the user bound them.

use eframe::egui;
use egui::{Event, PointerButton, Ui};

use crate::command::{Bindings, Command, Key, Shortcut};

/// Commands whose keys were pressed, in their order. While text is typed or the camera flies, plain keys belong to those.
pub fn pressed(ui: &Ui, bindings: &Bindings) -> Vec<Command> {
    let typing = ui.ctx().text_edit_focused();
    let flying = ui.input(|input| input.pointer.button_down(PointerButton::Secondary));
    let popup = egui::Popup::is_any_open(ui.ctx());
    ui.input(|input| {
        let given = input.events.iter().filter_map(|event| command(event, bindings));
        given
            .filter(|(shortcut, _)| !popup && !flying && (!typing || is_for_all(shortcut)))
            .map(|(_, c)| c)
            .collect()
    })
}

/// Not a letter that a text field wants, nor one of its own shortcuts.
fn is_for_all(shortcut: &Shortcut) -> bool {
    let edits_text = ["A", "C", "V", "X", "Y", "Z"].contains(&shortcut.key.name());
    let is_function = shortcut.key.name().starts_with('F') && shortcut.key.name().len() > 1;
    is_function && shortcut.key.name() != "F2" || shortcut.ctrl && !edits_text
}

fn command(event: &Event, bindings: &Bindings) -> Option<(Shortcut, Command)> {
    let shortcut = shortcut(event)?;
    let command = bindings.command(shortcut)?;
    let is_held = matches!(event, Event::Key { repeat: true, .. });
    // What is undone step by step is undone by holding the key.
    (!is_held || matches!(command, Command::Undo | Command::Redo)).then_some((shortcut, command))
}

/// What was pressed.
pub fn shortcut(event: &Event) -> Option<Shortcut> {
    // Copy, cut and paste come as events of their own where the system knows them.
    let named = |key: &str| Some(Shortcut { ctrl: true, shift: false, alt: false, key: Key::named(key)? });
    match event {
        Event::Key { key, pressed: true, modifiers, .. } => Some(Shortcut {
            ctrl: modifiers.command,
            // Some keyboards need Shift to write it.
            shift: modifiers.shift && *key != egui::Key::Plus,
            alt: modifiers.alt,
            key: Key::named(key.name())?,
        }),
        Event::Copy => named("C"),
        Event::Cut => named("X"),
        Event::Paste(_) => named("V"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::Modifiers;

    fn given(key: egui::Key, modifiers: Modifiers) -> Option<Command> {
        let event = Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers };
        command(&event, &Bindings::default()).map(|(_, command)| command)
    }

    #[test]
    fn keys_give_the_commands_of_the_table() {
        assert_eq!(given(egui::Key::W, Modifiers::NONE), Some(Command::ToolMove));
        assert_eq!(given(egui::Key::Z, Modifiers::COMMAND), Some(Command::Undo));
        assert_eq!(given(egui::Key::Num1, Modifiers::ALT), Some(Command::DrawComposite));
        assert_eq!(given(egui::Key::Backslash, Modifiers::NONE), Some(Command::ToggleSnapping));
        assert_eq!(given(egui::Key::PageDown, Modifiers::NONE), Some(Command::DropToFloor));
        assert_eq!(command(&Event::Copy, &Bindings::default()).map(|(_, c)| c), Some(Command::Copy));
    }

    #[test]
    fn letters_are_left_to_text_but_saving_is_not() {
        let keys = |text: &str| text.parse::<Shortcut>().unwrap();
        assert!(!is_for_all(&keys("W")) && !is_for_all(&keys("Ctrl+C")) && !is_for_all(&keys("Delete")));
        assert!(is_for_all(&keys("Ctrl+S")) && is_for_all(&keys("F5")) && is_for_all(&keys("Ctrl+P")));
    }
}
