//! `new` makes a whole project or nothing.

mod program;

use std::path::Path;

use engine::scene::SkyKind;
use engine::scene::file::{load_project, load_scene, scene_names};
use program::{run_in, write, write_furnace, write_gltf};

#[test]
fn files_become_scenes_and_the_first_is_the_default() {
    let folder = tempfile::tempdir().unwrap();
    write_gltf(folder.path(), "lamp post", "maps/a.png");
    write(folder.path().join("maps/a.png"), TINY_PNG);
    write_furnace(folder.path());
    let args = ["new", "p", "--from", "lamp post.gltf", "furnace.obj", "--sky", "1,2,3", "--json"];
    let run = run_in(folder.path(), &args).done();

    let project = folder.path().join("p");
    assert_eq!(run.json()["default_scene"], "lamp post");
    assert_eq!(load_project(&project).unwrap().default_scene, "lamp post");
    assert_eq!(scene_names(&project).unwrap(), ["furnace", "lamp post"]);
    for name in ["furnace", "lamp post"] {
        let scene = load_scene(&project, name).unwrap();
        assert_eq!(scene.sky.kind, SkyKind::Constant { radiance: glam::Vec3::new(1.0, 2.0, 3.0) });
        assert!(scene.entities.iter().any(|entity| entity.mesh.is_some()), "{name}");
        assert!(scene.entities.iter().all(|entity| entity.light.is_none()), "no light is invented");
    }
    for file in
        ["lamp post/lamp post.gltf", "lamp post/lamp post.bin", "lamp post/maps/a.png", "furnace/furnace.mtl"]
    {
        assert!(project.join("assets").join(file).is_file(), "{file}");
    }
    assert_eq!(names_in(&project), ["assets", "project.ron", "scenes"]);
}

#[test]
fn a_picture_beside_the_files_folder_keeps_its_place() {
    let folder = tempfile::tempdir().unwrap();
    let file = write_gltf(&folder.path().join("kit/chair"), "chair", "../maps/a.png");
    write(folder.path().join("kit/maps/a.png"), TINY_PNG);
    let run = run_in(folder.path(), &["new", "p", "--from", file.to_str().unwrap()]).done();
    let assets = folder.path().join("p/assets/chair");
    assert!(assets.join("chair/chair.gltf").is_file() && assets.join("maps/a.png").is_file(), "{run:?}");
    assert!(!run.stderr.contains("warning"), "{}", run.stderr);
}

#[test]
fn a_project_that_is_there_is_not_touched() {
    let folder = tempfile::tempdir().unwrap();
    write_furnace(folder.path());
    write(folder.path().join("p/project.ron"), "mine");
    let run = run_in(folder.path(), &["new", "p", "--from", "furnace.obj"]);
    run.failed(1, &["p", "is a project already"]);
    assert_eq!(names_in(&folder.path().join("p")), ["project.ron"]);
    assert_eq!(std::fs::read_to_string(folder.path().join("p/project.ron")).unwrap(), "mine");
}

#[test]
fn a_folder_with_assets_of_its_own_is_not_touched() {
    let folder = tempfile::tempdir().unwrap();
    write_furnace(folder.path());
    write(folder.path().join("p/assets/mine.txt"), "mine");
    run_in(folder.path(), &["new", "p", "--from", "furnace.obj"]).failed(1, &["assets"]);
    assert_eq!(names_in(&folder.path().join("p")), ["assets"]);
}

#[test]
fn a_folder_with_other_things_becomes_a_project() {
    let folder = tempfile::tempdir().unwrap();
    write_furnace(folder.path());
    write(folder.path().join("p/notes.txt"), "mine");
    run_in(folder.path(), &["new", "p", "--from", "furnace.obj"]).done();
    assert_eq!(names_in(&folder.path().join("p")), ["assets", "notes.txt", "project.ron", "scenes"]);
}

#[test]
fn a_broken_file_leaves_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    write_furnace(folder.path());
    write(folder.path().join("broken.gltf"), "{ \"asset\": ");
    for broken in ["broken.gltf", "nowhere.obj"] {
        let run = run_in(folder.path(), &["new", "p", "--from", "furnace.obj", broken]);
        run.failed(1, &[broken]);
        assert_eq!(names_in(folder.path()), ["broken.gltf", "furnace.mtl", "furnace.obj"]);
    }
}

#[test]
fn two_files_of_one_name_become_two_scenes() {
    let folder = tempfile::tempdir().unwrap();
    let (a, b) = (write_furnace(&folder.path().join("a")), write_furnace(&folder.path().join("b")));
    let args = ["new", "p", "--from", a.to_str().unwrap(), b.to_str().unwrap()];
    run_in(folder.path(), &args).done();
    assert_eq!(scene_names(&folder.path().join("p")).unwrap(), ["furnace", "furnace-2"]);
}

fn names_in(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// One grey pixel.
const TINY_PNG: &[u8] = &[
    0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44, 0x52, 0x00,
    0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x01, 0x08, 0x00, 0x00, 0x00, 0x00, 0x3a, 0x7e, 0x9b, 0x55, 0x00,
    0x00, 0x00, 0x0a, 0x49, 0x44, 0x41, 0x54, 0x78, 0x9c, 0x63, 0x68, 0x00, 0x00, 0x00, 0x82, 0x00, 0x81,
    0x77, 0xcd, 0x72, 0xb6, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82,
];
