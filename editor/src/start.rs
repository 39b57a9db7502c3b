//! From a project on disk to the editor's window; where there is no display, to pictures: bake what is not baked, then
//! play.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use bake::progress::Bar;
use bake::{Baked, Settings};
use editor::app;
use editor::opened::Opened;
use engine::play::{self, Options};

/// Where it lies in this workspace.
const SAMPLE: &str = "projects/cornell";

pub fn run(project: Option<PathBuf>) -> Result<()> {
    // The sample is to be seen in its own light at once; somebody's own project is baked when they ask for it.
    let is_sample = project.is_none();
    let project = project.map_or_else(sample, Ok)?;
    if has_display() {
        match edit(&project, is_sample) {
            Err(NoWindow(why)) => eprintln!("no window ({why}): playing without one"),
            Ok(edited) => return edited,
        }
    }
    let baked = bake_where_needed(&project)?;
    println!("bake:       {}", baked.file.display());
    println!("            its certificate: `hohlraum-bake check {}`", project.display());
    play_into_files(&project)
}

/// Why the editor cannot be shown.
struct NoWindow(String);

fn edit(project: &Path, bake_first: bool) -> Result<Result<()>, NoWindow> {
    let opened = match Opened::load(project, None) {
        Ok(opened) => opened,
        Err(error) => return Ok(Err(error.into())),
    };
    app::run(opened, bake_first).map(Ok).map_err(|error| NoWindow(error.to_string()))
}

/// Nothing is traced where the bake on disk is current.
fn bake_where_needed(project: &Path) -> Result<Baked> {
    let bar = Bar::new();
    bar.stop_on_signals()?;
    let baked = bake::bake(project, None, &Settings::default(), &bar)?;
    drop(bar);
    baked.warnings.iter().for_each(|warning| eprintln!("warning: {warning}"));
    Ok(baked)
}

/// Twelve seconds of the scene, a picture for each.
fn play_into_files(project: &Path) -> Result<()> {
    let out = project.join("out");
    let stats = out.join("stats.json");
    let options = Options {
        headless: true,
        frames: Some(120),
        fixed_dt: Some(0.1),
        every: 10,
        out: Some(out.clone()),
        stats: Some(stats.clone()),
        ..Options::new(project)
    };
    play::run(&options)?;
    println!("pictures:   {}", out.display());
    println!("statistics: {}", stats.display());
    Ok(())
}

/// X11 and Wayland say so in the environment; other systems always have one.
fn has_display() -> bool {
    let set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    std::env::consts::OS != "linux" || set("DISPLAY") || set("WAYLAND_DISPLAY")
}

/// The sample of the folder that we are in, else of the workspace that the program was built in.
fn sample() -> Result<PathBuf> {
    let program = std::env::current_exe()?;
    let places = [Path::new("")].into_iter().chain(program.ancestors());
    let found = places.map(|place| place.join(SAMPLE)).find(|sample| sample.join("project.ron").is_file());
    found.with_context(|| format!("there is no {SAMPLE} here: name a project, `hohlraum PROJECT`"))
}
