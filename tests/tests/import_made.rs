//! Small files, made here, each for one thing that importers get wrong.

use std::path::Path;

use engine::scene::assets::{Assets, ClipSource, Interpolation};
use engine::scene::import::{Imported, import, load_assets};
use engine::scene::material::Wrap;
use engine::scene::{
    Alpha, Entity, EntityId, LightKind, MaterialId, Mesh, MeshSource, Motion, Projection, SkyKind, Warning,
    world_from_local,
};
use glam::{DMat4, DVec3, Vec2, Vec3, Vec4};
use serde_json::{Value, json};
use tempfile::TempDir;

/// A glTF file under construction: arrays become accessors of one buffer, inside the file.
struct Made {
    json: Value,
    bytes: Vec<u8>,
}

impl Made {
    fn new() -> Self {
        Self {
            json: json!({"asset": {"version": "2.0"}, "accessors": [], "bufferViews": []}),
            bytes: Vec::new(),
        }
    }

    fn view(&mut self, bytes: &[u8], stride: usize) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let mut view = json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()});
        if stride > 0 {
            view["byteStride"] = json!(stride);
        }
        self.bytes.extend(bytes);
        push(&mut self.json["bufferViews"], view)
    }

    fn array(&mut self, bytes: &[u8], component: u32, kind: &str, count: usize) -> usize {
        let view = self.view(bytes, 0);
        let accessor = json!({"bufferView": view, "componentType": component, "type": kind, "count": count});
        push(&mut self.json["accessors"], accessor)
    }

    fn floats(&mut self, values: &[f32], kind: &str) -> usize {
        let width = ["SCALAR", "VEC2", "VEC3", "VEC4"].iter().position(|&name| name == kind).unwrap() + 1;
        self.array(&bytes_of(values), 5126, kind, values.len() / width)
    }

    /// A mesh of one primitive, and one node that draws it.
    fn draw(&mut self, primitive: Value) {
        self.json["meshes"] = json!([{"name": "made", "primitives": [primitive]}]);
        if self.json["nodes"].is_null() {
            self.json["nodes"] = json!([{"mesh": 0, "name": "thing"}]);
        }
    }

    fn text(&self) -> String {
        let mut json = self.json.clone();
        if !self.bytes.is_empty() {
            let uri = format!("data:application/octet-stream;base64,{}", base64(&self.bytes));
            json["buffers"] = json!([{"uri": uri, "byteLength": self.bytes.len()}]);
        }
        json.to_string()
    }

    fn read(&self) -> (Imported, Assets, Vec<Warning>) {
        let folder = project(&[("a.gltf", self.text().as_bytes())]);
        read(folder.path(), "a.gltf")
    }

    fn mesh(&self) -> Mesh {
        let (_, assets, _) = self.read();
        let mesh = assets.meshes.values().next().unwrap();
        mesh.validate().unwrap();
        mesh.as_ref().clone()
    }

    /// Of import or load, whichever refuses.
    fn refusal(&self) -> String {
        let folder = project(&[("a.gltf", self.text().as_bytes())]);
        refusal(folder.path(), "a.gltf")
    }
}

fn push(list: &mut Value, value: Value) -> usize {
    let list = list.as_array_mut().unwrap();
    list.push(value);
    list.len() - 1
}

fn bytes_of(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

fn base64(bytes: &[u8]) -> String {
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

fn project(files: &[(&str, &[u8])]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
    folder
}

fn read(project: &Path, file: &str) -> (Imported, Assets, Vec<Warning>) {
    let imported = import(project, file).unwrap();
    let (assets, warnings) = load_assets(project, &imported.scene).unwrap();
    (imported, assets, warnings)
}

fn refusal(project: &Path, file: &str) -> String {
    let refused = import(project, file).and_then(|imported| load_assets(project, &imported.scene));
    let message = refused.expect_err("a refusal").to_string();
    assert!(message.contains(file), "{message}");
    message
}

fn entity<'a>(imported: &'a Imported, name: &str) -> &'a Entity {
    imported.scene.entities.iter().find(|entity| entity.name == name).unwrap()
}

