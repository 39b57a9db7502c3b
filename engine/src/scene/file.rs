//! Projects and scenes on disk: the only reader and writer of both.
//!
//! ```text
//! project.ron          settings
//! scenes/NAME.ron      one scene each
//! assets/              imported files, as they came
//! baked/NAME/          what the baker made; safe to delete
//! ```
//! Text is RON, versioned, stable in order; a save writes a new file beside the old one, syncs it, and
//! renames it over the old one.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::{Feature, Forced, Scene, SceneError};

/// Of both kinds of file. Older versions are read, newer ones are refused.
pub const VERSION: u32 = 1;

/// `project.ron`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Project {
    pub version: u32,
    /// Opened when no scene is named.
    pub default_scene: String,
    #[serde(default)]
    pub bake: BakeSettings,
    /// Features that are there, or left out, whatever their rules find.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub features: BTreeMap<Feature, Forced>,
}

/// How the project's scenes are baked where the command line says nothing.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BakeSettings {
    #[serde(default)]
    pub quality: Quality,
    /// Rays a row, instead of the quality's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rays: Option<u32>,
    /// Metres, instead of the quality's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub patch_length: Option<f64>,
    /// Metres by scene and quality ("cornell/draft"), fixed at the first bake so that an edit moves no
    /// patch that it does not touch.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub base_length: BTreeMap<String, f64>,
    /// Bake closed rooms of albedo 1 as authored, however long their light bounces.
    #[serde(default, skip_serializing_if = "super::entity::is_false")]
    pub unlimited_gain: bool,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quality {
    Draft,
    #[default]
    Standard,
    Fine,
}

impl std::fmt::Display for Quality {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Draft => "draft",
            Self::Standard => "standard",
            Self::Fine => "fine",
        })
    }
}

impl Default for Project {
    fn default() -> Self {
        Self {
            version: VERSION,
            default_scene: "main".to_owned(),
            bake: BakeSettings::default(),
            features: BTreeMap::new(),
        }
    }
}

/// `scenes/NAME.ron`: the version, then the scene.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SceneFile {
    version: u32,
    scene: Scene,
}

/// The same, written without a copy of the scene.
#[derive(Serialize)]
#[serde(rename = "SceneFile")]
struct SceneToWrite<'a> {
    version: u32,
    scene: &'a Scene,
}

pub fn project_path(project: &Path) -> PathBuf {
    project.join("project.ron")
}

pub fn scene_path(project: &Path, name: &str) -> PathBuf {
    project.join("scenes").join(format!("{name}.ron"))
}

/// Where the bake of a scene lies.
pub fn baked_dir(project: &Path, name: &str) -> PathBuf {
    project.join("baked").join(name)
}

pub fn load_project(project: &Path) -> Result<Project, SceneError> {
    let path = project_path(project);
    if !path.is_file() {
        return Err(SceneError::File {
            path: project.to_owned(),
            message: "is not a project: it has no project.ron; `hohlraum-bake new` makes one".to_owned(),
        });
    }
    let loaded: Project = read(&path)?;
    known_version(&path, loaded.version)?;
    Ok(loaded)
}

pub fn save_project(project: &Path, settings: &Project) -> Result<(), SceneError> {
    write(&project_path(project), settings)
}

pub fn load_scene(project: &Path, name: &str) -> Result<Scene, SceneError> {
    let path = scene_path(project, name);
    if !path.is_file() {
        let names = scene_names(project)?.join(", ");
        let message = format!("the project has no scene `{name}`; it has: {names}");
        return Err(SceneError::File { path, message });
    }
    scene_from_text(&path, &read_text(&path)?)
}

/// A scene file's text, read and checked; `path` is what errors name.
pub fn scene_from_text(path: &Path, text: &str) -> Result<Scene, SceneError> {
    let loaded: SceneFile = from_text(path, text).or_else(|error| {
        // A newer file may hold what this program has no field for: what counts is that it is newer.
        known_version(path, version_of(text))?;
        Err(error)
    })?;
    known_version(path, loaded.version)?;
    loaded.scene.validate()?;
    Ok(loaded.scene)
}

/// What a scene file holds, byte for byte; `path` is what errors name.
pub fn text_of_scene(path: &Path, scene: &Scene) -> Result<String, SceneError> {
    to_text(path, &SceneToWrite { version: VERSION, scene })
}

pub fn save_scene(project: &Path, name: &str, scene: &Scene) -> Result<(), SceneError> {
    let path = scene_path(project, name);
    write_atomically(&path, text_of_scene(&path, scene)?.as_bytes())
}

/// In alphabetical order.
pub fn scene_names(project: &Path) -> Result<Vec<String>, SceneError> {
    let folder = project.join("scenes");
    let entries =
        std::fs::read_dir(&folder).map_err(|source| SceneError::Io { path: folder.clone(), source })?;
    let mut names: Vec<String> = entries
        .filter_map(|entry| {
            let path = entry.ok()?.path();
            (path.extension()? == "ron").then(|| Some(path.file_stem()?.to_str()?.to_owned()))?
        })
        .collect();
    names.sort();
    Ok(names)
}

/// Writes beside `path`, syncs, renames: a reader sees the old file or the new one, never half of either.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), SceneError> {
    let failed = |source| SceneError::Io { path: path.to_owned(), source };
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).map_err(failed)?;
    // Not `NamedTempFile::new_in`, whose files nobody but their owner may read.
    let create = |path: &Path| std::fs::File::create_new(path);
    let mut file = tempfile::Builder::new().make_in(folder, create).map_err(failed)?;
    file.write_all(bytes).map_err(failed)?;
    file.as_file().sync_all().map_err(failed)?;
    file.persist(path).map_err(|error| failed(error.error))?;
    Ok(())
}

fn read_text(path: &Path) -> Result<String, SceneError> {
    std::fs::read_to_string(path).map_err(|source| SceneError::Io { path: path.to_owned(), source })
}

/// A file in the dialect of project and scene files.
pub fn read<T: for<'a> Deserialize<'a>>(path: &Path) -> Result<T, SceneError> {
    from_text(path, &read_text(path)?)
}

pub fn write<T: Serialize>(path: &Path, value: &T) -> Result<(), SceneError> {
    write_atomically(path, to_text(path, value)?.as_bytes())
}

/// Text in that dialect; `path` is what errors name.
pub fn from_text<T: for<'a> Deserialize<'a>>(path: &Path, text: &str) -> Result<T, SceneError> {
    ron::Options::default()
        .with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME)
        .from_str(text)
        .map_err(|error| SceneError::File { path: path.to_owned(), message: error.to_string() })
}

pub fn to_text<T: Serialize>(path: &Path, value: &T) -> Result<String, SceneError> {
    let pretty = ron::ser::PrettyConfig::new()
        .depth_limit(6)
        .compact_arrays(true)
        .extensions(ron::extensions::Extensions::IMPLICIT_SOME);
    let mut text = ron::Options::default()
        .to_string_pretty(value, pretty)
        .map_err(|error| SceneError::File { path: path.to_owned(), message: error.to_string() })?;
    text.push('\n');
    Ok(text)
}

/// 0 where the text says none.
fn version_of(text: &str) -> u32 {
    #[derive(Deserialize)]
    struct Versioned {
        version: u32,
    }
    from_text(Path::new(""), text).map_or(0, |Versioned { version }| version)
}

fn known_version(path: &Path, version: u32) -> Result<(), SceneError> {
    if version <= VERSION {
        return Ok(());
    }
    let message = format!("is of version {version}; this program reads up to {VERSION}: use a newer one");
    Err(SceneError::File { path: path.to_owned(), message })
}
