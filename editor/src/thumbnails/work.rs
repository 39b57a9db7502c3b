//! The two threads behind thumbnails: one reads files and makes pictures small, the other owns the renderer.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, Receiver, Sender, SyncSender};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, TryLockError};
use std::thread::JoinHandle;

use eframe::egui::{ColorImage, Context};
use engine::gpu::Gpu;
use engine::scene::assets::{Assets, Picture};
use engine::scene::import::{import, load_assets};
use engine::scene::{ImageSource, Material, Scene};

use super::Subject;
use super::paint::Painter;
use super::shrink::shrunk;
use crate::importing::load;

/// What one is made of.
#[derive(Clone)]
pub enum Work {
    Model {
        subject: Subject,
        project: PathBuf,
        file: String,
    },
    Picture {
        subject: Subject,
        project: PathBuf,
        image: ImageSource,
        /// Where it is in memory.
        held: Option<Arc<Picture>>,
    },
    Material {
        subject: Subject,
        material: Box<Material>,
        images: Vec<(ImageSource, Arc<Picture>)>,
    },
}

impl Work {
    fn subject(&self) -> &Subject {
        match self {
            Self::Model { subject, .. } | Self::Picture { subject, .. } | Self::Material { subject, .. } => {
                subject
            }
        }
    }
}

pub struct Done {
    pub subject: Subject,
    /// `None`: it cannot be made.
    pub image: Option<ColorImage>,
    pub material: Option<Material>,
}

/// What is drawn.
enum Drawing {
    Model(Subject, Box<Scene>, Assets),
    Material(Subject, Box<Material>, Vec<(ImageSource, Arc<Picture>)>),
    /// Nothing more.
    End,
}

#[derive(Default)]
struct Asked {
    wanted: Vec<Work>,
    /// Begun, and not taken yet.
    begun: HashSet<Subject>,
    ends: bool,
}

type Shared = Arc<(Mutex<Asked>, Condvar)>;

pub struct Workers {
    shared: Shared,
    done: Receiver<Done>,
    draw: SyncSender<Drawing>,
    painter: Option<JoinHandle<()>>,
}

impl Workers {
    pub fn start(ctx: Context, gpu: Arc<Gpu>) -> Self {
        let shared = Shared::default();
        let (answer, done) = mpsc::channel();
        // One ahead of the other, no more: scenes may be large.
        let (draw, drawings) = mpsc::sync_channel(1);
        let answer = Answer { answer, ctx };
        let (read, told, drawn) = (shared.clone(), answer.clone(), draw.clone());
        std::thread::spawn(move || {
            while let Some(work) = next(&read) {
                reads(work, &drawn, &told);
            }
        });
        let watched = shared.clone();
        let painter = std::thread::spawn(move || paints(gpu, &drawings, &answer, &watched));
        Self { shared, done, draw, painter: Some(painter) }
    }

    /// These and no others: what was asked for before and is not shown any more is left. False: a thread has them in its
    /// hand, which is not waited for.
    pub fn ask(&self, wanted: Vec<Work>) -> bool {
        let (asked, more) = &*self.shared;
        let Some(mut asked) = at_once(asked) else { return false };
        let begun = &asked.begun;
        let new: Vec<Work> = wanted.into_iter().filter(|work| !begun.contains(work.subject())).collect();
        asked.wanted = new;
        drop(asked);
        more.notify_one();
        true
    }

    pub fn done(&self, most: usize) -> Vec<Done> {
        let Some(mut asked) = at_once(&self.shared.0) else { return Vec::new() };
        let done: Vec<Done> = self.done.try_iter().take(most).collect();
        asked.begun.retain(|subject| done.iter().all(|done| done.subject != *subject));
        done
    }
}

/// `None`: another thread holds it.
fn at_once(asked: &Mutex<Asked>) -> Option<MutexGuard<'_, Asked>> {
    match asked.try_lock() {
        Ok(asked) => Some(asked),
        Err(TryLockError::Poisoned(asked)) => Some(asked.into_inner()),
        Err(TryLockError::WouldBlock) => None,
    }
}

/// Nothing is drawn any more when the device goes; what is read is not waited for.
impl Drop for Workers {
    fn drop(&mut self) {
        self.shared.0.lock().unwrap_or_else(PoisonError::into_inner).ends = true;
        self.shared.1.notify_all();
        let _ = self.draw.send(Drawing::End);
        if let Some(painter) = self.painter.take() {
            let _ = painter.join();
        }
    }
}

/// The first that is wanted. `None`: it is over.
fn next(shared: &Shared) -> Option<Work> {
    let (asked, more) = &**shared;
    let mut asked = asked.lock().unwrap_or_else(PoisonError::into_inner);
    loop {
        if asked.ends {
            return None;
        }
        if !asked.wanted.is_empty() {
            let work = asked.wanted.remove(0);
            asked.begun.insert(work.subject().clone());
            return Some(work);
        }
        asked = more.wait(asked).unwrap_or_else(PoisonError::into_inner);
    }
}

#[derive(Clone)]
struct Answer {
    answer: Sender<Done>,
    ctx: Context,
}

impl Answer {
    /// Nobody waits any more where the editor is gone.
    fn send(&self, subject: Subject, image: Option<ColorImage>, material: Option<Material>) {
        let _ = self.answer.send(Done { subject, image, material });
        self.ctx.request_repaint();
    }
}

fn reads(work: Work, draw: &SyncSender<Drawing>, told: &Answer) {
    match work {
        Work::Picture { subject, project, image, held } => {
            let picture = held.or_else(|| load::picture(&project, &image).ok());
            told.send(subject, picture.map(|picture| shrunk(&picture)), None);
        }
        Work::Model { subject, project, file } => match model(&project, &file) {
            Some((scene, assets)) => drop(draw.send(Drawing::Model(subject, Box::new(scene), assets))),
            None => told.send(subject, None, None),
        },
        Work::Material { subject, material, images } => {
            drop(draw.send(Drawing::Material(subject, material, images)));
        }
    }
}

fn model(project: &Path, file: &str) -> Option<(Scene, Assets)> {
    let scene = import(project, file).ok()?.scene;
    let (assets, _) = load_assets(project, &scene).ok()?;
    Some((scene, assets))
}

fn paints(gpu: Arc<Gpu>, drawings: &Receiver<Drawing>, told: &Answer, shared: &Shared) {
    let mut painter = None;
    let ends = || shared.0.lock().unwrap_or_else(PoisonError::into_inner).ends;
    while let Ok(drawing) = drawings.recv() {
        if ends() {
            return;
        }
        if painter.is_none() {
            painter = Painter::new(gpu.clone()).ok();
        }
        let painter = painter.as_mut();
        match drawing {
            Drawing::Model(subject, scene, assets) => {
                let image = painter.and_then(|painter| painter.model(&scene, &assets).ok());
                told.send(subject, image, None);
            }
            Drawing::Material(subject, material, images) => {
                let image = painter.and_then(|painter| painter.material(&material, images).ok());
                told.send(subject, image, Some(*material));
            }
            Drawing::End => return,
        }
    }
}
