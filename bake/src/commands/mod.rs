//! What `hohlraum-bake` can be told to do, one file a command.

pub mod bake;
pub mod check;
mod columns;
pub mod new;
pub mod plan;
pub mod query;
pub mod report;
mod staging;

use std::path::Path;

use engine::scene::SceneError;
use engine::scene::file::load_project;

/// The scene that is meant: the one that was named, or the project's default one.
fn scene_name(project: &Path, scene: Option<&str>) -> Result<String, SceneError> {
    let default = load_project(project)?.default_scene;
    Ok(scene.map_or(default, str::to_owned))
}
