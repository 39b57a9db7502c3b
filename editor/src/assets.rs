//! The project's files: what lies in `assets/`, what of it a scene refers to, what is missing, and what happens to
//! references when a file moves.

mod wish;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use engine::scene::{
    Entity, EntityId, ImageSource, Material, MeshSource, Motion, Scene, Sky, SkyKind, Texture,
};

use crate::edit::{Edit, Field};
use crate::importing;
pub use wish::{Carried, Place, Wish};

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    Folder,
    /// glTF, GLB, OBJ.
    Model,
    Picture,
    /// Buffers, material libraries, what came along.
    Other,
}

/// A file or folder below `assets/`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Asset {
    /// Relative to the project, forward slashes.
    pub file: String,
    pub kind: Kind,
    pub bytes: u64,
    /// Another one: the file holds something else.
    pub modified: Option<SystemTime>,
}

impl Asset {
    /// Without the folders.
    pub fn name(&self) -> &str {
        name(&self.file)
    }
}

/// The last part of a path of the project.
pub fn name(file: &str) -> &str {
    file.rsplit('/').next().unwrap_or(file)
}

/// The folder that a file or folder lies in.
pub fn folder(file: &str) -> &str {
    file.rsplit_once('/').map_or("", |(folder, _)| folder)
}

/// Who refers to a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum User {
    Entity(EntityId),
    Material(engine::scene::MaterialId),
    Sky,
}

/// All below `assets/`, folders before files, by name; import settings are not listed. Reads the disk.
pub fn list(project: &Path) -> Vec<Asset> {
    let mut found = Vec::new();
    let mut folders = vec!["assets".to_owned()];
    while let Some(folder) = folders.pop() {
        let Ok(entries) = project.join(&folder).read_dir() else { continue };
        for entry in entries.flatten() {
            let (Ok(name), Ok(metadata)) = (entry.file_name().into_string(), entry.metadata()) else {
                continue;
            };
            let file = format!("{folder}/{name}");
            if name.starts_with('.') {
                continue; // what an import is at
            }
            let kind = if metadata.is_dir() { Kind::Folder } else { kind(&name) };
            if kind == Kind::Folder {
                folders.push(file.clone());
            }
            if !importing::is_settings(&name) {
                let modified = metadata.modified().ok();
                found.push(Asset { file, kind, bytes: metadata.len(), modified });
            }
        }
    }
    found.sort_by(|a, b| (a.kind != Kind::Folder, &a.file).cmp(&(b.kind != Kind::Folder, &b.file)));
    found
}

/// By the ending, which a reader does not have to believe.
pub fn kind(name: &str) -> Kind {
    let ending = name.rsplit('.').next().unwrap_or_default().to_ascii_lowercase();
    match ending.as_str() {
        "gltf" | "glb" | "obj" => Kind::Model,
        "png" | "jpg" | "jpeg" | "hdr" | "bmp" | "tga" => Kind::Picture,
        _ => Kind::Other,
    }
}

/// Names that hold the text, in any case of letters.
pub fn search<'a>(assets: &'a [Asset], text: &str) -> Vec<&'a Asset> {
    let text = text.to_lowercase();
    assets.iter().filter(|asset| asset.file.to_lowercase().contains(&text)).collect()
}

/// Every file that the scene refers to, and who does.
pub fn references(scene: &Scene) -> BTreeMap<String, Vec<User>> {
    let mut found: BTreeMap<String, Vec<User>> = BTreeMap::new();
    let mut add = |file: &String, user| {
        let users = found.entry(file.clone()).or_default();
        if users.last() != Some(&user) {
            users.push(user);
        }
    };
    for entity in &scene.entities {
        files_of_entity(entity).into_iter().for_each(|file| add(file, User::Entity(entity.id)));
    }
    for material in &scene.materials {
        textures(material)
            .into_iter()
            .for_each(|texture| add(&texture.image.file, User::Material(material.id)));
    }
    if let SkyKind::Picture { image, .. } = &scene.sky.kind {
        add(&image.file, User::Sky);
    }
    found
}

/// Files that the scene refers to and the project does not have, and who refers to them. Reads the disk.
pub fn missing(project: &Path, scene: &Scene) -> Vec<(String, Vec<User>)> {
    references(scene).into_iter().filter(|(file, _)| !project.join(file).is_file()).collect()
}

/// What a path is called after `from` became `to`. `None`: it is neither that nor below it.
pub fn moved(file: &str, from: &str, to: &str) -> Option<String> {
    let below = file.strip_prefix(from)?;
    (below.is_empty() || below.starts_with('/')).then(|| format!("{to}{below}"))
}

/// All references to a file, or to what lies below a folder, lead to another. Empty where there are none.
pub fn relink(scene: &Scene, from: &str, to: &str) -> Edit {
    let moved = |file: &str| moved(file, from, to);
    let fields = scene.entities.iter().flat_map(|entity| relinked(entity, &moved)).collect();
    let materials =
        scene.materials.iter().filter_map(|material| relinked_material(material, &moved)).collect();
    let mut edits = vec![Edit::Set(fields), Edit::SetMaterials(materials)];
    edits.extend(relinked_sky(&scene.sky, &moved).map(|sky| Edit::Sky(Box::new(sky))));
    Edit::several(format!("Relink {}", from.rsplit('/').next().unwrap_or(from)), edits)
}

