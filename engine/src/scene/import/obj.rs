//! Wavefront OBJ: polygons by objects and materials.
//!
//! An object is what follows an `o` or a `g`; in it, each material's polygons make one primitive. Vertex
//! colours and MTL colours count as linear. Free-form curves, points and lines are left out.

mod parse;

use std::collections::HashMap;
use std::path::Path;

use glam::{Vec2, Vec3, Vec4};

use super::path::beside;
use super::polygon::triangulated;
use super::triangles::{Part, joined};
use super::{existing, mtl};
use crate::scene::{
    Density, Entity, EntityId, Material, MaterialId, Mesh, MeshRenderer, MeshSource, Reflection, Scene,
    Warning,
};

pub use parse::open;

/// A file's polygons, as indices into its arrays.
pub struct Obj {
    /// Relative to the project.
    pub file: String,
    positions: Vec<Vec3>,
    /// As long as `positions`, or empty.
    colors: Vec<Vec4>,
    uvs: Vec<Vec2>,
    normals: Vec<Vec3>,
    objects: Vec<Object>,
    /// As `usemtl` names them, in the order of first use.
    materials: Vec<String>,
    /// As `mtllib` names them.
    libraries: Vec<String>,
    /// Points, lines and faces of fewer than three corners.
    left_out: usize,
    /// Corners whose texture coordinate or normal is not there: they go without.
    lacking: usize,
}

struct Object {
    name: String,
    runs: Vec<Run>,
}

/// Polygons of one material. A polygon's corners end where the next one's begin.
struct Run {
    material: Option<usize>,
    corners: Vec<Corner>,
    ends: Vec<usize>,
}

/// Places in the file's arrays.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Corner {
    position: usize,
    uv: Option<usize>,
    normal: Option<usize>,
}

/// The n-th object.
pub fn mesh(obj: &Obj, index: usize) -> Result<(Mesh, Vec<Warning>), String> {
    let object = obj.objects.get(index);
    let object = object.ok_or_else(|| format!("has no object {index}: there are {}", obj.objects.len()))?;
    let parts = object.runs.iter().map(|run| Ok(part(obj, run))).enumerate();
    let named = |message: String| format!("object {index} `{}`: {message}", object.name);
    let (mesh, dropped) = joined(parts).map_err(named)?;
    let mut warnings = Vec::new();
    if dropped > 0 {
        let message = format!("{dropped} triangles have corners that are not finite and were dropped");
        warnings.push(Warning::new(&obj.file, named(message)));
    }
    Ok((mesh, warnings))
}

/// One entity an object, with the materials of the libraries. Also which files the libraries and their
/// pictures are, relative to the project.
pub fn scene(project: &Path, obj: &Obj) -> (Scene, Vec<Warning>, Vec<String>) {
    let mut warnings = Vec::new();
    let mut companions = Vec::new();
    let known = library(project, obj, &mut warnings, &mut companions);
    let mut materials: Vec<Material> = Vec::new();
    for (n, name) in obj.materials.iter().enumerate() {
        let found = known.get(name).cloned().unwrap_or_else(|| {
            warnings.push(Warning::new(&obj.file, format!("material `{name}` is in no library; it is grey")));
            mtl::unpainted(name)
        });
        materials.push(Material { id: MaterialId(n as u32), name: name.clone(), ..found });
    }
    if obj.objects.iter().flat_map(|object| &object.runs).any(|run| run.material.is_none()) {
        let id = MaterialId(obj.materials.len() as u32);
        materials.push(Material { id, ..mtl::unpainted("default") });
    }
    if obj.left_out > 0 {
        let message = format!("{} points, lines and faces without an area were left out", obj.left_out);
        warnings.push(Warning::new(&obj.file, message));
    }
    if obj.lacking > 0 {
        let message =
            format!("{} corners refer to texture coordinates or normals that are not there", obj.lacking);
        warnings.push(Warning::new(&obj.file, message));
    }
    if obj.objects.is_empty() {
        warnings.push(Warning::new(&obj.file, "has no triangles"));
    }
    let entities = (0..obj.objects.len()).map(|n| entity(obj, n)).collect();
    (Scene { materials, entities, ..Scene::default() }, warnings, companions)
}

fn entity(obj: &Obj, n: usize) -> Entity {
    let object = &obj.objects[n];
    let material = |run: &Run| MaterialId(run.material.unwrap_or(obj.materials.len()) as u32);
    let mesh = MeshRenderer {
        mesh: MeshSource::File { file: obj.file.clone(), mesh: n as u32 },
        materials: object.runs.iter().map(material).collect(),
        casts_shadows: true,
        density: Density::default(),
        reflection: Reflection::default(),
    };
    let id = EntityId(n as u64 + 1);
    Entity { id, name: object.name.clone(), is_static: true, mesh: Some(mesh), ..Entity::default() }
}