/// A unit square in the XY plane: four corners, counter-clockwise.
const SQUARE: [f32; 12] = [0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.];
const FACING: [f32; 12] = [0., 0., 1., 0., 0., 1., 0., 0., 1., 0., 0., 1.];

fn square() -> (Made, Value) {
    let mut made = Made::new();
    let attributes =
        json!({"POSITION": made.floats(&SQUARE, "VEC3"), "NORMAL": made.floats(&FACING, "VEC3")});
    (made, attributes)
}

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
    assert_eq!(mesh.uvs[0].as_ref().unwrap()[2..], [Vec2::ONE, Vec2::new(0.0, 0.2)]);
    assert_eq!(mesh.colors.unwrap()[3], Vec4::new(0.0, 1.0, 0.2, 1.0));
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
    assert_eq!(imported.scene.materials[2].name, "default");
    assert!(imported.warnings[0].message.contains("1 primitives of points, lines"));
    let mesh = &assets.meshes[&renderer.mesh];
    assert_eq!(mesh.primitives.iter().map(|p| (p.first, p.count)).collect::<Vec<_>>(), [(0, 6), (6, 6)]);
    assert_eq!(mesh.colors.as_ref().unwrap()[3..5], [Vec4::ONE, Vec4::new(0.5, 0.5, 0.5, 1.0)]);
}

#[test]
fn materials_say_what_the_file_says() {
    let (mut made, attributes) = square();
    made.draw(json!({"attributes": attributes, "mode": 6, "material": 0}));
    made.json["images"] = json!([{"uri": "t.png"}]);
    made.json["samplers"] = json!([{"wrapS": 33071, "wrapT": 33648, "magFilter": 9728, "minFilter": 9729}]);
    made.json["textures"] = json!([{"source": 0, "sampler": 0}, {"source": 0}, {}]);
    let transform = json!({"offset": [0.5, 0.25], "rotation": 1.0, "scale": [2, 3], "texCoord": 1});
    made.json["materials"] = json!([
        {
            "pbrMetallicRoughness": {
                "baseColorFactor": [0.1, 0.2, 0.3, 0.4], "metallicFactor": 0.5, "roughnessFactor": 0.25,
                "baseColorTexture": {"index": 0, "extensions": {"KHR_texture_transform": transform}},
            },
            "normalTexture": {"index": 1, "scale": 0.7}, "emissiveTexture": {"index": 2},
            "emissiveFactor": [1, 0.5, 0], "alphaMode": "MASK", "alphaCutoff": 0.3, "doubleSided": true,
            "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 12.5}, "KHR_materials_unlit": {}},
        },
        {"alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.5]}},
        {"pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.5]}},
    ]);
    let (imported, _, warnings) = made.read();
    let [m, blend, opaque] = &imported.scene.materials[..] else { panic!() };
    assert_eq!((m.albedo.color, m.opacity), (Vec3::new(0.1, 0.2, 0.3), 0.4));
    assert_eq!((m.metallic, m.roughness, m.normal_scale), (0.5, 0.25, 0.7));
    assert_eq!((m.alpha, m.double_sided, m.unlit), (Alpha::Mask { cutoff: 0.3 }, true, true));
    assert_eq!((m.emission.radiance(), m.emission.sampled), (Vec3::new(12.5, 6.25, 0.0), true));
    assert!(!blend.emission.sampled && blend.alpha == Alpha::Blend && blend.opacity == 0.5);
    assert!(opaque.alpha == Alpha::Opaque && opaque.opacity == 1.0);
    let t = m.albedo.texture.as_ref().unwrap();
    assert_eq!((t.image.file.as_str(), t.image.image, t.uv_set), ("t.png", None, 1));
    assert_eq!((t.offset, t.rotation, t.scale), (Vec2::new(0.5, 0.25), 1.0, Vec2::new(2.0, 3.0)));
    assert_eq!((t.wrap_u, t.wrap_v, t.nearest, t.mipmaps), (Wrap::Clamp, Wrap::Mirror, true, false));
    let n = m.normal_texture.as_ref().unwrap();
    assert!(n.mipmaps && !n.nearest && n.wrap_u == Wrap::Repeat);
    // The picture is not there, and one texture has none: warnings, no refusal.
    assert_eq!(imported.companions, ["t.png"]);
    assert!(imported.warnings.iter().any(|w| w.message.contains("t.png is missing")));
    assert!(m.emission.texture.is_none());
    assert!(warnings[0].to_string().starts_with("t.png: the picture is missing"), "{}", warnings[0]);
}

#[test]
fn instances_become_children() {
    let (mut made, attributes) = square();
    let places = made.floats(&[1., 0., 0., 2., 0., 0., 3., 0., 0.], "VEC3");
    let turns = made.array(&[0, 0, 127, 0, 0, 0, 0, 127, 0, 127, 0, 0], 5120, "VEC4", 3);
    made.json["accessors"][turns]["normalized"] = json!(true);
    made.json["nodes"] = json!([{"mesh": 0, "name": "fence", "translation": [0, 5, 0], "extensions": {
        "EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": places, "ROTATION": turns}}}}]);
    made.json["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing"]);
    made.json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    made.draw(json!({"attributes": attributes, "mode": 6}));
    let (imported, assets, _) = made.read();
    assert_eq!(assets.meshes.len(), 1);
    let fence = entity(&imported, "fence");
    assert!(fence.mesh.is_none());
    let posts: Vec<_> = imported.scene.entities.iter().filter(|e| e.parent == Some(fence.id)).collect();
    assert_eq!(posts.len(), 3);
    assert!(posts.iter().all(|post| post.is_static && post.mesh.is_some()));
    assert!((posts[0].transform.rotation * DVec3::X).abs_diff_eq(-DVec3::X, 1e-6));
    assert_eq!(world_from_local(&imported.scene)[2].translation, DVec3::new(2., 5., 0.));
}

