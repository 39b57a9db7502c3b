//! What is played: a scene with its assets and its bake, and where everything is at a time.

use std::collections::{BTreeMap, HashSet};
use std::path::Path;
use std::sync::Arc;

use glam::{DAffine3, DVec3};

use super::cubemaps::Cubemaps;
use super::{PlayError, baked};
use crate::gpu::Gpu;
use crate::render::{Asked, Eye, RenderError, Renderer, Settings};
use crate::scene::assets::{Assets, ClipSource};
use crate::scene::import::load_assets;
use crate::scene::motion::moved;
use crate::scene::transform::world_from_local_of;
use crate::scene::{Changes, Entity, Feature, Forced, Motion, Scene, Warning, file};
use crate::transport::needs::{Needs, needs_in_play};
use crate::transport::{self, Transport};

pub struct World {
    pub name: String,
    pub scene: Scene,
    pub assets: Assets,
    pub transport: Arc<Transport>,
    /// What is there of all that costs, what is left out, and why.
    pub needs: Needs,
    /// What the author says of features, and promises.
    pub features: Asked,
    /// What of the scene has no baked light, and why.
    pub left_out: Vec<String>,
    /// Albedo as authored, however long light bounces.
    pub unlimited_gain: bool,
    /// Of baked reflection probes, on disk.
    pub cubemaps: Cubemaps,
    /// What the author says of features, whatever their rules find.
    forced: BTreeMap<Feature, Forced>,
    /// By entity: whether its light is on, as authored and as it was switched by hand.
    lit: Vec<bool>,
    /// Metres across all that is drawn at the start.
    pub size: f64,
    /// Looked through where the scene has no camera.
    default_eye: Eye,
}

impl World {
    /// Reads a scene of a project (`None`: its default scene) and its bake. One whose certificate does not hold is an
    /// error, or is warned of where it is forced.
    pub fn load(project: &Path, scene: Option<&str>, force: bool) -> Result<(Self, Vec<Warning>), PlayError> {
        let settings = file::load_project(project)?;
        let name = scene.unwrap_or(&settings.default_scene).to_owned();
        let scene = file::load_scene(project, &name)?;
        let (assets, mut warnings) = load_assets(project, &scene)?;
        warnings.extend(transport::materials::warnings(&scene));
        let found = baked::find(project, &name, (&scene, &assets), &settings, force)?;
        let mut transport = found.transport;
        if let Some(broken) = transport.certificate.broken().filter(|_| !transport.patches.is_empty()) {
            let message = format!("its bake is used though its certificate does not hold: {broken}");
            warnings.push(Warning::new(format!("scene `{name}`"), message));
        }
        let remedy = format!("run `hohlraum-bake {} --scene {name}`", project.display());
        let told = found.grown.iter().chain(&found.lacks);
        let told = told.map(|told| Warning::new(format!("scene `{name}`"), format!("{told}; {remedy}")));
        warnings.extend(told);
        let left_out = found.lacks.iter().map(|lacks| format!("baked light: {lacks}")).collect();
        let (low, high) = extent(&scene, &assets, &transport);
        if transport.surface.vertices.is_empty() {
            transport.origin = origin_near((low + high) * 0.5);
        }
        let needs = needs_in_play(&scene, &assets, &transport, &settings.features);
        let asked = Asked::new(&settings.features).promising_grey(!needs.has(Feature::Colour));
        let transport = Arc::new(transport);
        let unlimited_gain = settings.bake.unlimited_gain;
        let (size, default_eye) = ((high - low).length(), Eye::framing(low, high));
        let lit = scene.entities.iter().map(|entity| entity.light.as_ref().is_some_and(|l| l.on)).collect();
        let cubemaps = Cubemaps::new(project, &name, &scene, &assets, &transport);
        let world = Self {
            name,
            scene,
            assets,
            transport,
            needs,
            features: asked,
            forced: settings.features,
            left_out,
            unlimited_gain,
            cubemaps,
            lit,
            size,
            default_eye,
        };
        Ok((world, warnings))
    }

    /// As a path tracer sees it that knows static surfaces alone: nothing moves or switches, and what could move is gone.
    pub fn hold_still(&mut self) {
        for entity in &mut self.scene.entities {
            entity.motion = None;
            entity.mesh = entity.mesh.take().filter(|_| entity.is_static);
            entity.light.iter_mut().for_each(|light| light.switching = None);
        }
        self.needs = needs_in_play(&self.scene, &self.assets, &self.transport, &self.forced);
        self.left_out.push("all that moves: asked for by --still".to_owned());
    }

