//! Meshes of glTF files, each made for one thing that importers get wrong.

use engine::scene::import::{import, load_assets};
use engine::scene::{MaterialId, Mesh, MeshSource};
use glam::{Vec2, Vec3, Vec4};
use serde_json::{Value, json};
use tests::made::{FACING, Made, SQUARE, bytes_of, entity, project, push, read, refusal, square};

fn area(mesh: &Mesh) -> Vec3 {
    let triangle = |t: [u32; 3]| {
        let [a, b, c] = t.map(|index| mesh.positions[index as usize]);
        (b - a).cross(c - a) / 2.0
    };
    mesh.triangles().map(triangle).sum()
}

#[test]
fn indices_of_every_width_mean_the_same() {
    let corners = [0u32, 1, 2, 0, 2, 3];
    let wide: Vec<u8> = corners.iter().flat_map(|c| c.to_le_bytes()).collect();
    let narrow: Vec<u8> = corners.iter().flat_map(|&c| (c as u16).to_le_bytes()).collect();
    let bytes = corners.map(|c| c as u8);
    for (bytes, component) in [(&wide[..], 5125), (&narrow[..], 5123), (&bytes[..], 5121)] {
        let (mut made, attributes) = square();
        let indices = made.array(bytes, component, "SCALAR", 6);
        made.draw(json!({"attributes": attributes, "indices": indices}));
        let mesh = made.mesh();
        assert_eq!((mesh.indices, mesh.positions.len()), (corners.to_vec(), 4));
    }
}

#[test]
fn strips_and_fans_keep_their_winding() {
    for (mode, indices, triangles) in [(5, [0u8, 1, 3, 2], 2), (6, [0, 1, 2, 3], 2)] {
        let (mut made, attributes) = square();
        let indices = made.array(&indices, 5121, "SCALAR", 4);
        made.draw(json!({"attributes": attributes, "indices": indices, "mode": mode}));
        let mesh = made.mesh();
        assert_eq!(mesh.triangles().len(), triangles);
        assert!(area(&mesh).abs_diff_eq(Vec3::Z, 1e-6), "{mode}");
    }
}

#[test]
fn sparse_and_interleaved_arrays_are_unwound() {
    let mut made = Made::new();
    let rows: Vec<f32> =
        (0..4).flat_map(|n| [&SQUARE[3 * n..3 * n + 3], &FACING[3 * n..3 * n + 3]].concat()).collect();
    let view = made.view(&bytes_of(&rows), 24);
    let moved = made.view(&bytes_of(&[5., 5., 0.]), 0);
    let place = made.view(&[2], 0);
    let positions = json!({"bufferView": view, "componentType": 5126, "type": "VEC3", "count": 4, "sparse": {
        "count": 1, "indices": {"bufferView": place, "componentType": 5121}, "values": {"bufferView": moved}}});
    let positions = push(&mut made.json["accessors"], positions);
    let normals =
        json!({"bufferView": view, "byteOffset": 12, "componentType": 5126, "type": "VEC3", "count": 4});
    let normals = push(&mut made.json["accessors"], normals);
    made.draw(json!({"attributes": {"POSITION": positions, "NORMAL": normals}, "mode": 6}));
    let mesh = made.mesh();
    assert_eq!(mesh.positions, [Vec3::ZERO, Vec3::X, Vec3::new(5., 5., 0.), Vec3::Y]);
    assert_eq!(mesh.normals, [Vec3::Z; 4]);
    for wrong in [4, 255] {
        *made.bytes.last_mut().unwrap() = wrong;
        assert!(made.refusal().contains("accessor 0 has sparse places that do not ascend below 4"));
    }
    *made.bytes.last_mut().unwrap() = 2;
    // Without a buffer view an accessor is zeros, and no claim of a size is believed.
    made.json["accessors"][positions].as_object_mut().unwrap().remove("bufferView");
    assert_eq!(made.mesh().positions[1], Vec3::ZERO);
    made.json["accessors"][positions]["count"] = json!(1u64 << 60);
    assert!(made.refusal().contains("no bytes"));
}

#[test]
fn without_normals_every_triangle_is_flat() {
    let mut made = Made::new();
    let mut corners = SQUARE;
    corners[11] = 1.0; // the fourth corner lifts the second triangle
    let attributes = json!({"POSITION": made.floats(&corners, "VEC3")});
    made.draw(json!({"attributes": attributes, "mode": 6}));
    let mesh = made.mesh();
    assert_eq!((mesh.positions.len(), mesh.normals[0]), (6, Vec3::Z));
    assert!(mesh.normals[3].is_normalized() && mesh.normals[3] != Vec3::Z);
}

