//! What is played: a scene with its assets and its bake, and where everything is at a time.

use std::path::Path;
use std::sync::Arc;

use glam::{DAffine3, DVec3};

use super::PlayError;
use crate::render::Eye;
use crate::scene::assets::{Assets, ClipSource};
use crate::scene::file::Quality;
use crate::scene::import::load_assets;
use crate::scene::motion::moved;
use crate::scene::transform::world_from_local_of;
use crate::scene::{Entity, Motion, Scene, Warning, file};
use crate::transport::key::{BakeWith, transport_key};
use crate::transport::{self, Transport};

pub struct World {
    pub name: String,
    pub scene: Scene,
    pub assets: Assets,
    pub transport: Arc<Transport>,
    /// Albedo as authored, however long light bounces.
    pub unlimited_gain: bool,
    /// Metres across all that is drawn at the start.
    pub size: f64,
    /// Looked through where the scene has no camera.
    default_eye: Eye,
}

impl World {
    /// Reads a scene of a project (`None`: its default scene) and its bake.
    pub fn load(project: &Path, scene: Option<&str>) -> Result<(Self, Vec<Warning>), PlayError> {
        let settings = file::load_project(project)?;
        let name = scene.unwrap_or(&settings.default_scene).to_owned();
        let scene = file::load_scene(project, &name)?;
        let (assets, mut warnings) = load_assets(project, &scene)?;
        warnings.extend(transport::materials::warnings(&scene));
        let transport = Arc::new(bake_of(project, &name, &scene)?);
        let unlimited_gain = settings.bake.unlimited_gain;
        let (low, high) = extent(&scene, &assets, &transport);
        let (size, default_eye) = ((high - low).length(), Eye::framing(low, high));
        Ok((Self { name, scene, assets, transport, unlimited_gain, size, default_eye }, warnings))
    }

    /// `world_from_local` of every entity after so many seconds.
    pub fn placed_at(&self, seconds: f64) -> Vec<DAffine3> {
        placed_at(&self.scene, &self.assets, seconds)
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
    let moving = scene.entities.iter().zip(&world_from_local).flat_map(|(entity, world)| {
        let renderer = entity.mesh.as_ref().filter(|_| !entity.is_static && !entity.hidden);
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

/// The bake on disk; nothing where there is nothing to bake.
fn bake_of(project: &Path, name: &str, scene: &Scene) -> Result<Transport, PlayError> {
    let path = transport::file::path(project, name);
    if path.is_file() {
        let transport = transport::file::load(&path)?;
        let certificate = &transport.certificate;
        let with = BakeWith {
            quality: Quality::default(), // a name for rays and length
            rays: certificate.rays_per_row,
            length: certificate.base_length,
        };
        if transport_key(project, scene, &with) != certificate.key {
            let project = project.display().to_string();
            return Err(PlayError::Stale { project, scene: name.to_owned() });
        }
        return Ok(transport);
    }
    let to_bake = |entity: &Entity| entity.is_static && entity.mesh.is_some() && !entity.hidden;
    if scene.entities.iter().any(to_bake) {
        let project = project.display().to_string();
        return Err(PlayError::Unbaked { project, scene: name.to_owned() });
    }
    Ok(Transport::default())
}
