//! A project that was opened: its document, what it refers to, and what lights it.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use engine::play::World;
use engine::scene::assets::Assets;
use engine::scene::import::load_assets;
use engine::scene::{EntityId, SceneError, Warning};
use engine::transport::Transport;
use engine::transport::reflection::Cube;

use crate::baking::{self, Baked};
use crate::document::Document;

pub struct Opened {
    pub document: Document,
    pub assets: Arc<Assets>,
    /// The bake without what is stale of it.
    pub shown: Arc<Transport>,
    pub baked: Option<Baked>,
    pub cubemaps: HashMap<EntityId, Cube>,
    pub unlimited_gain: bool,
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
                let World { assets, transport: shown, unlimited_gain, .. } = world;
                let loaded =
                    baking::load(&document, &assets);
                let baked = loaded.unwrap_or_else(|error| {
                    warnings.push(Warning::new(document.name(), error));
                    None
                });
                let assets = Arc::new(assets);
                Ok(Self { document, assets, shown, baked, cubemaps, unlimited_gain, warnings })
            }
            Err(error) => {
                warnings.push(Warning::new(document.name(), error.to_string()));
                let (assets, more) = load_assets(project, document.scene())?;
                warnings.extend(more);
                let (shown, cubemaps) = Default::default();
                let assets = Arc::new(assets);
                Ok(Self { document, assets, shown, baked: None, cubemaps, unlimited_gain: false, warnings })
            }
        }
    }
}
