//! What else glTF files hold: nodes, materials, lights, animations, paths. Each file is made for one trap.

use engine::scene::assets::{ClipSource, Interpolation};
use engine::scene::import::import;
use engine::scene::material::Wrap;
use engine::scene::{Alpha, EntityId, LightKind, Motion, Projection, SkyKind, world_from_local};
use glam::{DMat4, DVec3, Vec2, Vec3, Vec4};
use serde_json::{Value, json};
use tests::made::{Made, entity, project, read, refusal, square};

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
            "extensions": {
                "KHR_materials_emissive_strength": {"emissiveStrength": 12.5}, "KHR_materials_unlit": {}},
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
        {"name": "cart", "children": [1], "translation": [9, 9, 9], "mesh": 0},
        {"name": "load", "mesh": 0}, {"name": "wall", "mesh": 0}]);
    made.json["animations"] = json!([
        {"channels": [{"sampler": 0, "target": {"path": "weights", "node": 2}}],
         "samplers": [{"input": times, "output": times}]},
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
        {"name": "mirrored", "matrix": mirror, "mesh": 0},
        {"name": "scaled", "scale": [1, -2, 3], "translation": [4500000.123, 0, 0]}]);
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
        (json!("1.0"), "version `1.0`"),
        (json!(1), "version `1`"),
        (json!("3.1"), "version `3.1`"),
        (Value::Null, "no glTF version"),
    ] {
        made.json["asset"]["version"] = version;
        assert!(made.refusal().contains(said));
    }
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
