//! What panels ask for. They are given the document to read; what they want done is collected here and done when all of
//! them are drawn, so that every panel of a picture shows the same scene.

use engine::scene::EntityId;

use crate::command::Command;
use crate::edit::Edit;
use crate::selection::Selection;

#[derive(Clone, Debug, PartialEq)]
pub enum Ask {
    /// As one step.
    Commit(Edit),
    /// Shown until the drag ends; each replaces the one before.
    Preview(Edit),
    /// The drag is over: what it shows becomes one step.
    End,
    /// The drag is off.
    Cancel,
    Select(Vec<EntityId>),
    Selection(Selection),
    /// The scene view goes there.
    Frame(Vec<EntityId>),
    Run(Command),
    /// Under a parent, before one of its children or as the last.
    Reparent { ids: Vec<EntityId>, parent: Option<EntityId>, before: Option<EntityId> },
}

#[derive(Default)]
pub struct Asks {
    list: Vec<Ask>,
}

impl Asks {
    pub fn push(&mut self, ask: Ask) {
        self.list.push(ask);
    }

    pub fn take(&mut self) -> Vec<Ask> {
        std::mem::take(&mut self.list)
    }
}
