//! glTF 2.0 and GLB.
//!
//! The JSON is read into structs of our own ([`json`]), in which nothing is believed: every index, every
//! byte range is checked where it is used, and what is wrong is told with the file's name.

mod accessor;
mod animation;
mod json;
mod lights;
mod material;
mod matrix;
mod mesh;
mod nodes;

use std::path::Path;

pub use animation::clip;
pub use mesh::mesh;
pub use nodes::scene;

use super::path::{Reference, resolve, shortened};
use json::{Head, Root, get};
use serde_json::Value;

/// A file with the bytes of its buffers.
pub struct Gltf {
    /// Relative to the project.
    pub file: String,
    root: Root,
    buffers: Vec<Vec<u8>>,
}

/// Extensions whose content is read, or that change nothing that we show. A file may require them.
const SUPPORTED: &[&str] = &[
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    SPECULAR,
    "KHR_materials_unlit",
    "KHR_texture_transform",
    "KHR_mesh_quantization", // accessors of all types are read anyway
    "EXT_mesh_gpu_instancing",
];

/// Its diffuse part and its glossiness are read.
const SPECULAR: &str = "KHR_materials_pbrSpecularGlossiness";

/// Extensions that say nothing visible: no warning where a file uses them.
const INVISIBLE: &[&str] =
    &["KHR_xmp", "KHR_xmp_json_ld", "KHR_materials_variants", "KHR_physics_rigid_bodies"];

/// Reads the file's JSON and buffers. `bytes` are those of `project/file`.
pub fn open(project: &Path, file: &str, bytes: &[u8]) -> Result<Gltf, String> {
    let (text, blob) = json_and_blob(bytes)?;
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    let unread = |error: serde_json::Error| format!("is no readable glTF: {error}");
    check_head(&serde_json::from_slice(text).map_err(unread)?)?;
    let root: Root =
        serde_json::from_slice(text).or_else(|error| reread(text).ok_or(error)).map_err(unread)?;
    let buffers = (0..root.buffers.len()).map(|n| buffer(project, file, &root, n, blob));
    let buffers: Vec<Vec<u8>> = buffers.collect::<Result<_, _>>()?;
    check_compression(&root, &buffers)?;
    Ok(Gltf { file: file.to_owned(), root, buffers })
}

/// Once more, with integers that were written as 1.0.
fn reread(text: &[u8]) -> Option<Root> {
    let mut value = serde_json::from_slice(text).ok()?;
    round_integers(&mut value);
    serde_json::from_value(value).ok()
}

fn round_integers(value: &mut Value) {
    match value {
        Value::Array(values) => values.iter_mut().for_each(round_integers),
        Value::Object(values) => values.values_mut().for_each(round_integers),
        Value::Number(number) => {
            let whole = number.as_f64().filter(|x| x.fract() == 0.0 && (0.0..=MOST_INTEGER).contains(x));
            *number = whole.map_or_else(|| number.clone(), |x| (x as u64).into());
        }
        _ => {}
    }
}

/// Up to here f64 knows every integer.
const MOST_INTEGER: f64 = 9_007_199_254_740_991.0;

/// Whether the content looks like GLB or JSON, whatever the file is called.
pub fn recognises(bytes: &[u8]) -> bool {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    bytes.starts_with(b"glTF") || text.trim_ascii_start().first() == Some(&b'{')
}

/// Files that this one refers to, relative to the project; those that lead out of it are left out.
pub fn companions(gltf: &Gltf) -> Vec<String> {
    let buffers = gltf.root.buffers.iter().filter_map(|buffer| buffer.uri.as_deref());
    let images = gltf.root.images.iter().filter_map(|image| image.uri.as_deref());
    let files = buffers.chain(images).filter_map(|uri| match resolve(&gltf.file, uri) {
        Ok(Reference::File(path)) => Some(path),
        _ => None,
    });
    files.collect()
}

/// The bytes of the n-th picture that lies inside the file.
pub fn image_bytes(gltf: &Gltf, image: usize) -> Result<Vec<u8>, String> {
    let image = get(&gltf.root.images, image, "picture")?;
    match (&image.uri, image.buffer_view) {
        (Some(uri), _) => match resolve(&gltf.file, uri)? {
            Reference::Data(bytes) => Ok(bytes),
            Reference::File(path) => Err(format!("has its picture in another file, {path}")),
        },
        (None, Some(view)) => accessor::view_bytes(gltf, view).map(<[u8]>::to_vec),
        (None, None) => Err("has a picture without bytes".to_owned()),
    }
}

