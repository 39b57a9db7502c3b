//! What a file has to be before the crate's wrappers, which unwrap, may look at it.
//!
//! The head is read first, to refuse a file for a reason that its author understands. Then what the crate
//! demands and glTF does not is filled in, and the crate validates the rest.

use gltf::json::buffer::View;
use gltf::json::extensions::scene::khr_lights_punctual::{Spot, Type};
use gltf::json::mesh::Semantic;
use gltf::json::validation::{Checked, Error, Validate};
use gltf::json::{Accessor, Index, Path, Root};
use serde_json::{Map, Value, json};

use super::Gltf;
use crate::scene::import::path::shortened;

/// Extensions whose content is read, or that change nothing that we show. A file may require them.
const SUPPORTED: &[&str] = &[
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    SPECULAR,
    "KHR_materials_unlit",
    "KHR_texture_transform",
    super::nodes::INSTANCING,
];

/// Its diffuse part and its glossiness are read.
const SPECULAR: &str = "KHR_materials_pbrSpecularGlossiness";

/// Extensions that say nothing visible: no warning where a file uses them.
const INVISIBLE: &[&str] =
    &["KHR_xmp", "KHR_xmp_json_ld", "KHR_materials_variants", "KHR_physics_rigid_bodies"];

/// Whether the file is of a version, and asks for extensions, that can be read.
pub fn head(json: &Value) -> Result<(), String> {
    let version = match &json["asset"]["version"] {
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
    let least = json["asset"]["minVersion"].as_str().unwrap_or("2.0");
    if least != "2.0" {
        return Err(format!("needs a reader of glTF {}; this one reads glTF 2.0", shortened(least)));
    }
    let required = json["extensionsRequired"].as_array().into_iter().flatten().filter_map(Value::as_str);
    let unknown: Vec<&str> = required.filter(|name| !SUPPORTED.contains(name)).collect();
    if unknown.is_empty() {
        return Ok(());
    }
    Err(format!("requires {}, which cannot be read: export it again without", shortened(&unknown.join(", "))))
}

/// What the crate's types demand and glTF does not.
pub fn straighten(json: &mut Value) {
    round_integers(json);
    json["asset"] = json!({"version": "2.0"}); // the head has been checked
    for scene in objects(json, "scenes") {
        scene.entry("nodes").or_insert_with(|| json!([]));
    }
    for mesh in objects(json, "meshes") {
        for primitive in mesh.get_mut("primitives").into_iter().flat_map(elements) {
            primitive.entry("attributes").or_insert_with(|| json!({}));
        }
    }
    // What moves no node is for extensions.
    for animation in objects(json, "animations") {
        if let Some(Value::Array(channels)) = animation.get_mut("channels") {
            channels.retain(|channel| channel["target"]["node"].is_number());
        }
    }
}

fn objects<'a>(json: &'a mut Value, list: &str) -> impl Iterator<Item = &'a mut Map<String, Value>> {
    json.get_mut(list).into_iter().flat_map(elements)
}

fn elements(list: &mut Value) -> impl Iterator<Item = &mut Map<String, Value>> {
    list.as_array_mut().into_iter().flatten().filter_map(Value::as_object_mut)
}

/// Some exporters write integers as 1.0.
fn round_integers(value: &mut Value) {
    match value {
        Value::Array(values) => values.iter_mut().for_each(round_integers),
        Value::Object(values) => values.values_mut().for_each(round_integers),
        Value::Number(number) => {
            let whole =
                number.as_f64().filter(|x| x.fract() == 0.0 && x.is_sign_positive() && *x <= MOST_INTEGER);
            *number = whole.map_or_else(|| number.clone(), |x| (x as u64).into());
        }
        _ => {}
    }
}

/// Up to here f64 knows every integer.
const MOST_INTEGER: f64 = 9_007_199_254_740_991.0;

