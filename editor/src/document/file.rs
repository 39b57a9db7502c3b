//! The document's file: opened, saved whole or not at all, and watched for what others do to it.

use std::path::{Path, PathBuf};

use engine::scene::file::{
    Project, load_project, project_path, save_project, scene_from_text, scene_names, scene_path,
    text_of_scene, write_atomically,
};
use engine::scene::{Scene, SceneError, Warning};

use super::disk::Work;
use super::notes::{self, Notes};
use super::{Document, Drag, Event};
use crate::edit::Edit;
use crate::recovery::{self, Recovery};
use crate::watch::{Changed, Stamp};

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

impl SaveError {
    pub fn path(&self) -> Option<&Path> {
        match self {
            Self::Disk { error: SceneError::Io { path, .. } | SceneError::File { path, .. }, .. } => {
                Some(path)
            }
            Self::ChangedOutside { path } | Self::Exists { path } => Some(path),
            Self::Disk { .. } | Self::Name(_) => None,
        }
    }
}

impl Document {
    /// Opens a scene of a project (`None`: its default scene).
    pub fn open(project: &Path, scene: Option<&str>) -> Result<(Self, Vec<Warning>), SceneError> {
        let settings = load_project(project)?;
        let name = scene.unwrap_or(&settings.default_scene);
        let path = scene_path(project, name);
        if !path.is_file() {
            let message =
                format!("the project has no scene `{name}`; it has: {}", scene_names(project)?.join(", "));
            return Err(SceneError::File { path, message });
        }
        let (scene, stamp) = read(&path)?;
        let mut warnings = engine::transport::materials::warnings(&scene);
        let (notes, damaged) = Notes::load(&notes::path(project, name));
        warnings.extend(damaged);
        let mut document = Self::new(project, name, scene, Some(stamp), notes);
        match recovery::find(project, name) {
            Ok(recovery) => document.recovery = recovery,
            Err(error) => {
                warnings.push(Warning::new(name, format!("what was not saved cannot be recovered: {error}")))
            }
        }
        Ok((document, warnings))
    }

    /// Makes a project in a folder that is none yet, with this scene, and opens it.
    pub fn new_project(project: &Path, name: &str, scene: Scene) -> Result<Self, SaveError> {
        check_name(name)?;
        let taken = [project_path(project), scene_path(project, name)];
        if let Some(path) = taken.into_iter().find(|path| path.exists()) {
            return Err(SaveError::Exists { path });
        }
        let document = Self::new_scene(project, name, scene)?;
        let assets = project.join("assets");
        std::fs::create_dir_all(&assets).map_err(|source| disk(SceneError::Io { path: assets, source }))?;
        // What versions of a project need not hold.
        write_atomically(&project.join(".gitignore"), b"baked/\nout/\n.hohlraum/\n").map_err(disk)?;
        // The last: a folder is a project only when all of it is there.
        let settings = Project { default_scene: name.to_owned(), ..Project::default() };
        save_project(project, &settings).map_err(disk)?;
        Ok(document)
    }

    /// Adds a scene to a project and opens it.
    pub fn new_scene(project: &Path, name: &str, scene: Scene) -> Result<Self, SaveError> {
        scene.validate().map_err(disk)?;
        let stamp = write_new_scene(project, name, &scene)?;
        Ok(Self::new(project, name, scene, Some(stamp), Notes::default()))
    }

    pub fn path(&self) -> PathBuf {
        scene_path(&self.project, &self.name)
    }

    /// Replaces the scene's file whole. A file that another program changed since is left as it is.
    pub fn save(&mut self) -> Result<(), SaveError> {
        self.finish_saving();
        self.settle();
        let stamp = write_scene(&self.path(), self.stamp.as_ref(), self.scene())?;
        self.saved(self.state, stamp);
        Ok(())
    }

    /// The same while editing goes on: what came of it is among the next [`super::Event`]s.
    pub fn save_in_background(&mut self) {
        if self.saving {
            self.save_again = true;
            return;
        }
        self.settle();
        let (path, known) = (self.path(), self.stamp.clone());
        let work = Work::Save { path, known, scene: Box::new(self.scene().clone()), state: self.state };
        self.saving = self.disk().ask(work);
        if !self.saving {
            // There is no thread: then it is done here.
            let result = self.save();
            self.events.push(Event::Saved(result));
        }
    }

    /// Under another name, which the document has from then on.
    pub fn save_as(&mut self, name: &str) -> Result<(), SaveError> {
        self.finish_saving();
        self.settle();
        let stamp = write_new_scene(&self.project, name, self.scene())?;
        self.renamed(name);
        self.saved(self.state, stamp);
        Ok(())
    }

    /// The same while editing goes on; what came of it is among the next [`super::Event`]s.
    pub fn save_as_in_background(&mut self, name: &str) {
        self.finish_saving();
        self.settle();
        let (project, name) = (self.project.clone(), name.to_owned());
        let scene = Box::new(self.scene().clone());
        let work = Work::SaveAs { project, name: name.clone(), scene, state: self.state };
        self.saving = self.disk().ask(work);
        if !self.saving {
            // There is no thread: then it is done here.
            let result = self.save_as(&name);
            self.events.push(Event::Saved(result));
        }
    }

    /// The scene's file is another. What was kept for a crash was of the old one; locks go along.
    pub(super) fn renamed(&mut self, name: &str) {
        let (project, old) = (self.project.clone(), std::mem::replace(&mut self.name, name.to_owned()));
        self.disk().ask(Work::ForgetRecovery { project, name: old });
        self.written_notes = Notes::default();
    }

    /// The file holds the scene as it was in this state.
    pub(super) fn saved(&mut self, state: u64, stamp: Stamp) {
        self.stamp = Some(stamp);
        self.saved_state = Some(state);
        if !self.is_dirty() {
            self.forget_recovery();
        }
        self.write_notes();
    }