#[test]
fn lights_cameras_and_the_sky_come_from_the_file_alone() {
    let mut made = Made::new();
    made.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [
        {"type": "directional", "intensity": 3, "color": [1, 0.5, 0.25]},
        {"type": "point", "range": 7},
        {"type": "spot", "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.6}},
        {"type": "spot"}, {"type": "laser"}]}});
    made.json["cameras"] = json!([
        {"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1, "zfar": 50}},
        {"type": "orthographic", "orthographic": {"xmag": 3, "ymag": 2, "znear": 0, "zfar": 9}},
        {"type": "perspective", "perspective": {"yfov": 0, "znear": 0.1}}]);
    let lit = |n: u32| json!({"name": format!("l{n}"), "extensions": {"KHR_lights_punctual": {"light": n}}});
    let mut nodes: Vec<Value> = (0..5).map(lit).collect();
    nodes.extend((0..3).map(|n| json!({"name": format!("c{n}"), "camera": n})));
    made.json["nodes"] = json!(nodes);
    made.json["scenes"] =
        json!([{"nodes": [0]}, {"nodes": [0, 1, 2, 3, 4, 5, 6, 7], "extras": {"sky_radiance": [0.5, 1, 2]}}]);
    made.json["scene"] = json!(1);
    let (imported, ..) = made.read();
    let light = |name: &str| entity(&imported, name).light.clone();
    let sun = light("l0").unwrap();
    assert_eq!((sun.kind, sun.power()), (LightKind::Sun, Vec3::new(3.0, 1.5, 0.75)));
    let point = light("l1").unwrap();
    assert_eq!((point.kind, point.range, point.intensity), (LightKind::Point, Some(7.0), 1.0));
    assert_eq!(light("l2").unwrap().kind, LightKind::Spot { inner: 0.1, outer: 0.6 });
    let quarter = std::f32::consts::FRAC_PI_4;
    assert_eq!(light("l3").unwrap().kind, LightKind::Spot { inner: 0.0, outer: quarter });
    assert!(light("l4").is_none());
    let camera = entity(&imported, "c0").camera.as_ref().unwrap();
    assert_eq!(
        (camera.projection, camera.near, camera.far),
        (Projection::Perspective { fov_y: 0.8 }, 0.1, Some(50.0))
    );
    let camera = entity(&imported, "c1").camera.as_ref().unwrap();
    assert_eq!(camera.projection, Projection::Orthographic { half_height: 2.0 });
    assert!(entity(&imported, "c2").camera.is_none());
    assert_eq!(imported.warnings.len(), 2, "{:?}", imported.warnings);
    assert_eq!(imported.scene.sky.kind, SkyKind::Constant { radiance: Vec3::new(0.5, 1.0, 2.0) });
    made.json["scene"] = json!(0);
    let (imported, ..) = made.read();
    assert_eq!((imported.scene.entities.len(), &imported.scene.sky.kind), (1, &SkyKind::None));
}