/// What the wrappers would stumble over though nobody misses it.
pub fn repair(root: &mut Root) {
    for accessor in &mut root.accessors {
        accessor.sparse.take_if(|sparse| sparse.count.0 == 0);
    }
    let nodes = root.nodes.len();
    for animation in &mut root.animations {
        animation
            .channels
            .retain(|channel| channel.target.node.value() < nodes && channel.target.path != Checked::Invalid);
    }
    let lights = root.extensions.as_mut().and_then(|extensions| extensions.khr_lights_punctual.as_mut());
    for light in lights.into_iter().flat_map(|lights| &mut lights.lights) {
        if light.type_ == Checked::Valid(Type::Spot) {
            let quarter = std::f32::consts::FRAC_PI_4;
            light.spot.get_or_insert(Spot { inner_cone_angle: 0.0, outer_cone_angle: quarter });
        }
    }
}

/// The crate's own validation, without what has another answer here.
pub fn validate(root: &Root) -> Result<(), String> {
    let mut wrong = None;
    positions(root)?;
    root.validate(root, Path::new, &mut |path, error| {
        let path = path();
        if wrong.is_none() && !is_bearable(path.as_str(), error) {
            wrong = Some(invalid(&path, error));
        }
    });
    wrong.map_or(Ok(()), Err)
}

/// The crate looks at these before it validates that they are there.
fn positions(root: &Root) -> Result<(), String> {
    for (m, mesh) in root.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let accessor = primitive.attributes.get(&Checked::Valid(Semantic::Positions));
            if accessor.is_some_and(|accessor| root.get(*accessor).is_none()) {
                let path = Path::new().field("meshes").index(m).field("primitives").index(p);
                return Err(invalid(&path.field("attributes").key("POSITION"), Error::IndexOutOfBounds));
            }
        }
    }
    Ok(())
}

fn invalid(path: &Path, error: Error) -> String {
    format!("is no valid glTF: {path}: {error}")
}

fn is_bearable(path: &str, error: Error) -> bool {
    let of_attribute = path.contains(".attributes["); // names of nobody, no bounds, no positions
    match error {
        Error::Unsupported => true, // the head has been checked
        Error::Missing => of_attribute || path.ends_with(".bufferView"), // zeros
        Error::Invalid => of_attribute || path.ends_with(".byteStride") || is_kind_of_light(path),
        Error::IndexOutOfBounds | Error::Oversize => false,
    }
}

/// Lights of an unknown kind are left out.
fn is_kind_of_light(path: &str) -> bool {
    path.starts_with("extensions.khrLightsPunctual.lights[") && path.ends_with("].type")
}

/// Exporters forget to require compression: where it is used, the plain bytes have to be there too.
pub fn compression(root: &Root, buffers: &[Vec<u8>]) -> Result<(), String> {
    let is_bare = |accessor: &Index<Accessor>| {
        root.get(*accessor)
            .is_some_and(|accessor| accessor.buffer_view.is_none() && accessor.sparse.is_none())
    };
    let mut primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let draco = primitives.any(|primitive| {
        let extensions = primitive.extensions.as_ref();
        extensions.is_some_and(|extensions| extensions.others.contains_key("KHR_draco_mesh_compression"))
            && primitive.attributes.values().any(is_bare)
    });
    let is_compressed = |view: &View, name: &str| {
        let extensions = view.extensions.as_ref();
        extensions.is_some_and(|extensions| extensions.others.contains_key(name))
            && buffers.get(view.buffer.value()).is_some_and(Vec::is_empty)
    };
    let meshopt = ["EXT_meshopt_compression", "KHR_meshopt_compression"]
        .into_iter()
        .find(|name| root.buffer_views.iter().any(|view| is_compressed(view, name)));
    match draco.then_some("KHR_draco_mesh_compression").or(meshopt) {
        Some(name) => Err(format!("is compressed by {name}, which cannot be read: export it again without")),
        None => Ok(()),
    }
}

/// What of the extensions that the file uses is lost.
pub fn lost_extensions(gltf: &Gltf) -> Vec<String> {
    let lost = gltf.document.extensions_used().filter_map(|name| match name {
        SPECULAR => Some(format!("uses {name}, of which the specular colour is not read")),
        _ if SUPPORTED.contains(&name) || INVISIBLE.contains(&name) => None,
        _ => Some(format!("uses {name}, which is not read")),
    });
    lost.collect()
}
