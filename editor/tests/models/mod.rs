//! Small files as other programs write them.

use std::path::Path;

/// Two triangles, each an object of its own, the second `height` above the first.
pub fn two_triangles(file: &Path, height: f64) {
    let text = format!(
        "mtllib two.mtl\no low\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n\
         o high\nv 0 0 {height}\nv 1 0 {height}\nv 0 1 {height}\nusemtl green\nf 4 5 6\n"
    );
    std::fs::write(file, text).unwrap();
    let library = "newmtl red\nKd 1 0 0\nnewmtl green\nKd 0 1 0\n";
    std::fs::write(file.with_file_name("two.mtl"), library).unwrap();
}

/// A GLB of one triangle, under nodes of these names, each in the one before.
pub fn glb(file: &Path, nodes: &[&str]) {
    let chain: Vec<String> = (0..nodes.len())
        .map(|n| {
            let content = if n + 1 < nodes.len() {
                format!(r#""children":[{}]"#, n + 1)
            } else {
                r#""mesh":0"#.to_owned()
            };
            format!(r#"{{"name":"{}",{content}}}"#, nodes[n])
        })
        .collect();
    let mut json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}}],"buffers":[{{"byteLength":36}}]}}"#,
        chain.join(",")
    );
    while json.len() % 4 > 0 {
        json.push(' ');
    }
    let corners = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let bytes: Vec<u8> = corners.iter().flat_map(|x| x.to_le_bytes()).collect();
    let mut out = b"glTF".to_vec();
    let words = [2, 12 + 8 + json.len() as u32 + 8 + 36, json.len() as u32, 0x4E4F_534A];
    out.extend(words.iter().flat_map(|word| word.to_le_bytes()));
    out.extend(json.as_bytes());
    out.extend([36u32, 0x004E_4942].iter().flat_map(|word| word.to_le_bytes()));
    out.extend(bytes);
    std::fs::write(file, out).unwrap();
}
