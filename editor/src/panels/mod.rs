//! The panels: one file each. They read the document and ask for edits; none of them changes anything but how it looks
//! itself.

pub mod game;
pub mod hierarchy;
pub mod scene;
pub mod toolbar;
