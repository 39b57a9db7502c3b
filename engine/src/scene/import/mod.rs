//! Files of others, made into scenes of ours.

use std::path::Path;

use super::assets::Assets;
use super::{Scene, SceneError, Warning};

/// What a file says, as a scene whose entities refer to meshes and pictures of `file` (its path relative
/// to the project, forward slashes).
#[derive(Debug)]
pub struct Imported {
    pub scene: Scene,
    pub warnings: Vec<Warning>,
    /// Files that this one refers to (buffers, pictures, material libraries), relative to its folder.
    pub companions: Vec<String>,
}

/// Reads `project/file`, glTF, GLB or OBJ by its ending.
pub fn import(_project: &Path, _file: &str) -> Result<Imported, SceneError> {
    todo!()
}

/// Reads every mesh, picture and clip that the scene refers to. What is missing or broken is a warning
/// where the scene still makes sense without it (a picture, a clip) and an error where it does not (a mesh).
pub fn load_assets(_project: &Path, _scene: &Scene) -> Result<(Assets, Vec<Warning>), SceneError> {
    todo!()
}
