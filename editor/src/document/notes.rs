//! What the editor notes about a scene and the scene's file does not hold: locks, and ids that were given.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use engine::scene::file::{read, write};
use engine::scene::{EntityId, SceneError, Warning};
use serde::{Deserialize, Serialize};

use crate::recovery::folder;

/// `.hohlraum/notes/NAME.ron`. Without it a scene is the same and nothing is locked.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Notes {
    /// Not to be picked in the scene view.
    pub locked: BTreeSet<EntityId>,
    /// Ids below it were given, perhaps to what is gone.
    pub next_entity: u64,
}

pub fn path(project: &Path, name: &str) -> PathBuf {
    folder(project).join("notes").join(format!("{name}.ron"))
}

impl Notes {
    /// Those of a scene. Damaged ones are none, with a warning.
    pub fn load(path: &Path) -> (Self, Option<Warning>) {
        if !path.is_file() {
            return (Self::default(), None);
        }
        match read(path) {
            Ok(notes) => (notes, None),
            Err(error) => {
                let message = format!("nothing is locked, the editor's notes are damaged ({error})");
                (Self::default(), Some(Warning::new(path.display().to_string(), message)))
            }
        }
    }

    pub fn save(&self, path: &Path) -> Result<(), SceneError> {
        write(path, self)
    }
}
