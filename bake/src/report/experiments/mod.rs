//! What is measured, one file an experiment.

use engine::transport::Transport;

use super::Budget;
use super::model::{Advice, Diagram, Split};
use super::player::Played;
use crate::{BakeError, Opened, Watcher};

/// The scene, opened, with the bake that the project ships, and what the player said of it.
pub struct Setup {
    pub(crate) opened: Opened,
    pub transport: Transport,
    /// None where there is no player or nothing to draw with.
    pub played: Option<Played>,
}

/// What all experiments found.
#[derive(Clone, Debug, Default)]
pub struct Measured {
    pub diagrams: Vec<Diagram>,
    pub split: Split,
    pub advice: Vec<Advice>,
    pub seeds: Vec<(String, u64)>,
    pub notes: Vec<String>,
}

pub fn all(_setup: &Setup, _budget: &Budget, _watcher: &dyn Watcher) -> Result<Measured, BakeError> {
    Ok(Measured::default())
}
