//! Opening another document: its files are read and its renderer is made on a thread of its own. What was open stays in
//! sight until then, and opening can be given up.

use std::path::PathBuf;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use eframe::egui;
use egui::{RichText, Ui};
use engine::gpu::Gpu;
use engine::play::world::placed_at;
use engine::render::Eye;
use glam::DVec3;

use super::Editor;
use crate::baking::Baking;
use crate::document::Document;
use crate::intents::Session;
use crate::job::Job;
use crate::log::Source;
use crate::opened::{Opened, Wanted};
use crate::panels::game::GameView;
use crate::panels::hierarchy::Hierarchy;
use crate::panels::scene::SceneView;
use crate::scenery::{AsBaked, Placed};
use crate::theme;
use crate::viewport::{Plan, Ready};

/// What is being opened.
pub(super) struct Opening {
    place: PathBuf,
    job: Job<Result<Box<Arrived>, String>>,
}

/// All that the window needs to show it at once.
struct Arrived {
    opened: Opened,
    ready: Ready,
    as_baked: AsBaked,
}

/// Documents that were left and still finish what they write; the editor does not end before them.
#[derive(Default)]
pub(super) struct Closing(Vec<JoinHandle<()>>);

impl Closing {
    fn close(&mut self, document: Document) {
        self.0.retain(|thread| !thread.is_finished());
        // Without a thread it is as if the editor had ended: what is not saved is kept to be recovered.
        let thread = std::thread::Builder::new().name("close".to_owned()).spawn(|| document.close());
        self.0.extend(thread);
    }
}

impl Drop for Closing {
    fn drop(&mut self) {
        self.0.drain(..).for_each(|thread| drop(thread.join()));
    }
}

impl Editor {
    pub(super) fn load(&mut self, wanted: Wanted) {
        let place = wanted.place();
        self.session.log.info(format!("Opening {}", place.display()));
        let gpu = self.stage.gpu().clone();
        match Job::start("open", move || arrive(&gpu, &wanted)) {
            Ok(job) => self.opening = Some(Opening { place, job }),
            Err(error) => self.session.log.error(Source::File(place), error.to_string()),
        }
    }

    /// A document is on its way.
    pub fn is_opening(&self) -> bool {
        self.opening.is_some()
    }

    pub(super) fn open(&mut self, ui: &Ui) {
        let Some(opening) = &mut self.opening else { return };
        let Some(ended) = opening.job.poll() else { return self.opening_sign(ui) };
        self.opening = None;
        match ended {
            Ok(Ok(arrived)) => self.replace(*arrived, ui),
            Ok(Err(error)) | Err(error) => self.session.log.error(Source::Nothing, error),
        }
        ui.ctx().request_repaint();
    }

    /// Nothing is edited that will be gone when the other is there.
    fn opening_sign(&mut self, ui: &Ui) {
        let Some(opening) = &self.opening else { return };
        let modal = theme::dialog(ui, "opening").show(ui.ctx(), |ui| {
            ui.set_width(380.0);
            ui.label(RichText::new("Opening").heading());
            ui.add_space(6.0);
            ui.horizontal(|ui| {
                ui.spinner();
                ui.label(opening.place.display().to_string());
            });
            ui.add_space(12.0);
            ui.button("Cancel").clicked()
        });
        if modal.inner || modal.should_close() {
            self.session.log.info(format!("Opening {} was given up", opening.place.display()));
            self.opening = None;
        }
        ui.ctx().request_repaint_after(Duration::from_millis(30));
    }

    fn replace(&mut self, arrived: Arrived, ui: &Ui) {
        let Arrived { opened, ready, as_baked } = arrived;
        let Opened { mut document, assets, baked, warnings, .. } = opened;
        self.stage.show(ready);
        self.baked = as_baked;
        self.baking = Baking::default();
        baked.into_iter().for_each(|baked| self.baking.show(baked));
        let log = self.session.log.clone();
        log.warnings(&warnings, document.scene());
        if document.path() == self.session.document.path() {
            // What was kept of it was given up a moment ago.
            document.discard_recovery();
        }
        let left = std::mem::replace(&mut self.session, Session::new(document, log));
        self.closing.close(left.document);
        (self.assets, self.is_outdated) = (assets, false);
        (self.play, self.placed) = (None, Placed::default());
        self.hierarchy = Hierarchy::default();
        self.bring = Default::default();
        (self.seeking, self.due) = (None, Default::default());
        let handling = self.scene.handling;
        (self.scene, self.game) = (SceneView::default(), GameView::default());
        self.scene.handling = handling;
        self.arrived(ui.ctx());
    }
}

/// On a thread of its own: files are written and read, a bake may be large, pipelines are made.
fn arrive(gpu: &Arc<Gpu>, wanted: &Wanted) -> Result<Box<Arrived>, String> {
    let mut opened = wanted.load()?;
    let (scene, assets, shown) = (opened.document.scene(), opened.assets.clone(), opened.shown.clone());
    let as_baked = AsBaked::of(scene, &assets, &shown);
    let (settings, features) = (opened.settings, opened.features.clone());
    let cubemaps = std::mem::take(&mut opened.cubemaps);
    let plan = Plan { transport: shown, assets: assets.clone(), settings, features, cubemaps };
    let plain = Eye::looking(DVec3::Z, DVec3::ZERO);
    let eye = Eye::of_scene(scene, &placed_at(scene, &assets, 0.0)).unwrap_or(plain);
    let ready = Ready::make(gpu, plan, scene, eye).map_err(|error| error.to_string())?;
    Ok(Box::new(Arrived { opened, ready, as_baked }))
}
