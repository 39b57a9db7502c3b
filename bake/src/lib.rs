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
mod overlap;
mod patch;
mod pipeline;
mod probe;
mod query;
mod rays;
mod receiver;
mod settings;
mod split;
mod surface;

pub mod chain;
pub mod compress;
pub mod form_factors;
pub mod progress;
pub mod reference;
pub mod report;

use std::path::Path;

use engine::scene::assets::Assets;
use engine::scene::file::{Project, Quality, baked_dir, load_project, load_scene};
use engine::scene::import::load_assets;
use engine::scene::{Scene, SceneError, SkyKind, Warning};
use engine::transport::directional::{AXES, any_directional};
use engine::transport::file::TransportError;
use engine::transport::key::{BakeWith, inputs, transport_key};
use engine::transport::probe_field::ProbeField;
use engine::transport::stale::Stale;
use engine::transport::{Certificate, Transport, file, materials, packed};
use glam::{DVec3, Vec3};

use crate::pipeline::Caches;
use crate::surface::Surface;

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
    pub transport: Transport,
    /// Where it was written.
    pub file: std::path::PathBuf,
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

/// What would be baked, without baking it.
#[derive(Clone, Debug, Default, serde::Serialize)]
pub struct Plan {
    pub scene: String,
    pub quality: String,
    /// Metres.
    pub patch_length: f64,
    pub patches: usize,
    pub receivers: usize,
    pub probes: usize,
    pub sky_patches: usize,
    pub triangles: usize,
    pub rays: u64,
    /// Of those, how many are on disk already.
    pub rays_kept: u64,
    /// Estimated by tracing a few thousand rays.
    pub seconds: f64,
    pub bytes: u64,
    pub left_out: Vec<String>,
    pub warnings: Vec<String>,
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
    on_threads(settings.threads, || run(project, scene, settings, watcher))
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
    scene: Option<&str>,
    settings: &Settings,
    watcher: &dyn Watcher,
) -> Result<Baked, BakeError> {
    let started = std::time::Instant::now();
    watcher.stage("reading", 1);
    let mut opened = Opened::open(project, scene)?;
    let (with, is_new_length) =
        settings::settle(&opened.settings, &opened.name, settings, layout::area(&opened.surface))?;
    let inputs = inputs(&opened.scene, &opened.assets, &with);
    let key = transport_key(&inputs);
    let file = file::path(project, &opened.name);
    watcher.advance(1, 0);

    let current = (!settings.force).then(|| file::load_uncertified(&file).ok()).flatten();
    let current = current.filter(|transport| transport.certificate.key == key);
    let unchanged = current.is_some();
    let mut transport = match current {
        Some(transport) => transport,
        None => {
            let caches = if settings.force {
                Caches::none()
            } else {
                Caches::open(&baked_dir(project, &opened.name).join("cache"), &key)
            };
            let (transport, warnings) =
                pipeline::make(&opened.scene, &opened.assets, &opened.surface, &with, &caches, watcher)?;
            opened.warnings.extend(warnings);
            caches.delete();
            transport
        }
    };

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
    certificate.left_out = left_out(&opened.scene);
    certificate.left_out.extend(left_out_of_probes(&transport));
    if !unchanged {
        certificate.threads = rayon::current_num_threads();
        certificate.seconds = started.elapsed().as_secs_f64();
    }
    if certificate != before {
        // A new colour changes the gain, but no row: the file is written again all the same, in one piece.
        transport.certificate = certificate;
        transport.certificate.bytes = file::length(&transport);
        file::save(&file, &transport)?;
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
    Ok(Baked { transport, file, warnings: opened.warnings, unchanged })
}

/// A scene with all that it refers to, and its static surface.
struct Opened {
    settings: Project,
    name: String,
    scene: Scene,
    assets: Assets,
    surface: Surface,
    warnings: Vec<Warning>,
}

impl Opened {
    fn open(project: &Path, scene: Option<&str>) -> Result<Self, BakeError> {
        let settings = load_project(project)?;
        let name = scene.unwrap_or(&settings.default_scene).to_owned();
        let scene = load_scene(project, &name)?;
        let (assets, mut warnings) = load_assets(project, &scene)?;
        let surface = surface::sanitise(&scene, &assets)?;
        warnings.extend(surface.warnings.iter().cloned());
        Ok(Self { settings, name, scene, assets, surface, warnings })
    }
}

fn left_out(scene: &Scene) -> Vec<String> {
    let mut left_out = Vec::new();
    if scene.sky.kind == SkyKind::None {
        left_out.push("sky patches: the scene has no sky".to_owned());
    }
    if scene.entities.iter().all(|entity| entity.light_probes.is_none()) {
        left_out.push("light-probe rows: the scene has no light probes".to_owned());
    }
    if !any_directional(scene) {
        left_out.push("directional rows: no static surface has a normal map".to_owned());
    }
    left_out
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

/// What [`bake`] would do.
pub fn plan(project: &Path, scene: Option<&str>, settings: &Settings) -> Result<Plan, BakeError> {
    let opened = Opened::open(project, scene)?;
    let (with, _) =
        settings::settle(&opened.settings, &opened.name, settings, layout::area(&opened.surface))?;
    let key = transport_key(&inputs(&opened.scene, &opened.assets, &with));
    let baked = file::load_certificate(&file::path(project, &opened.name));
    let is_current = baked.is_ok_and(|certificate| certificate.key == key);
    let layout = layout::layout(&opened.scene, &opened.assets, &opened.surface, with.length, &Silent)?;
    let transport = &layout.transport;
    let rows = transport.patches.len() + transport.receivers.len();
    let rays =
        rows as u64 * u64::from(with.rays) + transport.probes.len() as u64 * u64::from(pipeline::PROBE_RAYS);
    let rays = rays + layout.directional as u64 * u64::from(with.rays);
    let kept = if is_current { rays } else { 0 };
    let (per_ray, per_row) = pipeline::measure(&layout, &opened.scene, &opened.assets, with.rays);
    // Entries of patches take eight bytes, others four where columns are few enough.
    let entries = |rows: usize| rows as f64 * per_row;
    let short = if transport.columns() <= packed::MOST_COLUMNS { 4.0 } else { 8.0 };
    let bytes = entries(transport.patches.len()) * 8.0
        + entries(transport.receivers.len() + AXES * layout.directional + 9 * transport.probes.len()) * short;
    Ok(Plan {
        scene: opened.name,
        quality: with.quality.to_string(),
        patch_length: with.length,
        patches: transport.patches.len(),
        receivers: transport.receivers.len(),
        probes: transport.probes.len(),
        sky_patches: transport.sky_patches as usize,
        triangles: transport.surface.triangles.len(),
        rays,
        rays_kept: kept,
        seconds: (rays - kept) as f64 * per_ray / rayon::current_num_threads() as f64,
        bytes: file::length(transport) + bytes as u64,
        left_out: left_out(&opened.scene),
        warnings: opened.warnings.iter().chain(&layout.warnings).map(Warning::to_string).collect(),
    })
}

/// A scene with the bake on disk, which is current.
struct Solvable {
    opened: Opened,
    transport: Transport,
}

impl Solvable {
    /// To be asked: its certificate holds, or it is forced.
    fn certified(project: &Path, scene: Option<&str>, settings: &Settings) -> Result<Self, BakeError> {
        Self::open(project, scene, settings, if settings.force { file::load_uncertified } else { file::load })
    }

    fn open(
        project: &Path,
        scene: Option<&str>,
        settings: &Settings,
        load: fn(&Path) -> Result<Transport, TransportError>,
    ) -> Result<Self, BakeError> {
        let opened = Opened::open(project, scene)?;
        let file = file::path(project, &opened.name);
        let project_name = project.display().to_string();
        let quality = settings.quality.map(|quality| quality.to_string());
        if !file.is_file() {
            let quality = quality.unwrap_or_else(|| opened.settings.bake.quality.to_string());
            return Err(BakeError::Missing { project: project_name, scene: opened.name, quality });
        }
        let transport = load(&file)?;
        let certificate = &transport.certificate;
        let stale = |why: &str| {
            Err(BakeError::Stale { project: project_name, scene: opened.name.clone(), why: why.to_owned() })
        };
        if quality.is_some_and(|quality| quality != certificate.quality) {
            return stale(&format!("it was made at quality {}", certificate.quality));
        }
        let with = BakeWith {
            quality: settings.quality.unwrap_or_default(),
            rays: certificate.rays_per_row,
            length: certificate.base_length,
        };
        let now = inputs(&opened.scene, &opened.assets, &with);
        if transport_key(&now) != certificate.key {
            return stale(&Stale::between(&certificate.inputs, &now).to_string());
        }
        Ok(Self { opened, transport })
    }
}

/// The certificate of the bake on disk, every statement computed again from the stored arrays.
pub fn check(project: &Path, scene: Option<&str>, settings: &Settings) -> Result<Certificate, BakeError> {
    let Solvable { opened, transport, .. } =
        Solvable::open(project, scene, settings, file::load_uncertified)?;
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
