//! What panels want. A panel reads the document and writes intents; after all panels they are carried out here, and
//! nobody else touches the scene. What is refused is told in the log, once.

use engine::scene::{EntityId, Material, Warning};
use glam::DVec3;

use crate::clipboard;
use crate::document::Document;
use crate::edit::{Edit, Field, copies, tree};
use crate::log::{Log, Source};
use crate::primitives::{self, Primitive};
use crate::selection::{Click, Selection};

/// One wish, as data.
#[derive(Clone, Debug, PartialEq)]
pub enum Intent {
    Commit(Edit),
    /// A drag: begun, shown again and again, ended or given up.
    Begin(String),
    Preview(Edit),
    End,
    Cancel,
    Undo,
    Redo,
    Select(Vec<EntityId>),
    /// A click on one of those that are shown.
    Click {
        id: EntityId,
        how: Click,
        shown: Vec<EntityId>,
    },
    Create {
        primitive: Primitive,
        place: DVec3,
        /// 1: as a rule.
        size: f64,
        parent: Option<EntityId>,
    },
    /// With the usual values.
    CreateMaterial,
    Rename {
        id: EntityId,
        name: String,
    },
    /// What is selected, where nothing else is said.
    Delete,
    Duplicate,
    /// The text of what was copied goes where the window's clipboard is: see [`Session::copied`].
    Copy,
    Cut,
    Paste {
        text: String,
        parent: Option<EntityId>,
    },
    Reparent {
        ids: Vec<EntityId>,
        parent: Option<EntityId>,
        before: Option<EntityId>,
    },
    Hide {
        ids: Vec<EntityId>,
        hidden: bool,
    },
    /// All but these and what they stand under or carry.
    Isolate(Vec<EntityId>),
    ShowAll,
    Lock {
        ids: Vec<EntityId>,
        locked: bool,
    },
    Static {
        ids: Vec<EntityId>,
        is_static: bool,
        with_children: bool,
    },
    SelectAll,
    InvertSelection,
}

/// A document and what belongs to editing it.
pub struct Session {
    pub document: Document,
    pub selection: Selection,
    pub log: Log,
    /// For the window's clipboard, to be taken.
    pub copied: Option<String>,
}

impl Session {
    pub fn new(document: Document, log: Log) -> Self {
        Self { document, selection: Selection::default(), log, copied: None }
    }

    pub fn carry_out(&mut self, intents: impl IntoIterator<Item = Intent>) {
        intents.into_iter().for_each(|intent| self.one(intent));
        self.selection.retain_existing(self.document.indexed());
    }

    fn one(&mut self, intent: Intent) {
        match intent {
            Intent::Commit(edit) => drop(self.commit(edit)),
            Intent::Begin(name) => self.document.begin(name),
            Intent::Preview(edit) => self.document.preview(edit),
            Intent::End => {
                let ended = self.document.end();
                self.told(ended);
            }
            Intent::Cancel => self.document.cancel(),
            Intent::Undo => self.travel("Undone", Document::undo),
            Intent::Redo => self.travel("Done again", Document::redo),
            Intent::Select(ids) => self.selection.set(ids),
            Intent::Click { id, how, shown } => self.selection.click(id, how, &shown),
            Intent::Create { primitive, place, size, parent } => {
                self.create(primitive, (place, size), parent);
            }
            Intent::CreateMaterial => self.create_material(),
            Intent::Rename { id, name } => drop(self.commit(Edit::set(id, Field::Name(name)))),
            Intent::Delete => self.delete(),
            Intent::Duplicate => self.duplicate(),
            Intent::Copy => drop(self.copy()),
            Intent::Cut => {
                if self.copy() {
                    self.delete();
                }
            }
            Intent::Paste { text, parent } => self.paste(&text, parent),
            Intent::Reparent { ids, parent, before } => self.reparent(&ids, parent, before),
            Intent::Hide { ids, hidden } => self.set_flag(&ids, false, Field::Hidden(hidden)),
            Intent::Isolate(ids) => self.isolate(&ids),
            Intent::ShowAll => self.show_all(),
            Intent::Lock { ids, locked } => self.document.set_locked(&ids, locked),
            Intent::Static { ids, is_static, with_children } => {
                self.set_flag(&ids, with_children, Field::Static(is_static));
            }
            Intent::SelectAll => self.selection.set(self.pickable().collect::<Vec<_>>()),
            Intent::InvertSelection => {
                let others: Vec<EntityId> =
                    self.pickable().filter(|id| !self.selection.contains(*id)).collect();
                self.selection.set(others);
            }
        }
        if let Some(error) = self.document.take_refused() {
            self.log.scene_error(&error, self.document.scene());
        }
    }

