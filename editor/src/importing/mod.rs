//! Files of others, brought into the project beside the editing: copied, read, and made ready on a thread of its own.
//! What goes wrong leaves the project as it was.

mod again;
mod ready;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::thread::JoinHandle;

use engine::scene::SceneError;
use engine::scene::file::write;
use engine::scene::import::settings::{self, ImportSettings, stem};
use engine::scene::import::{import, load_assets};

pub use again::{Record, reimport};
pub use ready::Ready;

/// What the thread is at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Stage {
    Copying,
    Reading,
    /// Meshes and pictures.
    Loading,
    Done,
}

const STAGES: [Stage; 4] = [Stage::Copying, Stage::Reading, Stage::Loading, Stage::Done];

impl Stage {
    pub fn name(self) -> &'static str {
        match self {
            Self::Copying => "copying",
            Self::Reading => "reading",
            Self::Loading => "loading meshes and pictures",
            Self::Done => "done",
        }
    }

    /// 0..1, of a file of the usual kind: most of the time goes into decoding what lies in it.
    pub fn share(self) -> f32 {
        [0.0, 0.2, 0.4, 1.0][self as usize]
    }
}

/// An import that goes on.
pub struct Job {
    /// What is imported.
    pub source: PathBuf,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<Result<Ready, String>>>,
}

#[derive(Default)]
struct Shared {
    stage: AtomicU8,
    cancelled: AtomicBool,
}

impl Shared {
    /// Refused when it was cancelled meanwhile.
    fn enter(&self, stage: Stage) -> Result<(), String> {
        self.stage.store(stage as u8, Ordering::Relaxed);
        if self.cancelled.load(Ordering::Relaxed) {
            Err("the import was cancelled".to_owned())
        } else {
            Ok(())
        }
    }
}

impl Job {
    /// A file from anywhere; one that lies in the project's `assets` already is read where it is.
    pub fn start(project: &Path, source: &Path, settings: ImportSettings) -> Result<Self, String> {
        let shared = Arc::new(Shared::default());
        let (project, file, told) = (project.to_owned(), source.to_owned(), shared.clone());
        let work = move || run(&project, &file, settings, &told);
        let thread = std::thread::Builder::new().name("import".to_owned()).spawn(work);
        let thread = thread.map_err(|error| format!("{}: cannot be imported: {error}", source.display()))?;
        Ok(Self { source: source.to_owned(), shared, thread: Some(thread) })
    }

    pub fn stage(&self) -> Stage {
        STAGES[usize::from(self.shared.stage.load(Ordering::Relaxed)).min(STAGES.len() - 1)]
    }

    /// It ends at its next stage, and nothing of it stays.
    pub fn cancel(&self) {
        self.shared.cancelled.store(true, Ordering::Relaxed);
    }

    /// To be called with every picture: what came of it, once. Errors name the file.
    pub fn poll(&mut self) -> Option<Result<Ready, String>> {
        let thread = self.thread.take_if(|thread| thread.is_finished())?;
        let panicked = |_| Err(format!("{}: importing it failed: see the terminal", self.source.display()));
        Some(thread.join().unwrap_or_else(panicked))
    }
}

/// Nobody waits for what nobody will see.
impl Drop for Job {
    fn drop(&mut self) {
        self.cancel();
    }
}

fn run(project: &Path, source: &Path, settings: ImportSettings, shared: &Shared) -> Result<Ready, String> {
    shared.enter(Stage::Copying)?;
    let inside = inside(project, source);
    let copied = match &inside {
        Some(_) => None,
        None => Some(Copied::of(project, source).map_err(|error| bake::chain::told(error.as_ref()))?),
    };
    let file = inside.or(copied.as_ref().map(|copied| copied.file.clone())).unwrap_or_default();
    let told = |error: SceneError| bake::chain::told(&error);
    let path = project.join(&file);
    let before = std::fs::read(settings::path(&path)).ok();
    write_settings(&path, &settings).map_err(told)?;
    match read(project, &file, shared) {
        Ok(ready) => {
            copied.into_iter().for_each(Copied::keep);
            Ok(ready)
        }
        Err(error) => {
            restore_settings(&path, before);
            Err(error)
        }
    }
}

