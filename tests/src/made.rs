//! Small glTF files, made by the tests that read them.

use std::path::Path;

use engine::scene::assets::Assets;
use engine::scene::import::{Imported, import, load_assets};
use engine::scene::{Entity, Mesh, Warning};
use serde_json::{Value, json};
use tempfile::TempDir;

/// A glTF file under construction: arrays become accessors of one buffer, inside the file.
pub struct Made {
    pub json: Value,
    pub bytes: Vec<u8>,
}

impl Made {
    #[expect(clippy::new_without_default)]
    pub fn new() -> Self {
        Self {
            json: json!({"asset": {"version": "2.0"}, "accessors": [], "bufferViews": []}),
            bytes: Vec::new(),
        }
    }

    pub fn view(&mut self, bytes: &[u8], stride: usize) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let mut view = json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()});
        if stride > 0 {
            view["byteStride"] = json!(stride);
        }
        self.bytes.extend(bytes);
        push(&mut self.json["bufferViews"], view)
    }

    pub fn array(&mut self, bytes: &[u8], component: u32, kind: &str, count: usize) -> usize {
        let view = self.view(bytes, 0);
        let accessor = json!({"bufferView": view, "componentType": component, "type": kind, "count": count});
        push(&mut self.json["accessors"], accessor)
    }

    pub fn floats(&mut self, values: &[f32], kind: &str) -> usize {
        let width = ["SCALAR", "VEC2", "VEC3", "VEC4"].iter().position(|&name| name == kind).unwrap() + 1;
        self.array(&bytes_of(values), 5126, kind, values.len() / width)
    }

    /// A mesh of one primitive, and one node that draws it.
    pub fn draw(&mut self, primitive: Value) {
        self.json["meshes"] = json!([{"name": "made", "primitives": [primitive]}]);
        if self.json["nodes"].is_null() {
            self.json["nodes"] = json!([{"mesh": 0, "name": "thing"}]);
        }
    }

    pub fn text(&self) -> String {
        let mut json = self.json.clone();
        if !self.bytes.is_empty() {
            let uri = format!("data:application/octet-stream;base64,{}", base64(&self.bytes));
            json["buffers"] = json!([{"uri": uri, "byteLength": self.bytes.len()}]);
        }
        json.to_string()
    }

    pub fn read(&self) -> (Imported, Assets, Vec<Warning>) {
        let folder = project(&[("a.gltf", self.text().as_bytes())]);
        read(folder.path(), "a.gltf")
    }

    pub fn mesh(&self) -> Mesh {
        let (_, assets, _) = self.read();
        let mesh = assets.meshes.values().next().unwrap();
        mesh.validate().unwrap();
        mesh.as_ref().clone()
    }

    /// Of import or load, whichever refuses.
    pub fn refusal(&self) -> String {
        let folder = project(&[("a.gltf", self.text().as_bytes())]);
        refusal(folder.path(), "a.gltf")
    }
}

pub fn push(list: &mut Value, value: Value) -> usize {
    let list = list.as_array_mut().unwrap();
    list.push(value);
    list.len() - 1
}

pub fn bytes_of(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

pub fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let digits = |three: &[u8]| {
        let bits =
            three.iter().chain([0, 0].iter()).take(3).fold(0, |bits, &byte| bits << 8 | usize::from(byte));
        let digit =
            |n: usize| if n <= three.len() { char::from(DIGITS[bits >> (18 - 6 * n) & 63]) } else { '=' };
        [0, 1, 2, 3].map(digit)
    };
    bytes.chunks(3).flat_map(digits).collect()
}

pub fn project(files: &[(&str, &[u8])]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
    folder
}

pub fn read(project: &Path, file: &str) -> (Imported, Assets, Vec<Warning>) {
    let imported = import(project, file).unwrap();
    let (assets, warnings) = load_assets(project, &imported.scene).unwrap();
    (imported, assets, warnings)
}

pub fn refusal(project: &Path, file: &str) -> String {
    let refused = import(project, file).and_then(|imported| load_assets(project, &imported.scene));
    let message = refused.expect_err("a refusal").to_string();
    assert!(message.contains(file), "{message}");
    message
}

pub fn entity<'a>(imported: &'a Imported, name: &str) -> &'a Entity {
    imported.scene.entities.iter().find(|entity| entity.name == name).unwrap()
}

/// A unit square in the XY plane: four corners, counter-clockwise.
pub const SQUARE: [f32; 12] = [0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.];
pub const FACING: [f32; 12] = [0., 0., 1., 0., 0., 1., 0., 0., 1., 0., 0., 1.];

pub fn square() -> (Made, Value) {
    let mut made = Made::new();
    let attributes =
        json!({"POSITION": made.floats(&SQUARE, "VEC3"), "NORMAL": made.floats(&FACING, "VEC3")});
    (made, attributes)
}
