//! The document's file: opened, saved whole or not at all, and watched for what others do to it.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use engine::scene::file::{
    Project, load_project, project_path, save_project, scene_from_text, scene_path, text_of_scene,
    write_atomically,
};
use engine::scene::{Scene, SceneError, Warning};

use super::Document;
use crate::edit::Edit;

/// What is known of the file on disk.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Known {
    /// `None`: it did not exist.
    pub stamp: Option<Stamp>,
}

/// When it was written, and what it holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Stamp {
    pub modified: Option<SystemTime>,
    pub length: u64,
    pub hash: blake3::Hash,
}

/// Somebody else did something to the scene's file since it was read or saved here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Changed {
    Written,
    Gone,
}

/// Why a scene is not on disk. The document is as dirty as before.
#[derive(Debug, thiserror::Error)]
pub enum SaveError {
    #[error("{error}: {remedy}; the scene is still open and not saved")]
    Disk { error: SceneError, remedy: &'static str },
    #[error("{}: was changed by another program since it was opened: reload it, or save under another name", path.display())]
    ChangedOutside { path: PathBuf },
    #[error("{}: exists already: choose another name", path.display())]
    Exists { path: PathBuf },
    #[error(
        "`{0}` cannot be the name of a file: leave out / \\ < > : \" | ? * and dots or blanks at its ends"
    )]
    Name(String),
}

impl Document {
    /// Opens a scene of a project (`None`: its default scene).
    pub fn open(project: &Path, scene: Option<&str>) -> Result<(Self, Vec<Warning>), SceneError> {
        let settings = load_project(project)?;
        let name = scene.unwrap_or(&settings.default_scene);
        let path = scene_path(project, name);
        if !path.is_file() {
            let names = engine::scene::file::scene_names(project)?.join(", ");
            let message = format!("the project has no scene `{name}`; it has: {names}");
            return Err(SceneError::File { path, message });
        }
        let (scene, stamp) = read(&path)?;
        let warnings = engine::transport::materials::warnings(&scene);
        Ok((Self::new(project, name, scene, Known { stamp: Some(stamp) }), warnings))
    }

    /// Makes a project in a folder that is none yet, with this scene, and opens it.
    pub fn new_project(project: &Path, name: &str, scene: Scene) -> Result<Self, SaveError> {
        check_name(name)?;
        let taken = [project_path(project), scene_path(project, name)];
        if let Some(path) = taken.into_iter().find(|path| path.exists()) {
            return Err(SaveError::Exists { path });
        }
        let document = Self::new_scene(project, name, scene)?;
        std::fs::create_dir_all(project.join("assets"))
            .map_err(|source| disk(SceneError::Io { path: project.join("assets"), source }))?;
        // The last: a folder is a project only when all of it is there.
        let settings = Project { default_scene: name.to_owned(), ..Project::default() };
        save_project(project, &settings).map_err(disk)?;
        Ok(document)
    }

    /// Adds a scene to a project and opens it.
    pub fn new_scene(project: &Path, name: &str, scene: Scene) -> Result<Self, SaveError> {
        check_name(name)?;
        let path = scene_path(project, name);
        if path.exists() {
            return Err(SaveError::Exists { path });
        }
        let stamp = write(&path, &scene)?;
        Ok(Self::new(project, name, scene, Known { stamp: Some(stamp) }))
    }

    /// Replaces the scene's file whole. A file that another program changed since is left as it is.
    pub fn save(&mut self) -> Result<(), SaveError> {
        let path = self.path();
        if self.changed_outside() == Some(Changed::Written) {
            return Err(SaveError::ChangedOutside { path });
        }
        self.settle();
        let stamp = write(&path, self.scene())?;
        self.file.stamp = Some(stamp);
        self.saved_state = Some(self.state);
        Ok(())
    }

    /// Under another name, which the document has from then on.
    pub fn save_as(&mut self, name: &str) -> Result<(), SaveError> {
        check_name(name)?;
        let path = scene_path(&self.project, name);
        if path.exists() {
            return Err(SaveError::Exists { path });
        }
        self.settle();
        let stamp = write(&path, self.scene())?;
        self.name = name.to_owned();
        self.file.stamp = Some(stamp);
        self.saved_state = Some(self.state);
        Ok(())
    }

    pub fn path(&self) -> PathBuf {
        scene_path(&self.project, &self.name)
    }

    /// Reads the file where its time or length is another than was known.
    pub fn changed_outside(&self) -> Option<Changed> {
        changed(&self.path(), self.file.stamp.as_ref()?)
    }

    /// Takes what the file holds now, as a step that undo takes back.
    pub fn reload(&mut self) -> Result<(), SceneError> {
        let (scene, stamp) = read(&self.path())?;
        self.cancel();
        self.commit(Edit::several("Reload", [Edit::Whole(Box::new(scene))]))?;
        self.file.stamp = Some(stamp);
        self.saved_state = Some(self.state);
        Ok(())
    }
}

/// What another program made of a file since it had this stamp.
pub fn changed(path: &Path, known: &Stamp) -> Option<Changed> {
    let Ok(metadata) = path.metadata() else { return Some(Changed::Gone) };
    if metadata.len() == known.length && metadata.modified().ok() == known.modified {
        return None;
    }
    let same = std::fs::read(path).is_ok_and(|bytes| blake3::hash(&bytes) == known.hash);
    (!same).then_some(Changed::Written)
}

fn read(path: &Path) -> Result<(Scene, Stamp), SceneError> {
    let failed = |source| SceneError::Io { path: path.to_owned(), source };
    let text = std::fs::read_to_string(path).map_err(failed)?;
    let modified = path.metadata().and_then(|metadata| metadata.modified()).ok();
    Ok((scene_from_text(path, &text)?, stamp(&text, modified)))
}

fn write(path: &Path, scene: &Scene) -> Result<Stamp, SaveError> {
    let text = text_of_scene(path, scene).map_err(disk)?;
    write_atomically(path, text.as_bytes()).map_err(disk)?;
    Ok(stamp(&text, path.metadata().and_then(|metadata| metadata.modified()).ok()))
}

fn stamp(text: &str, modified: Option<SystemTime>) -> Stamp {
    Stamp { modified, length: text.len() as u64, hash: blake3::hash(text.as_bytes()) }
}

/// With what can be done about it.
fn disk(error: SceneError) -> SaveError {
    use std::io::ErrorKind;
    let SceneError::Io { source, .. } = &error else {
        return SaveError::Disk { error, remedy: "save under another name" };
    };
    let remedy = match source.kind() {
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
            "make the folder writable, or save in another project"
        }
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => "make room on the disk and save again",
        ErrorKind::NotADirectory | ErrorKind::AlreadyExists => {
            "a file stands where a folder has to be: move it away and save again"
        }
        _ => "save again, or under another name",
    };
    SaveError::Disk { error, remedy }
}

/// Usable as a file's name on every system.
fn check_name(name: &str) -> Result<(), SaveError> {
    let is_usable = |c: char| !c.is_control() && !r#"/\<>:"|?*"#.contains(c);
    let is_name = !name.is_empty() && name.chars().all(is_usable) && name.trim_matches([' ', '.']) == name;
    if is_name { Ok(()) } else { Err(SaveError::Name(name.to_owned())) }
}
