//! What a bake would divide the surface into, before it is baked: for editors that show it while densities are painted.

use std::path::Path;

use engine::scene::Scene;
use engine::scene::assets::Assets;
use engine::scene::file::load_project;
use engine::transport::Transport;
use engine::transport::needs::as_baked;

use crate::{BakeError, Settings, Watcher, layout, settings, surface};

/// A scene as it stands in memory, divided as [`crate::bake_scene`] would divide it: a transport without rows. No ray is
/// traced and nothing is written; of the project its settings are read.
pub fn divide(
    project: &Path,
    name: &str,
    scene: &Scene,
    assets: &Assets,
    settings: &Settings,
    watcher: &dyn Watcher,
) -> Result<Transport, BakeError> {
    scene.validate()?;
    let of_project = load_project(project)?;
    let scene = as_baked(scene, assets, &of_project.features);
    let surface = surface::sanitise(&scene, assets)?;
    let (with, _) = settings::settle(&of_project, name, settings, layout::area(&surface))?;
    Ok(layout::layout(&scene, assets, &surface, with.length, watcher)?.transport)
}
