//! The panels: one file each. They read the document and ask for edits; none of them changes anything but how it looks
//! itself.

pub mod assets;
pub mod console;
pub mod files;
pub mod folder;
pub mod game;
pub mod hierarchy;
pub mod menu;
pub mod palette;
pub mod preferences;
pub mod scene;
pub mod statistics;
pub mod status;
pub mod toolbar;
