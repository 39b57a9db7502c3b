//! What a bake depends on, as one hash: geometry, density, holes, probes and how it is baked. Lights, colours,
//! emission and the sky's brightness are not in it: they change without a bake.

use std::path::Path;

use crate::scene::file::Quality;
use crate::scene::{Alpha, MeshSource, Scene, SkyKind, world_from_local};

/// How a scene is baked, settled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BakeWith {
    pub quality: Quality,
    /// Rays a row; a power of two.
    pub rays: u32,
    /// Metres.
    pub length: f64,
}

/// Counts up whenever the same input bakes to other bytes. 3: probes beside walls keep how far they see.
const METHOD: u32 = 3;

/// Two scenes with one key have the same transport. A file that cannot be read counts as absent.
pub fn transport_key(project: &Path, scene: &Scene, with: &BakeWith) -> String {
    let mut hasher = blake3::Hasher::new();
    let mut add = |name: &str, bytes: &[u8]| {
        hasher.update(name.as_bytes());
        hasher.update(&(bytes.len() as u64).to_le_bytes());
        hasher.update(bytes);
    };
    add("method", &METHOD.to_le_bytes());
    add("with", format!("{:?}", (with.rays, with.length.to_bits())).as_bytes());
    add("sky", &[u8::from(scene.sky.kind != SkyKind::None)]);
    let mut files = std::collections::BTreeSet::new();
    for (entity, world) in scene.entities.iter().zip(world_from_local(scene)) {
        let place = format!("{:?}{:?}", entity.id, world.to_cols_array().map(f64::to_bits));
        if let Some(group) = &entity.light_probes {
            add("probes", format!("{place}{:?}{}", group.positions, entity.hidden).as_bytes());
        }
        let Some(renderer) = entity.mesh.as_ref().filter(|_| entity.is_static && !scene.is_hidden(entity))
        else {
            continue;
        };
        add("mesh", format!("{place}{:?}", renderer.mesh).as_bytes());
        add("density", format!("{:?}", renderer.density).as_bytes());
        if let MeshSource::File { file, .. } = &renderer.mesh {
            files.insert(file.clone());
        }
        for material in renderer.materials.iter().map(|&id| (id, scene.material(id))) {
            let (id, Some(material)) = material else { continue };
            let sides = (id, material.double_sided, material.emission.sampled, material.alpha);
            add("material", format!("{sides:?}").as_bytes());
            if material.alpha != Alpha::Opaque {
                add("alpha", format!("{:?}{:?}", material.opacity, material.albedo.texture).as_bytes());
                files.extend(material.albedo.texture.iter().map(|texture| texture.image.file.clone()));
            }
        }
    }
    for file in files {
        let bytes = std::fs::read(project.join(&file)).unwrap_or_default();
        add("file", file.as_bytes());
        add("bytes", blake3::hash(&bytes).as_bytes());
    }
    hasher.finalize().to_hex().to_string()
}
