//! What goes on beside the editing: bakes, recovery files, files that others change.

use std::time::Instant;

use bake::Settings;
use eframe::egui::{Panel, Ui};

use super::Editor;
use crate::baking::Badge;
use crate::command::Command;
use crate::document::Event;
use crate::icons::{self, Icon};
use crate::intents::Session;
use crate::log::Source;
use crate::scenery::AsBaked;
use crate::theme;
use crate::watch::Changed;

impl Editor {
    /// With every picture. Waits for nothing.
    pub(super) fn beside(&mut self, ui: &Ui) {
        for event in self.session.document.tick(Instant::now()) {
            self.tell(event);
        }
        self.take_bake();
        self.files.pivot = self.scene.camera.pivot;
        if self.files.follow(&mut self.session.document) {
            self.follow_renames(ui.ctx());
        }
        self.take_files(ui);
        if !matches!(self.baking.badge(&self.session.document), Badge::Current | Badge::LightOnly) {
            self.baking.compare(&self.session.document, &self.assets);
        }
        let wait = if self.baking.progress().is_some() { 100 } else { 1000 };
        ui.ctx().request_repaint_after(std::time::Duration::from_millis(wait));
    }

    fn tell(&mut self, event: Event) {
        let Session { document, log, .. } = &self.session;
        match event {
            Event::Saved(Ok(())) => {
                self.is_outdated = false;
                log.info(format!("Saved {}", document.path().display()));
            }
            Event::Saved(Err(error)) => log.error(Source::File(document.path()), bake::chain::told(&error)),
            Event::Reloaded(Ok(())) => {
                self.is_outdated = false;
                log.info(format!("Reloaded {}", document.path().display()));
            }
            Event::Reloaded(Err(error)) => log.scene_error(&error, document.scene()),
            Event::NotRecoverable(error) | Event::NotNoted(error) => {
                log.scene_error(&error, document.scene())
            }
            Event::SceneChanged(Changed::Written | Changed::New) => {
                self.is_outdated = true;
                log.warning(Source::File(document.path()), "Another program has written the scene's file");
            }
            Event::SceneChanged(Changed::Gone) => {
                log.warning(
                    Source::File(document.path()),
                    "The scene's file is gone: saving writes it again",
                );
            }
            Event::AssetChanged(path, change) => self.asset_changed(&path, change),
        }
    }

    /// Another program wrote the scene's file: whose is it to be?
    pub(super) fn outdated(&mut self, ui: &mut Ui) {
        if !self.is_outdated {
            return;
        }
        let bar = theme::bar(ui.style());
        let bar = Panel::top("outdated").exact_size(30.0).frame(bar).show_separator_line(false);
        let (reload, keep) = bar
            .show(ui, |ui| {
                ui.horizontal_centered(|ui| {
                    icons::label(ui, Icon::Warning, ui.visuals().warn_fg_color);
                    ui.label("Another program has written this scene's file.");
                    let reload = ui.button("Reload").on_hover_text("Undo brings your own back");
                    let keep = ui.button("Keep mine").on_hover_text("The next save replaces the file");
                    (reload.clicked(), keep.clicked())
                })
                .inner
            })
            .inner;
        if reload {
            self.session.document.reload_in_background();
        }
        if keep {
            self.session.document.keep_own();
            self.is_outdated = false;
        }
    }

    pub(crate) fn run_bake(&mut self, command: Command) {
        if command == Command::CancelBake {
            self.session.log.info("The bake stops");
            return self.baking.cancel();
        }
        match self.baking.start(&self.session.document, Settings::default()) {
            Ok(()) => self.session.log.info("Baking"),
            Err(error) => self.session.log.error(Source::Nothing, error),
        }
    }

    fn take_bake(&mut self) {
        let Some(ended) = self.baking.poll() else { return };
        let Session { document, log, .. } = &self.session;
        match ended {
            Ok(warnings) => {
                log.warnings(&warnings, document.scene());
                log.info("Baked");
                self.relight();
            }
            Err(error) => log.error(Source::Nothing, error),
        }
    }

    /// The light of the bake that has just ended.
    fn relight(&mut self) {
        let Some(transport) = self.baking.transport().cloned() else { return };
        let Session { document, log, .. } = &self.session;
        if let Err(error) = self.stage.relight(transport.clone(), &self.assets) {
            return log.error(Source::Nothing, error.to_string());
        }
        self.baked = AsBaked::of(document.scene(), &self.assets, &transport);
        self.placed.forget();
        self.scene.picture.forget();
        self.game.picture.forget();
    }
}
