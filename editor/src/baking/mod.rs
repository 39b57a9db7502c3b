//! The bake beside the editing: on threads of its own, of the scene as it stands, saved or not. The editor goes on and
//! swaps the transport in when it is there.

pub mod density;
pub mod patches;
mod progress;

use std::path::Path;
use std::sync::Arc;

use bake::{BakeError, Settings};
use engine::scene::assets::Assets;
use engine::scene::file::{Quality, load_project};
use engine::scene::{Scene, Warning};
use engine::transport::key::{BakeWith, inputs};
use engine::transport::stale::Stale as Difference;
use engine::transport::{Certificate, Transport, file};

use crate::document::Document;
use crate::edit::Stale;
use crate::job::Job;
pub use progress::{Meter, Progress};

/// What the badge tells.
#[derive(Clone, Debug, PartialEq)]
pub enum Badge {
    /// There is no bake: direct light alone.
    Missing,
    /// The bake was made of this scene.
    Current,
    /// The scene has changed since, but in nothing that the bake minds.
    LightOnly,
    /// What the bake minds has changed: bake again. Why, where it is known.
    Stale(String),
}

/// A bake's light.
pub struct Baked {
    pub transport: Arc<Transport>,
    pub warnings: Vec<Warning>,
    /// The scene that was baked, as long as it is not the one on disk: edits go on while a bake does.
    scene: Option<Arc<Scene>>,
    /// The state of the document that it was made of or found with.
    state: Option<u64>,
    /// The document's revision that it was compared with, and what it differed by.
    revision: u64,
    differs: Difference,
}

impl Baked {
    /// Without what is stale of it, as the player leaves it out. `None`: nothing can be told of it.
    pub fn fitting(&self) -> Option<Arc<Transport>> {
        if self.transport.certificate.inputs.is_empty() {
            return None;
        }
        if self.differs.is_empty() {
            return Some(self.transport.clone());
        }
        let mut transport = Transport::clone(&self.transport);
        transport.leave_out(&self.differs);
        Some(Arc::new(transport))
    }
}

/// A bake that goes on.
struct Bake {
    job: Job<Result<Baked, BakeError>>,
    meter: Arc<Meter>,
}

/// The bake that is shown, and the one that is made.
#[derive(Default)]
pub struct Baking {
    shown: Option<Baked>,
    bake: Option<Bake>,
    compare: Option<Job<(u64, Difference)>>,
    /// A file that the scene refers to has changed: no edit says so.
    doubted: bool,
}

impl Baking {
    pub fn show(&mut self, baked: Baked) {
        self.shown = Some(baked);
    }

    /// A file that the scene refers to has changed: the bake counts as stale until it was compared.
    pub fn doubt(&mut self) {
        (self.doubted, self.compare) = (true, None);
    }

    /// What it differs by from the scene, as far as that was compared: [`Transport::leave_out`] wants to know.
    pub fn differs(&self) -> Option<&Difference> {
        Some(&self.shown.as_ref()?.differs)
    }

    pub fn transport(&self) -> Option<&Arc<Transport>> {
        Some(&self.shown.as_ref()?.transport)
    }

    /// What was baked last in this session: where everything in the bake is.
    pub fn scene(&self) -> Option<&Arc<Scene>> {
        self.shown.as_ref()?.scene.as_ref()
    }

    /// Starts one, unless one goes on. One core is left to the editor.
    pub fn start(&mut self, document: &Document, settings: Settings) -> Result<(), String> {
        if self.bake.is_some() {
            return Err("a bake goes on already".to_owned());
        }
        let threads = std::thread::available_parallelism().map_or(1, |cores| (cores.get() - 1).max(1));
        let settings = Settings { threads: settings.threads.or(Some(threads)), ..settings };
        let meter = Arc::new(Meter::default());
        let (project, name) = (document.project().to_owned(), document.name().to_owned());
        let (scene, watcher) = (document.scene().clone(), meter.clone());
        let (state, revision) = (document.state(), document.revision());
        let work = move || {
            let made_of = Some(Arc::new(scene.clone()));
            let baked = bake::bake_scene(&project, &name, scene, &settings, &*watcher)?;
            let (transport, differs) = (Arc::new(baked.transport), Difference::default());
            Ok(Baked { transport, warnings: baked.warnings, scene: made_of, state, revision, differs })
        };
        let job = Job::start("bake", work).map_err(|error| format!("the bake cannot start: {error}"))?;
        self.bake = Some(Bake { job, meter });
        Ok(())
    }