#[test]
fn what_an_animation_moves_is_not_static() {
    let (mut made, attributes) = square();
    let times = made.floats(&[0.0, 2.0], "SCALAR");
    let places = made.floats(&[0., 0., 0., 4., 0., 0.], "VEC3");
    made.json["nodes"] = json!([
        {"name": "cart", "children": [1], "translation": [9, 9, 9], "mesh": 0}, {"name": "load", "mesh": 0}, {"name": "wall", "mesh": 0}]);
    made.json["animations"] = json!([
        {"channels": [{"sampler": 0, "target": {"path": "weights", "node": 2}}], "samplers": [{"input": times, "output": times}]},
        {"channels": [{"sampler": 0, "target": {"path": "translation", "node": 0}}],
         "samplers": [{"input": times, "output": places, "interpolation": "LINEAR"}]}]);
    made.draw(json!({"attributes": attributes, "mode": 6}));
    let (imported, assets, _) = made.read();
    let is_static = |name: &str| entity(&imported, name).is_static;
    assert_eq!((is_static("cart"), is_static("load"), is_static("wall")), (false, false, true));
    let cart = entity(&imported, "cart");
    let Some(Motion::Clip { file, animation: 1, node: 0, speed: 1.0 }) = &cart.motion else {
        panic!("{:?}", cart.motion)
    };
    let clip = &assets.clips[&ClipSource { file: file.clone(), animation: 1, node: 0 }];
    assert_eq!(
        (clip.seconds, clip.translation.as_ref().unwrap().interpolation),
        (2.0, Interpolation::Linear)
    );
    assert_eq!(clip.sample(0.5, &cart.transform).translation, DVec3::X);
    assert_eq!(clip.sample(2.5, &cart.transform).translation, DVec3::X);
    // Keys that are not ascending: the clip is left out, the scene is not.
    let backwards = made.floats(&[2.0, 1.0], "SCALAR");
    made.json["animations"][1]["samplers"][0]["input"] = json!(backwards);
    let (_, assets, warnings) = made.read();
    assert!(assets.clips.is_empty() && warnings[0].message.contains("ascending"));
}

