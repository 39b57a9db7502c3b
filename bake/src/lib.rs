//! The bake: from a scene to its light transport. A library that needs no GPU; `hohlraum-bake` is its
//! command line.

mod aggregate;
mod balance;
mod cache;
mod certify;
mod chart;
mod cut;
mod depth;
mod directional;
mod directions;
mod emitter;
mod gap;
mod holes;
mod layout;
mod opened;
mod overlap;
mod patch;
mod pipeline;
mod plan;
mod preview;
mod probe;
mod query;
mod rays;
mod receiver;
mod settings;
mod ship;
mod split;
mod surface;

pub mod adopt;
pub mod chain;
pub mod compress;
pub mod form_factors;
pub mod progress;
pub mod reference;
pub mod report;

use std::path::Path;

use engine::scene::file::{Quality, baked_dir, load_project};
use engine::scene::{EntityId, Feature, Scene, SceneError, Warning};
use engine::transport::file::TransportError;
use engine::transport::key::{Input, What, inputs, transport_key};
use engine::transport::needs::{Needs, needs_of_transport};
use engine::transport::probe_field::ProbeField;
use engine::transport::{Certificate, Transport, file, materials};
use glam::{DVec3, Vec3};

use crate::opened::{Opened, Solvable};
use crate::pipeline::Caches;
pub use crate::plan::{Plan, plan};
pub use crate::preview::divide;

/// What the command line says; where it says nothing, the project's settings hold.
#[derive(Clone, Debug, Default)]
pub struct Settings {
    pub quality: Option<Quality>,
    /// Rays a row.
    pub rays: Option<u32>,
    /// Metres.
    pub patch_length: Option<f64>,
    /// `None`: as many as the machine has.
    pub threads: Option<usize>,
    /// Bake everything anew, whatever is there. Query: ask a bake whose certificate does not hold, too.
    pub force: bool,
}

/// Follows a bake, from any thread.
pub trait Watcher: Sync {
    /// A new stage begins, of `steps` steps.
    fn stage(&self, _name: &str, _steps: u64) {}
    /// Some steps of the stage are done, with this many rays.
    fn advance(&self, _steps: u64, _rays: u64) {}
    /// Asked often: a bake that is told to stop does so within a second, and keeps what is reusable.
    fn cancelled(&self) -> bool {
        false
    }
}

/// Watches nothing.
pub struct Silent;

impl Watcher for Silent {}

/// What a bake gives.
pub struct Baked {
    /// The full one.
    pub transport: Transport,
    /// What the player loads: less than the full transport where a scene does without some of it.
    pub file: std::path::PathBuf,
    pub needs: Needs,
    pub warnings: Vec<Warning>,
    /// Nothing had changed: the file on disk was current and no ray was traced.
    pub unchanged: bool,
}

#[derive(Debug, thiserror::Error)]
pub enum BakeError {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Transport(#[from] TransportError),
    #[error("cancelled; what was traced so far is kept and the next bake goes on from there")]
    Cancelled,
    #[error("scene `{scene}` has no bake: run `hohlraum-bake {project} --scene {scene} --quality {quality}`")]
    Missing { project: String, scene: String, quality: String },
    #[error("the bake of scene `{scene}` is stale ({why}): run `hohlraum-bake {project} --scene {scene}`")]
    Stale { project: String, scene: String, why: String },
    #[error("{0}")]
    Other(String),
}

/// A point on a surface, with its normal.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    pub position: DVec3,
    pub normal: DVec3,
}

/// Irradiance at a point [W/m2].
#[derive(Clone, Copy, Debug, Default)]
pub struct Irradiance {
    /// Seen unblocked from emitters, sky and punctual lights.
    pub direct: DVec3,
    pub indirect: DVec3,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// What the runtime shows there.
    #[default]
    Receivers,
    /// A fresh final gather from the solved radiosity.
    Gather,
}

/// Bakes a scene of a project (`None`: its default scene) and writes `baked/NAME/`.
pub fn bake(
    project: &Path,
    scene: Option<&str>,
    settings: &Settings,
    watcher: &dyn Watcher,
) -> Result<Baked, BakeError> {
    on_threads(settings.threads, || run(project, || Opened::open(project, scene), settings, watcher))
}

