//! OBJ and MTL, made here.

use engine::scene::import::{import, load_assets};
use engine::scene::{Alpha, MaterialId, Scene};
use glam::{Vec2, Vec3, Vec4};
use tempfile::TempDir;

fn project(files: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
    folder
}

/// Each object's name, triangles and materials.
fn shown(folder: &TempDir, scene: &Scene) -> Vec<(String, usize, Vec<MaterialId>)> {
    let (assets, _) = load_assets(folder.path(), scene).unwrap();
    let one = |entity: &engine::scene::Entity| {
        let renderer = entity.mesh.as_ref().unwrap();
        let mesh = &assets.meshes[&renderer.mesh];
        mesh.validate().unwrap();
        assert_eq!(mesh.primitives.len(), renderer.materials.len());
        (entity.name.clone(), mesh.triangles().len(), renderer.materials.clone())
    };
    scene.entities.iter().map(one).collect()
}

#[test]
fn objects_polygons_and_materials_are_read() {
    let obj = "mtllib my mats.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv .5 2 0\nvt 0 0\nvt 1 0.25\n\
        o floor\nusemtl red paint\nf 1 2 3 4\nusemtl lamp\nf -5/1 -4/2 -3/1 \\\n -1/2 -2/1\n\
        o empty\nl 1 2 3\no wall\nf 1 2 3\nusemtl gone\nf 1 3 4\n";
    let mtl = "newmtl red paint\nKd 0.8 0.1 0.1\nmap_Kd -s 2 3 1 -clamp on maps\\my tex.png\nd 0.5\nPr 0.3\nPm 1\n\
        newmtl lamp\nKe 5 4 3\nmap_Ke glow.png\nmap_d other.png\nTr 0\n";
    let folder = project(&[("a/room.OBJ", obj), ("a/my mats.mtl", mtl), ("a/maps/my tex.png", "no picture")]);
    let imported = import(folder.path(), "a/room.OBJ").unwrap();
    let [red, lamp, gone] = &imported.scene.materials[..] else { panic!("{:?}", imported.scene.materials) };
    assert_eq!((red.albedo.color, red.opacity, red.alpha), (Vec3::new(0.8, 0.1, 0.1), 0.5, Alpha::Blend));
    assert_eq!((red.roughness, red.metallic, gone.name.as_str()), (0.3, 1.0, "gone"));
    let texture = red.albedo.texture.as_ref().unwrap();
    assert_eq!((texture.image.file.as_str(), texture.scale), ("a/maps/my tex.png", Vec2::new(2.0, 3.0)));
    // The picture's first row is v = 1 in OBJ: 3 times 1 ends where the picture ends.
    assert_eq!(texture.picture_from_uv(Vec2::new(0.0, 1.0)).y, 1.0);
    assert_eq!((lamp.emission.radiance(), lamp.emission.sampled), (Vec3::new(5.0, 4.0, 3.0), true));
    assert_eq!(imported.companions, ["my mats.mtl", "maps/my tex.png", "glow.png"]);
    for said in ["glow.png is missing", "`gone` is in no library", "`map_d`", "1 points, lines"] {
        assert!(imported.warnings.iter().any(|warning| warning.message.contains(said)), "{said}");
    }
    let ids = |list: &[u32]| list.iter().map(|&id| MaterialId(id)).collect::<Vec<_>>();
    let expected = [("floor".to_owned(), 5, ids(&[0, 1])), ("wall".to_owned(), 2, ids(&[1, 2]))];
    assert_eq!(shown(&folder, &imported.scene), expected);
    let (assets, warnings) = load_assets(folder.path(), &imported.scene).unwrap();
    assert_eq!((assets.images.len(), warnings.len()), (0, 2));
    let floor = &assets.meshes[&imported.scene.entities[0].mesh.as_ref().unwrap().mesh];
    assert!(floor.uvs[0].as_ref().unwrap().contains(&Vec2::new(1.0, 0.75)));
    assert!(floor.normals.iter().all(|&normal| normal == Vec3::Z));
}