#[test]
fn matrices_lose_nothing_even_sheared_or_mirrored() {
    let shear = [1., 0.2, 0., 0., 0.5, 2., 0.1, 0., -3., 0., 0.5, 0., 4., 5., 6., 1.];
    let mirror = [-1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 7., 0., 0., 1.];
    let (mut made, attributes) = square();
    made.json["nodes"] = json!([
        {"name": "sheared", "matrix": shear, "mesh": 0, "children": [1]}, {"name": "below", "mesh": 0},
        {"name": "mirrored", "matrix": mirror, "mesh": 0}, {"name": "scaled", "scale": [1, -2, 3], "translation": [4500000.123, 0, 0]}]);
    made.draw(json!({"attributes": attributes, "mode": 6}));
    let (imported, ..) = made.read();
    let world = world_from_local(&imported.scene);
    let matrix_of = |name: &str| {
        let at = imported.scene.entities.iter().position(|entity| entity.name == name).unwrap();
        DMat4::from(world[at])
    };
    assert_eq!(imported.scene.entities.len(), 5);
    assert!(entity(&imported, "sheared").mesh.is_none() && entity(&imported, "sheared (sheared)").is_static);
    for name in ["sheared (sheared)", "below"] {
        assert!(matrix_of(name).abs_diff_eq(DMat4::from_cols_array(&shear), 1e-12), "{name}");
    }
    assert!(matrix_of("mirrored").abs_diff_eq(DMat4::from_cols_array(&mirror), 1e-12));
    let scaled = entity(&imported, "scaled").transform;
    assert_eq!((scaled.scale, scaled.translation.x), (DVec3::new(1., -2., 3.), 4500000.123));
}