/// Moves a file or folder of the project, with the import settings beside it. Refused where something is there
/// already or it would leave `assets/`. The scene follows by [`relink`]; other scenes of the project do not, and are
/// named.
pub fn rename(project: &Path, from: &str, to: &str) -> Result<Vec<String>, String> {
    let inside = |path: &str| {
        let names: Vec<&str> = path.split('/').collect();
        let is_name =
            |name: &&str| !name.is_empty() && !matches!(*name, "." | "..") && !name.contains(['\\', ':']);
        names.len() > 1 && names[0] == "assets" && names.iter().all(is_name)
    };
    if !inside(from) || !inside(to) {
        return Err(format!("`{from}` cannot become `{to}`: both have to lie in `assets`"));
    }
    let (source, target) = (project.join(from), project.join(to));
    if target.exists() {
        return Err(format!("{}: exists already; choose another name", target.display()));
    }
    let failed = |error: std::io::Error| format!("{}: {error}; nothing was moved", source.display());
    if let Some(folder) = target.parent() {
        std::fs::create_dir_all(folder).map_err(failed)?;
    }
    std::fs::rename(&source, &target).map_err(failed)?;
    let settings = importing::settings_path(&source);
    if settings.is_file() {
        // Without them the file is imported again as any other is.
        let _ = std::fs::rename(settings, importing::settings_path(&target));
    }
    Ok(users_elsewhere(project, from))
}

/// A file with its import settings, or a folder with all that lies in it.
pub fn delete(project: &Path, file: &str) -> Result<(), String> {
    if folder(file).is_empty() || !file.starts_with("assets/") || file.split('/').any(|part| part == "..") {
        return Err(format!("`{file}` does not lie in `assets`: it is left alone"));
    }
    let path = project.join(file);
    let failed = |error: std::io::Error| format!("{}: {error}", path.display());
    if path.is_dir() {
        return std::fs::remove_dir_all(&path).map_err(failed);
    }
    std::fs::remove_file(&path).map_err(failed)?;
    // Without its file it says nothing.
    let _ = std::fs::remove_file(importing::settings_path(&path));
    Ok(())
}

/// A folder of a name that is free.
pub fn new_folder(project: &Path, below: &str) -> Result<String, String> {
    let numbered = (2..1000).map(|n| format!("{below}/folder {n}"));
    let mut names = std::iter::once(format!("{below}/folder")).chain(numbered);
    let free = names.find(|name| !project.join(name).exists());
    let free = free.ok_or_else(|| format!("{below}: no name is left for a folder"))?;
    std::fs::create_dir_all(project.join(&free)).map_err(|error| format!("{free}: {error}"))?;
    Ok(free)
}

/// Scenes of the project that name the file.
fn users_elsewhere(project: &Path, file: &str) -> Vec<String> {
    let names = engine::scene::file::scene_names(project).unwrap_or_default();
    let names_it = |name: &String| {
        let path: PathBuf = engine::scene::file::scene_path(project, name);
        std::fs::read_to_string(path).is_ok_and(|text| text.contains(file))
    };
    names.into_iter().filter(names_it).collect()
}

fn files_of_entity(entity: &Entity) -> Vec<&String> {
    let mesh = entity.mesh.as_ref().and_then(|mesh| match &mesh.mesh {
        MeshSource::File { file, .. } => Some(file),
        MeshSource::Shape(_) => None,
    });
    let clip = entity.motion.as_ref().and_then(|motion| match motion {
        Motion::Clip { file, .. } => Some(file),
        _ => None,
    });
    mesh.into_iter().chain(clip).collect()
}

pub fn textures(material: &Material) -> Vec<&Texture> {
    let Material { albedo, metallic_roughness_texture, normal_texture, emission, .. } = material;
    let textures = [&albedo.texture, metallic_roughness_texture, normal_texture, &emission.texture];
    textures.into_iter().flatten().collect()
}

type Moved<'a> = &'a dyn Fn(&str) -> Option<String>;

fn relinked(entity: &Entity, moved: Moved) -> Vec<(EntityId, Field)> {
    let mut fields = Vec::new();
    if let Some(renderer) = &entity.mesh
        && let MeshSource::File { file, mesh } = &renderer.mesh
        && let Some(file) = moved(file)
    {
        let mesh = MeshSource::File { file, mesh: *mesh };
        let renderer = engine::scene::MeshRenderer { mesh, ..renderer.clone() };
        fields.push((entity.id, Field::Mesh(Some(Box::new(renderer)))));
    }
    if let Some(Motion::Clip { file, animation, node, speed }) = &entity.motion
        && let Some(file) = moved(file)
    {
        let clip = Motion::Clip { file, animation: *animation, node: *node, speed: *speed };
        fields.push((entity.id, Field::Motion(Some(Box::new(clip)))));
    }
    fields
}

fn relinked_material(material: &Material, moved: Moved) -> Option<Material> {
    let mut new = material.clone();
    let Material { albedo, metallic_roughness_texture, normal_texture, emission, .. } = &mut new;
    let textures = [&mut albedo.texture, metallic_roughness_texture, normal_texture, &mut emission.texture];
    for texture in textures.into_iter().flatten() {
        if let Some(file) = moved(&texture.image.file) {
            texture.image = ImageSource { file, image: texture.image.image };
        }
    }
    (new != *material).then_some(new)
}

fn relinked_sky(sky: &Sky, moved: Moved) -> Option<Sky> {
    let SkyKind::Picture { image, strength, turn } = &sky.kind else { return None };
    let image = ImageSource { file: moved(&image.file)?, image: image.image };
    Some(Sky { kind: SkyKind::Picture { image, strength: *strength, turn: *turn }, ..sky.clone() })
}
