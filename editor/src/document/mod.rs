//! The document: one scene that is being authored, and the one door through which edits reach it.
//!
//! Every edit is checked ([`engine::scene::Scene::validate`]) before it becomes a step of the history: what a scene
//! file could not hold is refused, and the scene stays as it was. A drag is many previews and one step.

mod disk;
mod file;
mod notes;
mod tick;

use std::path::{Path, PathBuf};

use engine::scene::{Entity, EntityId, Material, MaterialId, Scene, SceneError};
use glam::DAffine3;

use crate::edit::{Edit, IndexedScene, Stale};
use crate::history::{History, Step};
use crate::recovery::Recovery;
use crate::watch::Stamp;
use disk::Disk;
pub use file::{SaveError, is_name};
use notes::Notes;
pub use tick::Event;

pub struct Document {
    project: PathBuf,
    name: String,
    scene: IndexedScene,
    history: History,
    drag: Option<Drag>,
    /// The state that the scene is in; one that was seen before has the number it had.
    state: u64,
    /// The highest number given.
    last_state: u64,
    saved_state: Option<u64>,
    revisions: Revisions,
    /// Ids below it were given, perhaps to what is gone: they are never given again.
    next_entity: u64,
    next_material: u32,
    refused: Option<SceneError>,
    /// Of the scene's file, as it was read or written last.
    stamp: Option<Stamp>,
    notes: Notes,
    /// As they are on disk.
    written_notes: Notes,
    recovery: Option<Recovery>,
    disk: Option<Disk>,
    clock: tick::Clock,
    saving: bool,
    /// Asked for while a save went on.
    save_again: bool,
    events: Vec<Event>,
}

/// Between the first preview and the end of a drag.
struct Drag {
    name: String,
    /// What undoes the preview that is shown.
    back: Option<(Edit, Stale)>,
}

/// Counts of changes: the latest of all, and the latest that was as dear as light or transport.
#[derive(Clone, Copy, Debug, Default)]
struct Revisions {
    any: u64,
    light: u64,
    transport: u64,
}

impl Revisions {
    fn count(&mut self, stale: Stale) {
        self.any += 1;
        if stale >= Stale::Light {
            self.light = self.any;
        }
        if stale >= Stale::Transport {
            self.transport = self.any;
        }
    }
}

impl Document {
    /// A document of this scene, which is as its file says.
    fn new(project: &Path, name: &str, scene: Scene, stamp: Option<Stamp>, notes: Notes) -> Self {
        let next_entity = scene.free_entity_id().0.max(notes.next_entity);
        let next_material = scene.materials.iter().map(|material| material.id.0 + 1).max().unwrap_or(1);
        Self {
            project: project.to_owned(),
            name: name.to_owned(),
            scene: IndexedScene::new(scene),
            history: History::default(),
            drag: None,
            state: 0,
            last_state: 0,
            saved_state: Some(0),
            revisions: Revisions::default(),
            next_entity,
            next_material,
            refused: None,
            stamp,
            written_notes: notes.clone(),
            notes,
            recovery: None,
            disk: None,
            clock: tick::Clock::default(),
            saving: false,
            save_again: false,
            events: Vec::new(),
        }
    }

    pub fn scene(&self) -> &Scene {
        self.scene.scene()
    }

    /// With what finds its entities: what builders of edits ask for.
    pub fn indexed(&self) -> &IndexedScene {
        &self.scene
    }

    pub fn project(&self) -> &Path {
        &self.project
    }

    /// Of the scene.
    pub fn name(&self) -> &str {
        &self.name
    }

    pub fn entity(&self, id: EntityId) -> Option<&Entity> {
        self.scene.entity(id)
    }

    pub fn material(&self, id: MaterialId) -> Option<&Material> {
        self.scene.material(id)
    }

    /// In the order of the hierarchy. `None`: the roots.
    pub fn children(&self, parent: Option<EntityId>) -> &[EntityId] {
        self.scene.children(parent)
    }

    pub fn world_from_local(&self, id: EntityId) -> DAffine3 {
        self.scene.world_from_local(id)
    }

    /// Not to be picked in the scene view. The scene's file does not hold it, and undo leaves it alone.
    pub fn is_locked(&self, id: EntityId) -> bool {
        self.notes.locked.contains(&id)
    }

    pub fn set_locked(&mut self, ids: &[EntityId], locked: bool) {
        for &id in ids {
            let _ = if locked { self.notes.locked.insert(id) } else { self.notes.locked.remove(&id) };
        }
        self.write_notes();
    }

    /// An id that no entity has or had.
    pub fn new_entity_id(&mut self) -> EntityId {
        self.next_entity += 1;
        EntityId(self.next_entity - 1)
    }

    /// Gives ids as [`Self::new_entity_id`] does, while the scene is read. Those that no edit takes are given again.
    pub fn id_giver(&self) -> impl FnMut() -> EntityId + use<> {
        let mut next = self.next_entity;
        move || {
            next += 1;
            EntityId(next - 1)
        }
    }

    pub fn new_material_id(&mut self) -> MaterialId {
        self.next_material += 1;
        MaterialId(self.next_material - 1)
    }