/// Bakes a scene of a project as it stands in memory, saved or not, and writes `baked/NAME/`. The scene's own file is
/// neither read nor written.
pub fn bake_scene(
    project: &Path,
    name: &str,
    scene: Scene,
    settings: &Settings,
    watcher: &dyn Watcher,
) -> Result<Baked, BakeError> {
    let open = || {
        scene.validate()?;
        Opened::of(project, load_project(project)?, name.to_owned(), scene)
    };
    on_threads(settings.threads, || run(project, open, settings, watcher))
}

/// `None`: as many as the machine has.
fn on_threads<T: Send>(
    threads: Option<usize>,
    work: impl FnOnce() -> Result<T, BakeError> + Send,
) -> Result<T, BakeError> {
    let Some(threads) = threads else { return work() };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map_err(|error| BakeError::Other(format!("{threads} threads: {error}")))?.install(work)
}

fn run(
    project: &Path,
    open: impl FnOnce() -> Result<Opened, BakeError>,
    settings: &Settings,
    watcher: &dyn Watcher,
) -> Result<Baked, BakeError> {
    let started = std::time::Instant::now();
    watcher.stage("reading", 1);
    let mut opened = open()?;
    let (with, is_new_length) =
        settings::settle(&opened.settings, &opened.name, settings, layout::area(&opened.surface))?;
    let inputs = inputs(&opened.scene, &opened.assets, &with, opened.forced());
    let key = transport_key(&inputs);
    watcher.advance(1, 0);

    let load = || file::load_full_uncertified(project, &opened.name).ok();
    let on_disk = (!settings.force).then(load).flatten();
    let unchanged = on_disk.as_ref().is_some_and(|transport| transport.certificate.key == key);
    let in_probes = |transport: &Transport| differ_in_probes(&transport.certificate.inputs, &inputs);
    let kept = match on_disk {
        Some(transport) if unchanged => Some((transport, Vec::new())),
        Some(transport) if in_probes(&transport) => opened.make_probes(transport, &with, watcher)?,
        _ => None,
    };
    let (mut transport, warnings) = match kept {
        Some(kept) => kept,
        None => {
            let folder = baked_dir(project, &opened.name).join("cache");
            let caches = if settings.force { Caches::none() } else { Caches::open(&folder, &key) };
            let made =
                pipeline::make(&opened.scene, &opened.assets, &opened.surface, &with, &caches, watcher)?;
            caches.delete();
            made
        }
    };
    opened.warnings.extend(warnings);

    watcher.stage("certificate", 1);
    let before = transport.certificate.clone();
    let mut certificate = before.clone();
    let mut materials = materials::of_patches(&transport, &opened.scene, &opened.assets);
    let unlimited = opened.settings.bake.unlimited_gain;
    let limited =
        certify::certify_materials(&mut certificate, &transport, &opened.scene, &mut materials, unlimited);
    opened.warnings.extend(limited);
    opened.warnings.extend(materials::warnings(&opened.scene));
    opened.warnings.sort();
    opened.warnings.dedup();
    certificate.key = key;
    certificate.inputs = inputs;
    certificate.warnings = opened.warnings.iter().map(Warning::to_string).collect();
    // How long light lasts says what solves it.
    transport.certificate.cavity_gain = certificate.cavity_gain;
    let needs = needs_of_transport(&opened.authored, &opened.assets, &transport, &opened.settings.features);
    certificate.left_out = needs.left_out().chain(left_out_of_probes(&transport)).collect();
    certificate.shipped_for = ship::made_for(&opened.authored, &opened.assets, &needs, unlimited);
    certificate.needs = Some(needs.clone());
    if !unchanged {
        certificate.threads = rayon::current_num_threads();
        certificate.seconds = started.elapsed().as_secs_f64();
    }
    // A new colour or light changes no row: what the player loads is written again, the full transport beside it not.
    if certificate != before || !file::is_whole(project, &opened.name) {
        transport.certificate = certificate;
        transport.dense = !needs.has(Feature::Columns);
        transport.certificate.bytes = file::length(&transport);
        let shipped = ship::ship(&transport, opened.scenes(), &opened.assets, &needs, unlimited);
        file::save_pair(project, &opened.name, &transport, shipped.as_ref(), unchanged)?;
    }
    if unchanged {
        transport.certificate.rays_traced = 0;
        transport.certificate.seconds = started.elapsed().as_secs_f64();
    } else if is_new_length {
        let base_length = settings::base_length_key(&opened.name, with.quality);
        opened.settings.bake.base_length.insert(base_length, with.length);
        engine::scene::file::save_project(project, &opened.settings)?;
    }
    watcher.advance(1, 0);
    let file = file::path(project, &opened.name);
    Ok(Baked { transport, file, needs, warnings: opened.warnings, unchanged })
}

