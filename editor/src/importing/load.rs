//! What a scene refers to and memory does not hold: found, and read file by file, so that a file that is missing or broken
//! keeps no other from being seen.

use std::collections::{BTreeSet, HashSet};
use std::path::Path;
use std::sync::Arc;

use engine::scene::assets::{Assets, ClipSource, Picture};
use engine::scene::import::load_assets;
use engine::scene::{
    Entity, ImageSource, Material, Mesh, MeshRenderer, MeshSource, Motion, Scene, SkyKind, Texture, Warning,
};

use crate::edit::IndexedScene;

/// The part of a scene that refers to what is not there, without the files that were tried in vain. `None`: all is there.
pub fn wanted(scene: &IndexedScene, known: &Assets, hopeless: &HashSet<String>) -> Option<Scene> {
    let is_hopeful = |file: &str| !hopeless.contains(file);
    let lacks = |image: &ImageSource| !known.images.contains_key(image) && is_hopeful(&image.file);
    let mut part = Scene::default();
    let all = scene.scene();
    let mut used = HashSet::new();
    for entity in &all.entities {
        if lacks_mesh(entity, scene, known, &is_hopeful) || lacks_clip(entity, known, &is_hopeful) {
            used.extend(entity.mesh.iter().flat_map(|mesh| mesh.materials.iter().copied()));
            part.entities.push(Entity { parent: None, ..entity.clone() });
        }
    }
    for material in &all.materials {
        let shows_new = textures(material).any(|texture| lacks(&texture.image));
        if shows_new || used.contains(&material.id) {
            part.materials.push(stripped(material, &lacks));
        }
    }
    if let SkyKind::Picture { image, .. } = &all.sky.kind
        && lacks(image)
    {
        part.sky = all.sky.clone();
    }
    let is_dark = part.sky == Default::default();
    let shows = part.materials.iter().any(|material| textures(material).any(|texture| lacks(&texture.image)));
    (!part.entities.is_empty() || shows || !is_dark).then_some(part)
}

fn textures(material: &Material) -> impl Iterator<Item = &Texture> {
    crate::assets::textures(material).into_iter()
}

/// Pictures that are there are not read again; a normal map stays, as it says which meshes need tangents.
fn stripped(material: &Material, lacks: &dyn Fn(&ImageSource) -> bool) -> Material {
    let lacking = |texture: &Option<Texture>| texture.clone().filter(|texture| lacks(&texture.image));
    let mut new = material.clone();
    new.albedo.texture = lacking(&material.albedo.texture);
    new.emission.texture = lacking(&material.emission.texture);
    new.metallic_roughness_texture = lacking(&material.metallic_roughness_texture);
    new
}

/// It is not there, or it is without the tangents that a normal map needs by now.
fn lacks_mesh(
    entity: &Entity,
    scene: &IndexedScene,
    known: &Assets,
    is_hopeful: &dyn Fn(&str) -> bool,
) -> bool {
    let Some(renderer) = &entity.mesh else { return false };
    let lacks = known.meshes.get(&renderer.mesh).is_none_or(|mesh| lacks_tangents(mesh, renderer, scene));
    lacks && file_of(renderer).is_none_or(is_hopeful)
}

fn lacks_tangents(mesh: &Mesh, renderer: &MeshRenderer, scene: &IndexedScene) -> bool {
    let is_bumped = |primitive: usize| {
        let id = renderer.materials.get(primitive).or(renderer.materials.last())?;
        let map = scene.material(*id)?.normal_texture.as_ref()?;
        mesh.uvs[usize::from(map.uv_set.min(1))].as_ref()
    };
    mesh.tangents.is_none() && (0..mesh.primitives.len()).any(|primitive| is_bumped(primitive).is_some())
}

fn file_of(renderer: &MeshRenderer) -> Option<&str> {
    match &renderer.mesh {
        MeshSource::File { file, .. } => Some(file),
        MeshSource::Shape(_) => None,
    }
}

fn lacks_clip(entity: &Entity, known: &Assets, is_hopeful: &dyn Fn(&str) -> bool) -> bool {
    let Some(Motion::Clip { file, animation, node, .. }) = &entity.motion else { return false };
    let source = ClipSource { file: file.clone(), animation: *animation, node: *node };
    !known.clips.contains_key(&source) && is_hopeful(file)
}

