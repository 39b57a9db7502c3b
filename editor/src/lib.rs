//! Hohlraum's scene editor without its windows: the document, what changes it, and what happens beside it.
//!
//! Everything that changes a scene is an [`edit::Edit`], plain data; the [`document::Document`] is the one door
//! through which edits reach the scene. Nothing here draws, and nothing here waits for a disk or a bake where a
//! picture is waited for.

pub mod assets;
pub mod baking;
pub mod clipboard;
pub mod command;
pub mod document;
pub mod edit;
pub mod history;
pub mod importing;
pub mod intents;
pub mod log;
pub mod primitives;
pub mod recent;
pub mod recovery;
pub mod selection;
pub mod watch;