    /// Applies the edit as one step, which undo takes back. What would make the scene one that no file may hold is
    /// refused: the error says why, and nothing has changed. A drag that was going on ends first.
    pub fn commit(&mut self, edit: Edit) -> Result<(), SceneError> {
        self.end()?;
        let name = edit.name(&self.scene);
        let (back, stale) = self.apply(edit);
        self.keep(name, back, stale)
    }

    /// A drag begins: previews follow, and then [`Self::end`] or [`Self::cancel`].
    pub fn begin(&mut self, name: impl Into<String>) {
        self.settle();
        self.drag = Some(Drag { name: name.into(), back: None });
    }

    /// Shows the scene with this edit applied to what it was when the drag began: each preview replaces the one
    /// before. Without a drag it begins one of its own name.
    pub fn preview(&mut self, edit: Edit) {
        if self.drag.is_none() {
            self.begin(edit.name(&self.scene));
        }
        self.take_back();
        let applied = self.apply(edit);
        if let Some(drag) = &mut self.drag {
            drag.back = Some(applied);
        }
    }

    pub fn is_dragging(&self) -> bool {
        self.drag.is_some()
    }

    /// The last preview becomes one step, unless it changed nothing.
    pub fn end(&mut self) -> Result<(), SceneError> {
        match self.drag.take() {
            Some(Drag { name, back: Some((back, stale)) }) => self.keep(name, back, stale),
            _ => Ok(()),
        }
    }

    /// Ends a drag that somebody left open; why its result was refused waits for [`Self::take_refused`].
    fn settle(&mut self) {
        if let Err(error) = self.end() {
            self.refused = Some(error);
        }
    }

    /// Why the last drag that was not ended by itself was taken back, told once.
    pub fn take_refused(&mut self) -> Option<SceneError> {
        self.refused.take()
    }

    /// The scene is as it was when the drag began.
    pub fn cancel(&mut self) {
        self.take_back();
        self.drag = None;
    }

    fn take_back(&mut self) {
        if let Some((back, _)) = self.drag.as_mut().and_then(|drag| drag.back.take()) {
            self.apply(back);
        }
    }

    /// Undoes a step and tells its name. A drag that is going on is the step.
    pub fn undo(&mut self) -> Option<String> {
        self.settle();
        let step = self.history.pop_undo()?;
        let (redo, name) = self.travel(step);
        self.history.push_redo(redo);
        Some(name)
    }

    pub fn redo(&mut self) -> Option<String> {
        self.settle();
        let step = self.history.pop_redo()?;
        let (undo, name) = self.travel(step);
        self.history.push_undo(undo);
        Some(name)
    }

    /// Goes a step, and gives the step back.
    fn travel(&mut self, step: Step) -> (Step, String) {
        let here = self.state;
        let (back, _) = self.apply(step.edit);
        // What it costs is the same in both directions.
        self.revisions.count(step.stale);
        self.state = step.leads_to;
        (Step::new(step.name.clone(), back, step.stale, here), step.name)
    }

    pub fn can_undo(&self) -> bool {
        self.history.undo_names().next().is_some() || self.is_dragging()
    }

    pub fn can_redo(&self) -> bool {
        self.history.redo_names().next().is_some()
    }

    /// Names of steps, bytes that they hold, and how many had to go.
    pub fn history(&self) -> &History {
        &self.history
    }

    /// Bytes that undo may hold, for who tests it or has little memory.
    pub fn limit_history(&mut self, budget: usize) {
        self.history = History::within(budget);
    }

    /// Differs from what its file holds.
    pub fn is_dirty(&self) -> bool {
        self.state().is_none() || self.saved_state != Some(self.state)
    }

    /// The state that the scene is in: the same number again means the same scene. `None`: a preview is shown.
    pub fn state(&self) -> Option<u64> {
        let is_previewed = self.drag.as_ref().is_some_and(|drag| drag.back.is_some());
        (!is_previewed).then_some(self.state)
    }

    /// Counts every change, previews and undo too.
    pub fn revision(&self) -> u64 {
        self.revisions.any
    }

    /// What does not hold any more since the document had this revision.
    pub fn stale_since(&self, revision: u64) -> Stale {
        match self.revisions {
            revisions if revisions.transport > revision => Stale::Transport,
            revisions if revisions.light > revision => Stale::Light,
            _ => Stale::Nothing,
        }
    }

    fn apply(&mut self, edit: Edit) -> (Edit, Stale) {
        let applied = edit.apply(&mut self.scene);
        self.revisions.count(if applied.back.is_empty() { Stale::Nothing } else { applied.stale });
        (applied.back, applied.stale)
    }

    /// What has been applied becomes a step, or is taken back.
    fn keep(&mut self, name: String, back: Edit, stale: Stale) -> Result<(), SceneError> {
        if back.is_empty() {
            return Ok(());
        }
        if let Err(error) = self.scene().validate() {
            self.apply(back);
            return Err(error);
        }
        self.history.push(Step::new(name, back, stale, self.state));
        self.last_state += 1;
        self.state = self.last_state;
        self.claim_ids();
        Ok(())
    }

    /// Ids that an edit brought are not given again either.
    fn claim_ids(&mut self) {
        let scene = self.scene.scene();
        self.next_entity = self.next_entity.max(scene.free_entity_id().0);
        let above = scene.materials.iter().map(|material| material.id.0 + 1).max().unwrap_or(1);
        self.next_material = self.next_material.max(above);
    }
}

#[cfg(test)]
mod tests;
