//! The report: error against run time, every point measured on this machine in this run.
//!
//! Work-precision diagrams in the sense of numerical analysis: what a setting costs along x, how wrong it is along y,
//! both logarithmic, one line a method. And where the error comes from: one switch at a time, from what the player
//! shows to a path tracer that shares nothing with it but the triangles.

pub mod budget;
mod csv;
pub mod experiments;
pub mod files;
pub mod front;
mod machine;
pub mod model;
mod numbers;
mod page;
pub mod player;
pub mod plot;
mod sentences;
pub mod trend;

use std::path::{Path, PathBuf};

use engine::scene::file::Quality;

pub use budget::Budget;
pub use model::Report;
pub use sentences::summary;

use self::budget::Within;
use self::experiments::{Measured, Setup};
use self::model::FrameTime;
use crate::{BakeError, Opened, Settings, Solvable, Watcher};

/// Of the budget, what the bake may take, then the player of what is left.
const FOR_BAKE: f64 = 0.6;
const FOR_PLAYER: f64 = 0.3;
/// Of what is left after both, and seconds at least: to draw and to write.
const FOR_PAGE: f64 = 0.03;
const FOR_PAGE_AT_LEAST: f64 = 2.0;

/// What the command line says.
#[derive(Clone, Debug)]
pub struct ReportSettings {
    /// `None`: of the bake that is there, or as the project says.
    pub quality: Option<Quality>,
    /// `None`: as many as the machine has.
    pub threads: Option<usize>,
    /// Seconds that the whole report may take, baking included.
    pub budget: f64,
    /// Where the files go.
    pub out: PathBuf,
}

/// Measures a scene of a project (`None`: its default scene) and writes tables, plots and the page.
pub fn report(
    project: &Path,
    scene: Option<&str>,
    settings: &ReportSettings,
    watcher: &dyn Watcher,
) -> Result<Report, BakeError> {
    let made = crate::on_threads(settings.threads, || run(project, scene, settings, watcher));
    made.map_err(|error| match error {
        BakeError::Cancelled => BakeError::Other(
            "cancelled; no report was written, and a bake that was begun goes on from there the next time"
                .to_owned(),
        ),
        error => error,
    })
}

fn run(
    project: &Path,
    scene: Option<&str>,
    settings: &ReportSettings,
    watcher: &dyn Watcher,
) -> Result<Report, BakeError> {
    let budget = Budget::new(settings.budget);
    files::can_be_written(&settings.out)?;
    let Solvable { opened, transport } = baked(project, scene, settings, &budget, watcher)?;
    let for_player = budget.part(FOR_PLAYER);
    let (played, unplayed) = player::play(project, &opened.name, &transport, &for_player, watcher)?;
    let setup = Setup { opened, transport, played };
    let for_page = (budget.left() * FOR_PAGE).max(FOR_PAGE_AT_LEAST);
    let measured = experiments::all(&setup, &budget.but(for_page), watcher)?;
    let mut report = told(project, &setup, measured);
    report.notes.extend(unplayed);
    (report.budget, report.seconds) = (settings.budget, budget.spent());
    let files = files::of(&report, settings, watcher)?;
    files::write(&settings.out, &files)?;
    Ok(report)
}

/// The bake on disk where it is current, or a new one.
fn baked(
    project: &Path,
    scene: Option<&str>,
    settings: &ReportSettings,
    budget: &Budget,
    watcher: &dyn Watcher,
) -> Result<Solvable, BakeError> {
    let with = Settings { quality: settings.quality, ..Settings::default() };
    match Solvable::certified(project, scene, &with) {
        Err(BakeError::Missing { .. } | BakeError::Stale { .. } | BakeError::Transport(_)) => {}
        opened => return opened,
    }
    let within = Within { watcher, budget: budget.part(FOR_BAKE) };
    match crate::bake(project, scene, &with, &within) {
        Err(BakeError::Cancelled) if !watcher.cancelled() => Err(too_long(project, scene)),
        Err(error) => Err(error),
        Ok(baked) => Ok(Solvable { opened: Opened::open(project, scene)?, transport: baked.transport }),
    }
}

fn too_long(project: &Path, scene: Option<&str>) -> BakeError {
    let scene = scene.map_or(String::new(), |scene| format!(" --scene {scene}"));
    BakeError::Other(format!(
        "the bake alone takes more than the budget has for it ({:.0} %): run `hohlraum-bake {}{scene}` first \
         (what was traced is kept), or give a larger --budget",
        100.0 * FOR_BAKE,
        project.display()
    ))
}

fn told(project: &Path, setup: &Setup, measured: Measured) -> Report {
    let Measured { diagrams, split, advice, seeds, notes } = measured;
    let certificate = setup.transport.certificate.clone();
    let played = setup.played.as_ref();
    Report {
        project: project.display().to_string(),
        scene: setup.opened.name.clone(),
        quality: certificate.quality.clone(),
        machine: machine::machine(played),
        seeds,
        certificate,
        picture: played.and_then(|played| played.picture.clone()),
        frame: played.map(|played| FrameTime {
            passes: played.passes.clone(),
            whole: played.frame.clone(),
            bound: played.bound,
        }),
        diagrams,
        split,
        advice,
        notes,
        seconds: 0.0,
        budget: 0.0,
    }
}
