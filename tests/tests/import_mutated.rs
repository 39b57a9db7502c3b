//! Files with bytes knocked about: read or refused, never a panic. The knocks are the same in every run.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use engine::scene::import::{import, load_assets};
use serde_json::{Value, json};
use tests::made::{project, square};

/// A file with something of everything, in which a knock can break something.
fn everything() -> String {
    let (mut made, mut attributes) = square();
    attributes["TEXCOORD_0"] = json!(made.array(&[0; 8], 5121, "VEC2", 4));
    attributes["COLOR_0"] = json!(made.array(&[9; 16], 5121, "VEC4", 4));
    let turns = made.array(&[0, 0, 0, 127, 0, 0, 127, 0], 5120, "VEC4", 2);
    let times = made.floats(&[0.0, 2.0], "SCALAR");
    let places = made.floats(&[0., 0., 0., 4., 0., 0.], "VEC3");
    let indices = made.array(&[0, 1, 2, 0, 2, 3], 5121, "SCALAR", 6);
    made.json["accessors"][indices]["sparse"] = json!({"count": 1,
        "indices": {"bufferView": indices, "componentType": 5121}, "values": {"bufferView": indices}});
    made.json["animations"] = json!([{"channels": [{"sampler": 0, "target": {"path": "translation", "node": 0}},
        {"sampler": 1, "target": {"path": "rotation", "node": 0}}],
        "samplers": [{"input": times, "output": places}, {"input": times, "output": turns}]}]);
    made.json["skins"] = json!([{"joints": [1]}]);
    made.json["nodes"] = json!([
        {"mesh": 0, "skin": 0, "children": [1, 2]}, {"camera": 0, "matrix": [1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]},
        {"mesh": 0, "extensions": {"KHR_lights_punctual": {"light": 0},
            "EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": places, "ROTATION": turns}}}}]);
    made.json["scenes"] = json!([{"nodes": [0], "extras": {"sky_radiance": [1, 2, 3]}}]);
    made.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "spot", "range": 3}]}});
    made.json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}]);
    let moved = json!({"KHR_texture_transform": {"scale": [2, 2]}});
    made.json["materials"] = json!([{"emissiveTexture": {"index": 0}, "alphaMode": "MASK",
        "normalTexture": {"index": 0, "extensions": moved.clone()}, "extensions": {"KHR_materials_unlit": {},
        "KHR_materials_pbrSpecularGlossiness": {"diffuseTexture": {"index": 0, "extensions": moved}}}}]);
    made.json["samplers"] = json!([{"magFilter": 9728, "minFilter": 9987, "wrapS": 33071}]);
    made.json["textures"] = json!([{"source": 0, "sampler": 0}]);
    made.json["images"] = json!([{"bufferView": 0}]);
    made.draw(json!({"attributes": attributes, "indices": indices, "material": 0}));
    made.text()
}

const OBJ: &str = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0 .5 1 0\nvt 0 1\nvn 0 0 1\no a\nusemtl m\n\
    f 1/1/1 2//1 3\nf -3 -2 -1 \\\n 1\ng b\nl 1 2\nf 1 2 3 1 3 2\n";
const MTL: &str = "newmtl m\nKd 1 .5 0\nKe 2\nmap_Kd -s 2 1 1 -clamp on a b.png\nd .5\nmap_d x.png\n";

/// The same random numbers in every run (xorshift).
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % end as u64) as usize
    }
}

const SEED: Random = Random(0x9e37_79b9_7f4a_7c15);

/// Whether the file was read, with what it refers to; `None` after a panic.
fn survived(project: &Path, file: &str) -> Option<bool> {
    let read = || match import(project, file).and_then(|made| load_assets(project, &made.scene)) {
        Ok((assets, _)) => {
            assets.meshes.values().for_each(|mesh| mesh.validate().unwrap());
            true
        }
        Err(_) => false,
    };
    catch_unwind(AssertUnwindSafe(read)).ok()
}

#[test]
fn knocked_files_are_survived() {
    let gltf = everything().into_bytes();
    let (mut read, mut broken) = ([0, 0], Vec::new());
    let mut random = SEED;
    for round in 0..3000 {
        let mut files = [("a.gltf", gltf.clone()), ("a.obj", OBJ.into()), ("m.mtl", MTL.into())];
        for (_, bytes) in &mut files {
            for _ in 0..=random.below(3) {
                let at = random.below(bytes.len());
                bytes[at] = b"0123456789-.e\"{}[],:/ \n\0\xffa"[random.below(26)];
            }
        }
        let folder = project(&files.each_ref().map(|(name, bytes)| (*name, bytes.as_slice())));
        for (file, read) in ["a.gltf", "a.obj"].into_iter().zip(&mut read) {
            match survived(folder.path(), file) {
                Some(is_read) => *read += usize::from(is_read),
                None => broken.push(format!("round {round}: {file}")),
            }
        }
    }
    println!("read in spite of it, of 3000: glTF {}, OBJ {}", read[0], read[1]);
    assert!(broken.is_empty() && read.iter().all(|&count| count > 300), "{broken:?}");
}

#[test]
fn values_of_all_kinds_in_all_places_are_survived() {
    let whole: Value = serde_json::from_str(&everything()).unwrap();
    let odd = [
        json!(null),
        json!(-1),
        json!(0),
        json!(1),
        json!(2),
        json!(3),
        json!(7),
        json!(255),
        json!(5121),
        json!(5125),
        json!(u32::MAX),
        json!(1u64 << 32),
        json!(u64::MAX),
        json!(1e300),
        json!(0.5),
        json!(true),
        json!(""),
        json!("VEC3"),
        json!("SCALAR"),
        json!("spot"),
        json!("orthographic"),
        json!("CUBICSPLINE"),
        json!("data:,a"),
        json!([]),
        json!([0]),
        json!({}),
        json!({"count": 0}),
    ];
    let places = places(&whole, String::new());
    let (mut read, mut broken) = (0, Vec::new());
    let mut random = SEED;
    for round in 0..places.len() * odd.len() + 1000 {
        let mut json = whole.clone();
        // Each value in each place, then several at once.
        let (at, value) = (round / odd.len(), round % odd.len());
        let more = if at < places.len() { 0 } else { 1 + random.below(3) };
        let others = (0..more).map(|_| (random.below(places.len()), random.below(odd.len())));
        for (at, value) in std::iter::once((at % places.len(), value)).chain(others.collect::<Vec<_>>()) {
            if let Some(place) = json.pointer_mut(&places[at]) {
                *place = odd[value].clone();
            }
        }
        let folder = project(&[("a.gltf", json.to_string().as_bytes())]);
        match survived(folder.path(), "a.gltf") {
            Some(is_read) => read += usize::from(is_read),
            None => broken.push(json.to_string()),
        }
    }
    println!("read in spite of it: {read}, places {}", places.len());
    assert!(broken.is_empty() && read > 300, "{}: {:#?}", broken.len(), &broken[..broken.len().min(3)]);
}

/// Pointers to all values.
fn places(value: &Value, path: String) -> Vec<String> {
    let inner: Vec<(String, &Value)> = match value {
        Value::Array(values) => values.iter().enumerate().map(|(n, v)| (format!("{path}/{n}"), v)).collect(),
        Value::Object(values) => values.iter().map(|(key, v)| (format!("{path}/{key}"), v)).collect(),
        _ => Vec::new(),
    };
    std::iter::once(path).chain(inner.into_iter().flat_map(|(path, value)| places(value, path))).collect()
}
