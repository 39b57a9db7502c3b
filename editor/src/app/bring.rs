//! Files on their way into the project and into the scene. All that asks a disk goes on beside the editing; here is asked for
//! it, and what came of it is taken.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{self, Receiver};

use eframe::egui::{Context, Ui};
use engine::scene::assets::Assets;
use engine::scene::import::settings::ImportSettings;
use engine::scene::{MeshSource, Scene, Warning, shape};

use super::Editor;
use crate::assets::{self, Place, Wish};
use crate::importing::{Ended, Failed, Imports, Order, Ready, Record, Then, load, reimport};
use crate::layout::{self, Pane};
use crate::log::Source;
use crate::watch::Changed;

/// What goes on with files.
#[derive(Default)]
pub(crate) struct Bring {
    pub imports: Imports,
    /// What the scene refers to and memory does not hold, being read.
    loading: Option<Receiver<Loaded>>,
    /// Files that were tried in vain; tried again when they change.
    hopeless: HashSet<String>,
    /// The document's revision that is complete.
    complete: Option<u64>,
    /// On disk: moved, deleted.
    work: Vec<Receiver<Done>>,
    /// Of this session: where the files of undone renames are.
    moved: Vec<(String, String)>,
    /// Dropped by the desktop, which does not say where: the mouse does when it is seen again. With the pictures waited.
    pub(super) dropped: Option<(Vec<PathBuf>, u32)>,
}

/// What was read, and the files that were asked for.
struct Loaded {
    assets: Assets,
    warnings: Vec<Warning>,
    files: HashSet<String>,
}

/// What a disk was asked for.
enum Done {
    Moved {
        from: String,
        to: String,
        result: Result<Vec<String>, String>,
    },
    /// A file that an undone step refers to is where it was.
    MovedBack {
        to: String,
        result: Result<(), String>,
    },
    Deleted {
        file: String,
        result: Result<(), String>,
    },
    Folder(Result<String, String>),
    Recorded(Result<(), String>),
}

impl Editor {
    pub(crate) fn wish(&mut self, wish: Wish, ui: &Ui) {
        let goes_always = matches!(wish, Wish::CancelImport | Wish::Reveal { .. } | Wish::RevealMaterial(_));
        if self.play.is_some() && !goes_always {
            return self.session.log.warning(Source::Nothing, "Stop playing first: files wait until then");
        }
        match wish {
            Wish::Bring { sources, settings, place } => {
                let then = || place.map_or(Then::Keep, Then::Place);
                sources.into_iter().for_each(|source| self.import(source, settings, then()));
            }
            Wish::Place { file, place } => {
                let source = self.session.document.project().join(file);
                self.import(source, None, Then::Place(place));
            }
            Wish::Again { file, settings } => {
                let source = self.session.document.project().join(file);
                self.import(source, settings, Then::Again);
            }
            Wish::RelinkFrom { from, source } => self.import(source, None, Then::Relink(from)),
            Wish::Relink { from, to } => self.relink(&from, &to),
            Wish::Move { from, to } => self.on_disk(ui.ctx(), move |project| {
                let result = assets::rename(project, &from, &to);
                Done::Moved { from, to, result }
            }),
            Wish::Delete { file } => self.on_disk(ui.ctx(), move |project| {
                let result = assets::delete(project, &file);
                Done::Deleted { file, result }
            }),
            Wish::NewFolder { below } => {
                self.on_disk(ui.ctx(), move |project| Done::Folder(assets::new_folder(project, &below)));
            }
            Wish::AskForRelink { from } => self.files.ask_for_relink(&from),
            Wish::AskForImport => self.files.ask_for_import(),
            Wish::CancelImport => self.bring.imports.cancel(),
            Wish::Reveal { file } => {
                layout::reveal(&mut self.layout, Pane::Assets);
                self.files.reveal(self.session.document.project(), &file);
            }
            Wish::RevealMaterial(material) => {
                layout::reveal(&mut self.layout, Pane::Assets);
                self.files.reveal_material(material);
            }
            Wish::Refuse { file, why } => self.session.log.error(Source::File(file.into()), why),
        }
        ui.ctx().request_repaint();
    }

    pub(super) fn import(&mut self, source: PathBuf, settings: Option<ImportSettings>, then: Then) {
        let document = &self.session.document;
        let scene = (then == Then::Again).then(|| document.name().to_owned());
        let (project, known) = (document.project().to_owned(), self.assets.clone());
        self.session.log.info(format!("Importing {}", source.display()));
        self.bring.imports.push(Order { project, source, settings, scene, known }, then);
    }

    /// With every picture. Waits for nothing.
    pub(super) fn take_files(&mut self, ui: &Ui) {
        self.take_dropped(ui);
        if let Some(ended) = self.bring.imports.poll() {
            self.take_import(ended, ui);
        }
        let mut done = Vec::new();
        self.bring.work.retain(|work| {
            let answer = work.try_recv();
            let goes_on = matches!(answer, Err(mpsc::TryRecvError::Empty));
            done.extend(answer.ok());
            goes_on
        });
        done.into_iter().for_each(|done| self.take_done(done, ui.ctx()));
        self.complete(ui.ctx());
        let waits = !self.bring.imports.is_idle() || !self.bring.work.is_empty() || self.files.is_listing();
        if waits || self.bring.loading.is_some() {
            ui.ctx().request_repaint_after(std::time::Duration::from_millis(30));
        }
    }

