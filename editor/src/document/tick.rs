//! What the document does by itself while it is open: a recovery file every minute, a look at its files every second.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use engine::scene::SceneError;

use super::disk::{Disk, Done, Work};
use super::{Document, SaveError};
use crate::recovery;
use crate::watch::Changed;

/// From one look at the files to the next.
const LOOK_EVERY: Duration = Duration::from_secs(1);

/// What happened beside the editing, to be told.
#[derive(Debug)]
pub enum Event {
    /// A save in the background ended.
    Saved(Result<(), SaveError>),
    /// The scene's file was read again.
    Reloaded(Result<(), SceneError>),
    /// What is not saved is not kept for a crash either.
    NotRecoverable(SceneError),
    /// The editor's notes (locks) were not written.
    NotNoted(SceneError),
    /// The scene's own file is another than it was: offer to reload it.
    SceneChanged(Changed),
    /// A file that the scene refers to.
    AssetChanged(PathBuf, Changed),
}

/// When what was done last.
#[derive(Debug, Default)]
pub struct Clock {
    looked: Option<Instant>,
    /// When something was first not kept, and the revision that was kept last.
    unkept_since: Option<Instant>,
    kept_revision: u64,
    /// Files that are followed, as they were named last.
    followed: Vec<PathBuf>,
}

impl Document {
    /// To be called with every picture. Waits for nothing.
    pub fn tick(&mut self, now: Instant) -> Vec<Event> {
        self.keep_for_recovery(now);
        self.look(now);
        for done in self.disk.as_ref().map(Disk::done).unwrap_or_default() {
            self.take_done(done);
        }
        std::mem::take(&mut self.events)
    }

    /// Files besides the scene's own whose changes are to be told, relative to the project.
    pub fn follow(&mut self, assets: impl IntoIterator<Item = String>) {
        let project = &self.project;
        let assets = assets.into_iter().map(|file| project.join(file));
        let files: Vec<PathBuf> = std::iter::once(self.path()).chain(assets).collect();
        if files != self.clock.followed {
            self.clock.followed.clone_from(&files);
            let scene = self.stamp.clone();
            self.disk().ask(Work::Follow { files, scene });
        }
    }

    /// A save in the background goes on.
    pub fn is_saving(&self) -> bool {
        self.saving
    }

    /// Waits until it is done.
    pub(super) fn finish_saving(&mut self) {
        while self.saving {
            match self.disk.as_ref().and_then(Disk::next) {
                Some(done) => self.take_done(done),
                None => self.saving = false, // its thread is gone
            }
        }
    }

    pub(super) fn disk(&mut self) -> &Disk {
        self.disk.get_or_insert_with(Disk::start)
    }

    fn keep_for_recovery(&mut self, now: Instant) {
        if !self.is_dirty() || self.revision() == self.clock.kept_revision {
            self.clock.unkept_since = None;
            return;
        }
        let since = *self.clock.unkept_since.get_or_insert(now);
        // What is in a hand is not kept: a drag may be nothing that a file can hold.
        if now.duration_since(since) >= recovery::EVERY && !self.is_dragging() {
            self.clock.unkept_since = None;
            self.clock.kept_revision = self.revision();
            let scene = Box::new(self.scene().clone());
            let work = Work::Recovery { project: self.project.clone(), name: self.name.clone(), scene };
            self.disk().ask(work);
        }
    }

    fn look(&mut self, now: Instant) {
        if self.clock.looked.is_some_and(|looked| now.duration_since(looked) < LOOK_EVERY) {
            return;
        }
        if self.clock.followed.first() != Some(&self.path()) {
            self.follow([]);
        }
        self.clock.looked = Some(now);
        self.disk().ask(Work::Look);
    }

    fn take_done(&mut self, done: Done) {
        match done {
            Done::Saved { state, stamp } => {
                self.saving = false;
                let result = stamp.map(|stamp| self.saved(state, stamp));
                self.events.push(Event::Saved(result));
                if std::mem::take(&mut self.save_again) {
                    self.save_in_background();
                }
            }
            Done::SavedAs { name, state, stamp } => {
                self.saving = false;
                let result = stamp.map(|stamp| {
                    self.renamed(&name);
                    self.saved(state, stamp);
                });
                self.events.push(Event::Saved(result));
            }
            Done::Read(read) => {
                let result = read.and_then(|(scene, stamp)| self.reloaded(*scene, stamp));
                self.events.push(Event::Reloaded(result));
            }
            Done::Recovery(Ok(())) => {}
            Done::Recovery(Err(error)) => self.events.push(Event::NotRecoverable(error)),
            Done::Notes(error) => self.events.push(Event::NotNoted(error)),
            Done::Changed(changes) => changes.into_iter().for_each(|(path, change)| self.tell(path, change)),
        }
    }

    /// What this document wrote itself is no change.
    fn tell(&mut self, path: PathBuf, change: Changed) {
        if path != self.path() {
            return self.events.push(Event::AssetChanged(path, change));
        }
        if self.changed_outside().is_some() {
            self.events.push(Event::SceneChanged(change));
        }
    }
}
