//! Files of others, made into scenes of ours.
//!
//! [`import()`] reads a glTF, GLB or OBJ file into entities and materials that refer to what lies in it;
//! [`load_assets`] reads what a scene refers to: meshes, pictures, clips. Both believe nothing that a file
//! says.

mod gltf;
mod image;
mod mtl;
mod normals;
mod obj;
mod path;
mod polygon;
pub mod settings;
mod tangents;
mod triangles;
mod whole;

use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::path::Path;
use std::sync::Arc;

use rayon::prelude::*;

use super::assets::{Assets, Clip, ClipSource, Picture};
use super::{
    ImageSource, Material, MaterialId, Mesh, MeshSource, Motion, Scene, SceneError, SkyKind, Warning, shape,
};
use settings::{ImportSettings, Structure};

/// What a file says, as a scene whose entities refer to meshes and pictures of `file` (its path relative
/// to the project, forward slashes).
#[derive(Debug)]
pub struct Imported {
    pub scene: Scene,
    pub warnings: Vec<Warning>,
    /// Files that this one refers to (buffers, pictures, material libraries), relative to its folder.
    pub companions: Vec<String>,
}

/// A file of meshes, open.
enum Model {
    Gltf(Box<gltf::Gltf>),
    Obj(obj::Obj),
}

impl Model {
    /// As the file says it, whatever its settings; with the files that it refers to.
    fn scene(&self, project: &Path) -> Result<(Scene, Vec<Warning>, Vec<String>), String> {
        match self {
            Self::Gltf(gltf) => {
                let (scene, warnings) = gltf::scene(project, gltf)?;
                Ok((scene, warnings, gltf::companions(gltf)))
            }
            Self::Obj(obj) => Ok(obj::scene(project, obj)),
        }
    }

    /// The file's n-th, whatever its settings.
    fn mesh(&self, n: usize) -> Result<(Mesh, Vec<Warning>), String> {
        match self {
            Self::Gltf(gltf) => gltf::mesh(gltf, n),
            Self::Obj(obj) => obj::mesh(obj, n),
        }
    }
}

/// A file of meshes, and how it is to be read.
struct Source {
    model: Model,
    settings: ImportSettings,
}

impl Source {
    /// With the files that it refers to.
    fn scene(&self, project: &Path, file: &str) -> Result<(Scene, Vec<Warning>, Vec<String>), String> {
        let (mut scene, warnings, files) = self.model.scene(project)?;
        match self.settings.structure {
            Structure::Hierarchy => self.settings.place(&mut scene, file),
            Structure::One => {
                let (_, materials) = self.joined(&scene)?;
                scene = whole::scene_of(scene, file, materials);
            }
        }
        Ok((scene, warnings, files))
    }

    fn mesh(&self, project: &Path, n: usize) -> Result<(Mesh, Vec<Warning>), String> {
        let (mut mesh, warnings) = match self.settings.structure {
            Structure::Hierarchy => self.model.mesh(n)?,
            Structure::One if n == 0 => (self.joined(&self.model.scene(project)?.0)?.0, Vec::new()),
            Structure::One => return Err(format!("has one mesh, as it is imported: there is no mesh {n}")),
        };
        normals::settle(&mut mesh, self.settings.normals);
        Ok((mesh, warnings))
    }

    fn joined(&self, scene: &Scene) -> Result<(Mesh, Vec<MaterialId>), String> {
        let mesh = |n: u32| self.model.mesh(n as usize).map(|(mesh, _)| mesh);
        whole::joined(scene, &self.settings.scene_from_file(), mesh)
    }
}

/// Reads `project/file`, glTF, GLB or OBJ by content and ending. Pictures need not be there (that is a
/// warning), buffers must. Errors name the file and what is wrong with it.
pub fn import(project: &Path, file: &str) -> Result<Imported, SceneError> {
    let refused = |message: String| SceneError::File { path: project.join(file), message };
    let source = open(project, file)?;
    let (scene, warnings, files) = source.scene(project, file).map_err(refused)?;
    scene.validate().map_err(|error| refused(error.to_string()))?;
    let companions = distinct(files).iter().map(|companion| path::seen_from(file, companion)).collect();
    Ok(Imported { scene, warnings: distinct(warnings), companions })
}

/// Reads every mesh, picture and clip that the scene refers to, each once. What is missing or broken is a
/// warning where the scene still makes sense without it (a picture, a clip) and an error where it does not
/// (a mesh): it names the entity that refers to it, and the file.
pub fn load_assets(project: &Path, scene: &Scene) -> Result<(Assets, Vec<Warning>), SceneError> {
    let (meshes, images, clips) = (wanted_meshes(scene), wanted_images(scene), wanted_clips(scene));
    let in_meshes = meshes.keys().filter_map(|source| match source {
        MeshSource::File { file, .. } => Some(file),
        MeshSource::Shape(_) => None,
    });
    let in_images = images.iter().filter(|image| image.image.is_some()).map(|image| &image.file);
    let files: BTreeSet<&String> =
        in_meshes.chain(in_images).chain(clips.iter().map(|clip| &clip.file)).collect();
    let models: Models = files
        .into_par_iter()
        .map(|file| (file.clone(), open(project, file).map_err(|e| e.to_string())))
        .collect();

    let mut assets = Assets::default();
    let mut warnings = Vec::new();
    let read: Vec<_> =
        meshes.par_iter().map(|(source, user)| (*source, *user, mesh(project, &models, source))).collect();
    for (source, user, mesh) in read {
        let (mut mesh, said) =
            mesh.map_err(|message| SceneError::Entity { entity: user.to_owned(), message })?;
        warnings.extend(said);
        for (primitive, uv_set) in tangents::wanted(scene, source, mesh.primitives.len()) {
            tangents::complete(&mut mesh, primitive, uv_set);
        }
        assets.meshes.insert(source.clone(), Arc::new(mesh));
    }
    let read: Vec<_> = images.par_iter().map(|source| (*source, picture(project, &models, source))).collect();
    for (source, picture) in read {
        match picture {
            Ok(picture) => drop(assets.images.insert(source.clone(), Arc::new(picture))),
            Err(message) => warnings.push(Warning::new(&source.file, message)),
        }
    }
    for source in clips {
        match clip(&models, &source) {
            Ok(clip) => drop(assets.clips.insert(source, Arc::new(clip))),
            Err(message) => warnings.push(Warning::new(&source.file, message)),
        }
    }
    Ok((assets, distinct(warnings)))
}

