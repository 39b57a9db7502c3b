//! Wavefront OBJ: polygons by objects and materials.
//!
//! An object is what follows an `o` or a `g`; in it, each material's polygons make one primitive. Vertex
//! colours and MTL colours count as linear. Free-form curves, points and lines are left out.

use std::collections::HashMap;
use std::path::Path;

use glam::{Vec2, Vec3, Vec4};

use super::path::{beside, shortened};
use super::polygon::triangulated;
use super::triangles::{Part, joined};
use super::{existing, mtl};
use crate::scene::{
    Density, Entity, EntityId, Material, MaterialId, Mesh, MeshRenderer, MeshSource, Reflection, Scene,
    Warning,
};

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

/// Parses a file. Errors name the line.
pub fn open(file: &str, bytes: &[u8]) -> Result<Obj, String> {
    let text = text(bytes)?;
    let mut obj = Obj {
        file: file.to_owned(),
        positions: Vec::new(),
        colors: Vec::new(),
        uvs: Vec::new(),
        normals: Vec::new(),
        objects: Vec::new(),
        materials: Vec::new(),
        libraries: Vec::new(),
        left_out: 0,
    };
    let mut current = Current { name: "unnamed".to_owned(), material: None, is_new: true };
    // A backslash continues a line; the line numbers of messages count what was joined as one.
    let joined = text.replace("\\\r\n", " ").replace("\\\n", " ");
    for (n, line) in joined.lines().enumerate() {
        statement(&mut obj, &mut current, line.trim())
            .map_err(|message| format!("line {}: {message}", n + 1))?;
    }
    obj.objects.retain(|object| !object.runs.is_empty());
    Ok(obj)
}

/// The n-th object.
pub fn mesh(obj: &Obj, index: usize) -> Result<(Mesh, Vec<Warning>), String> {
    let object = obj.objects.get(index);
    let object = object.ok_or_else(|| format!("has no object {index}: there are {}", obj.objects.len()))?;
    let parts = object.runs.iter().map(|run| part(obj, run)).collect();
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
            warnings
                .push(Warning::new(&obj.file, format!("material `{name}` is in no library; it is white")));
            Material::default()
        });
        materials.push(Material { id: MaterialId(n as u32), name: name.clone(), ..found });
    }
    if obj.objects.iter().flat_map(|object| &object.runs).any(|run| run.material.is_none()) {
        let id = MaterialId(obj.materials.len() as u32);
        materials.push(Material { id, name: "default".to_owned(), ..Material::default() });
    }
    if obj.left_out > 0 {
        let message = format!("{} points, lines and faces without an area were left out", obj.left_out);
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

/// Pictures lie beside the library, or beside the OBJ; where the path is of another machine, its last name does.
fn picture(project: &Path, obj: &Obj, library: &str, written: &str) -> Result<String, String> {
    let last = written.rsplit(['/', '\\']).next().unwrap_or(written);
    let places = [(library, written), (&obj.file, written), (library, last), (&obj.file, last)];
    let found = places
        .iter()
        .filter_map(|(file, name)| beside(file, name).ok())
        .find_map(|file| existing(project, file));
    found.map_or_else(|| beside(library, written), Ok)
}

fn text(bytes: &[u8]) -> Result<&str, String> {
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return Err("is UTF-16 text: save it as UTF-8".to_owned());
    }
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    std::str::from_utf8(bytes)
        .map_err(|error| format!("is not UTF-8 text (byte {}): save it as UTF-8", error.valid_up_to()))
}

/// What the next face belongs to.
struct Current {
    name: String,
    material: Option<usize>,
    /// The next face begins an object.
    is_new: bool,
}

fn statement(obj: &mut Obj, current: &mut Current, line: &str) -> Result<(), String> {
    let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    match keyword {
        "v" => vertex(obj, rest)?,
        "vt" => {
            let [u, v, ..] = numbers(rest, 1)?;
            obj.uvs.push(Vec2::new(u, 1.0 - v)); // OBJ's v goes up, a picture's rows go down
        }
        "vn" => {
            let [x, y, z, ..] = numbers(rest, 3)?;
            obj.normals.push(Vec3::new(x, y, z));
        }
        "f" | "fo" => face(obj, current, rest)?,
        "o" | "g" => {
            let name = if rest.trim().is_empty() { "unnamed" } else { rest.trim() };
            current.is_new |= current.name != name;
            current.name = name.to_owned();
        }
        "usemtl" => current.material = material_index(obj, rest.trim()),
        "mtllib" => obj.libraries.push(rest.trim().to_owned()),
        "l" | "p" => obj.left_out += 1,
        _ => {}
    }
    Ok(())
}

