//! Wavefront OBJ by the crate tobj, which sees a straightened text ([`text`]).
//!
//! An object is what follows an `o` or a `g`; in it, each material's polygons make one primitive. Vertex
//! colours and MTL colours count as linear. Free-form curves, points and lines are left out.

mod text;

use std::collections::HashMap;
use std::path::Path;

use glam::{Vec2, Vec3, Vec4};

use super::path::{beside, shortened};
use super::polygon::triangulated;
use super::triangles::{Part, Repairs, joined};
use super::{existing, mtl};
use crate::scene::{
    Density, Entity, EntityId, Material, MaterialId, Mesh, MeshRenderer, MeshSource, Reflection, Scene,
    Warning,
};

/// A file's polygons.
pub struct Obj {
    /// Relative to the project.
    pub file: String,
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

/// Polygons of one material.
struct Run {
    material: Option<usize>,
    meshes: Vec<tobj::Mesh>,
}

/// Polygons as they are: concave ones are divided here.
const OPTIONS: tobj::LoadOptions =
    tobj::LoadOptions { single_index: false, triangulate: false, ignore_points: true, ignore_lines: true };

/// Parses a file. Errors name the line.
pub fn open(file: &str, bytes: &[u8]) -> Result<Obj, String> {
    let text::Straightened { text, materials, libraries, left_out, lacking, .. } =
        text::straightened(utf8(bytes)?)?;
    let mut rest = text.as_bytes();
    let (models, _) = tobj::load_obj_buf(&mut rest, &OPTIONS, |_| Ok(names(&materials)))
        .map_err(|error| at_line(&text[..text.len() - rest.len()], error))?;
    let file = file.to_owned();
    Ok(Obj { file, objects: objects(models), materials, libraries, left_out, lacking })
}

fn utf8(bytes: &[u8]) -> Result<&str, String> {
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return Err("is UTF-16 text: save it as UTF-8".to_owned());
    }
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    std::str::from_utf8(bytes)
        .map_err(|error| format!("is not UTF-8 text (byte {}): save it as UTF-8", error.valid_up_to()))
}

/// A library of names alone: what the libraries say is read with the scene.
fn names(materials: &[String]) -> (Vec<tobj::Material>, HashMap<String, usize>) {
    let named = |name: &String| tobj::Material { name: name.clone(), ..tobj::Material::default() };
    let places = materials.iter().cloned().zip(0..).collect();
    (materials.iter().map(named).collect(), places)
}

/// `read` ends with the line in which the error is.
fn at_line(read: &str, error: tobj::LoadError) -> String {
    let line = read.lines().count() - text::LINES_BEFORE;
    format!("line {line}: {error}: `{}`", shortened(read.lines().last().unwrap_or_default().trim()))
}

/// tobj begins a model at each `o`, `g` and `usemtl`.
fn objects(models: Vec<tobj::Model>) -> Vec<Object> {
    let mut objects: Vec<Object> = Vec::new();
    for tobj::Model { name, mesh } in models.into_iter().filter(|model| !model.mesh.indices.is_empty()) {
        if objects.last().is_none_or(|object| object.name != name) {
            objects.push(Object { name, runs: Vec::new() });
        }
        let Some(Object { runs, .. }) = objects.last_mut() else { continue };
        match runs.iter_mut().find(|run| run.material == mesh.material_id) {
            Some(run) => run.meshes.push(mesh),
            None => runs.push(Run { material: mesh.material_id, meshes: vec![mesh] }),
        }
    }
    objects
}

/// The n-th object.
pub fn mesh(obj: &Obj, index: usize) -> Result<(Mesh, Vec<Warning>), String> {
    let object = obj.objects.get(index);
    let object = object.ok_or_else(|| format!("has no object {index}: there are {}", obj.objects.len()))?;
    let parts = object.runs.iter().map(|run| Ok(part(run))).enumerate();
    let named = |message: String| format!("object {index} `{}`: {message}", object.name);
    let (mesh, repairs) = joined(parts).map_err(named)?;
    // Corners that have no normal or texture coordinate stand as NaN here.
    let repairs = Repairs { replaced: 0, ..repairs };
    let warnings = repairs.messages().map(|message| Warning::new(&obj.file, named(message)));
    Ok((mesh, warnings.collect()))
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

fn part(run: &Run) -> Part {
    let has_uvs = run.meshes.iter().any(|mesh| !mesh.texcoords.iter().all(|uv| uv.is_nan()));
    let has_normals = run.meshes.iter().any(|mesh| !mesh.normals.iter().all(|normal| normal.is_nan()));
    let mut vertices: Vec<Vertex> = Vec::new();
    let mut indices = Vec::new();
    for mesh in &run.meshes {
        let mut vertex_of: HashMap<([u32; 3], usize), u32> = HashMap::new();
        let mut start = 0;
        for (n, arity) in arities(mesh).enumerate() {
            let corners = start..start + arity;
            let points: Vec<Vec3> =
                mesh.indices[corners].iter().map(|&at| vec3(&mesh.positions, at)).collect();
            for at in triangulated(&points).into_iter().flatten().map(|at| start + at) {
                let places = [mesh.indices[at], mesh.texcoord_indices[at], mesh.normal_indices[at]];
                let vertex = vertex(mesh, places);
                // A face without normals among faces that have them is flat: it shares no vertices.
                let own = if has_normals && vertex.normal.is_nan() { n + 1 } else { 0 };
                indices.push(*vertex_of.entry((places, own)).or_insert_with(|| {
                    vertices.push(vertex);
                    vertices.len() as u32 - 1
                }));
            }
            start += arity;
        }
    }
    let colors = vertices.iter().map(|vertex| vertex.color).collect::<Option<Vec<_>>>();
    Part {
        positions: vertices.iter().map(|vertex| vertex.position).collect(),
        normals: has_normals.then(|| vertices.iter().map(|vertex| vertex.normal).collect()),
        tangents: None,
        uvs: [has_uvs.then(|| vertices.iter().map(|vertex| vertex.uv).collect()), None],
        colors: colors.filter(|colors| !colors.is_empty()),
        indices,
    }
}

/// Of each polygon; tobj leaves them out where all are triangles.
fn arities(mesh: &tobj::Mesh) -> impl Iterator<Item = usize> {
    let triangles = if mesh.face_arities.is_empty() { mesh.indices.len() / 3 } else { 0 };
    mesh.face_arities.iter().map(|&arity| arity as usize).chain(std::iter::repeat_n(3, triangles))
}

/// The uv and the normal are NaN where the file has none.
#[derive(Clone, Copy)]
struct Vertex {
    position: Vec3,
    uv: Vec2,
    normal: Vec3,
    color: Option<Vec4>,
}

fn vertex(mesh: &tobj::Mesh, [position, uv, normal]: [u32; 3]) -> Vertex {
    let [u, v] = [0, 1].map(|axis| mesh.texcoords[2 * uv as usize + axis]);
    Vertex {
        position: vec3(&mesh.positions, position),
        uv: Vec2::new(u, 1.0 - v), // OBJ's v goes up, a picture's rows go down
        normal: vec3(&mesh.normals, normal),
        color: (!mesh.vertex_color.is_empty()).then(|| vec3(&mesh.vertex_color, position).extend(1.0)),
    }
}

fn vec3(values: &[f32], at: u32) -> Vec3 {
    Vec3::from_slice(&values[3 * at as usize..])
}
