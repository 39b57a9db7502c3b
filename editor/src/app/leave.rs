//! Leaving a document: for another one, or for good. What is not saved is asked about first.

use std::time::Duration;

use eframe::egui;
use egui::{RichText, Ui, ViewportCommand};

use super::Editor;
use crate::command::Command;
use crate::opened::Wanted;
use crate::panels::files::Chosen;
use crate::theme;

/// What comes after the document is left.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Then {
    Quit,
    Open(Wanted),
}

/// How far leaving has come.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Leaving {
    then: Then,
    answer: Answer,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Answer {
    Awaited,
    /// What comes next waits until it is on disk.
    Saving,
    /// The window closes, and is not asked about again.
    Given,
}

impl Editor {
    pub(crate) fn ask_for_file(&mut self, question: Command) {
        let document = &self.session.document;
        self.asking.ask(question, &self.preferences, document.project(), document.name());
    }

    /// Something is asked: keys give no commands.
    pub(super) fn is_asking(&self) -> bool {
        let is_offered = self.session.document.recovery().is_some();
        self.leaving.is_some()
            || self.opening.is_some()
            || self.asking.is_open()
            || self.settings.is_open()
            || is_offered
    }

    pub(super) fn dialogs(&mut self, ui: &mut Ui) {
        let wants_to_close = ui.input(|input| input.viewport().close_requested());
        let is_given = self.leaving.as_ref().is_some_and(|leaving| leaving.answer == Answer::Given);
        if wants_to_close && self.session.document.is_dirty() && !is_given {
            ui.ctx().send_viewport_cmd(ViewportCommand::CancelClose);
            self.leaving = Some(Leaving { then: Then::Quit, answer: Answer::Awaited });
        }
        if let Some(chosen) = self.asking.show(ui) {
            self.chosen(chosen);
        }
        self.files.show_dialog(ui, &self.session.document, &mut self.asks);
        self.settings(ui);
        self.confirm(ui);
        self.offer_recovery(ui);
        self.open(ui);
    }

    fn chosen(&mut self, chosen: Chosen) {
        let document = &mut self.session.document;
        let project = document.project().to_owned();
        let wanted = match chosen {
            Chosen::SaveAs(name) => return document.save_as_in_background(&name),
            Chosen::Project(project) => Wanted::Open { project, scene: None },
            Chosen::NewProject(project) => Wanted::NewProject(project),
            Chosen::Scene(name) => Wanted::Open { project, scene: Some(name) },
            Chosen::NewScene(name) => Wanted::NewScene { project, name },
        };
        if document.is_dirty() {
            self.leaving = Some(Leaving { then: Then::Open(wanted), answer: Answer::Awaited });
        } else {
            self.load(wanted);
        }
    }

    fn settings(&mut self, ui: &Ui) {
        if self.settings.show(ui, &mut self.preferences, &mut self.bindings) {
            self.preferences.shortcuts = self.bindings.to_preferences();
            self.apply_preferences(ui.ctx());
        }
    }

    /// What was not saved when the editor ended last.
    fn offer_recovery(&mut self, ui: &Ui) {
        let document = &mut self.session.document;
        if document.recovery().is_none() {
            return;
        }
        let mut answer = None;
        theme::dialog(ui, "recovery").show(ui.ctx(), |ui| {
            ui.set_width(380.0);
            ui.label(RichText::new("Unsaved work was found").heading());
            ui.add_space(6.0);
            ui.label(format!(
                "The editor ended before `{}` was saved. What it kept can be taken over.",
                document.name()
            ));
            ui.add_space(12.0);
            answer = choice(ui, &["Recover", "Discard"]);
        });
        match answer {
            Some("Recover") => {
                if let Err(error) = document.recover() {
                    self.session.log.scene_error(&error, self.session.document.scene());
                }
            }
            Some(_) => document.discard_recovery(),
            None => {}
        }
    }

    fn confirm(&mut self, ui: &Ui) {
        let Some(Leaving { then, answer }) = self.leaving.clone() else { return };
        match answer {
            Answer::Awaited => {}
            Answer::Given => return,
            Answer::Saving if self.session.document.is_saving() => {
                return ui.ctx().request_repaint_after(Duration::from_millis(20));
            }
            // Told in the console; what was to come does not.
            Answer::Saving if self.session.document.is_dirty() => return self.leaving = None,
            Answer::Saving => return self.leave(then, ui),
        }
        let mut answer = None;
        let modal = theme::dialog(ui, "unsaved").show(ui.ctx(), |ui| {
            ui.set_width(360.0);
            ui.label(RichText::new(format!("Save `{}` first?", self.session.document.name())).heading());
            ui.add_space(6.0);
            ui.label("It has changes that are not saved.");
            ui.add_space(12.0);
            answer = choice(ui, &["Save", "Discard", "Cancel"]);
        });
        match answer {
            Some("Save") => {
                self.session.document.save_in_background();
                self.leaving = Some(Leaving { then, answer: Answer::Saving });
            }
            Some("Discard") => self.leave(then, ui),
            Some(_) => self.leaving = None,
            None if modal.should_close() => self.leaving = None,
            None => {}
        }
    }

    fn leave(&mut self, then: Then, ui: &Ui) {
        match then {
            Then::Quit => {
                self.session.document.give_up();
                self.leaving = Some(Leaving { then, answer: Answer::Given });
                ui.ctx().send_viewport_cmd(ViewportCommand::Close);
            }
            Then::Open(wanted) => {
                self.leaving = None;
                self.load(wanted);
            }
        }
    }
}

/// A row of buttons, and which was pressed.
fn choice(ui: &mut Ui, names: &[&'static str]) -> Option<&'static str> {
    let button =
        |ui: &mut Ui, name: &str| ui.add(egui::Button::new(name).min_size(egui::vec2(84.0, 24.0))).clicked();
    ui.horizontal(|ui| names.iter().copied().filter(|name| button(ui, name)).last()).inner
}