/// The materials of all libraries by name.
fn library(
    project: &Path,
    obj: &Obj,
    warnings: &mut Vec<Warning>,
    companions: &mut Vec<String>,
) -> HashMap<String, Material> {
    let mut known = HashMap::new();
    for file in obj.libraries.iter().flat_map(|names| library_files(project, obj, names)) {
        companions.push(file.clone());
        let bytes = match std::fs::read(project.join(&file)) {
            Ok(bytes) => bytes,
            Err(error) => {
                warnings.push(Warning::new(
                    &obj.file,
                    format!("the material library {file} is missing: {error}"),
                ));
                continue;
            }
        };
        let locate = |written: &str| picture(project, obj, &file, written);
        for authored in mtl::materials(&String::from_utf8_lossy(&bytes), locate) {
            let Material { albedo, emission, normal_texture, .. } = &authored.material;
            let used = [&albedo.texture, &emission.texture, normal_texture].into_iter().flatten();
            companions.extend(used.map(|texture| texture.image.file.clone()));
            let name = authored.material.name.clone();
            let about_this = |message| Warning::new(&file, format!("material `{name}`: {message}"));
            warnings.extend(authored.lost.into_iter().map(about_this));
            known.entry(name).or_insert(authored.material);
        }
    }
    let missing = companions
        .iter()
        .filter(|file| !project.join(file).is_file() && !file.to_ascii_lowercase().ends_with(".mtl"));
    warnings.extend(missing.map(|file| Warning::new(&obj.file, format!("the picture {file} is missing"))));
    known
}

/// A name with blanks, or several names: whichever is there.
fn library_files(project: &Path, obj: &Obj, names: &str) -> Vec<String> {
    let whole = beside(&obj.file, names);
    if whole.as_ref().is_ok_and(|file| project.join(file).is_file()) || !names.contains(char::is_whitespace) {
        return whole.into_iter().collect();
    }
    names.split_whitespace().filter_map(|name| beside(&obj.file, name).ok()).collect()
}

/// Pictures lie beside the library, or beside the OBJ; where the path is of another machine, its last name
/// does.
fn picture(project: &Path, obj: &Obj, library: &str, written: &str) -> Result<String, String> {
    let last = written.rsplit(['/', '\\']).next().unwrap_or(written);
    let places = [(library, written), (&obj.file, written), (library, last), (&obj.file, last)];
    let found = places
        .iter()
        .filter_map(|(file, name)| beside(file, name).ok())
        .find_map(|file| existing(project, file));
    found.map_or_else(|| beside(library, written), Ok)
}

fn part(obj: &Obj, run: &Run) -> Part {
    let has = |given: fn(&Corner) -> bool| run.corners.iter().any(given);
    let (has_uvs, has_normals) = (has(|corner| corner.uv.is_some()), has(|corner| corner.normal.is_some()));
    let mut vertices: Vec<Corner> = Vec::new();
    let mut vertex_of: HashMap<(Corner, usize), u32> = HashMap::new();
    let mut indices = Vec::new();
    let mut start = 0;
    for (n, &end) in run.ends.iter().enumerate() {
        let corners = &run.corners[start..end];
        let points: Vec<Vec3> = corners.iter().map(|corner| obj.positions[corner.position]).collect();
        for at in triangulated(&points).into_iter().flatten() {
            // A face without normals among faces that have them is flat: it shares no vertices.
            let own = if has_normals && corners[at].normal.is_none() { n + 1 } else { 0 };
            indices.push(*vertex_of.entry((corners[at], own)).or_insert_with(|| {
                vertices.push(corners[at]);
                vertices.len() as u32 - 1
            }));
        }
        start = end;
    }
    let uv = |corner: &Corner| corner.uv.map_or(Vec2::ZERO, |at| obj.uvs[at]);
    let normal = |corner: &Corner| corner.normal.map_or(Vec3::ZERO, |at| obj.normals[at]);
    Part {
        positions: vertices.iter().map(|corner| obj.positions[corner.position]).collect(),
        normals: has_normals.then(|| vertices.iter().map(normal).collect()),
        tangents: None,
        uvs: [has_uvs.then(|| vertices.iter().map(uv).collect()), None],
        colors: color_of(obj, &vertices),
        indices,
    }
}

/// A file may colour only its later vertices: `colors` is then as long as `positions` all the same.
fn color_of(obj: &Obj, vertices: &[Corner]) -> Option<Vec<Vec4>> {
    (!obj.colors.is_empty()).then(|| vertices.iter().map(|corner| obj.colors[corner.position]).collect())
}
