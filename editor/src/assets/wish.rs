//! What panels want done with files, as data: carried out when all of them are drawn, on threads of their own where a disk
//! is asked.

use std::path::PathBuf;

use engine::scene::import::settings::ImportSettings;
use engine::scene::{EntityId, MaterialId};
use glam::DVec3;

use super::Kind;

/// Where an imported model comes to stand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// In the world, metres.
    At(DVec3),
    /// At the origin of an entity, under it.
    Under(EntityId),
}

#[derive(Clone, Debug, PartialEq)]
pub enum Wish {
    /// Files from anywhere come into the project; without a place they stand in no scene yet.
    Bring {
        sources: Vec<PathBuf>,
        settings: Option<ImportSettings>,
        place: Option<Place>,
    },
    /// A model of the project comes to stand in the scene once more.
    Place {
        file: String,
        place: Place,
    },
    /// A model is read again, with other settings where they are given, and what came of it follows.
    Again {
        file: String,
        settings: Option<ImportSettings>,
    },
    /// A file or folder of the project; all that refers to it does so by the new name.
    Move {
        from: String,
        to: String,
    },
    Delete {
        file: String,
    },
    /// What refers to a file that is missing refers to another.
    Relink {
        from: String,
        to: String,
    },
    /// Likewise, to one that comes into the project first.
    RelinkFrom {
        from: String,
        source: PathBuf,
    },
    /// The assets panel asks which.
    AskForRelink {
        from: String,
    },
    NewFolder {
        below: String,
    },
    /// The assets panel asks which files, and how they are to be read.
    AskForImport,
    CancelImport,
    /// The assets panel shows and selects it.
    Reveal {
        file: PathBuf,
    },
    RevealMaterial(MaterialId),
    /// It is told in the console.
    Refuse {
        file: String,
        why: String,
    },
}

/// What is dragged out of the assets panel.
#[derive(Clone, Debug, PartialEq)]
pub enum Carried {
    File { file: String, kind: Kind },
    Material(MaterialId),
}
