//! A project that was opened: its document, what it refers to, and what lights it.

use std::path::Path;
use std::sync::Arc;

use engine::play::World;
use engine::scene::assets::Assets;
use engine::scene::import::load_assets;
use engine::scene::{EntityId, SceneError};
use engine::transport::Transport;
use engine::transport::reflection::Cube;

use crate::document::Document;

pub struct Opened {
    pub document: Document,
    pub assets: Assets,
    pub transport: Arc<Transport>,
    pub cubemaps: std::collections::HashMap<EntityId, Cube>,
    pub unlimited_gain: bool,
    /// For the console.
    pub warnings: Vec<String>,
}

impl Opened {
    /// A bake that cannot be used is told, and the scene is shown without it.
    pub fn load(project: &Path, scene: Option<&str>) -> Result<Self, SceneError> {
        let (document, warnings) = Document::open(project, scene)?;
        let mut warnings: Vec<String> = warnings.iter().map(ToString::to_string).collect();
        match World::load(project, Some(document.name()), false) {
            Ok((world, more)) => {
                warnings.extend(more.iter().map(ToString::to_string));
                let cubemaps = world.cubemaps.load(&world.scene);
                let World { assets, transport, unlimited_gain, .. } = world;
                Ok(Self { document, assets, transport, cubemaps, unlimited_gain, warnings })
            }
            Err(error) => {
                warnings.push(error.to_string());
                let (assets, more) = load_assets(project, document.scene())?;
                warnings.extend(more.iter().map(ToString::to_string));
                let (transport, cubemaps) = Default::default();
                Ok(Self { document, assets, transport, cubemaps, unlimited_gain: false, warnings })
            }
        }
    }
}