    /// Whether it was taken.
    pub fn commit(&mut self, edit: Edit) -> bool {
        let committed = self.document.commit(edit);
        self.told(committed)
    }

    fn told(&mut self, result: Result<(), engine::scene::SceneError>) -> bool {
        if let Err(error) = &result {
            self.log.scene_error(error, self.document.scene());
        }
        result.is_ok()
    }

    fn warn(&self, warnings: &[Warning]) {
        self.log.warnings(warnings, self.document.scene());
    }

    fn travel(&mut self, done: &str, go: fn(&mut Document) -> Option<String>) {
        if let Some(name) = go(&mut self.document) {
            self.log.info(format!("{done}: {name}"));
        }
    }

    /// What a click in the scene view could mean.
    fn pickable(&self) -> impl Iterator<Item = EntityId> {
        let ids = self.document.scene().entities.iter().map(|entity| entity.id);
        ids.filter(|id| !self.document.is_locked(*id))
    }

    fn create(&mut self, primitive: Primitive, stand: (DVec3, f64), parent: Option<EntityId>) {
        let (edit, id) = primitives::create(&mut self.document, primitive, stand, parent);
        if self.commit(edit) && id.is_some() {
            self.selection.set(id);
        }
    }

    fn create_material(&mut self) {
        let id = self.document.new_material_id();
        let material = Material { id, name: format!("material {}", id.0), ..Material::default() };
        let at = self.document.scene().materials.len();
        self.commit(Edit::InsertMaterials(vec![(at, material)]));
    }

    fn delete(&mut self) {
        let (edit, warnings) = tree::delete(self.document.indexed(), self.selection.ids());
        if self.commit(edit) {
            self.warn(&warnings);
            self.selection.clear();
        }
    }

    fn duplicate(&mut self) {
        let top = self.document.indexed().topmost(self.selection.ids());
        let mut ids = self.document.id_giver();
        let edit = copies::duplicate(self.document.indexed(), &top, &mut ids);
        let copies = edit.entities();
        if self.commit(edit) {
            self.selection.set(self.document.indexed().topmost(&copies));
        }
    }

    fn copy(&mut self) -> bool {
        if self.selection.is_empty() {
            return false;
        }
        match clipboard::copy(&self.document, self.selection.ids()) {
            Ok(text) => self.copied = Some(text),
            Err(error) => self.log.error(Source::Nothing, error),
        }
        self.copied.is_some()
    }

    fn paste(&mut self, text: &str, parent: Option<EntityId>) {
        match clipboard::paste(&mut self.document, text, parent) {
            Ok((edit, top, warnings)) => {
                if self.commit(edit) {
                    self.warn(&warnings);
                    self.selection.set(top);
                }
            }
            Err(error) => self.log.error(Source::Nothing, error),
        }
    }

    fn reparent(&mut self, ids: &[EntityId], parent: Option<EntityId>, before: Option<EntityId>) {
        match tree::reparent(self.document.indexed(), ids, parent, before) {
            Ok((edit, warnings)) => {
                if self.commit(edit) {
                    self.warn(&warnings);
                }
            }
            Err(error) => self.log.error(Source::Nothing, error),
        }
    }

    fn set_flag(&mut self, ids: &[EntityId], with_children: bool, field: Field) {
        let edit = tree::set_flag(self.document.indexed(), ids, with_children, field);
        self.commit(edit);
    }

    fn isolate(&mut self, ids: &[EntityId]) {
        let edit = tree::isolate(self.document.indexed(), ids);
        self.commit(edit);
    }

    fn show_all(&mut self) {
        let hidden = self.document.scene().entities.iter().filter(|entity| entity.hidden);
        let shown = hidden.map(|entity| (entity.id, Field::Hidden(false))).collect();
        self.commit(Edit::Set(shown));
    }
}