    fn take_import(&mut self, ended: Ended, ui: &Ui) {
        let Ended { name, then, result } = ended;
        let log = self.session.log.clone();
        let ready = match result {
            Ok(ready) => ready,
            // The user wished so: it is no error.
            Err(Failed::Cancelled) => {
                return log.info(format!("The import of {name} was cancelled: nothing of it stays"));
            }
            Err(Failed::Refused(why)) => return log.error(Source::File(name.into()), why),
        };
        log.warnings(&ready.warnings, &ready.scene);
        load::add_shared(Arc::make_mut(&mut self.assets), &ready.assets);
        self.bring.hopeless.remove(&ready.file);
        self.thumbnails.forget(&ready.file);
        self.files.refresh();
        match then {
            Then::Place(place) if !ready.scene.entities.is_empty() => self.place(&ready, place, ui),
            Then::Again => self.again(&ready, ui.ctx()),
            Then::Relink(from) => self.relink(&from, &ready.file),
            Then::Keep | Then::Place(_) => log.info(format!("{name} lies in the project as {}", ready.file)),
        }
    }

    fn place(&mut self, ready: &Ready, place: Place, ui: &Ui) {
        let document = &mut self.session.document;
        let (edit, root, record) = match place {
            Place::At(at) => ready.place(document, at),
            Place::Under(parent) => ready.place_under(document, glam::DVec3::ZERO, Some(parent)),
        };
        if self.session.commit(edit) {
            self.record(record, ui.ctx());
            self.carry_out(crate::intents::Intent::Select(vec![root]), ui);
            let count = ready.scene.entities.len();
            let objects = if count == 1 { "object" } else { "objects" };
            self.session.log.info(format!("Imported {}: {count} {objects}", ready.file));
            self.asks.push(crate::ask::Ask::Fit(vec![root]));
        }
    }

    /// What is to be known when the file is imported again.
    fn record(&mut self, record: Record, ctx: &Context) {
        let name = self.session.document.name().to_owned();
        self.on_disk(ctx, move |project| {
            let saved = record.save(project, &name);
            Done::Recorded(saved.map_err(|error| bake::chain::told(&error)))
        });
    }

    /// Every placement of a file follows what it says now, except in what was edited since.
    fn again(&mut self, ready: &Ready, ctx: &Context) {
        let placed = ready.records.iter().filter(|r| self.session.document.entity(r.root).is_some());
        let placed: Vec<Record> = placed.cloned().collect();
        for record in &placed {
            let (edit, next, warnings) = reimport(&mut self.session.document, record, ready);
            if self.session.commit(edit) {
                self.session.log.warnings(&warnings, self.session.document.scene());
                self.record(next, ctx);
            }
        }
        self.changed_beneath();
        self.session.log.info(format!(
            "{} was imported again: it stands in {} places",
            ready.file,
            placed.len()
        ));
    }

    /// Meshes or pictures are others under the same names: no edit says so.
    fn changed_beneath(&mut self) {
        self.baking.doubt();
        self.placed.forget();
        self.scene.picture.forget();
        self.game.picture.forget();
    }

    fn relink(&mut self, from: &str, to: &str) {
        let edit = assets::relink(self.session.document.scene(), from, to);
        self.bring.hopeless.remove(to);
        self.session.commit(edit);
    }

    pub(super) fn asset_changed(&mut self, path: &Path, change: Changed) {
        let Ok(below) = path.strip_prefix(self.session.document.project()) else { return };
        let file = below.iter().map(|part| part.to_string_lossy()).collect::<Vec<_>>().join("/");
        self.files.refresh();
        if !self.files.is_used(&file) {
            return; // it has another name since
        }
        if change == Changed::Gone {
            let told = format!("{file} is gone: put it back, or relink it in the assets panel");
            return self.session.log.warning(Source::File(path.to_owned()), told);
        }
        self.bring.hopeless.remove(&file);
        self.thumbnails.forget(&file);
        match assets::kind(&file) {
            assets::Kind::Model if self.play.is_none() => self.import(path.to_owned(), None, Then::Again),
            // Read again as what is not there is.
            _ => {
                Arc::make_mut(&mut self.assets).images.retain(|image, _| image.file != file);
                self.bring.complete = None;
                self.changed_beneath();
            }
        }
    }

    /// What the scene refers to since the last edit is read, if memory does not hold it.
    fn complete(&mut self, ctx: &Context) {
        self.take_loaded_files();
        let document = &self.session.document;
        if self.bring.loading.is_some() || document.is_dragging() {
            return;
        }
        if self.bring.complete == Some(document.revision()) {
            return;
        }
        self.bring.complete = Some(document.revision());
        add_shapes(&mut self.assets, document.scene());
        let Some(part) = load::wanted(document.indexed(), &self.assets, &self.bring.hopeless) else { return };
        let (sender, receiver) = mpsc::channel();
        let (project, ctx) = (document.project().to_owned(), ctx.clone());
        self.bring.loading = Some(receiver);
        std::thread::spawn(move || {
            let (assets, warnings) = load::what_is_there(&project, &part);
            let files = assets::references(&part).into_keys().collect();
            // Nobody waits any more where the editor is gone.
            let _ = sender.send(Loaded { assets, warnings, files });
            ctx.request_repaint();
        });
    }