/// Everything is as it was but what is read by what moves.
fn differ_in_probes(was: &[Input], is: &[Input]) -> bool {
    let but_probes = |inputs: &[Input]| -> Vec<(What, EntityId, String)> {
        let others = inputs.iter().filter(|input| input.what != What::Probes);
        others.map(|input| (input.what, input.entity, input.key.clone())).collect()
    };
    was != is && but_probes(was) == but_probes(is)
}

/// Light probes that no object reads, and what the others do without.
fn left_out_of_probes(transport: &Transport) -> Vec<String> {
    let mut left_out = Vec::new();
    let inside = transport.probes.iter().filter(|probe| probe.valid < 0.5).count();
    if inside > 0 {
        left_out.push(format!("{inside} light probes: they are inside solids"));
    }
    let merged = ProbeField::new(transport).merged.len();
    if merged > 0 {
        left_out.push(format!("{merged} light probes: others are in the same place"));
    }
    if !transport.probes.is_empty() && transport.depths.probes.is_empty() {
        left_out.push("depths of light probes: no wall stands between neighbours".to_owned());
    }
    left_out
}

/// The certificate of the bake on disk, every statement computed again from the stored arrays.
pub fn check(project: &Path, scene: Option<&str>, settings: &Settings) -> Result<Certificate, BakeError> {
    let Solvable { opened, transport, .. } =
        Solvable::open(project, scene, settings, file::load_full_uncertified)?;
    check_shipped(project, &opened)?;
    let mut certificate = transport.certificate.clone();
    let mut materials = materials::of_patches(&transport, &opened.scene, &opened.assets);
    let unlimited = opened.settings.bake.unlimited_gain;
    certify::certify_rows(&mut certificate, &transport);
    certify::certify_materials(&mut certificate, &transport, &opened.scene, &mut materials, unlimited);
    let hash = transport.hash().to_hex().to_string();
    if hash != certificate.transport_hash {
        return Err(BakeError::Other(format!(
            "the arrays hash to {hash}, the certificate says {}",
            certificate.transport_hash
        )));
    }
    Ok(certificate)
}

/// What the player loads is of the bake beside it, and was made for this scene.
fn check_shipped(project: &Path, opened: &Opened) -> Result<(), BakeError> {
    let stale = |why: &str| BakeError::Stale {
        project: project.display().to_string(),
        scene: opened.name.clone(),
        why: why.to_owned(),
    };
    if !file::is_whole(project, &opened.name) {
        return Err(stale("its light file and the full transport beside it are of different bakes"));
    }
    let light = file::path(project, &opened.name);
    let omissions = file::load_omissions(&light)?;
    let changed = ship::changed(&omissions, &opened.authored, &opened.assets);
    if changed.is_empty() {
        return Ok(());
    }
    let names = file::names(&changed);
    Err(stale(&format!("{} leaves out what the scene may need by now: {names}", light.display())))
}

/// Irradiance at points, in their order. A point too far from any front face is an error that names its
/// place in the list (from 1).
pub fn query_points(
    project: &Path,
    scene: Option<&str>,
    settings: &Settings,
    points: &[Point],
    method: Method,
) -> Result<Vec<Irradiance>, BakeError> {
    query::Query::new(Solvable::certified(project, scene, settings)?).points(points, method)
}

/// SH coefficients of incoming radiance at points, in their order, fresh rows from the solved radiosity.
pub fn query_probes(
    project: &Path,
    scene: Option<&str>,
    settings: &Settings,
    points: &[DVec3],
) -> Result<Vec<[Vec3; 9]>, BakeError> {
    query::Query::new(Solvable::certified(project, scene, settings)?).probes(points)
}