#[test]
fn files_that_need_what_we_lack_are_refused_by_name() {
    let mut made = Made::new();
    made.json["extensionsRequired"] = json!(["KHR_texture_transform", "KHR_draco_mesh_compression", "X_own"]);
    let message = made.refusal();
    assert!(message.contains("KHR_draco_mesh_compression, X_own") && message.contains("export"), "{message}");
    let mut made = Made::new();
    made.json["extensionsUsed"] = json!(["KHR_materials_clearcoat", "KHR_lights_punctual"]);
    let warnings = made.read().0.warnings;
    assert_eq!(
        warnings.iter().map(ToString::to_string).collect::<Vec<_>>(),
        ["a.gltf: uses KHR_materials_clearcoat, which is not read"]
    );
    for (version, said) in [
        (json!("1.0"), "glTF 1.0"),
        (json!(1), "glTF 1"),
        (json!("3.1"), "glTF 3.1"),
        (Value::Null, "no glTF version"),
    ] {
        made.json["asset"]["version"] = version;
        assert!(made.refusal().contains(said));
    }
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
        ("/accessors/0/count", json!(5), "mesh 0 `made`, primitive 0: POSITION: accessor 0 needs more bytes"),
        (
            "/accessors/0/count",
            huge.clone(),
            "mesh 0 `made`, primitive 0: POSITION: accessor 0 needs more bytes",
        ),
        ("/accessors/1/count", json!(3), "3 normals for 4 positions"),
        ("/accessors/0/type", json!("MAT4"), "MAT4"),
        ("/accessors/0/componentType", json!(5130), "5130"),
        ("/accessors/0/bufferView", json!(77), "buffer view 77"),
        ("/accessors/2/componentType", json!(5126), "needs more bytes"),
        ("/bufferViews/0/byteLength", huge.clone(), "leads beyond"),
        ("/bufferViews/0/byteOffset", huge, "leads beyond"),
        ("/bufferViews/0/buffer", json!(3), "buffer 3"),
        ("/meshes/0/primitives/0/indices", json!(9), "accessor 9"),
        ("/meshes/0/primitives/0/material", json!(9), "material 9"),
        ("/nodes/0/mesh", json!(9), "mesh 9"),
        ("/nodes/0", json!({"rotation": [0, 0, 0, 0], "name": "n"}), "n: its rotation"),
        ("/nodes/0", json!({"children": [4]}), "node 4"),
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
fn hierarchies_that_bite_their_tail_or_reach_the_floor_are_read() {
    let mut made = Made::new();
    made.json["nodes"] = json!([{"children": [1]}, {"children": [0, 1]}]);
    made.json["scenes"] = json!([{"nodes": [0]}]);
    let (imported, ..) = made.read();
    assert_eq!(imported.scene.entities.len(), 2);
    assert!(imported.warnings[0].message.contains("more than one place"));
    let deep: Vec<Value> = (1..20_000).map(|n| json!({"children": [n]})).chain([json!({})]).collect();
    made.json["nodes"] = json!(deep);
    assert_eq!(made.read().0.scene.entities.len(), 20_000);
}

#[test]
fn a_file_without_scene_or_nodes_still_shows_its_meshes() {
    let (mut made, attributes) = square();
    made.draw(json!({"attributes": attributes, "mode": 6}));
    made.json["nodes"] = json!([{"children": [1]}, {"mesh": 0}]);
    let (imported, ..) = made.read();
    let parents: Vec<_> = imported.scene.entities.iter().map(|e| (e.name.as_str(), e.parent)).collect();
    assert_eq!(parents, [("node 0", None), ("node 1", Some(EntityId(1)))]);
    made.json.as_object_mut().unwrap().remove("nodes");
    let (imported, assets, _) = made.read();
    assert_eq!((imported.scene.entities[0].name.as_str(), assets.meshes.len()), ("made", 1));
}

#[test]
fn paths_with_blanks_and_letters_of_the_world_are_found() {
    let (mut made, attributes) = square();
    made.draw(json!({"attributes": attributes, "mode": 6, "material": 0}));
    made.json["buffers"] = json!([{"uri": "d%C3%A4ta%20x.bin", "byteLength": made.bytes.len()}]);
    made.json["images"] = json!([{"uri": "../bilder/ř ❤.png"}]);
    made.json["textures"] = json!([{"source": 0}]);
    made.json["materials"] = json!([{"emissiveTexture": {"index": 0}}]);
    let text = made.json.to_string();
    let mut png = std::io::Cursor::new(Vec::new());
    image::RgbImage::from_pixel(2, 1, image::Rgb([255, 0, 51]))
        .write_to(&mut png, image::ImageFormat::Png)
        .unwrap();
    let folder = project(&[
        ("assets/mein Modell.GLTF", text.as_bytes()),
        ("assets/däta x.bin", &made.bytes),
        ("bilder/ř ❤.png", &png.into_inner()),
    ]);
    let (imported, assets, warnings) = read(folder.path(), "assets/mein Modell.GLTF");
    assert!(imported.warnings.is_empty() && warnings.is_empty());
    assert_eq!(imported.companions, ["däta x.bin", "../bilder/ř ❤.png"]);
    let picture = assets.images.values().next().unwrap();
    assert_eq!((picture.width, picture.height, picture.texel(1, 0)), (2, 1, Vec4::new(1.0, 0.0, 0.2, 1.0)));
    // Out of the project: a picture is left out, a buffer is refused.
    for way_out in ["../../x.png", "/etc/x.png", "file:///etc/x.png", "https://example.org/x.png"] {
        made.json["images"] = json!([{"uri": way_out}]);
        std::fs::write(folder.path().join("assets/a.gltf"), made.json.to_string()).unwrap();
        let (imported, ..) = read(folder.path(), "assets/a.gltf");
        assert!(
            imported.warnings[0].message.contains(way_out)
                && imported.scene.materials[0].emission.texture.is_none()
        );
    }
    made.json["buffers"][0]["uri"] = json!("../../x.bin");
    std::fs::write(folder.path().join("assets/a.gltf"), made.json.to_string()).unwrap();
    assert!(refusal(folder.path(), "assets/a.gltf").contains("outside the project"));
    made.json["buffers"][0]["uri"] = json!("gone.bin");
    std::fs::write(folder.path().join("assets/a.gltf"), made.json.to_string()).unwrap();
    assert!(refusal(folder.path(), "assets/a.gltf").contains("gone.bin"));
    assert!(import(folder.path(), "../a.gltf").is_err() && import(folder.path(), "/etc/passwd").is_err());
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
