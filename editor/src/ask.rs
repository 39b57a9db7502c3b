//! What panels ask for. They are given the document to read; what they want done is collected here and done when all of
//! them are drawn, so that every panel of a picture shows the same scene.

use engine::scene::EntityId;

use crate::assets::Wish;
use crate::command::Command;
use crate::intents::Intent;
use crate::layout::Pane;
use crate::panels::scene::pick::Pick;

#[derive(Clone, Debug, PartialEq)]
pub enum Ask {
    Intent(Intent),
    Run(Command),
    /// Of the project's files.
    Files(Wish),
    /// The scene view goes there.
    Frame(Vec<EntityId>),
    /// The same where they are larger than the picture.
    Fit(Vec<EntityId>),
    /// The panel, until it is shown again.
    Close(Pane),
    /// What the mouse met; what is asked after it is done when it is answered.
    Pick(Box<Pick>),
}

impl From<Intent> for Ask {
    fn from(intent: Intent) -> Self {
        Self::Intent(intent)
    }
}

impl From<Pane> for Ask {
    fn from(pane: Pane) -> Self {
        Self::Close(pane)
    }
}

impl From<Command> for Ask {
    fn from(command: Command) -> Self {
        Self::Run(command)
    }
}

impl From<Wish> for Ask {
    fn from(wish: Wish) -> Self {
        Self::Files(wish)
    }
}

impl From<Pick> for Ask {
    fn from(pick: Pick) -> Self {
        Self::Pick(Box::new(pick))
    }
}

#[derive(Default)]
pub struct Asks {
    list: Vec<Ask>,
}

impl Asks {
    pub fn push(&mut self, ask: impl Into<Ask>) {
        self.list.push(ask.into());
    }

    pub fn take(&mut self) -> Vec<Ask> {
        std::mem::take(&mut self.list)
    }
}
