//! The mouse over the scene view, as every tool of it sees it.

use eframe::egui;
use egui::{Key, Modifiers, Pos2, Response, Ui};

use super::Seen;
use crate::ask::Asks;
use crate::intents::Intent;
use crate::lens::Lens;

pub(super) struct Hand<'a> {
    pub ui: &'a Ui,
    pub response: &'a Response,
    pub lens: &'a Lens,
    pub seen: &'a Seen<'a>,
    pub at: Option<Pos2>,
    /// The left button went down on the picture in this moment.
    pub pressed: bool,
    pub down: bool,
    /// The mouse is on the picture and nothing lies over it.
    pub over: bool,
    pub modifiers: Modifiers,
}

impl<'a> Hand<'a> {
    /// `free`: neither the camera nor a bar has the mouse.
    pub fn new(ui: &'a Ui, response: &'a Response, lens: &'a Lens, seen: &'a Seen<'a>, free: bool) -> Self {
        let over = free && response.contains_pointer();
        ui.input(|input| {
            let pointer = &input.pointer;
            Self {
                ui,
                response,
                lens,
                seen,
                at: pointer.latest_pos(),
                pressed: pointer.primary_pressed() && over,
                down: pointer.primary_down(),
                over,
                modifiers: input.modifiers,
            }
        })
    }

    /// Not while text is typed.
    pub fn key(&self, key: Key) -> bool {
        !self.ui.ctx().text_edit_focused() && self.ui.input(|input| input.key_pressed(key))
    }

    /// Ends a drag that Escape gives up or the button lets go. Returns whether it is over.
    pub fn ends(&self, asks: &mut Asks) -> bool {
        let is_given_up = self.ui.input(|input| input.key_pressed(Key::Escape));
        if is_given_up || !self.down {
            asks.push(if is_given_up { Intent::Cancel } else { Intent::End });
        }
        is_given_up || !self.down
    }

    pub fn painter(&self) -> egui::Painter {
        self.ui.painter_at(self.lens.rect)
    }
}