    /// What another program did to the file. Reads it only where its time or length is another than was known.
    pub fn changed_outside(&self) -> Option<Changed> {
        self.stamp.as_ref()?.changed(&self.path())
    }

    /// Takes what the file holds now, as a step that undo takes back.
    pub fn reload(&mut self) -> Result<(), SceneError> {
        let (scene, stamp) = read(&self.path())?;
        self.reloaded(scene, stamp)
    }

    /// The same while editing goes on; what came of it is among the next [`super::Event`]s.
    pub fn reload_in_background(&mut self) {
        let work = Work::Read { path: self.path() };
        self.disk().ask(work);
    }

    pub(super) fn reloaded(&mut self, scene: Scene, stamp: Stamp) -> Result<(), SceneError> {
        self.cancel();
        self.commit(Edit::several("Reload", [Edit::Whole(Box::new(scene))]))?;
        self.saved(self.state, stamp);
        Ok(())
    }

    /// What another program wrote is not wanted: the next save replaces it.
    pub fn keep_own(&mut self) {
        (self.stamp, self.saved_state) = (None, None);
    }

    /// What a session that did not end well left of this scene.
    pub fn recovery(&self) -> Option<&Recovery> {
        self.recovery.as_ref()
    }

    /// Takes it, as a step that undo takes back; the scene's file stays as it is until it is saved.
    pub fn recover(&mut self) -> Result<(), SceneError> {
        let Some(recovery) = self.recovery.take() else { return Ok(()) };
        self.commit(Edit::several("Recover", [Edit::Whole(Box::new(recovery.scene))]))
    }

    /// It is not wanted.
    pub fn discard_recovery(&mut self) {
        self.recovery = None;
        self.forget_recovery();
    }

    /// The end that the user chose: what is not saved is not wanted.
    pub fn close(mut self) {
        self.give_up();
    }

    /// What is not saved is not wanted: nothing is kept for the next start.
    pub fn give_up(&mut self) {
        self.cancel();
        self.saved_state = Some(self.state);
        self.write_notes();
        self.disk = None; // finishes what it writes
        self.recovery = None;
        recovery::remove(&self.project, &self.name);
    }

    fn forget_recovery(&mut self) {
        // One that was offered and not answered stays to be answered.
        if self.recovery.is_none() {
            let work = Work::ForgetRecovery { project: self.project.clone(), name: self.name.clone() };
            self.disk().ask(work);
        }
    }

    pub(super) fn write_notes(&mut self) {
        let notes = Notes { next_entity: self.next_entity, ..self.notes.clone() };
        if notes != self.written_notes {
            self.written_notes = notes.clone();
            let path = notes::path(&self.project, &self.name);
            self.disk().ask(Work::Notes { path, notes });
        }
    }
}

/// Ended by a panic, or by who forgot to ask: what is not saved is kept for the next start.
impl Drop for Document {
    fn drop(&mut self) {
        let drag: Option<Drag> = self.drag.take();
        let is_wanted = self.is_dirty() || drag.is_some_and(|drag| drag.back.is_some());
        self.disk = None; // finishes what it writes
        if is_wanted {
            // There is nobody left to tell.
            let _ = recovery::write(&self.project, &self.name, self.scene.scene());
        }
    }
}

pub fn read(path: &Path) -> Result<(Scene, Stamp), SceneError> {
    let bytes = std::fs::read(path).map_err(|source| SceneError::Io { path: path.to_owned(), source })?;
    let text = String::from_utf8_lossy(&bytes);
    Ok((scene_from_text(path, &text)?, Stamp::of(path, &bytes)))
}

/// Writes the file whole, unless another program changed it since it was known.
pub fn write_scene(path: &Path, known: Option<&Stamp>, scene: &Scene) -> Result<Stamp, SaveError> {
    if known.and_then(|known| known.changed(path)) == Some(Changed::Written) {
        return Err(SaveError::ChangedOutside { path: path.to_owned() });
    }
    let text = text_of_scene(path, scene).map_err(disk)?;
    write_atomically(path, text.as_bytes()).map_err(disk)?;
    Ok(Stamp::of(path, text.as_bytes()))
}

/// Writes a scene of a name that the project does not have yet.
pub fn write_new_scene(project: &Path, name: &str, scene: &Scene) -> Result<Stamp, SaveError> {
    check_name(name)?;
    let path = scene_path(project, name);
    if path.exists() {
        return Err(SaveError::Exists { path });
    }
    write_scene(&path, None, scene)
}

/// With what can be done about it.
fn disk(error: SceneError) -> SaveError {
    use std::io::ErrorKind;
    let SceneError::Io { source, .. } = &error else {
        return SaveError::Disk { error, remedy: "mend it and save again" };
    };
    let remedy = match source.kind() {
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
            "make the folder writable, or save in another project"
        }
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded | ErrorKind::FileTooLarge => {
            "make room on the disk and save again"
        }
        ErrorKind::NotADirectory | ErrorKind::AlreadyExists => {
            "a file stands where a folder has to be: move it away and save again"
        }
        _ => "save again, or under another name",
    };
    SaveError::Disk { error, remedy }
}

/// Usable as a file's name on every system.
pub fn is_name(name: &str) -> bool {
    let is_usable = |c: char| !c.is_control() && !r#"/\<>:"|?*"#.contains(c);
    !name.is_empty() && name.chars().all(is_usable) && name.trim_matches([' ', '.']) == name
}

fn check_name(name: &str) -> Result<(), SaveError> {
    if is_name(name) { Ok(()) } else { Err(SaveError::Name(name.to_owned())) }
}
