//! A project that was opened: its document, what it refers to, and what lights it.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use engine::play::World;
use engine::render::{Asked, Settings};
use engine::scene::assets::Assets;
use engine::scene::file::scene_path;
use engine::scene::import::load_assets;
use engine::scene::{EntityId, SceneError, Warning};
use engine::transport::Transport;
use engine::transport::reflection::Cube;
use glam::DVec3;

use crate::baking::{self, Baked};
use crate::document::Document;
use crate::primitives;

pub struct Opened {
    pub document: Document,
    pub assets: Arc<Assets>,
    /// The full bake without what is stale of it: what the player's file leaves out an edit may ask for at any time.
    pub shown: Arc<Transport>,
    pub baked: Option<Baked>,
    pub cubemaps: HashMap<EntityId, Cube>,
    pub settings: Settings,
    /// What the author says of features.
    pub features: Asked,
    /// For the console.
    pub warnings: Vec<Warning>,
}

impl Opened {
    /// A bake that cannot be used is told, and the scene is shown without it.
    pub fn load(project: &Path, scene: Option<&str>) -> Result<Self, SceneError> {
        let (document, mut warnings) = Document::open(project, scene)?;
        match World::load(project, Some(document.name()), false) {
            Ok((world, more)) => {
                warnings.extend(more);
                let cubemaps = world.cubemaps.load(&world.scene);
                let World { assets, transport, unlimited_gain, features, .. } = world;
                let loaded = baking::load(&document, &assets);
                let baked = loaded.unwrap_or_else(|error| {
                    warnings.push(Warning::new(document.name(), error));
                    None
                });
                let fitting = baked.as_ref().and_then(Baked::fitting);
                let shown = fitting.unwrap_or_else(|| Arc::new(without_light(transport.origin)));
                let settings = Settings { unlimited_gain, ..Settings::default() };
                let assets = Arc::new(assets);
                Ok(Self { document, assets, shown, baked, cubemaps, settings, features, warnings })
            }
            Err(error) => {
                warnings.push(Warning::new(document.name(), error.to_string()));
                let (assets, more) = load_assets(project, document.scene())?;
                warnings.extend(more);
                let (shown, cubemaps, settings, features) = Default::default();
                let assets = Arc::new(assets);
                Ok(Self { document, assets, shown, baked: None, cubemaps, settings, features, warnings })
            }
        }
    }
}

/// Which document is to be opened, or made first.
#[derive(Clone, Debug, PartialEq)]
pub enum Wanted {
    /// `scene`: `None` for the project's default one.
    Open {
        project: PathBuf,
        scene: Option<String>,
    },
    /// With what every new scene has.
    NewScene {
        project: PathBuf,
        name: String,
    },
    NewProject(PathBuf),
}

impl Wanted {
    pub fn place(&self) -> PathBuf {
        match self {
            Self::Open { project, scene: None } | Self::NewProject(project) => project.clone(),
            Self::Open { project, scene: Some(name) } | Self::NewScene { project, name } => {
                scene_path(project, name)
            }
        }
    }

    /// Waits for the disk. What is there already is not overwritten.
    pub fn load(&self) -> Result<Opened, String> {
        let first = primitives::first_scene;
        let (project, scene) = match self {
            Self::Open { project, scene } => (project, scene.as_deref()),
            Self::NewScene { project, name } => {
                Document::new_scene(project, name, first()).map_err(|error| bake::chain::told(&error))?;
                (project, Some(name.as_str()))
            }
            Self::NewProject(project) => {
                Document::new_project(project, "main", first()).map_err(|error| bake::chain::told(&error))?;
                (project, None)
            }
        };
        Opened::load(project, scene).map_err(|error| bake::chain::told(&error))
    }
}

fn without_light(origin: DVec3) -> Transport {
    Transport { origin, ..Transport::default() }
}
