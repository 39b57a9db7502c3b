//! What is not saved yet, kept beside the project so that neither a crash nor a power cut costs more than a minute:
//! `.hohlraum/recovery/NAME.ron`, a scene file like any other. A clean save or a clean end deletes it.

use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use engine::scene::file::{scene_from_text, scene_path, text_of_scene, write_atomically};
use engine::scene::{Scene, SceneError};

/// From one recovery file to the next, while something is not saved.
pub const EVERY: Duration = Duration::from_secs(60);

/// What the editor keeps beside a project for itself; safe to delete.
pub fn folder(project: &Path) -> PathBuf {
    project.join(".hohlraum")
}

pub fn path(project: &Path, name: &str) -> PathBuf {
    folder(project).join("recovery").join(format!("{name}.ron"))
}

/// What a session that did not end well left.
#[derive(Clone, Debug)]
pub struct Recovery {
    pub scene: Scene,
    pub path: PathBuf,
    pub written: SystemTime,
}

/// A scene that could not be saved any more is not kept in place of one that could.
pub fn write(project: &Path, name: &str, scene: &Scene) -> Result<(), SceneError> {
    scene.validate()?;
    let path = path(project, name);
    write_atomically(&path, text_of_scene(&path, scene)?.as_bytes())
}

/// What there is to recover: newer than the scene's file, readable, and something else than it holds. What is broken
/// is an error that names it; it stays where it is.
pub fn find(project: &Path, name: &str) -> Result<Option<Recovery>, SceneError> {
    let path = path(project, name);
    let time = |path: &Path| path.metadata().and_then(|metadata| metadata.modified());
    let Ok(written) = time(&path) else { return Ok(None) };
    let saved = scene_path(project, name);
    if time(&saved).is_ok_and(|saved| saved > written) {
        return Ok(None);
    }
    let read = |path: &Path| {
        std::fs::read_to_string(path).map_err(|source| SceneError::Io { path: path.to_owned(), source })
    };
    let text = read(&path)?;
    if read(&saved).is_ok_and(|saved| saved == text) {
        return Ok(None);
    }
    Ok(Some(Recovery { scene: scene_from_text(&path, &text)?, path, written }))
}

/// Nothing is left to recover.
pub fn remove(project: &Path, name: &str) {
    // What cannot be removed is older than the scene's file, and so is not offered.
    let _ = std::fs::remove_file(path(project, name));
}