#[test]
fn normals_that_are_none_become_those_of_the_face() {
    let mut made = Made::new();
    let normals = [0., 0., 0., f32::NAN, 0., 0., 0., 0., 2., 0., f32::INFINITY, 0.];
    let attributes =
        json!({"POSITION": made.floats(&SQUARE, "VEC3"), "NORMAL": made.floats(&normals, "VEC3")});
    made.draw(json!({"attributes": attributes, "mode": 6}));
    assert_eq!(made.mesh().normals, [Vec3::Z; 4]);
}

#[test]
fn triangles_with_corners_that_are_no_numbers_are_dropped() {
    let mut made = Made::new();
    let mut corners = SQUARE;
    corners[10] = f32::NAN;
    let attributes = json!({"POSITION": made.floats(&corners, "VEC3")});
    made.draw(json!({"attributes": attributes, "mode": 6}));
    let (_, assets, warnings) = made.read();
    let mesh = assets.meshes.values().next().unwrap();
    assert_eq!(mesh.triangles().len(), 1);
    assert!(mesh.positions.iter().all(|p| p.is_finite()));
    assert!(warnings[0].to_string().contains("a.gltf: mesh 0 `made`: 1 triangles"), "{}", warnings[0]);
}

#[test]
fn normalised_integers_become_numbers_from_0_to_1() {
    let (mut made, mut attributes) = square();
    let uvs = made.array(&[0, 0, 255, 0, 255, 255, 0, 51], 5121, "VEC2", 4);
    let colors: Vec<u8> = [0u16, 65535, 13107].repeat(4).iter().flat_map(|c| c.to_le_bytes()).collect();
    let colors = made.array(&colors, 5123, "VEC3", 4);
    for accessor in [uvs, colors] {
        made.json["accessors"][accessor]["normalized"] = json!(true);
    }
    attributes["TEXCOORD_0"] = json!(uvs);
    attributes["COLOR_0"] = json!(colors);
    made.draw(json!({"attributes": attributes, "mode": 6}));
    let mesh = made.mesh();
    let uvs = &mesh.uvs[0].as_ref().unwrap()[2..];
    assert!(uvs[0] == Vec2::ONE && uvs[1].abs_diff_eq(Vec2::new(0.0, 0.2), 1e-7), "{uvs:?}");
    assert!(mesh.colors.unwrap()[3].abs_diff_eq(Vec4::new(0.0, 1.0, 0.2, 1.0), 1e-7));
}

#[test]
fn primitives_are_joined_in_the_order_of_their_materials() {
    let (mut made, attributes) = square();
    let colors = made.floats(&[0.5; 12], "VEC3");
    let mut colored = attributes.clone();
    colored["COLOR_0"] = json!(colors);
    made.draw(json!({}));
    made.json["materials"] = json!([{"name": "a"}, {"name": "b"}]);
    made.json["meshes"][0]["primitives"] = json!([
        {"attributes": attributes, "mode": 6, "material": 1},
        {"attributes": attributes, "mode": 1, "material": 0},
        {"attributes": colored, "mode": 6},
    ]);
    let (imported, assets, _) = made.read();
    let renderer = entity(&imported, "thing").mesh.as_ref().unwrap();
    assert_eq!(renderer.materials, [MaterialId(1), MaterialId(2)]);
    let default = &imported.scene.materials[2];
    assert_eq!((default.name.as_str(), default.metallic, default.roughness), ("default", 0.0, 1.0));
    assert_eq!((default.albedo.color, imported.scene.materials[0].metallic), (Vec3::ONE, 1.0));
    assert!(imported.warnings[0].message.contains("1 primitives of points, lines"));
    let mesh = &assets.meshes[&renderer.mesh];
    assert_eq!(mesh.primitives.iter().map(|p| (p.first, p.count)).collect::<Vec<_>>(), [(0, 6), (6, 6)]);
    assert_eq!(mesh.colors.as_ref().unwrap()[3..5], [Vec4::ONE, Vec4::new(0.5, 0.5, 0.5, 1.0)]);
}

