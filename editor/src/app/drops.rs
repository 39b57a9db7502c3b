//! Files from outside: chosen in the desktop's dialog, or dropped on the window.

use std::path::PathBuf;
use std::sync::mpsc;

use eframe::egui::{Context, Pos2, Ui};

use super::Editor;
use crate::assets::{Place, Wish};
use crate::importing::Then;
use crate::panels::assets::reads_models;
use crate::tools::hit::Caster;
use crate::tools::surface;

/// Pictures that the mouse is waited for after a drop.
const PATIENCE: u32 = 30;

impl Editor {
    pub(super) fn browse(&mut self, ctx: &Context) {
        let (sender, receiver) = mpsc::channel();
        let ctx = ctx.clone();
        self.bring.browsing = Some(receiver);
        std::thread::spawn(move || {
            let dialog = rfd::FileDialog::new()
                .set_title("Import")
                .add_filter("Models and pictures", &ENDINGS)
                .add_filter("All files", &["*"]);
            // Nobody waits any more where the editor is gone.
            let _ = sender.send(dialog.pick_files().unwrap_or_default());
            ctx.request_repaint();
        });
    }

    pub(super) fn take_browsed(&mut self) {
        let Some(browsing) = &self.bring.browsing else { return };
        match browsing.try_recv() {
            Err(mpsc::TryRecvError::Empty) => return,
            Ok(sources) if reads_models(&sources) => self.files.ask_how(sources),
            Ok(sources) => sources.into_iter().for_each(|source| self.import(source, None, Then::Keep)),
            Err(mpsc::TryRecvError::Disconnected) => {}
        }
        self.bring.browsing = None;
    }

    /// Files from the desktop: into the scene where the mouse is over it, else into the project.
    pub(super) fn take_dropped(&mut self, ui: &Ui) {
        let (new, at) = ui.input(|input| {
            let files = input.raw.dropped_files.iter().map(|file| file.path().to_owned());
            (files.collect::<Vec<PathBuf>>(), input.pointer.latest_pos())
        });
        if !new.is_empty() {
            self.bring.dropped = Some((new, 0));
        }
        let Some((sources, waited)) = self.bring.dropped.take() else { return };
        if at.is_none() && waited < PATIENCE {
            self.bring.dropped = Some((sources, waited + 1));
            return ui.ctx().request_repaint();
        }
        let place = at.and_then(|at| self.place_under(at));
        self.wish(Wish::Bring { sources, settings: None, place }, ui);
    }

    /// Where a point of the scene view leads. `None`: it is not in the scene view.
    fn place_under(&self, at: Pos2) -> Option<Place> {
        let lens = self.scene.lens.filter(|lens| lens.rect.contains(at))?;
        let far = self.scene.camera.pivot.distance(lens.eye.position);
        let ray = lens.ray(at);
        let hit = Caster::default().cast(&self.scenery(), &ray, |_| true);
        Some(Place::At(surface::place(hit.as_ref(), &ray, far)))
    }
}

/// Dialogs tell large letters from small ones.
const ENDINGS: [&str; 18] = [
    "gltf", "glb", "obj", "png", "jpg", "jpeg", "hdr", "bmp", "tga", "GLTF", "GLB", "OBJ", "PNG", "JPG",
    "JPEG", "HDR", "BMP", "TGA",
];
