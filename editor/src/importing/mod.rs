//! Files of others, brought into the project beside the editing: copied, read, and made ready on a thread of its own.
//! What goes wrong leaves the project as it was.

mod again;
mod copied;
mod imports;
pub mod load;
mod ready;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::thread::JoinHandle;

use engine::scene::assets::Assets;
use engine::scene::file::write;
use engine::scene::import::settings::{self, ImportSettings};
use engine::scene::import::{import, load_assets};
use engine::scene::{ImageSource, Scene, SceneError};

use crate::assets::{Kind, kind};
pub use again::{Record, reimport};
use copied::Copied;
pub use imports::{Ended, Going, Imports, Then};
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

/// Why nothing came of an import.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Failed {
    /// It was to go no farther.
    #[error("the import was cancelled")]
    Cancelled,
    /// Names the file.
    #[error("{0}")]
    Refused(String),
}

impl From<String> for Failed {
    fn from(why: String) -> Self {
        Self::Refused(why)
    }
}

/// What is to be brought in, and how.
#[derive(Clone, Default)]
pub struct Order {
    pub project: PathBuf,
    /// From anywhere; what lies in the project's `assets` already is read where it is.
    pub source: PathBuf,
    /// `None`: those that lie beside it, else the usual ones.
    pub settings: Option<ImportSettings>,
    /// Where the file stands in the scene of this name is told with the result.
    pub scene: Option<String>,
    /// What is in memory: what the file still says the same stays what it is.
    pub known: Arc<Assets>,
}

/// An import that goes on.
pub struct Job {
    /// What is imported.
    pub source: PathBuf,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<Result<Ready, Failed>>>,
}

#[derive(Default)]
struct Shared {
    stage: AtomicU8,
    cancelled: AtomicBool,
}

impl Shared {
    /// Refused when it was cancelled meanwhile.
    fn enter(&self, stage: Stage) -> Result<(), Failed> {
        self.stage.store(stage as u8, Ordering::Relaxed);
        if self.cancelled.load(Ordering::Relaxed) { Err(Failed::Cancelled) } else { Ok(()) }
    }
}

impl Job {
    /// A file from anywhere; one that lies in the project's `assets` already is read where it is.
    pub fn start(project: &Path, source: &Path, settings: ImportSettings) -> Result<Self, Failed> {
        let (project, source) = (project.to_owned(), source.to_owned());
        Self::carry_out(Order { project, source, settings: Some(settings), ..Order::default() })
    }

    pub fn carry_out(order: Order) -> Result<Self, Failed> {
        let shared = Arc::new(Shared::default());
        let (source, told) = (order.source.clone(), shared.clone());
        let work = move || run(&order, &told);
        let thread = std::thread::Builder::new().name("import".to_owned()).spawn(work);
        let thread = thread.map_err(|error| format!("{}: cannot be imported: {error}", source.display()))?;
        Ok(Self { source, shared, thread: Some(thread) })
    }

    pub fn stage(&self) -> Stage {
        STAGES[usize::from(self.shared.stage.load(Ordering::Relaxed)).min(STAGES.len() - 1)]
    }

    /// It ends at its next stage, and nothing of it stays.
    pub fn cancel(&self) {
        self.shared.cancelled.store(true, Ordering::Relaxed);
    }

    /// To be called with every picture: what came of it, once. Errors name the file.
    pub fn poll(&mut self) -> Option<Result<Ready, Failed>> {
        let thread = self.thread.take_if(|thread| thread.is_finished())?;
        let told = || format!("{}: importing it failed: see the terminal", self.source.display());
        let panicked = |_| Err(Failed::Refused(told()));
        Some(thread.join().unwrap_or_else(panicked))
    }
}

/// Nobody waits for what nobody will see.
impl Drop for Job {
    fn drop(&mut self) {
        self.cancel();
    }
}

fn run(order: &Order, shared: &Shared) -> Result<Ready, Failed> {
    shared.enter(Stage::Copying)?;
    let Order { project, source, .. } = order;
    let is_picture = kind(&source.to_string_lossy()) == Kind::Picture;
    let inside = inside(project, source);
    let copied = match &inside {
        Some(_) => None,
        None if is_picture => Some(Copied::picture(project, source)?),
        None => Some(Copied::of(project, source).map_err(|error| bake::chain::told(error.as_ref()))?),
    };
    let file = inside.or(copied.as_ref().map(|copied| copied.file.clone())).unwrap_or_default();
    let ready = if is_picture { picture(project, &file, shared) } else { model(order, &file, shared) }?;
    copied.into_iter().for_each(Copied::keep);
    Ok(ready)
}

/// With the settings that were ordered; those that were there come back where it is refused.
fn model(order: &Order, file: &str, shared: &Shared) -> Result<Ready, Failed> {
    let path = order.project.join(file);
    let before = std::fs::read(settings::path(&path)).ok();
    if let Some(settings) = &order.settings {
        write_settings(&path, settings).map_err(|error| bake::chain::told(&error))?;
    }
    let read = read(&order.project, file, shared);
    if read.is_err() && order.settings.is_some() {
        restore_settings(&path, before);
    }
    let mut ready = read?;
    load::keep_what_is_the_same(&mut ready.assets, &order.known);
    if let Some(scene) = &order.scene {
        ready.records = Record::all(&order.project, scene, file);
    }
    Ok(ready)
}

fn read(project: &Path, file: &str, shared: &Shared) -> Result<Ready, Failed> {
    let told = |error: SceneError| bake::chain::told(&error);
    shared.enter(Stage::Reading)?;
    let imported = import(project, file).map_err(told)?;
    shared.enter(Stage::Loading)?;
    let (assets, warnings) = load_assets(project, &imported.scene).map_err(told)?;
    shared.enter(Stage::Done)?;
    let warnings = imported.warnings.into_iter().chain(warnings).collect();
    let (file, scene, assets) = (file.to_owned(), imported.scene, Arc::new(assets));
    Ok(Ready { file, scene, assets, warnings, records: Vec::new() })
}

/// A picture stands in no scene by itself: materials show it.
fn picture(project: &Path, file: &str, shared: &Shared) -> Result<Ready, Failed> {
    shared.enter(Stage::Loading)?;
    let source = ImageSource { file: file.to_owned(), image: None };
    let picture = load::picture(project, &source)?;
    shared.enter(Stage::Done)?;
    let mut assets = Assets::default();
    assets.images.insert(source, picture);
    let (file, scene, warnings, records) = (file.to_owned(), Scene::default(), Vec::new(), Vec::new());
    Ok(Ready { file, scene, assets: Arc::new(assets), warnings, records })
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
