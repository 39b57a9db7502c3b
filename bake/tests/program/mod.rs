//! The program as its users see it, and small scenes for it.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// What a run said and how it ended.
#[derive(Debug)]
pub struct Run {
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

/// Runs `hohlraum-bake` in a folder.
pub fn run_in(folder: &Path, args: &[&str]) -> Run {
    let output = Command::new(env!("CARGO_BIN_EXE_hohlraum-bake"))
        .args(args)
        .current_dir(folder)
        .stdin(Stdio::null())
        .output()
        .expect("the program starts");
    Run::from(output)
}

impl From<Output> for Run {
    fn from(output: Output) -> Self {
        let text = |bytes| String::from_utf8(bytes).expect("the program writes UTF-8");
        Self { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
    }
}

#[allow(dead_code)] // each test file uses some of these
impl Run {
    #[track_caller]
    pub fn done(self) -> Self {
        assert_eq!(self.code, Some(0), "{self:?}");
        self
    }

    /// Ended with this code, and stderr says all of this.
    #[track_caller]
    pub fn failed(&self, code: i32, says: &[&str]) {
        assert_eq!(self.code, Some(code), "{self:?}");
        for part in says {
            assert!(self.stderr.contains(part), "`{part}` is not in: {}", self.stderr);
        }
        assert!(!self.stderr.contains("panicked"), "{}", self.stderr);
    }

    /// The one object that `--json` prints, and nothing else.
    #[track_caller]
    pub fn json(&self) -> serde_json::Value {
        let value: serde_json::Value = serde_json::from_str(&self.stdout).expect("stdout is JSON");
        assert!(value.is_object(), "{value}");
        value
    }
}

#[allow(dead_code)]
pub fn write(path: PathBuf, bytes: impl AsRef<[u8]>) -> PathBuf {
    std::fs::create_dir_all(path.parent().expect("a file has a folder")).expect("its folder is made");
    std::fs::write(&path, bytes).expect("the file is written");
    path
}

/// A closed cube of two metres seen from inside, albedo 0.5, radiance 1: the irradiance is 2 pi everywhere.
#[allow(dead_code)]
pub fn write_furnace(folder: &Path) -> PathBuf {
    write(folder.join("furnace.mtl"), "newmtl wall\nKd 0.5 0.5 0.5\nKe 1 1 1\n");
    let corners = (0..8).map(|k| {
        let at = |bit: i32| if k >> bit & 1 == 1 { 1 } else { -1 };
        format!("v {} {} {}\n", at(0), at(1), at(2))
    });
    let faces = ["3 7 5 1", "6 8 4 2", "5 6 2 1", "4 8 7 3", "2 4 3 1", "7 8 6 5"];
    let faces = faces.map(|face| format!("f {face}\n")).concat();
    let text = format!("mtllib furnace.mtl\n{}o walls\nusemtl wall\n{faces}", corners.collect::<String>());
    write(folder.join("furnace.obj"), text)
}

/// One triangle, with its bytes in `NAME.bin` and a picture at `picture`, both relative to the file.
#[allow(dead_code)]
pub fn write_gltf(folder: &Path, name: &str, picture: &str) -> PathBuf {
    let corners = [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let bytes: Vec<u8> = corners.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    write(folder.join(format!("{name}.bin")), &bytes);
    let gltf = serde_json::json!({
        "asset": { "version": "2.0" },
        "buffers": [{ "uri": format!("{name}.bin"), "byteLength": bytes.len() }],
        "bufferViews": [{ "buffer": 0, "byteLength": bytes.len() }],
        "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                        "min": [0, 0, 0], "max": [1, 1, 0] }],
        "images": [{ "uri": picture }],
        "textures": [{ "source": 0 }],
        "materials": [{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "material": 0 }] }],
        "nodes": [{ "name": "triangle", "mesh": 0 }],
        "scenes": [{ "nodes": [0] }],
        "scene": 0,
    });
    write(folder.join(format!("{name}.gltf")), gltf.to_string())
}
