//! From a project on disk to a picture: bake what is not baked, then play.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use bake::progress::Bar;
use bake::{Baked, Settings};

/// Where it lies in this workspace.
const SAMPLE: &str = "projects/cornell";

pub fn run(project: Option<PathBuf>) -> Result<()> {
    let project = project.map_or_else(sample, Ok)?;
    let baked = bake_where_needed(&project)?;
    println!("bake and certificate: {}", baked.file.display());
    Ok(())
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

/// The sample of the folder that we are in, else of the workspace that the program was built in.
fn sample() -> Result<PathBuf> {
    let program = std::env::current_exe()?;
    let places = [Path::new("")].into_iter().chain(program.ancestors());
    let found = places.map(|place| place.join(SAMPLE)).find(|sample| sample.join("project.ron").is_file());
    found.with_context(|| format!("there is no {SAMPLE} here: name a project, `hohlraum PROJECT`"))
}
