//! glTF 2.0 and GLB, by the crate `gltf`.
//!
//! The crate's wrappers and readers index and unwrap. So a file is straightened and validated ([`check`])
//! before they see it, and the bytes of an accessor are known to be there ([`accessor`]) before they are
//! read. The crate keeps f32; a site far from the origin stands on f64: [`Placement`].

mod accessor;
mod animation;
mod check;
mod lights;
mod material;
mod matrix;
mod mesh;
mod nodes;

use std::borrow::Cow;
use std::path::Path;

use gltf::Document;
use gltf::json::Root;
use serde::Deserialize;
use serde_json::Value;

pub use animation::clip;
pub use mesh::mesh;
pub use nodes::scene;

use super::path::{Reference, resolve};

/// A file with the bytes of its buffers.
pub struct Gltf {
    /// Relative to the project.
    pub file: String,
    document: Document,
    /// Of every node.
    placements: Vec<Placement>,
    buffers: Vec<Vec<u8>>,
}

/// Where a node is, in the precision of the text.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Placement {
    /// Column by column.
    matrix: Option<[f64; 16]>,
    translation: Option<[f64; 3]>,
    rotation: Option<[f64; 4]>,
    scale: Option<[f64; 3]>,
}

/// Reads the file's JSON and buffers. `bytes` are those of `project/file`.
pub fn open(project: &Path, file: &str, bytes: &[u8]) -> Result<Gltf, String> {
    let unread = |error: serde_json::Error| format!("is no readable glTF: {error}");
    let (text, blob) = json_and_blob(bytes)?;
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&text);
    let mut json: Value = serde_json::from_slice(text).map_err(unread)?;
    check::head(&json)?;
    check::straighten(&mut json);
    let placements = json.get("nodes").map(Vec::deserialize).transpose().map_err(unread)?;
    let mut root = Root::deserialize(json).map_err(unread)?;
    check::repair(&mut root);
    let buffers = (0..root.buffers.len()).map(|n| buffer(project, file, &root, n, blob.as_deref()));
    let buffers: Vec<Vec<u8>> = buffers.collect::<Result<_, _>>()?;
    check::compression(&root, &buffers)?;
    check::validate(&root)?;
    let document = Document::from_json_without_validation(root);
    Ok(Gltf { file: file.to_owned(), document, placements: placements.unwrap_or_default(), buffers })
}

/// Whether the content looks like GLB or JSON, whatever the file is called.
pub fn recognises(bytes: &[u8]) -> bool {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    bytes.starts_with(b"glTF") || text.trim_ascii_start().first() == Some(&b'{')
}

/// Files that this one refers to, relative to the project; those that lead out of it are left out.
pub fn companions(gltf: &Gltf) -> Vec<String> {
    let root = gltf.document.as_json();
    let buffers = root.buffers.iter().filter_map(|buffer| buffer.uri.as_deref());
    let images = root.images.iter().filter_map(|image| image.uri.as_deref());
    let files = buffers.chain(images).filter_map(|uri| match resolve(&gltf.file, uri) {
        Ok(Reference::File(path)) => Some(path),
        _ => None,
    });
    files.collect()
}

/// The bytes of the n-th picture that lies inside the file.
pub fn image_bytes(gltf: &Gltf, image: usize) -> Result<Vec<u8>, String> {
    let image = find(gltf.document.as_json().images.iter(), image, "picture")?;
    match (&image.uri, image.buffer_view) {
        (Some(uri), _) => match resolve(&gltf.file, uri)? {
            Reference::Data(bytes) => Ok(bytes),
            Reference::File(path) => Err(format!("has its picture in another file, {path}")),
        },
        (None, Some(view)) => {
            let view = find(gltf.document.views(), view.value(), "buffer view")?;
            accessor::view_bytes(gltf, &view).map(<[u8]>::to_vec)
        }
        (None, None) => Err("has a picture without bytes".to_owned()),
    }
}

/// What stands at an index that a scene of ours, or an extension, names.
fn find<T>(mut list: impl ExactSizeIterator<Item = T>, index: usize, what: &str) -> Result<T, String> {
    let len = list.len();
    list.nth(index).ok_or_else(|| format!("refers to {what} {index}, and the file has {len}"))
}

type Bytes<'a> = Cow<'a, [u8]>;

/// The crate subtracts the header from the length that it announces, and takes what follows for a chunk.
fn json_and_blob(bytes: &[u8]) -> Result<(Bytes<'_>, Option<Bytes<'_>>), String> {
    if !bytes.starts_with(b"glTF") {
        return Ok((bytes.into(), None));
    }
    let length = bytes.get(8..12).and_then(|word| word.try_into().ok()).map_or(0, u32::from_le_bytes);
    if length < 12 {
        return Err("is GLB, and cut short".to_owned());
    }
    let bytes = &bytes[..bytes.len().min(length as usize)];
    let glb = gltf::Glb::from_slice(bytes).map_err(|error| format!("is no readable GLB 2: {error}"))?;
    Ok((glb.json, glb.bin))
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
    if (bytes.len() as u64) < buffer.byte_length.0 {
        return Err(named(format!(
            "{} bytes are announced, {} are there",
            buffer.byte_length.0,
            bytes.len()
        )));
    }
    Ok(bytes)
}