type Models = BTreeMap<String, Result<Source, String>>;

fn open(project: &Path, file: &str) -> Result<Source, SceneError> {
    let path = project.join(file);
    let refused = |message: String| SceneError::File { path: path.clone(), message };
    if path::inside(file).is_none() || Path::new(file).is_absolute() {
        return Err(refused("lies outside the project".to_owned()));
    }
    let bytes = std::fs::read(&path).map_err(|source| SceneError::Io { path: path.clone(), source })?;
    let ending = file.rsplit('.').next().unwrap_or_default().to_ascii_lowercase();
    let model = match ending.as_str() {
        "obj" if !bytes.starts_with(b"glTF") => obj::open(file, &bytes).map(Model::Obj).map_err(refused)?,
        _ if ending == "gltf" || ending == "glb" || gltf::recognises(&bytes) => {
            gltf::open(project, file, &bytes).map(|gltf| Model::Gltf(Box::new(gltf))).map_err(refused)?
        }
        _ => return Err(refused("is neither glTF, GLB nor OBJ".to_owned())),
    };
    Ok(Source { model, settings: settings::load(&path)? })
}

fn source<'a>(models: &'a Models, file: &str) -> Result<&'a Source, String> {
    match models.get(file) {
        Some(Ok(source)) => Ok(source),
        Some(Err(message)) => Err(message.clone()),
        None => Err(format!("{file} was not opened")),
    }
}

fn mesh(project: &Path, models: &Models, of: &MeshSource) -> Result<(Mesh, Vec<Warning>), String> {
    let (file, n) = match of {
        MeshSource::File { file, mesh } => (file, *mesh as usize),
        MeshSource::Shape(shape) => return Ok((shape::mesh(*shape), Vec::new())),
    };
    source(models, file)?.mesh(project, n).map_err(|message| format!("{file}: {message}"))
}

fn picture(project: &Path, models: &Models, of: &ImageSource) -> Result<Picture, String> {
    let Some(n) = of.image else {
        let file = path::inside(&of.file).ok_or("lies outside the project")?;
        let bytes =
            std::fs::read(project.join(file)).map_err(|error| format!("the picture is missing: {error}"))?;
        return image::decode(&bytes, &of.file);
    };
    match &source(models, &of.file)?.model {
        Model::Gltf(gltf) => image::decode(&gltf::image_bytes(gltf, n as usize)?, "")
            .map_err(|message| format!("picture {n} {message}")),
        Model::Obj(_) => Err("holds no pictures".to_owned()),
    }
}

fn clip(models: &Models, of: &ClipSource) -> Result<Clip, String> {
    match &source(models, &of.file)?.model {
        Model::Gltf(gltf) => gltf::clip(gltf, of.animation as usize, of.node as usize),
        Model::Obj(_) => Err("holds no animations".to_owned()),
    }
}

/// Each mesh and the first entity that draws it.
fn wanted_meshes(scene: &Scene) -> BTreeMap<&MeshSource, &str> {
    let mut wanted = BTreeMap::new();
    for entity in &scene.entities {
        if let Some(renderer) = &entity.mesh {
            wanted.entry(&renderer.mesh).or_insert(entity.name.as_str());
        }
    }
    wanted
}

fn wanted_images(scene: &Scene) -> BTreeSet<&ImageSource> {
    let of_sky = match &scene.sky.kind {
        SkyKind::Picture { image, .. } => Some(image),
        _ => None,
    };
    scene.materials.iter().flat_map(images_of).chain(of_sky).collect()
}

fn images_of(material: &Material) -> impl Iterator<Item = &ImageSource> {
    let Material { albedo, metallic_roughness_texture, normal_texture, emission, .. } = material;
    let textures = [&albedo.texture, metallic_roughness_texture, normal_texture, &emission.texture];
    textures.into_iter().flatten().map(|texture| &texture.image)
}

fn wanted_clips(scene: &Scene) -> Vec<ClipSource> {
    let clips = scene.entities.iter().filter_map(|entity| match &entity.motion {
        Some(Motion::Clip { file, animation, node, .. }) => {
            Some(ClipSource { file: file.clone(), animation: *animation, node: *node })
        }
        _ => None,
    });
    distinct(clips.collect())
}

/// The path, if a file is there.
fn existing(project: &Path, file: String) -> Option<String> {
    project.join(&file).is_file().then_some(file)
}

/// In the order of first appearance.
fn distinct<T: Clone + Eq + std::hash::Hash>(mut list: Vec<T>) -> Vec<T> {
    let mut seen = HashSet::new();
    list.retain(|one| seen.insert(one.clone()));
    list
}