    /// What draws it.
    pub fn renderer(&self, gpu: &Arc<Gpu>, settings: Settings) -> Result<Renderer, RenderError> {
        Renderer::asked(gpu.clone(), self.transport.clone(), &self.assets, settings, self.features.clone())
    }

    /// After the first frame: which reflection probes show nothing.
    pub fn tell_misplaced(&self, renderer: &Renderer) {
        for (entity, message) in renderer.misplaced_probes() {
            let name = self.scene.entity(entity).map_or("", |entity| &entity.name);
            eprintln!("warning: reflection probe `{name}` shows nothing: {message}");
        }
    }

    /// `world_from_local` of every entity after so many seconds.
    pub fn placed_at(&self, seconds: f64) -> Vec<DAffine3> {
        placed_at(&self.scene, &self.assets, seconds)
    }

    /// Lights that switch by themselves are as they are after so many seconds.
    pub fn follow(&mut self, seconds: f64) {
        for (entity, &lit) in self.scene.entities.iter_mut().zip(&self.lit) {
            let Some(light) = &mut entity.light else { continue };
            light.on = lit && light.switching.is_none_or(|switching| switching.is_on(seconds));
        }
    }

    /// Switches a light by its number, in the order of the hierarchy. Says what came of it; `None`: there are
    /// fewer lights.
    pub fn switch(&mut self, number: usize) -> Option<String> {
        let lights =
            self.scene.entities.iter().zip(&mut self.lit).filter(|(entity, _)| entity.light.is_some());
        let (entity, lit) = { lights }.nth(number)?;
        if entity.light.as_ref()?.changes == Changes::Never {
            return Some(format!("light `{}` never changes, as the scene says", entity.name));
        }
        *lit = !*lit;
        Some(format!("light `{}` is {}", entity.name, if *lit { "on" } else { "off" }))
    }

    /// The scene's camera, or a view of all that is there.
    pub fn eye(&self, world_from_local: &[DAffine3]) -> Eye {
        Eye::of_scene(&self.scene, world_from_local).unwrap_or(self.default_eye)
    }
}

/// The box about everything that is drawn; a metre about the origin where there is nothing.
fn extent(scene: &Scene, assets: &Assets, transport: &Transport) -> (DVec3, DVec3) {
    let still = transport.surface.vertices.iter().map(|v| transport.origin + v.position.as_dvec3());
    let world_from_local = placed_at(scene, assets, 0.0);
    let baked: HashSet<_> = transport.surface.batches.iter().map(|batch| batch.entity()).collect();
    let moving = scene.entities.iter().zip(&world_from_local).flat_map(|(entity, world)| {
        let is_drawn = !(entity.hidden || entity.is_static && baked.contains(&entity.id));
        let renderer = entity.mesh.as_ref().filter(|_| is_drawn);
        let mesh = renderer.and_then(|renderer| assets.meshes.get(&renderer.mesh));
        let positions = mesh.map_or(&[][..], |mesh| &mesh.positions);
        positions.iter().map(|position| world.transform_point3(position.as_dvec3()))
    });
    let points = still.chain(moving).filter(|point| point.is_finite());
    let both = points.fold(None, |both: Option<(DVec3, DVec3)>, point| {
        Some(both.map_or((point, point), |(low, high)| (low.min(point), high.max(point))))
    });
    both.unwrap_or((DVec3::splat(-0.5), DVec3::splat(0.5)))
}

/// `world_from_local` of every entity of a scene after so many seconds.
pub fn placed_at(scene: &Scene, assets: &Assets, seconds: f64) -> Vec<DAffine3> {
    world_from_local_of(scene, |index| parent_from_local(&scene.entities[index], assets, seconds))
}

fn parent_from_local(entity: &Entity, assets: &Assets, seconds: f64) -> DAffine3 {
    let Some(motion) = &entity.motion else { return entity.transform.parent_from_local() };
    let clip = match motion {
        Motion::Clip { file, animation, node, .. } => {
            assets.clips.get(&ClipSource { file: file.clone(), animation: *animation, node: *node })
        }
        _ => None,
    };
    moved(motion, &entity.transform, clip.map(Arc::as_ref), seconds).parent_from_local()
}

/// World coordinates are relative to it where no bake says to what: near enough for single precision, and the
/// origin itself for scenes about it.
fn origin_near(middle: DVec3) -> DVec3 {
    const GRID: f64 = 256.0;
    (middle / GRID).round() * GRID
}