fn read(project: &Path, file: &str, shared: &Shared) -> Result<Ready, String> {
    let told = |error: SceneError| bake::chain::told(&error);
    shared.enter(Stage::Reading)?;
    let imported = import(project, file).map_err(told)?;
    shared.enter(Stage::Loading)?;
    let (assets, warnings) = load_assets(project, &imported.scene).map_err(told)?;
    shared.enter(Stage::Done)?;
    let warnings = imported.warnings.into_iter().chain(warnings).collect();
    Ok(Ready { file: file.to_owned(), scene: imported.scene, assets: Arc::new(assets), warnings })
}

/// The path in the project, of what lies in its `assets`.
fn inside(project: &Path, source: &Path) -> Option<String> {
    let (project, source) = (project.canonicalize().ok()?, source.canonicalize().ok()?);
    let below = source.strip_prefix(project).ok()?;
    let names: Option<Vec<&str>> = below.iter().map(|name| name.to_str()).collect();
    names.filter(|names| names.first() == Some(&"assets")).map(|names| names.join("/"))
}

/// The usual ones need no file.
fn write_settings(file: &Path, settings: &ImportSettings) -> Result<(), SceneError> {
    let path = settings::path(file);
    if *settings != ImportSettings::default() || path.exists() { write(&path, settings) } else { Ok(()) }
}

fn restore_settings(file: &Path, before: Option<Vec<u8>>) {
    let path = settings::path(file);
    // A failure here is the second of its kind, and the first is told.
    let _ = match before {
        Some(bytes) => std::fs::write(path, bytes),
        None => std::fs::remove_file(path),
    };
}

/// Where the settings of a file lie.
pub fn settings_path(file: &Path) -> PathBuf {
    settings::path(file)
}

/// Is it such a file?
pub fn is_settings(name: &str) -> bool {
    name.ends_with(".import.ron")
}

/// A file and what it refers to, in the project; gone again unless it is kept.
struct Copied {
    folder: PathBuf,
    /// Relative to the project.
    file: String,
    kept: bool,
}

impl Copied {
    /// Into a folder of its own, that moves to its place when it is whole.
    fn of(project: &Path, source: &Path) -> anyhow::Result<Self> {
        let assets = project.join("assets");
        std::fs::create_dir_all(&assets)?;
        let staging = tempfile::Builder::new().prefix(".import-").tempdir_in(&assets)?;
        let name = usable(&stem(&source.file_name().unwrap_or_default().to_string_lossy()));
        let staged = bake::adopt::adopt(staging.path(), &name, source)?;
        let (folder, free) = move_in(&staging.path().join("assets").join(&name), &assets, &name)?;
        let below = staged.strip_prefix(&format!("assets/{name}/")).unwrap_or(&staged).to_owned();
        Ok(Self { folder, file: format!("assets/{free}/{below}"), kept: false })
    }

    fn keep(mut self) {
        self.kept = true;
    }
}

impl Drop for Copied {
    fn drop(&mut self) {
        if !self.kept {
            let _ = std::fs::remove_dir_all(&self.folder);
        }
    }
}

/// Under the first name that is free: `chair`, `chair-2`, `chair-3`.
fn move_in(staged: &Path, assets: &Path, name: &str) -> anyhow::Result<(PathBuf, String)> {
    let numbered = (2..10_000).map(|n| format!("{name}-{n}"));
    for free in std::iter::once(name.to_owned()).chain(numbered) {
        let folder = assets.join(&free);
        if !folder.exists() {
            std::fs::rename(staged, &folder)?;
            return Ok((folder, free));
        }
    }
    anyhow::bail!("{}: has no name left for `{name}`", assets.display())
}

/// As a folder's name on every system.
fn usable(stem: &str) -> String {
    let replaced = |c: char| if c.is_control() || r#"/\<>:"|?*"#.contains(c) { '_' } else { c };
    let name: String = stem.chars().map(replaced).collect();
    let name = name.trim_matches([' ', '.']);
    if name.is_empty() { "model".to_owned() } else { name.to_owned() }
}
