//! Files with bytes knocked about: read or refused, never a panic. The knocks are the same in every run.

use std::panic::{AssertUnwindSafe, catch_unwind};

use engine::scene::import::{import, load_assets};
use serde_json::json;
use tests::made::{project, square};

/// A file with something of everything, in which a knock can break something.
fn everything() -> String {
    let (mut made, attributes) = square();
    let times = made.floats(&[0.0, 2.0], "SCALAR");
    let places = made.floats(&[0., 0., 0., 4., 0., 0.], "VEC3");
    let indices = made.array(&[0, 1, 2, 0, 2, 3], 5121, "SCALAR", 6);
    made.json["accessors"][indices]["sparse"] = json!({"count": 1,
        "indices": {"bufferView": indices, "componentType": 5121}, "values": {"bufferView": indices}});
    made.json["animations"] = json!([{"channels": [{"sampler": 0, "target": {"path": "translation", "node": 0}}],
        "samplers": [{"input": times, "output": places}]}]);
    made.json["nodes"] = json!([
        {"mesh": 0, "children": [1, 2]}, {"camera": 0, "matrix": [1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]},
        {"mesh": 0, "extensions": {"KHR_lights_punctual": {"light": 0},
            "EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": places}}}}]);
    made.json["scenes"] = json!([{"nodes": [0], "extras": {"sky_radiance": [1, 2, 3]}}]);
    made.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "spot", "range": 3}]}});
    made.json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}]);
    made.json["materials"] = json!([{"emissiveTexture": {"index": 0}, "alphaMode": "MASK"}]);
    made.json["textures"] = json!([{"source": 0}]);
    made.json["images"] = json!([{"bufferView": 0}]);
    made.draw(json!({"attributes": attributes, "indices": indices, "material": 0}));
    made.text()
}

const OBJ: &str = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0 .5 1 0\nvt 0 1\nvn 0 0 1\no a\nusemtl m\n\
    f 1/1/1 2//1 3\nf -3 -2 -1 \\\n 1\ng b\nl 1 2\nf 1 2 3 1 3 2\n";
const MTL: &str = "newmtl m\nKd 1 .5 0\nKe 2\nmap_Kd -s 2 1 1 -clamp on a b.png\nd .5\nmap_d x.png\n";

#[test]
fn knocked_files_are_survived() {
    let gltf = everything().into_bytes();
    let (mut read, mut broken) = ([0, 0], Vec::new());
    let mut random = 0x9e37_79b9_7f4a_7c15_u64;
    let mut draw = |below: usize| {
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        (random % below as u64) as usize
    };
    for round in 0..3000 {
        let mut files = [("a.gltf", gltf.clone()), ("a.obj", OBJ.into()), ("m.mtl", MTL.into())];
        for (_, bytes) in &mut files {
            for _ in 0..=draw(3) {
                let at = draw(bytes.len());
                bytes[at] = b"0123456789-.e\"{}[],:/ \n\0\xffa"[draw(26)];
            }
        }
        let folder = project(&files.each_ref().map(|(name, bytes)| (*name, bytes.as_slice())));
        for (file, read) in ["a.gltf", "a.obj"].into_iter().zip(&mut read) {
            let survived = catch_unwind(AssertUnwindSafe(|| {
                if let Ok(imported) = import(folder.path(), file)
                    && let Ok((assets, _)) = load_assets(folder.path(), &imported.scene)
                {
                    assets.meshes.values().for_each(|mesh| mesh.validate().unwrap());
                    *read += 1;
                }
            }));
            if survived.is_err() {
                broken.push(format!("round {round}: {file}"));
            }
        }
    }
    println!("read in spite of it, of 3000: glTF {}, OBJ {}", read[0], read[1]);
    assert!(broken.is_empty() && read.iter().all(|&count| count > 300), "{broken:?}");
}
