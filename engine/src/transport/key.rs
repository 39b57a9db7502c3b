//! What a bake depends on: geometry, density, holes, probes where something reads them, and how it is baked, each part with a key of its own,
//! and one key of all. Lights, colours, emission and the sky's brightness are not in them: they change without a
//! bake.

use std::collections::{BTreeMap, HashMap};

use glam::DAffine3;
use serde::{Deserialize, Serialize};

use super::directional::any_directional;
use super::needs::as_baked;
use crate::scene::assets::{Assets, Picture, Pixels};
use crate::scene::file::Quality;
use crate::scene::{
    Alpha, Entity, EntityId, Feature, Forced, ImageSource, Mesh, MeshRenderer, MeshSource, Scene, SkyKind,
    world_from_local,
};

/// How a scene is baked, settled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BakeWith {
    pub quality: Quality,
    /// Rays a row; a power of two.
    pub rays: u32,
    /// Metres.
    pub length: f64,
}

/// Counts up whenever the same input bakes to other bytes. 5: cuts along what stands a
/// little off; weights of receivers and probes that four bytes hold; origins at halves of the grid. 6: points of the grid
/// on sides of the triangulation; what stands beside a foot of a wall hides; 256 points towards near emitters. 7: patches end
/// beside a gap, too.
const METHOD: u32 = 7;
/// Likewise for scenes with normal maps on static surfaces, and for no others.
const DIRECTIONAL_METHOD: u32 = 1;

/// One thing that a bake was made of.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Input {
    pub what: What,
    /// 0 for what belongs to no entity.
    pub entity: EntityId,
    /// For people.
    pub name: String,
    /// BLAKE3 of all that the bake takes from it.
    pub key: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum What {
    /// How the baker works, and what it was told.
    Method,
    /// Whether there is one.
    Sky,
    /// A static entity: its mesh, place, density, sides and holes.
    Surface,
    /// A group of light probes.
    Probes,
}

/// All that a bake of the scene depends on, of what it needs. What the assets do not have counts as absent.
pub fn inputs(
    scene: &Scene,
    assets: &Assets,
    with: &BakeWith,
    forced: &BTreeMap<Feature, Forced>,
) -> Vec<Input> {
    let scene = &as_baked(scene, assets, forced);
    let mut contents = Contents { assets, meshes: HashMap::new(), pictures: HashMap::new() };
    let mut method = format!("{:?}", (METHOD, with.rays, with.length.to_bits()));
    if any_directional(scene) {
        method += &format!("{DIRECTIONAL_METHOD}");
    }
    let mut inputs = vec![
        general(What::Method, "how it is baked", &method),
        general(What::Sky, "the sky", &format!("{}", scene.sky.kind != SkyKind::None)),
    ];
    for (entity, world) in scene.entities.iter().zip(world_from_local(scene)) {
        if let Some(group) = &entity.light_probes {
            let taken = format!("{}{:?}{}", place(&world), group.positions, entity.hidden);
            inputs.push(input(What::Probes, entity, &taken));
        }
        let drawn = entity.mesh.as_ref().filter(|_| entity.is_static && !scene.is_hidden(entity));
        if let Some(renderer) = drawn {
            let taken = format!("{}{}", place(&world), contents.surface(scene, renderer));
            inputs.push(input(What::Surface, entity, &taken));
        }
    }
    inputs
}

/// Two scenes with one key have the same transport.
pub fn transport_key(inputs: &[Input]) -> String {
    let all: Vec<_> = inputs.iter().map(|input| (input.what, input.entity, &input.key)).collect();
    hash(&format!("{all:?}"))
}

fn general(what: What, name: &str, taken: &str) -> Input {
    Input { what, entity: EntityId(0), name: name.to_owned(), key: hash(taken) }
}

fn input(what: What, entity: &Entity, taken: &str) -> Input {
    Input { what, entity: entity.id, name: entity.name.clone(), key: hash(taken) }
}

fn hash(taken: &str) -> String {
    blake3::hash(taken.as_bytes()).to_hex().to_string()
}

fn place(world: &DAffine3) -> String {
    format!("{:?}", world.to_cols_array().map(f64::to_bits))
}

/// Hashes of meshes and pictures, each made once.
struct Contents<'a> {
    assets: &'a Assets,
    meshes: HashMap<MeshSource, String>,
    pictures: HashMap<ImageSource, String>,
}

impl Contents<'_> {
    fn surface(&mut self, scene: &Scene, renderer: &MeshRenderer) -> String {
        let mut taken = format!("{}{:?}", self.mesh(&renderer.mesh), renderer.density);
        for material in renderer.materials.iter().filter_map(|&id| scene.material(id)) {
            let sides = (material.id, material.double_sided, material.emission.sampled, material.alpha);
            taken += &format!("{sides:?}");
            // Vertices are made of them.
            taken += &format!("{:?}", material.normal_texture.as_ref().map(|map| map.uv_set));
            if material.alpha == Alpha::Opaque {
                continue;
            }
            taken += &format!("{:?}{:?}", material.opacity, material.albedo.texture);
            if let Some(texture) = &material.albedo.texture {
                taken += &self.picture(&texture.image);
            }
        }
        taken
    }

    fn mesh(&mut self, source: &MeshSource) -> String {
        let known = self.meshes.entry(source.clone());
        known.or_insert_with(|| self.assets.meshes.get(source).map_or(String::new(), |m| of_mesh(m))).clone()
    }

    fn picture(&mut self, source: &ImageSource) -> String {
        let known = self.pictures.entry(source.clone());
        known
            .or_insert_with(|| self.assets.images.get(source).map_or(String::new(), |p| of_picture(p)))
            .clone()
    }
}

fn of_mesh(mesh: &Mesh) -> String {
    let primitives: Vec<u32> = mesh.primitives.iter().flat_map(|run| [run.first, run.count]).collect();
    let uvs = mesh.uvs.each_ref().map(|uvs| uvs.as_deref().unwrap_or_default());
    of_arrays(&[
        bytemuck::cast_slice(&mesh.positions),
        bytemuck::cast_slice(&mesh.normals),
        bytemuck::cast_slice(mesh.tangents.as_deref().unwrap_or_default()),
        bytemuck::cast_slice(uvs[0]),
        bytemuck::cast_slice(uvs[1]),
        bytemuck::cast_slice(mesh.colors.as_deref().unwrap_or_default()),
        bytemuck::cast_slice(&mesh.indices),
        bytemuck::cast_slice(&primitives),
    ])
}

pub(super) fn of_picture(picture: &Picture) -> String {
    let pixels = match &picture.pixels {
        Pixels::Rgba8(pixels) => bytemuck::cast_slice(pixels),
        Pixels::Rgb32f(pixels) => bytemuck::cast_slice(pixels),
    };
    of_arrays(&[bytemuck::bytes_of(&[picture.width, picture.height]), pixels])
}

fn of_arrays(arrays: &[&[u8]]) -> String {
    let mut hasher = blake3::Hasher::new();
    for bytes in arrays {
        hasher.update(&(bytes.len() as u64).to_le_bytes());
        hasher.update(bytes);
    }
    hasher.finalize().to_hex().to_string()
}
