//! The document's work on disk, on a thread of its own: a slow disk delays no picture.

use std::path::PathBuf;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;

use engine::scene::{Scene, SceneError};

use super::file::{SaveError, read, write_new_scene, write_scene};
use super::notes::Notes;
use crate::recovery;
use crate::watch::{Changed, Stamp, Watch};

/// What the thread is asked to do, in this order.
pub enum Work {
    /// `known`: what the file held; something else there is left alone.
    Save {
        path: PathBuf,
        known: Option<Stamp>,
        scene: Box<Scene>,
        state: u64,
    },
    /// Under a name that the project does not have yet.
    SaveAs {
        project: PathBuf,
        name: String,
        scene: Box<Scene>,
        state: u64,
    },
    Read {
        path: PathBuf,
    },
    Recovery {
        project: PathBuf,
        name: String,
        scene: Box<Scene>,
    },
    ForgetRecovery {
        project: PathBuf,
        name: String,
    },
    Notes {
        path: PathBuf,
        notes: Notes,
    },
    /// With what is known of the first of them.
    Follow {
        files: Vec<PathBuf>,
        scene: Option<Stamp>,
    },
    Look,
}

/// What came of it.
#[derive(Debug)]
pub enum Done {
    Saved { state: u64, stamp: Result<Stamp, SaveError> },
    SavedAs { name: String, state: u64, stamp: Result<Stamp, SaveError> },
    Read(Result<(Box<Scene>, Stamp), SceneError>),
    Recovery(Result<(), SceneError>),
    Notes(SceneError),
    Changed(Vec<(PathBuf, Changed)>),
}

/// The thread; dropped, it finishes what it was asked to do.
pub struct Disk {
    work: Option<Sender<Work>>,
    done: Receiver<Done>,
    thread: Option<JoinHandle<()>>,
}

impl Disk {
    pub fn start() -> Self {
        let (work, asked) = channel();
        let (answer, done) = channel();
        let thread = std::thread::Builder::new().name("disk".to_owned()).spawn(move || serve(asked, answer));
        // Without a thread nothing is asked: saving in the background then fails with the reason.
        Self { work: thread.is_ok().then_some(work), done, thread: thread.ok() }
    }

    /// False: there is no thread to do it.
    pub fn ask(&self, work: Work) -> bool {
        self.work.as_ref().is_some_and(|queue| queue.send(work).is_ok())
    }

    pub fn done(&self) -> Vec<Done> {
        self.done.try_iter().collect()
    }

    /// Waits for it. `None`: nothing will come.
    pub fn next(&self) -> Option<Done> {
        self.done.recv().ok()
    }
}

impl Drop for Disk {
    fn drop(&mut self) {
        self.work = None;
        if let Some(thread) = self.thread.take() {
            // It panics nowhere; if it did, what it was asked to write is not there either way.
            let _ = thread.join();
        }
    }
}

fn serve(asked: Receiver<Work>, answer: Sender<Done>) {
    let mut watch = Watch::default();
    for work in asked {
        let done = match work {
            Work::Save { path, known, scene, state } => {
                Some(Done::Saved { state, stamp: write_scene(&path, known.as_ref(), &scene) })
            }
            Work::SaveAs { project, name, scene, state } => {
                let stamp = write_new_scene(&project, &name, &scene);
                Some(Done::SavedAs { name, state, stamp })
            }
            Work::Read { path } => {
                Some(Done::Read(read(&path).map(|(scene, stamp)| (Box::new(scene), stamp))))
            }
            Work::Recovery { project, name, scene } => {
                Some(Done::Recovery(recovery::write(&project, &name, &scene)))
            }
            Work::ForgetRecovery { project, name } => {
                recovery::remove(&project, &name);
                None
            }
            Work::Notes { path, notes } => notes.save(&path).err().map(Done::Notes),
            Work::Follow { files, scene } => {
                if let (Some(file), Some(stamp)) = (files.first(), scene) {
                    watch.expect(file.clone(), stamp);
                }
                watch.follow(files);
                None
            }
            Work::Look => Some(watch.look()).filter(|changes| !changes.is_empty()).map(Done::Changed),
        };
        // Nobody listens any more when the document is gone; what was asked is done all the same.
        done.map(|done| answer.send(done));
    }
}
