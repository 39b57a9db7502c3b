//! Hohlraum's scene editor.
//!
//! Everything that changes a scene is an [`edit::Edit`], plain data; the [`document::Document`] is the one door
//! through which edits reach the scene. Panels read the document and [`ask`]; what they asked for is done when all of
//! them are drawn. Nothing waits for a disk, a bake or the GPU's answer where a
//! picture is waited for.

pub mod app;
pub mod ask;
pub mod assets;
pub mod baking;
pub mod camera;
pub mod clipboard;
pub mod command;
pub mod document;
pub mod edit;
pub mod gizmo;
pub mod history;
pub mod icons;
pub mod importing;
pub mod inspector;
pub mod intents;
pub mod job;
pub mod keys;
pub mod layout;
pub mod lens;
pub mod log;
pub mod opened;
pub mod panels;
pub mod play;
pub mod primitives;
pub mod recent;
pub mod recovery;
pub mod run;
pub mod scenery;
pub mod selection;
pub mod theme;
pub mod thumbnails;
pub mod tools;
pub mod viewport;
pub mod watch;
