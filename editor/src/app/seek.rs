//! What panels asked for, done in the order in which it was asked. What a click met is the GPU's to say, and what was asked
//! after the click (Delete, say) waits until that is known, as it may be about it; pictures go on meanwhile.

use std::collections::HashSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use eframe::egui::Ui;
use engine::render::View;
use engine::render::picking::Sought;
use engine::scene::EntityId;

use super::Editor;
use crate::ask::Ask;
use crate::intents::Intent;
use crate::layout;
use crate::log::Source;
use crate::panels::scene::pick::{Pick, What, joined};
use crate::scenery::Scenery;

/// A list of what lies under the mouse is no longer.
const MOST: usize = 24;

/// A question on its way.
pub(super) struct Seeking {
    pick: Pick,
    /// Nearer, and found before.
    through: Vec<EntityId>,
    sent: Sent,
}

enum Sent {
    /// Not yet: what was drawn before is not done. Whoever submits to a driver that draws on the processor waits for that.
    Behind(Arc<AtomicBool>),
    /// To the GPU.
    Asked(Sought),
}

impl Editor {
    pub(super) fn do_what_was_asked(&mut self, ui: &Ui) {
        let asked = self.asks.take();
        if !asked.is_empty() {
            ui.ctx().request_repaint();
        }
        self.due.extend(asked);
        self.go_on(ui);
    }

    fn go_on(&mut self, ui: &Ui) {
        while self.seeking.is_none()
            && let Some(ask) = self.due.pop_front()
        {
            match ask {
                Ask::Intent(intent) => self.carry_out(intent, ui),
                Ask::Run(command) => self.run(command, ui),
                Ask::Files(wish) => self.wish(wish, ui),
                Ask::Frame(ids) => self.frame(&ids),
                Ask::Fit(ids) => self.fit(&ids),
                Ask::Close(pane) => layout::close(&mut self.layout, pane),
                Ask::Pick(pick) => {
                    let through = self.scene.choosing.through(&pick);
                    self.go_through(*pick, through, ui);
                }
            }
        }
        if self.seeking.is_some() {
            ui.ctx().request_repaint();
        }
    }

    /// Takes what has come back. With every picture; waits for nothing.
    pub(super) fn take_sought(&mut self, ui: &Ui) {
        while let Some(seeking) = self.seeking.take() {
            let Seeking { pick, through, sent } = seeking;
            match self.answer(&pick, &through, sent) {
                Ok(found) => self.found(pick, through, &found, ui),
                Err(sent) => {
                    self.seeking = Some(Seeking { pick, through, sent });
                    break;
                }
            }
        }
        self.go_on(ui);
    }

    /// A question waits for what was drawn before it.
    pub fn is_behind(&self) -> bool {
        matches!(self.seeking, Some(Seeking { sent: Sent::Behind(_), .. }))
    }

    /// A click is not answered yet, or what was asked after it is not done.
    pub fn is_seeking(&self) -> bool {
        self.seeking.is_some() || !self.due.is_empty()
    }

    /// An icon is met at once; for surfaces the GPU is asked.
    fn go_through(&mut self, pick: Pick, through: Vec<EntityId>, ui: &Ui) {
        if let Some(icon) = pick.icon(&through) {
            return self.found(pick, through, &[icon], ui);
        }
        let behind = Sent::Behind(self.stage.renderer.drawn());
        match self.answer(&pick, &through, behind) {
            Ok(found) => self.found(pick, through, &found, ui),
            Err(sent) => self.seeking = Some(Seeking { pick, through, sent }),
        }
    }

    /// What is seen; or how far the question is.
    fn answer(&mut self, pick: &Pick, through: &[EntityId], sent: Sent) -> Result<Vec<EntityId>, Sent> {
        let sought = match sent {
            Sent::Asked(sought) => sought,
            Sent::Behind(done) => {
                // What is wrong with the device is told by who draws.
                let is_lost = self.stage.gpu().look().is_err();
                if !is_lost && !done.load(Ordering::Acquire) {
                    return Err(Sent::Behind(done));
                }
                self.send(pick, through)
            }
        };
        match sought.take(self.stage.gpu()) {
            None => Err(Sent::Asked(sought)),
            Some(Ok(found)) => Ok(found),
            Some(Err(error)) => {
                let told = format!("what lies under the mouse is not known: {error}");
                self.session.log.error(Source::Nothing, told);
                Ok(Vec::new())
            }
        }
    }

    fn send(&mut self, pick: &Pick, through: &[EntityId]) -> Sought {
        self.placed.follow(&self.session.document, &self.assets, &self.baked);
        let document = &self.session.document;
        let scenery = Scenery::of(document, &self.assets, &self.placed, self.play.as_ref());
        let all = scenery.scene.entities.iter().map(|entity| entity.id);
        let locked = all.filter(|id| document.is_locked(*id));
        let without: HashSet<EntityId> = through.iter().copied().chain(locked).collect();
        let now = scenery.now(pick.eye, View::Composite);
        self.stage.renderer.seek(&now, pick.size, pick.pixels, &without)
    }

    /// What that means. What was deleted meanwhile is not selected.
    fn found(&mut self, pick: Pick, mut through: Vec<EntityId>, found: &[EntityId], ui: &Ui) {
        let first = found.first().copied();
        match pick.what {
            What::Area => {
                let all = found.iter().chain(&pick.icons).copied().collect();
                self.choose_found(&pick, all, ui);
            }
            // Through all of it, and from the first again.
            What::Click(_) if first.is_none() && !through.is_empty() => self.go_through(pick, Vec::new(), ui),
            What::Click(at) => {
                through.extend(first);
                self.scene.choosing.went_through(at, through);
                self.choose_found(&pick, first.into_iter().collect(), ui);
            }
            What::List(at) => {
                through.extend(first);
                let is_open = first.is_some() && self.scene.choosing.list(at, &through);
                if is_open && through.len() < MOST {
                    self.go_through(pick, through, ui);
                }
            }
        }
    }

    fn choose_found(&mut self, pick: &Pick, found: Vec<EntityId>, ui: &Ui) {
        let ids = joined(&self.session.selection, found, pick.modifiers);
        self.carry_out(Intent::Select(ids), ui);
    }
}
