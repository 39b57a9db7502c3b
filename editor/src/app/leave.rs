//! Leaving a document: for another project, or for good. What is not saved is asked about first.

use std::path::PathBuf;
use std::sync::mpsc;

use eframe::egui;
use egui::{Modal, RichText, Ui, ViewportCommand};

use super::Editor;
use crate::baking::Baking;
use crate::intents::Session;
use crate::log::Source;
use crate::opened::Opened;
use crate::panels::game::GameView;
use crate::panels::hierarchy::Hierarchy;
use crate::panels::scene::SceneView;
use crate::scenery::{AsBaked, Placed};
use crate::viewport::Stage;

/// What comes after the document is left.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Then {
    Quit,
    Open(PathBuf),
}

impl Editor {
    pub(crate) fn ask_for_project(&mut self) {
        self.open.open(&self.preferences);
    }

    pub(super) fn dialogs(&mut self, ui: &mut Ui) {
        let wants_to_close = ui.input(|input| input.viewport().close_requested());
        if wants_to_close && self.session.document.is_dirty() && self.leaving != Some(Then::Quit) {
            ui.ctx().send_viewport_cmd(ViewportCommand::CancelClose);
            self.leaving = Some(Then::Quit);
        }
        if let Some(project) = self.open.show(ui) {
            if self.session.document.is_dirty() {
                self.leaving = Some(Then::Open(project));
            } else {
                self.load(project);
            }
        }
        self.files.show_dialog(ui, &self.session.document, &mut self.asks);
        self.confirm(ui);
        self.offer_recovery(ui);
        self.take_loaded(ui);
    }

    /// What was not saved when the editor ended last.
    fn offer_recovery(&mut self, ui: &Ui) {
        let document = &mut self.session.document;
        if document.recovery().is_none() {
            return;
        }
        let mut answer = None;
        Modal::new(egui::Id::unique("recovery")).show(ui.ctx(), |ui| {
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
        let Some(then) = self.leaving.clone() else { return };
        let mut answer = None;
        let modal = Modal::new(egui::Id::unique("unsaved")).show(ui.ctx(), |ui| {
            ui.set_width(360.0);
            ui.label(RichText::new(format!("Save `{}` first?", self.session.document.name())).heading());
            ui.add_space(6.0);
            ui.label("It has changes that are not saved.");
            ui.add_space(12.0);
            answer = choice(ui, &["Save", "Discard", "Cancel"]);
        });
        match answer {
            Some("Save") => {
                // What comes next needs to know whether it is on disk.
                match self.session.document.save() {
                    Ok(()) => self.leave(then, ui),
                    Err(error) => {
                        self.leaving = None;
                        self.session.log.error(Source::Nothing, bake::chain::told(&error));
                    }
                }
            }
            Some("Discard") => self.leave(then, ui),
            Some(_) => self.leaving = None,
            None if modal.should_close() => self.leaving = None,
            None => {}
        }
    }

    fn leave(&mut self, then: Then, ui: &Ui) {
        match then {
            // Stays what it is, so that the window is not asked about again.
            Then::Quit => {
                // Chosen: what is not saved is not kept for the next start either.
                self.session.document.discard_recovery();
                self.leaving = Some(Then::Quit);
                ui.ctx().send_viewport_cmd(ViewportCommand::Close);
            }
            Then::Open(project) => {
                self.leaving = None;
                self.load(project);
            }
        }
    }

    /// On a thread of its own: files are read, and a bake may be large.
    fn load(&mut self, project: PathBuf) {
        let (sender, receiver) = mpsc::channel();
        self.session.log.info(format!("Opening {}", project.display()));
        self.loading = Some(receiver);
        std::thread::spawn(move || {
            let opened = Opened::load(&project, None).map_err(|error| bake::chain::told(&error));
            // Nobody waits any more where the editor is gone.
            let _ = sender.send(opened);
        });
    }

    fn take_loaded(&mut self, ui: &Ui) {
        let Some(receiver) = &self.loading else { return };
        match receiver.try_recv() {
            Ok(Ok(opened)) => self.replace(opened, ui),
            Ok(Err(error)) => self.session.log.error(Source::Nothing, error),
            Err(mpsc::TryRecvError::Empty) => {
                return ui.ctx().request_repaint_after(std::time::Duration::from_millis(50));
            }
            Err(mpsc::TryRecvError::Disconnected) => {
                self.session.log.error(Source::Nothing, "the project could not be opened: see the terminal");
            }
        }
        self.loading = None;
    }

    fn replace(&mut self, opened: Opened, ui: &Ui) {
        let Opened { document, assets, shown, baked, cubemaps, settings, features, warnings } = opened;
        match Stage::new(&self.state, shown.clone(), &assets, (settings, features)) {
            Ok(stage) => self.stage = stage,
            Err(error) => return self.session.log.error(Source::Nothing, error.to_string()),
        }
        self.stage.renderer.give_cubemaps(cubemaps);
        self.baked = AsBaked::of(document.scene(), &assets, &shown);
        self.baking = Baking::default();
        baked.into_iter().for_each(|baked| self.baking.show(baked));
        let log = self.session.log.clone();
        log.warnings(&warnings, document.scene());
        let left = std::mem::replace(&mut self.session, Session::new(document, log));
        left.document.close();
        self.assets = assets;
        (self.play, self.placed) = (None, Placed::default());
        self.hierarchy = Hierarchy::default();
        self.bring = Default::default();
        let handling = self.scene.handling;
        (self.scene, self.game) = (SceneView::default(), GameView::default());
        self.scene.handling = handling;
        self.arrived(ui.ctx());
    }
}

/// A row of buttons, and which was pressed.
fn choice(ui: &mut Ui, names: &[&'static str]) -> Option<&'static str> {
    let button =
        |ui: &mut Ui, name: &str| ui.add(egui::Button::new(name).min_size(egui::vec2(84.0, 24.0))).clicked();
    ui.horizontal(|ui| names.iter().copied().filter(|name| button(ui, name)).last()).inner
}