#[test]
fn faces_with_and_without_normals_stand_side_by_side() {
    let obj = "v 0 0 0 1 0 0\nv 1 0 0\nv 0 1 0 0 0 0.5\nvn 0 0 -3\nf 1//1 2//1 3//1\nf 1/9/9 2/9 3/9/-9\n";
    let folder = project(&[("a.obj", obj)]);
    let imported = import(folder.path(), "a.obj").unwrap();
    assert!(imported.warnings[0].message.starts_with("5 corners refer to"));
    let (assets, _) = load_assets(folder.path(), &imported.scene).unwrap();
    let mesh = assets.meshes.values().next().unwrap();
    assert_eq!(mesh.normals, [[Vec3::NEG_Z; 3], [Vec3::Z; 3]].concat());
    let colors = mesh.colors.as_ref().unwrap();
    assert_eq!(colors[..3], [Vec4::new(1., 0., 0., 1.), Vec4::ONE, Vec4::new(0., 0., 0.5, 1.)]);
    assert_eq!(imported.scene.materials[0].name, "default");
}

#[test]
fn broken_obj_files_are_refused_by_line() {
    for (text, said) in [
        ("v 0 0\n", "line 1: position parse error: `v 0 0`"),
        ("v 0 0 x\n", "line 1: position parse error: `v 0 0 x`"),
        ("v 0 0 0\nf 1 1 2\n", "line 2: `2` refers to a position that is not there: 1 are"),
        ("v 0 0 0\nf 1 1 0\n", "`0` refers to a position"),
        ("v 0 0 0\nf 1 1 -2\n", "`-2` refers to a position"),
        ("v 0 0 0\nf 1 1 1.5\n", "`1.5` is no index"),
        ("v 0 0 0\nf 1 1 -9223372036854775808\n", "position"),
        ("v 0 0 0\nf / / /\n", "names no position"),
    ] {
        let folder = project(&[("a.obj", text)]);
        let message = import(folder.path(), "a.obj").unwrap_err().to_string();
        assert!(message.contains("a.obj") && message.contains(said), "`{message}` does not say `{said}`");
    }
    let folder = project(&[]);
    for (bytes, said) in [(&b"\xff\xfev\0 \0"[..], "UTF-16"), (&b"v 0 0 0\n# gr\xfcn\n"[..], "UTF-8")] {
        std::fs::write(folder.path().join("a.obj"), bytes).unwrap();
        assert!(import(folder.path(), "a.obj").unwrap_err().to_string().contains(said));
    }
}

#[test]
fn an_obj_without_triangles_is_an_empty_scene() {
    let folder = project(&[("a.obj", "\u{feff}# nothing\nmtllib gone.mtl\np 1\n")]);
    let imported = import(folder.path(), "a.obj").unwrap();
    assert!(imported.scene.entities.is_empty());
    assert!(imported.warnings.iter().any(|warning| warning.message == "has no triangles"));
    assert!(imported.warnings.iter().any(|warning| warning.message.contains("gone.mtl is missing")));
}

#[test]
fn one_bad_statement_of_a_library_costs_no_other() {
    let obj = "  mtllib\tm.mtl\n  o  a b \n  v 0 0 0 # origin\nv 1 0 0 1\nv 0 1 0\nvt 1\nusemtl\tm\nf 1/1 2/1 3/1\n";
    let mtl = "newmtl\nnewmtl m\nkd 0.5 0.5\nKd 0.5\nKa x\nillum 2.5\nKe 1 2 x\nd -halo 0.25\nPr none\nTr 0.1\nmap_Kd\n\
        newmtl n\nKd 1 0 nan\n";
    let folder = project(&[("a.obj", obj), ("m.mtl", mtl)]);
    let imported = import(folder.path(), "a.obj").unwrap();
    let [m] = &imported.scene.materials[..] else { panic!("{:?}", imported.scene.materials) };
    assert_eq!((m.albedo.color, m.opacity, m.emission.sampled), (Vec3::splat(0.5), 0.25, false));
    let warnings: Vec<String> = imported.warnings.iter().map(ToString::to_string).collect();
    for said in [
        "`m`: `Kd` material parse error: 0.5 0.5",
        "`Ke` material",
        "`Pr` is no number",
        "`map_Kd`",
        "`n`: `Kd`",
    ] {
        assert!(warnings.iter().any(|warning| warning.contains(said)), "{said}: {warnings:#?}");
    }
    assert_eq!((warnings.len(), shown(&folder, &imported.scene)[0].0.as_str()), (5, "a b"), "{warnings:#?}");
}
