//! Cubemaps of reflection probes that are baked: OpenEXR files `baked/NAME/reflections/ENTITY.exr`, six faces below
//! each other, with a key that says what they show.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use exr::error::Error;
use exr::prelude::{
    AttributeValue, Encoding, Image, Layer, LayerAttributes, ReadChannels, ReadLayers, RgbChannels,
    SpecificChannels, Text, Vec2, WritableImage,
};
use glam::Vec3;

use super::PlayError;
use crate::render::Renderer;
use crate::scene::{EntityId, Refresh, Scene, file};
use crate::transport::Transport;
use crate::transport::reflection::Cube;

/// The name of the key among a file's attributes.
const KEY: &str = "hohlraum.key";

/// Where the cubemaps of a scene lie, and what they have to show.
pub struct Cubemaps {
    folder: PathBuf,
    key: String,
}

impl Cubemaps {
    pub fn new(project: &Path, name: &str, scene: &Scene, transport: &Transport) -> Self {
        let folder = file::baked_dir(project, name).join("reflections");
        Self { folder, key: key(scene, transport) }
    }

    /// Those on disk that show the scene as it is; one that is broken or of another scene is as good as none.
    pub fn load(&self, scene: &Scene) -> HashMap<EntityId, Cube> {
        let baked = scene.entities.iter().filter(|entity| {
            entity.reflection_probe.as_ref().is_some_and(|probe| probe.refresh == Refresh::Baked)
        });
        baked.filter_map(|entity| Some((entity.id, load(&self.path(entity.id), &self.key)?))).collect()
    }

    /// Those that the last frame finished.
    pub fn save(&self, renderer: &mut Renderer) -> Result<(), PlayError> {
        for (entity, cube) in renderer.finished_cubemaps()? {
            let path = self.path(entity);
            store(&path, &self.key, &cube)
                .map_err(|error| PlayError::Write { path: path.clone(), message: error.to_string() })?;
        }
        Ok(())
    }

    fn path(&self, entity: EntityId) -> PathBuf {
        self.folder.join(format!("{}.exr", entity.0))
    }
}

/// The transport, and all of the scene but what moves and cameras.
fn key(scene: &Scene, transport: &Transport) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(transport.certificate.transport_hash.as_bytes());
    hasher.update(format!("{:?}{:?}", scene.sky, scene.materials).as_bytes());
    for entity in &scene.entities {
        let shown = entity.is_static || entity.mesh.is_none();
        if shown && entity.camera.is_none() {
            hasher.update(format!("{entity:?}").as_bytes());
        }
    }
    hasher.finalize().to_hex().to_string()
}

fn load(path: &Path, key: &str) -> Option<Cube> {
    let create = |size: Vec2<usize>, _: &RgbChannels| (size, vec![Vec3::ZERO; size.area()]);
    let set = |(size, texels): &mut (Vec2<usize>, Vec<Vec3>), at: Vec2<usize>, (r, g, b): (f32, f32, f32)| {
        texels[at.flat_index_for_size(*size)] = Vec3::new(r, g, b);
    };
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(create, set)
        .first_valid_layer();
    let image = image.all_attributes().from_file(path).ok()?;
    let found = image.layer_data.attributes.other.get(&Text::from(KEY))?;
    let matches = matches!(found, AttributeValue::Text(text) if text == key);
    let (size, texels) = image.layer_data.channel_data.pixels;
    let is_cube = size.height() == 6 * size.width() && size.width().is_power_of_two();
    let finite = texels.iter().all(|texel| texel.is_finite());
    (matches && is_cube && finite).then(|| Cube::new(size.width(), texels))
}

fn store(path: &Path, key: &str, cube: &Cube) -> Result<(), Error> {
    let size = cube.size();
    let texel = |at: Vec2<usize>| {
        let texel = cube.texels()[at.y() * size + at.x()];
        (texel.x, texel.y, texel.z)
    };
    let channels = SpecificChannels::rgb(texel);
    let mut attributes = LayerAttributes::named("reflections");
    attributes.other.insert(Text::from(KEY), AttributeValue::Text(Text::from(key)));
    let layer = Layer::new((size, 6 * size), attributes, Encoding::FAST_LOSSLESS, channels);
    let mut bytes = std::io::Cursor::new(Vec::new());
    Image::from_layer(layer).write().to_buffered(&mut bytes)?;
    file::write_atomically(path, bytes.get_ref()).map_err(|error| Error::Io(std::io::Error::other(error)))
}