/// Says why a file cannot be read before its content makes no sense.
fn check_head(head: &Head) -> Result<(), String> {
    let version = match &head.asset["version"] {
        Value::String(version) => version.clone(),
        Value::Null => return Err("names no glTF version: it is no glTF 2.0 file".to_owned()),
        other => other.to_string(),
    };
    if !version.starts_with("2.") && version != "2" {
        return Err(format!(
            "is of glTF version `{}`; only glTF 2.0 is read: export it anew",
            shortened(&version)
        ));
    }
    let least = head.asset["minVersion"].as_str().unwrap_or("2.0");
    if least != "2.0" {
        return Err(format!("needs a reader of glTF {}; this one reads glTF 2.0", shortened(least)));
    }
    let unknown: Vec<&str> = head
        .extensions_required
        .iter()
        .map(String::as_str)
        .filter(|name| !SUPPORTED.contains(name))
        .collect();
    if unknown.is_empty() {
        return Ok(());
    }
    Err(format!("requires {}, which cannot be read: export it again without", shortened(&unknown.join(", "))))
}

/// Exporters forget to require compression: where it is used, the plain bytes have to be there too.
fn check_compression(root: &Root, buffers: &[Vec<u8>]) -> Result<(), String> {
    let is_bare = |accessor: &usize| {
        root.accessors
            .get(*accessor)
            .is_some_and(|accessor| accessor.buffer_view.is_none() && accessor.sparse.is_none())
    };
    let mut primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let draco = primitives.any(|primitive| {
        primitive.extensions.contains_key("KHR_draco_mesh_compression")
            && primitive.attributes.values().any(is_bare)
    });
    let is_empty = |view: &json::BufferView| buffers.get(view.buffer).is_some_and(Vec::is_empty);
    let meshopt = ["EXT_meshopt_compression", "KHR_meshopt_compression"].into_iter().find(|name| {
        root.buffer_views.iter().any(|view| view.extensions.contains_key(*name) && is_empty(view))
    });
    match draco.then_some("KHR_draco_mesh_compression").or(meshopt) {
        Some(name) => Err(format!("is compressed by {name}, which cannot be read: export it again without")),
        None => Ok(()),
    }
}

/// What of the extensions that the file uses is lost.
fn lost_extensions(gltf: &Gltf) -> Vec<String> {
    let used = gltf.root.extensions_used.iter().map(String::as_str);
    let lost = used.filter_map(|name| match name {
        SPECULAR => Some(format!("uses {name}, of which the specular colour is not read")),
        _ if SUPPORTED.contains(&name) || INVISIBLE.contains(&name) => None,
        _ => Some(format!("uses {name}, which is not read")),
    });
    lost.collect()
}

/// GLB: a header of 12 bytes (magic, version, length), then chunks (length, type, bytes): JSON, and the blob
/// that is the first buffer.
fn json_and_blob(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), String> {
    if !bytes.starts_with(b"glTF") {
        return Ok((bytes, None));
    }
    let version = word(bytes, 4)?;
    if version != 2 {
        return Err(format!("is GLB of version {version}; only glTF 2.0 is read: export it anew"));
    }
    let length = word(bytes, 8)? as usize;
    let bytes = bytes.get(..length).ok_or_else(|| cut_short(length, bytes.len()))?;
    let (kind, text, rest) = chunk(bytes.get(12..).unwrap_or(&[]))?;
    if kind != 0x4e4f_534a {
        return Err("is GLB without JSON".to_owned());
    }
    let blob = if rest.is_empty() { None } else { Some(chunk(rest)?).filter(|chunk| chunk.0 == 0x004e_4942) };
    Ok((text, blob.map(|chunk| chunk.1)))
}

/// Type, bytes, and what follows.
fn chunk(bytes: &[u8]) -> Result<(u32, &[u8], &[u8]), String> {
    let (length, kind) = (word(bytes, 0)? as usize, word(bytes, 4)?);
    let body = &bytes[8..];
    if length > body.len() {
        return Err(cut_short(length, body.len()));
    }
    let (body, rest) = body.split_at(length);
    Ok((kind, body, rest))
}

fn word(bytes: &[u8], at: usize) -> Result<u32, String> {
    let word = bytes.get(at..at + 4).and_then(|word| word.try_into().ok());
    word.map(u32::from_le_bytes).ok_or_else(|| cut_short(at + 4, bytes.len()))
}

fn cut_short(needed: usize, held: usize) -> String {
    format!("is cut short: {needed} bytes are announced, {held} are there")
}

fn buffer(project: &Path, file: &str, root: &Root, n: usize, blob: Option<&[u8]>) -> Result<Vec<u8>, String> {
    let buffer = &root.buffers[n];
    let named = |message: String| format!("buffer {n}: {message}");
    let bytes = match &buffer.uri {
        Some(uri) => match resolve(file, uri).map_err(named)? {
            Reference::Data(bytes) => bytes,
            Reference::File(path) => {
                std::fs::read(project.join(&path)).map_err(|error| named(format!("{path}: {error}")))?
            }
        },
        None if n == 0 && blob.is_some() => blob.unwrap_or_default().to_vec(),
        None => return Ok(Vec::new()), // an error only where a view reads from it
    };
    if (bytes.len() as u64) < buffer.byte_length {
        return Err(named(format!("{} bytes are announced, {} are there", buffer.byte_length, bytes.len())));
    }
    Ok(bytes)
}
