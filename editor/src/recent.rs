//! What the editor remembers for its user, whatever project is open: `preferences.ron` in the user's own folder.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use engine::scene::file::{from_text, write};
use engine::scene::{SceneError, Warning};
use serde::{Deserialize, Serialize};

/// Older ones are read, newer ones are left alone.
const VERSION: u32 = 1;
const MOST_RECENT: usize = 12;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Preferences {
    pub version: u32,
    pub theme: Theme,
    /// Of all text and controls; 1 is as the display asks for.
    pub ui_scale: f32,
    /// Folders, the latest first.
    pub recent_projects: Vec<PathBuf>,
    /// Shortcuts that differ from the table's, by the command's id. None: no shortcut.
    pub shortcuts: BTreeMap<String, Vec<String>>,
    /// How the panels lie, as the windows wrote it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub layout: Option<String>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Theme {
    #[default]
    Dark,
    Light,
}

impl Default for Preferences {
    fn default() -> Self {
        Self {
            version: VERSION,
            theme: Theme::default(),
            ui_scale: 1.0,
            recent_projects: Vec::new(),
            shortcuts: BTreeMap::new(),
            layout: None,
        }
    }
}

/// The user's own folder for this program. `None`: the system names none.
pub fn folder() -> Option<PathBuf> {
    let chosen = std::env::var_os("HOHLRAUM_CONFIG").map(PathBuf::from);
    let usual = || Some(directories::ProjectDirs::from("", "", "hohlraum")?.config_dir().to_owned());
    chosen.or_else(usual)
}

fn path(folder: &Path) -> PathBuf {
    folder.join("preferences.ron")
}

impl Preferences {
    /// Those of a folder, or the usual ones where it has none. A damaged file is put aside and told once.
    pub fn load(folder: &Path) -> (Self, Option<Warning>) {
        let path = path(folder);
        let Ok(bytes) = std::fs::read(&path) else { return (Self::default(), None) };
        match Self::read(&path, &String::from_utf8_lossy(&bytes)) {
            Ok(preferences) => (preferences.checked(), None),
            Err(error) => {
                let aside = path.with_extension("broken.ron");
                let moved = std::fs::rename(&path, &aside).map(|()| aside.display().to_string());
                let message = format!(
                    "preferences are as they were at first, {} ({error})",
                    moved.map_or("the file is left alone".to_owned(), |aside| format!(
                        "the old ones are in {aside}"
                    ))
                );
                (Self::default(), Some(Warning::new(path.display().to_string(), message)))
            }
        }
    }

    fn read(path: &Path, text: &str) -> Result<Self, SceneError> {
        let preferences: Self = from_text(path, text)?;
        if preferences.version > VERSION {
            let message = format!("is of version {}, of a newer program", preferences.version);
            return Err(SceneError::File { path: path.to_owned(), message });
        }
        Ok(preferences)
    }

    /// Numbers that no window could show are those of the start.
    fn checked(mut self) -> Self {
        if !(0.5..=4.0).contains(&self.ui_scale) {
            self.ui_scale = 1.0;
        }
        self.recent_projects.truncate(MOST_RECENT);
        self.version = VERSION;
        self
    }

    pub fn save(&self, folder: &Path) -> Result<(), SceneError> {
        write(&path(folder), self)
    }

    /// The project comes to stand first.
    pub fn opened(&mut self, project: &Path) {
        let project = std::path::absolute(project).unwrap_or_else(|_| project.to_owned());
        self.recent_projects.retain(|other| *other != project);
        self.recent_projects.insert(0, project);
        self.recent_projects.truncate(MOST_RECENT);
    }

    /// Those that are still there. Looks at the disk.
    pub fn existing_projects(&self) -> impl Iterator<Item = &Path> {
        let is_project = |project: &&PathBuf| engine::scene::file::project_path(project).is_file();
        self.recent_projects.iter().filter(is_project).map(PathBuf::as_path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn preferences_come_back_and_the_latest_project_stands_first() {
        let folder = tempfile::tempdir().unwrap();
        let (mut preferences, warning) = Preferences::load(folder.path());
        assert!(warning.is_none());
        for n in 0..20 {
            preferences.opened(Path::new(&format!("/projects/{}", n % 15)));
        }
        preferences.theme = Theme::Light;
        preferences.shortcuts.insert("file.save".to_owned(), vec!["Ctrl+Alt+S".to_owned()]);
        preferences.save(folder.path()).unwrap();
        let (loaded, warning) = Preferences::load(folder.path());
        assert!(warning.is_none());
        assert_eq!(loaded, preferences);
        assert_eq!(
            (loaded.recent_projects.len(), loaded.recent_projects[0].as_path()),
            (12, Path::new("/projects/4"))
        );
        assert_eq!(loaded.existing_projects().count(), 0);
    }

    #[test]
    fn damaged_preferences_are_put_aside_and_told_once() {
        for damage in ["(version: 1, theme: da", "(version: 99)", "\u{0}\u{1}", "(ui_scale: 1e9, version: 1)"]
        {
            let folder = tempfile::tempdir().unwrap();
            std::fs::write(path(folder.path()), damage).unwrap();
            let (loaded, warning) = Preferences::load(folder.path());
            assert_eq!(loaded, Preferences::default(), "{damage}");
            assert_eq!(warning.is_none(), damage.contains("1e9"), "{damage}");
            if warning.is_some() {
                assert_eq!(
                    std::fs::read_to_string(folder.path().join("preferences.broken.ron")).unwrap(),
                    damage
                );
            }
            assert!(Preferences::load(folder.path()).1.is_none(), "told once: {damage}");
        }
    }
}