/// What of a scene can be read. What cannot is told, with the file and the remedy.
pub fn what_is_there(project: &Path, scene: &Scene) -> (Assets, Vec<Warning>) {
    if let Ok(all) = load_assets(project, scene) {
        return all;
    }
    let (mut assets, mut warnings) = (Assets::default(), Vec::new());
    for file in files(scene) {
        match load_assets(project, &part_of(scene, file)) {
            Ok((more, told)) => {
                add(&mut assets, more);
                warnings.extend(told);
            }
            Err(error) => {
                let told = bake::chain::told(&error);
                let remedy = "put the file back, or relink it in the assets panel";
                let about = file.unwrap_or("scene");
                warnings.push(Warning::new(about, format!("{told}; {remedy}")));
            }
        }
    }
    (assets, warnings)
}

/// `None`: what is in no file.
fn files(scene: &Scene) -> BTreeSet<Option<&str>> {
    let meshes = scene.entities.iter().filter_map(|entity| entity.mesh.as_ref()).map(file_of);
    meshes.chain([None]).collect()
}

/// The entities whose meshes lie in the file; what has none goes with the materials and the sky, which are read whatever
/// becomes of them.
fn part_of(scene: &Scene, file: Option<&str>) -> Scene {
    let lies_there = |entity: &&Entity| entity.mesh.as_ref().and_then(file_of) == file;
    let entities: Vec<Entity> = scene.entities.iter().filter(lies_there).cloned().collect();
    let mut part = Scene { entities, ..Scene::default() };
    match file {
        None => (part.materials, part.sky) = (scene.materials.clone(), scene.sky.clone()),
        Some(_) => part.materials = scene.materials.iter().map(|m| stripped(m, &|_| false)).collect(),
    }
    part
}

pub fn add(assets: &mut Assets, more: Assets) {
    assets.meshes.extend(more.meshes);
    assets.images.extend(more.images);
    assets.clips.extend(more.clips);
}

pub fn add_shared(assets: &mut Assets, more: &Assets) {
    assets.meshes.extend(more.meshes.iter().map(|(source, mesh)| (source.clone(), mesh.clone())));
    assets.images.extend(more.images.iter().map(|(source, picture)| (source.clone(), picture.clone())));
    assets.clips.extend(more.clips.iter().map(|(source, clip)| (source.clone(), clip.clone())));
}

/// What did not change keeps its place in memory, by which others see that it did not.
pub fn keep_what_is_the_same(new: &mut Arc<Assets>, known: &Assets) {
    let new = Arc::make_mut(new);
    for (source, mesh) in &mut new.meshes {
        if let Some(old) = known.meshes.get(source).filter(|old| **old == *mesh) {
            *mesh = old.clone();
        }
    }
    for (source, picture) in &mut new.images {
        if let Some(old) = known.images.get(source).filter(|old| **old == *picture) {
            *picture = old.clone();
        }
    }
}

/// What was known under the name of a file, or of what lies below a folder, is known under another.
pub fn renamed(assets: &mut Assets, moved: &dyn Fn(&str) -> Option<String>) {
    let meshes = assets.meshes.iter().filter_map(|(source, mesh)| match source {
        MeshSource::File { file, mesh: n } => {
            Some((MeshSource::File { file: moved(file)?, mesh: *n }, mesh.clone()))
        }
        MeshSource::Shape(_) => None,
    });
    let meshes: Vec<_> = meshes.collect();
    let images = assets.images.iter().filter_map(|(source, picture)| {
        Some((ImageSource { file: moved(&source.file)?, image: source.image }, picture.clone()))
    });
    let images: Vec<_> = images.collect();
    let clips = assets.clips.iter().filter_map(|(source, clip)| {
        Some((ClipSource { file: moved(&source.file)?, ..source.clone() }, clip.clone()))
    });
    let clips: Vec<_> = clips.collect();
    assets.meshes.extend(meshes);
    assets.images.extend(images);
    assets.clips.extend(clips);
}

/// A picture by itself. Errors name the file.
pub fn picture(project: &Path, source: &ImageSource) -> Result<Arc<Picture>, String> {
    let mut material = Material::default();
    material.albedo.texture = Some(Texture::new(source.clone()));
    let scene = Scene { materials: vec![material], ..Scene::default() };
    let (assets, warnings) = load_assets(project, &scene).map_err(|error| bake::chain::told(&error))?;
    let told = || match warnings.first() {
        Some(warning) => format!("{}: {}", project.join(&source.file).display(), warning.message),
        None => format!("{}: cannot be read as a picture", project.join(&source.file).display()),
    };
    assets.images.get(source).cloned().ok_or_else(told)
}
