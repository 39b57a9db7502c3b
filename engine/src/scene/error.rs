//! What can be wrong with a scene or with the files that it is read from.

use std::path::PathBuf;

/// Something that stops the work. Every message names the file or the entity, and the remedy.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    #[error("{}: {source}", path.display())]
    Io { path: PathBuf, source: std::io::Error },
    #[error("{}: {message}", path.display())]
    File { path: PathBuf, message: String },
    #[error("entity `{entity}`: {message}")]
    Entity { entity: String, message: String },
    #[error("material `{material}`: {message}")]
    Material { material: String, message: String },
    #[error("{0}")]
    Scene(String),
}

/// Something that the author should know and that stops nothing.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Warning {
    /// File, entity or material.
    pub about: String,
    pub message: String,
}

impl Warning {
    pub fn new(about: impl Into<String>, message: impl Into<String>) -> Self {
        Self { about: about.into(), message: message.into() }
    }
}

impl std::fmt::Display for Warning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.about, self.message)
    }
}
