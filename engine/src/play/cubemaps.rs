//! Cubemaps of reflection probes that are baked: OpenEXR files `baked/NAME/reflections/ENTITY.exr`, six faces below
//! each other, with a key that says what they show.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use exr::error::Error;
use exr::prelude::{
    AttributeValue, Encoding, Image, Layer, LayerAttributes, ReadChannels, ReadLayers, RgbChannels,
    SpecificChannels, Text, Vec2, WritableImage,
};
use glam::Vec3;

use super::{PlayError, World};
use crate::gpu::{Gpu, texture};
use crate::render::{Now, Renderer, Settings, View};
use crate::scene::assets::{Assets, Pixels};
use crate::scene::{Entity, EntityId, Refresh, Scene, file};
use crate::transport::Transport;
use crate::transport::reflection::Cube;

/// The name of the key among a file's attributes.
const KEY: &str = "hohlraum.key";

/// Of a preparation: then it has to do.
const MOST_FRAMES: u32 = 200;

/// Where the cubemaps of a scene lie, and what they have to show.
pub struct Cubemaps {
    folder: PathBuf,
    key: String,
}

impl Cubemaps {
    pub fn new(project: &Path, name: &str, scene: &Scene, assets: &Assets, transport: &Transport) -> Self {
        let folder = file::baked_dir(project, name).join("reflections");
        Self { folder, key: key(scene, assets, transport) }
    }

    /// Takes those that are not on disk, of the scene as it is at the start, with a renderer of their own: what is
    /// played afterwards is the same whether they were there or not.
    pub fn prepare(&self, gpu: &Arc<Gpu>, world: &World, settings: Settings) -> Result<(), PlayError> {
        if baked(&world.scene).count() == self.load(&world.scene).len() {
            return Ok(());
        }
        let settings = Settings { wait: true, products: None, ..settings };
        let mut renderer = world.renderer(gpu, settings)?;
        let display = texture::target(gpu, "preparation", [16, 16], 1, wgpu::TextureFormat::Rgba8UnormSrgb);
        let world_from_local = world.placed_at(0.0);
        let (scene, assets, view) = (&world.scene, &world.assets, View::Composite);
        let eye = world.eye(&world_from_local);
        let now = Now { scene, assets, world_from_local: &world_from_local, time: 0.0, eye, view };
        for _ in 0..MOST_FRAMES {
            let drawn = renderer.draw(&now, &display)?;
            if drawn.captures == 0 && drawn.transport_dispatches == 0 {
                break;
            }
        }
        self.save(&renderer)
    }

    /// Those on disk that show the scene as it is; one that is broken or of another scene is as good as none.
    pub fn load(&self, scene: &Scene) -> HashMap<EntityId, Cube> {
        baked(scene).filter_map(|entity| Some((entity.id, load(&self.path(entity.id), &self.key)?))).collect()
    }

    /// Those that are finished. One that cannot be written is taken anew the next time.
    fn save(&self, renderer: &Renderer) -> Result<(), PlayError> {
        for (entity, cube) in renderer.finished_cubemaps()? {
            let path = self.path(entity);
            if let Err(error) = store(&path, &self.key, &cube) {
                eprintln!("warning: {}: {error}; it is captured again the next time", path.display());
            }
        }
        Ok(())
    }

    fn path(&self, entity: EntityId) -> PathBuf {
        self.folder.join(format!("{}.exr", entity.0))
    }
}

fn baked(scene: &Scene) -> impl Iterator<Item = &Entity> {
    scene.entities.iter().filter(|entity| {
        entity.reflection_probe.as_ref().is_some_and(|probe| probe.refresh == Refresh::Baked)
    })
}

/// The transport, pictures, and all of the scene but what moves and cameras that are nothing else.
fn key(scene: &Scene, assets: &Assets, transport: &Transport) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(transport.certificate.transport_hash.as_bytes());
    hasher.update(format!("{:?}{:?}", scene.sky, scene.materials).as_bytes());
    for entity in &scene.entities {
        let shown = entity.is_static || entity.mesh.is_none() || entity.light.is_some();
        let shines = entity.light.is_some() || entity.reflection_probe.is_some();
        if shown && (shines || entity.camera.is_none()) {
            hasher.update(format!("{entity:?}").as_bytes());
        }
    }
    let mut pictures: Vec<_> =
        assets.images.iter().map(|(source, picture)| (source.clone(), picture)).collect();
    pictures.sort_by(|a, b| a.0.cmp(&b.0));
    for (source, picture) in pictures {
        hasher.update(format!("{source:?}{}x{}", picture.width, picture.height).as_bytes());
        match &picture.pixels {
            Pixels::Rgba8(pixels) => hasher.update(bytemuck::cast_slice(pixels)),
            Pixels::Rgb32f(pixels) => hasher.update(bytemuck::cast_slice(pixels)),
        };
    }
    hasher.finalize().to_hex().to_string()
}

fn load(path: &Path, key: &str) -> Option<Cube> {
    // What a damaged header says is not believed.
    let sound = |size: Vec2<usize>| size.height() == 6 * size.width() && size.width() <= 1024;
    let create = |size: Vec2<usize>, _: &RgbChannels| {
        (size, vec![Vec3::ZERO; if sound(size) { size.area() } else { 0 }])
    };
    let set = |(size, texels): &mut (Vec2<usize>, Vec<Vec3>), at: Vec2<usize>, (r, g, b): (f32, f32, f32)| {
        if let Some(texel) = texels.get_mut(at.flat_index_for_size(*size)) {
            *texel = Vec3::new(r, g, b);
        }
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
    let is_cube = sound(size) && size.width().is_power_of_two();
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
