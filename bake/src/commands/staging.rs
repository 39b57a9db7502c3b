//! A project that is being built beside its place, and is moved there when it is whole.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use engine::scene::file::project_path;
use tempfile::TempDir;

/// What a new project brings, `project.ron` last: a folder is a project only when all of it is there.
const PARTS: [&str; 3] = ["assets", "scenes", "project.ron"];

/// Removed when it is dropped.
pub struct Staging {
    folder: TempDir,
    target: PathBuf,
}

impl Staging {
    /// Refuses a target that is a project already or that holds what a project would overwrite; touches nothing.
    pub fn beside(target: &Path) -> Result<Self> {
        let named = || target.display().to_string();
        if project_path(target).exists() {
            bail!("{}: is a project already; choose another folder", named());
        }
        if target.exists() && !target.is_dir() {
            bail!("{}: is no folder; choose another name", named());
        }
        if let Some(part) = PARTS.iter().find(|part| target.join(part).symlink_metadata().is_ok()) {
            bail!("{}: has `{part}` already; choose an empty folder", named());
        }
        let target = std::path::absolute(target).with_context(named)?;
        // On the same file system as the target, so that a rename suffices.
        let parent = if target.is_dir() { &target } else { target.parent().unwrap_or(&target) };
        if !parent.is_dir() {
            bail!("{}: there is no such folder to make a project in", parent.display());
        }
        let folder =
            tempfile::Builder::new().prefix(".hohlraum-new-").tempdir_in(parent).with_context(named)?;
        Ok(Self { folder, target })
    }

    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Moves everything to its place, or takes back what was moved.
    pub fn install(self) -> Result<()> {
        let made = !self.target.is_dir();
        std::fs::create_dir_all(&self.target).with_context(|| self.target.display().to_string())?;
        for (moved, part) in PARTS.iter().enumerate() {
            let place = self.target.join(part);
            if let Err(error) = std::fs::rename(self.path().join(part), &place) {
                self.take_back(&PARTS[..moved], made);
                return Err(error).with_context(|| place.display().to_string());
            }
        }
        Ok(())
    }

    fn take_back(&self, parts: &[&str], made: bool) {
        for part in parts {
            // Back into the folder that is removed in a moment.
            let _ = std::fs::rename(self.target.join(part), self.path().join(part));
        }
        if made {
            let _ = std::fs::remove_dir(&self.target);
        }
    }
}
