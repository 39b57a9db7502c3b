//! How a file is to be read, where its author and ours disagree: `NAME.import.ron` beside it. Without one it is read as
//! it is.

use std::path::{Path, PathBuf};

use glam::{DAffine3, DMat3, DVec3};
use serde::{Deserialize, Serialize};

use crate::scene::file::read;
use crate::scene::{Entity, Scene, SceneError, Transform};

const VERSION: u32 = 1;

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ImportSettings {
    pub version: u32,
    /// Metres of one unit of the file.
    pub scale: f64,
    pub up: Up,
    pub normals: Normals,
    pub structure: Structure,
}

/// The file's axis that points up; it becomes +Y.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Up {
    #[default]
    Y,
    Z,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Normals {
    /// Its own, and flat triangles where it has none.
    #[default]
    File,
    /// Every triangle is flat.
    Flat,
    /// The mean of the triangles around each point, by their areas.
    Smooth,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Structure {
    /// An entity for each of the file's.
    #[default]
    Hierarchy,
    /// One entity that draws all of the file's meshes as one, mesh 0. Lights, cameras and motion are left out.
    One,
}

impl Default for ImportSettings {
    fn default() -> Self {
        Self {
            version: VERSION,
            scale: 1.0,
            up: Up::default(),
            normals: Normals::default(),
            structure: Structure::default(),
        }
    }
}

/// Where a file's settings lie.
pub fn path(file: &Path) -> PathBuf {
    let mut name = file.file_name().unwrap_or_default().to_owned();
    name.push(".import.ron");
    file.with_file_name(name)
}

/// Those of a file, or the usual ones.
pub fn load(file: &Path) -> Result<ImportSettings, SceneError> {
    let path = path(file);
    if !path.is_file() {
        return Ok(ImportSettings::default());
    }
    let settings: ImportSettings = read(&path)?;
    let refused = |message: String| Err(SceneError::File { path: path.clone(), message });
    if settings.version > VERSION {
        return refused(format!("is of version {}; this program reads up to {VERSION}", settings.version));
    }
    if !(settings.scale > 0.0 && settings.scale.is_finite()) {
        return refused(format!("its scale is {}: it has to be above 0", settings.scale));
    }
    Ok(settings)
}

impl ImportSettings {
    /// From the file's space to ours.
    pub fn scene_from_file(&self) -> DAffine3 {
        let turn = match self.up {
            Up::Y => DMat3::IDENTITY,
            Up::Z => DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y),
        };
        DAffine3::from_mat3(turn * self.scale)
    }

    /// Hangs the file's roots, where its space is not ours, below an entity that leads from one to the other: motion
    /// goes on in the space of the file.
    pub fn place(&self, scene: &mut Scene, file: &str) {
        let scene_from_file = self.scene_from_file();
        if scene_from_file == DAffine3::IDENTITY {
            return;
        }
        let id = scene.free_entity_id();
        for entity in scene.entities.iter_mut().filter(|entity| entity.parent.is_none()) {
            entity.parent = Some(id);
        }
        let (scale, rotation, translation) = scene_from_file.to_scale_rotation_translation();
        let transform = Transform { translation, rotation, scale };
        scene.entities.insert(0, Entity { id, name: stem(file), transform, ..Entity::default() });
    }
}

/// A file's name without folder and ending.
pub fn stem(file: &str) -> String {
    let name = file.rsplit('/').next().unwrap_or(file);
    name.rsplit_once('.').map_or(name, |(stem, _)| stem).to_owned()
}