    /// It stops within a second and keeps what can be used by the next.
    pub fn cancel(&self) {
        if let Some(bake) = &self.bake {
            bake.meter.cancel();
        }
    }

    pub fn progress(&self) -> Option<Progress> {
        self.bake.as_ref().map(|bake| bake.meter.progress())
    }

    /// To be called with every picture: the bake that has just ended. Its light is shown from then on, where there
    /// is any; a bake whose certificate does not hold is an error, and what was shown stays.
    pub fn poll(&mut self) -> Option<Result<Vec<Warning>, String>> {
        self.take_comparison();
        let ended = self.bake.as_mut()?.job.poll()?;
        self.bake = None;
        let baked = match ended {
            Ok(Ok(baked)) => baked,
            Ok(Err(error)) => return Some(Err(bake::chain::told(&error))),
            Err(panicked) => return Some(Err(panicked)),
        };
        if let Some(broken) = baked.transport.certificate.broken() {
            return Some(Err(format!("the bake's certificate does not hold: {broken}")));
        }
        let warnings = baked.warnings.clone();
        self.compare = None; // with what was shown before
        self.shown = Some(baked);
        Some(Ok(warnings))
    }

    /// What the badge tells of the scene as it is. Where an edit may have touched what the bake minds, it counts as
    /// stale until [`Self::compare`] has found that it did not.
    pub fn badge(&self, document: &Document) -> Badge {
        let Some(shown) = &self.shown else { return Badge::Missing };
        match document.stale_since(shown.revision) {
            Stale::Transport => Badge::Stale(String::new()),
            _ if self.doubted => Badge::Stale("A file that the scene refers to has changed".to_owned()),
            _ if !shown.differs.is_empty() => Badge::Stale(shown.differs.to_string()),
            _ if shown.state.is_some() && shown.state == document.state() => Badge::Current,
            _ => Badge::LightOnly,
        }
    }

    /// Reads all that the bake depends on, on a thread of its own, where an edit may have touched it: an undone edit
    /// fits again. `assets`: what the scene refers to.
    pub fn compare(&mut self, document: &Document, assets: &Arc<Assets>) {
        let Some(shown) = &self.shown else { return };
        let is_known = document.stale_since(shown.revision) < Stale::Transport && !self.doubted;
        if self.compare.is_some() || is_known || document.is_dragging() {
            return;
        }
        let (scene, assets, revision) = (document.scene().clone(), assets.clone(), document.revision());
        let (project, transport) = (document.project().to_owned(), shown.transport.clone());
        let compare = move || (revision, difference(&project, &transport.certificate, &scene, &assets));
        // Without a thread the badge stays as careful as it was.
        self.compare = Job::start("compare bake", compare).ok();
    }

    fn take_comparison(&mut self) {
        let Some(compared) = self.compare.as_mut().and_then(Job::poll) else { return };
        self.compare = None;
        if let (Ok((revision, differs)), Some(shown)) = (compared, &mut self.shown) {
            self.doubted = false;
            (shown.revision, shown.differs) = (revision, differs);
        }
    }
}

/// The bake of a document that lies on disk, whatever of it is stale; none is none. It reads the whole file: call it from
/// where scenes are opened, not from a picture.
pub fn load(document: &Document, assets: &Assets) -> Result<Option<Baked>, String> {
    let (project, name) = (document.project(), document.name());
    if !file::path(project, name).is_file() && !file::full_path(project, name).is_file() {
        return Ok(None);
    }
    let transport = file::load_full(project, name).map_err(|error| bake::chain::told(&error))?;
    let differs = difference(project, &transport.certificate, document.scene(), assets);
    let (state, revision) = (document.state(), document.revision());
    let transport = Arc::new(transport);
    Ok(Some(Baked { transport, warnings: Vec::new(), scene: None, state, revision, differs }))
}

/// Between what was baked and a scene, with the features that its project asks for. Reads the project's settings.
pub fn difference(project: &Path, certificate: &Certificate, scene: &Scene, assets: &Assets) -> Difference {
    let with = BakeWith {
        quality: Quality::default(), // a name for rays and length
        rays: certificate.rays_per_row,
        length: certificate.base_length,
    };
    let features = load_project(project).unwrap_or_default().features;
    Difference::between(&certificate.inputs, &inputs(scene, assets, &with, &features))
}

/// The editor that ends does not wait for a bake that nobody will see.
impl Drop for Baking {
    fn drop(&mut self) {
        self.cancel();
    }
}
