//! Files from outside: dropped on the window.

use std::path::PathBuf;

use eframe::egui::{Pos2, Ui};

use super::Editor;
use crate::assets::{Place, Wish};
use crate::tools::hit::Caster;
use crate::tools::surface;

/// Pictures that the mouse is waited for after a drop.
const PATIENCE: u32 = 30;

impl Editor {
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