    fn take_loaded_files(&mut self) {
        let Some(loading) = &self.bring.loading else { return };
        let loaded = match loading.try_recv() {
            Ok(loaded) => loaded,
            Err(mpsc::TryRecvError::Empty) => return,
            Err(mpsc::TryRecvError::Disconnected) => return self.bring.loading = None,
        };
        self.bring.loading = None;
        let scene = self.session.document.scene();
        self.session.log.warnings(&loaded.warnings, scene);
        let held = loaded.assets.meshes.keys().filter_map(|source| match source {
            MeshSource::File { file, .. } => Some(file),
            MeshSource::Shape(_) => None,
        });
        let images = loaded.assets.images.keys().map(|image| &image.file);
        let there: HashSet<&String> = held.chain(images).collect();
        let lost: Vec<String> = loaded.files.iter().filter(|file| !there.contains(file)).cloned().collect();
        self.bring.hopeless.extend(lost);
        load::add(Arc::make_mut(&mut self.assets), loaded.assets);
        self.placed.forget();
        self.scene.picture.forget();
        self.game.picture.forget();
    }

    fn on_disk(&mut self, ctx: &Context, work: impl FnOnce(&Path) -> Done + Send + 'static) {
        let (sender, receiver) = mpsc::channel();
        let (project, ctx) = (self.session.document.project().to_owned(), ctx.clone());
        self.bring.work.push(receiver);
        std::thread::spawn(move || {
            // Nobody waits any more where the editor is gone.
            let _ = sender.send(work(&project));
            ctx.request_repaint();
        });
    }

    fn take_done(&mut self, done: Done, ctx: &Context) {
        let log = self.session.log.clone();
        match done {
            Done::Moved { from, to, result: Ok(elsewhere) } => {
                let moved = |file: &str| assets::moved(file, &from, &to);
                load::renamed(Arc::make_mut(&mut self.assets), &moved);
                let edit = assets::relink(self.session.document.scene(), &from, &to);
                self.session.commit(edit);
                let own = self.session.document.name();
                for scene in elsewhere.iter().filter(|scene| *scene != own) {
                    let told = format!("Scene `{scene}` refers to {from} too: open it and relink {to}");
                    log.warning(Source::File(from.clone().into()), told);
                }
                log.info(format!("{from} is {to} now"));
                self.files.moved(&from, &to);
                self.bring.moved.push((from, to));
            }
            Done::MovedBack { to, result: Ok(()) } => log.info(format!("{to} is where it was")),
            Done::Deleted { file, result: Ok(()) } => {
                log.info(format!("Deleted {file}"));
                self.thumbnails.forget(&file);
            }
            Done::Folder(Ok(folder)) => self.files.begin_rename(&folder),
            Done::Recorded(Ok(())) => return,
            Done::Moved { from: file, result: Err(error), .. }
            | Done::Deleted { file, result: Err(error) } => {
                log.error(Source::File(file.into()), error);
            }
            Done::MovedBack { result: Err(error), .. }
            | Done::Folder(Err(error))
            | Done::Recorded(Err(error)) => log.error(Source::Nothing, error),
        }
        self.files.refresh();
        ctx.request_repaint();
    }

    /// A rename that was undone, or done again: the file goes along.
    pub(super) fn follow_renames(&mut self, ctx: &Context) {
        let missing: Vec<String> = self.files.missing().to_vec();
        for file in missing {
            let back = self.bring.moved.iter().find_map(|(from, to)| {
                let there = assets::moved(&file, from, to).map(|_| (to.clone(), from.clone()));
                there.or_else(|| assets::moved(&file, to, from).map(|_| (from.clone(), to.clone())))
            });
            let Some((is, was)) = back.filter(|(is, _)| self.files.has(is)) else { continue };
            let told = was.clone();
            self.on_disk(ctx, move |project| {
                let result = assets::rename(project, &is, &was).map(drop);
                Done::MovedBack { to: told, result }
            });
            return;
        }
    }
}

/// Shapes lie in no file.
fn add_shapes(assets: &mut Arc<Assets>, scene: &Scene) {
    let used = scene.entities.iter().filter_map(|entity| Some(&entity.mesh.as_ref()?.mesh));
    let lacking =
        used.filter(|source| !assets.meshes.contains_key(source)).filter_map(|source| match source {
            MeshSource::Shape(shape) => Some(*shape),
            MeshSource::File { .. } => None,
        });
    let lacking: HashSet<_> = lacking.collect();
    for shape in lacking {
        let mesh = Arc::new(shape::mesh(shape));
        Arc::make_mut(assets).meshes.insert(MeshSource::Shape(shape), mesh);
    }
}