#[test]
fn bytes_that_are_not_there_are_refused_by_mesh_and_primitive() {
    let broken = |path: &str, value: Value| {
        let (mut made, attributes) = square();
        let indices = made.array(&[0, 1, 2, 2], 5121, "SCALAR", 3);
        made.draw(json!({"attributes": attributes, "indices": indices, "material": 0}));
        made.json["materials"] = json!([{}]);
        *made.json.pointer_mut(path).unwrap() = value;
        made.refusal()
    };
    let huge = json!(u64::MAX / 2);
    for (path, value, said) in [
        ("/accessors/0/count", json!(5), "mesh 0 `made`: primitive 0: POSITION: accessor 0 needs more bytes"),
        (
            "/accessors/0/count",
            huge.clone(),
            "mesh 0 `made`: primitive 0: POSITION: accessor 0 needs more bytes",
        ),
        ("/accessors/1/count", json!(3), "primitive 0: has 3 normals for 4 positions"),
        ("/accessors/0/type", json!("MAT4"), "POSITION: accessor 0 holds Mat4 of F32"),
        ("/accessors/0/componentType", json!(5123), "POSITION: accessor 0 holds Vec3 of U16"),
        (
            "/accessors/0/componentType",
            json!(5130),
            "a.gltf: is no valid glTF: accessors[0].componentType: Invalid",
        ),
        ("/accessors/0/bufferView", json!(77), "accessors[0].bufferView: Index out of bounds"),
        ("/accessors/2/componentType", json!(5125), "needs more bytes"),
        ("/bufferViews/0/byteLength", huge.clone(), "leads beyond"),
        ("/bufferViews/0/byteOffset", huge, "leads beyond"),
        ("/bufferViews/0/buffer", json!(3), "bufferViews[0].buffer: Index out of bounds"),
        ("/meshes/0/primitives/0/indices", json!(9), "meshes[0].primitives[0].indices: Index out of bounds"),
        (
            "/meshes/0/primitives/0/attributes/POSITION",
            json!(9),
            "attributes[\"POSITION\"]: Index out of bounds",
        ),
        (
            "/meshes/0/primitives/0/material",
            json!(9),
            "meshes[0].primitives[0].material: Index out of bounds",
        ),
        ("/nodes/0/mesh", json!(9), "nodes[0].mesh: Index out of bounds"),
        ("/nodes/0", json!({"rotation": [0, 0, 0, 0], "name": "n"}), "n: its rotation"),
        ("/nodes/0", json!({"children": [4]}), "nodes[0].children[0]: Index out of bounds"),
    ] {
        let message = broken(path, value);
        assert!(message.contains(said), "`{message}` does not say `{said}`");
    }
    let (mut made, attributes) = square();
    let indices = made.array(&[0, 1, 4], 5121, "SCALAR", 3);
    made.draw(json!({"attributes": attributes, "indices": indices}));
    assert!(made.refusal().contains("an index is 4, but there are 4 vertices"));
}

#[test]
fn glb_is_read_and_a_short_one_refused() {
    let (mut made, attributes) = square();
    made.draw(json!({"attributes": attributes, "mode": 6}));
    made.json["buffers"] = json!([{"byteLength": made.bytes.len()}]);
    let mut text = made.json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut glb = b"glTF\x02\0\0\0".to_vec();
    glb.extend((12 + 8 + text.len() as u32 + 8 + made.bytes.len() as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", &text), (b"BIN\0", &made.bytes)] {
        glb.extend((chunk.len() as u32).to_le_bytes());
        glb.extend(kind);
        glb.extend(chunk);
    }
    let folder = project(&[("a.glb", &glb), ("unnamed", &glb)]);
    for file in ["a.glb", "unnamed"] {
        assert_eq!(read(folder.path(), file).1.meshes.len(), 1);
    }
    for length in 0..glb.len() {
        std::fs::write(folder.path().join("a.glb"), &glb[..length]).unwrap();
        refusal(folder.path(), "a.glb");
    }
}

#[test]
fn a_mesh_that_is_not_there_is_refused_with_the_entity_that_wants_it() {
    let (mut made, attributes) = square();
    made.draw(json!({"attributes": attributes, "mode": 6}));
    let folder = project(&[("a.gltf", made.text().as_bytes())]);
    let mut scene = import(folder.path(), "a.gltf").unwrap().scene;
    for (file, mesh) in [("a.gltf", 5), ("gone.gltf", 0)] {
        scene.entities[0].mesh.as_mut().unwrap().mesh = MeshSource::File { file: file.to_owned(), mesh };
        let message = load_assets(folder.path(), &scene).unwrap_err().to_string();
        assert!(message.contains("entity `thing`") && message.contains(file), "{message}");
    }
}