fn material_index(obj: &mut Obj, name: &str) -> Option<usize> {
    if name.is_empty() {
        return None;
    }
    let found = obj.materials.iter().position(|known| known == name);
    Some(found.unwrap_or_else(|| {
        obj.materials.push(name.to_owned());
        obj.materials.len() - 1
    }))
}

/// x y z, x y z w, or x y z r g b.
fn vertex(obj: &mut Obj, rest: &str) -> Result<(), String> {
    let [x, y, z, r, g, b, _] = numbers(rest, 3)?;
    obj.positions.push(Vec3::new(x, y, z));
    let colored = before_comment(rest).split_whitespace().count() >= 6;
    if colored && obj.colors.is_empty() {
        obj.colors = vec![Vec4::ONE; obj.positions.len() - 1];
    }
    if colored || !obj.colors.is_empty() {
        obj.colors.push(if colored { Vec4::new(r, g, b, 1.0) } else { Vec4::ONE });
    }
    Ok(())
}

/// At least `least` numbers; those that are not there are 0.
fn numbers(text: &str, least: usize) -> Result<[f32; 7], String> {
    let mut values = [0.0; 7];
    let mut count = 0;
    for (to, word) in values.iter_mut().zip(before_comment(text).split_whitespace()) {
        *to = word.parse().map_err(|_| format!("`{}` is no number", shortened(word)))?;
        count += 1;
    }
    if count < least { Err(format!("{least} numbers are needed, {count} are there")) } else { Ok(values) }
}

fn before_comment(text: &str) -> &str {
    text.split('#').next().unwrap_or(text)
}

fn face(obj: &mut Obj, current: &mut Current, rest: &str) -> Result<(), String> {
    let words = before_comment(rest).split_whitespace();
    let corners = words.map(|word| corner(obj, word)).collect::<Result<Vec<_>, _>>()?;
    if corners.len() < 3 {
        obj.left_out += 1;
        return Ok(());
    }
    if current.is_new || obj.objects.is_empty() {
        current.is_new = false;
        obj.objects.push(Object { name: current.name.clone(), runs: Vec::new() });
    }
    let Some(object) = obj.objects.last_mut() else { return Ok(()) };
    let at = object.runs.iter().position(|run| run.material == current.material).unwrap_or_else(|| {
        object.runs.push(Run { material: current.material, corners: Vec::new(), ends: Vec::new() });
        object.runs.len() - 1
    });
    let run = &mut object.runs[at];
    run.corners.extend(corners);
    run.ends.push(run.corners.len());
    Ok(())
}

/// `v`, `v/vt`, `v//vn` or `v/vt/vn`.
fn corner(obj: &Obj, word: &str) -> Result<Corner, String> {
    let mut fields = word.split('/');
    let mut next = |count: usize, what: &str| match fields.next() {
        None | Some("") => Ok(None),
        Some(field) => place(field, count, what).map(Some),
    };
    let position = next(obj.positions.len(), "position")?;
    let uv = next(obj.uvs.len(), "texture coordinate")?;
    let normal = next(obj.normals.len(), "normal")?;
    let position = position.ok_or_else(|| format!("`{}` names no position", shortened(word)))?;
    Ok(Corner { position, uv, normal })
}

/// Places count from 1; negative ones from the latest backwards.
fn place(field: &str, count: usize, what: &str) -> Result<usize, String> {
    let place: i64 = field.parse().map_err(|_| format!("`{}` is no index", shortened(field)))?;
    let from_start = if place < 0 { place + count as i64 } else { place - 1 };
    let found = usize::try_from(from_start).ok().filter(|&at| at < count);
    found.ok_or_else(|| format!("a face refers to {what} {place}, and {count} are there"))
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
