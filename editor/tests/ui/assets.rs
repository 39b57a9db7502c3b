//! Files: dropped, imported, renamed, lost and found, dragged onto objects.

use std::path::{Path, PathBuf};

use crate::models::{glb, two_triangles};
use crate::window::{Window, open};
use editor::intents::Intent;
use egui::{Key, Modifiers, Pos2};
use egui_kittest::kittest::Queryable;
use engine::scene::file::text_of_scene;
use engine::scene::{EntityId, ImageSource, MaterialId, MeshSource};
use glam::DVec3;

/// A picture of one color, TGA: blue, green, red.
fn picture(file: &Path, color: [u8; 3]) {
    const SIDE: u8 = 4;
    let mut bytes = vec![0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, SIDE, 0, SIDE, 0, 24, 0x20];
    (0..SIDE * SIDE).for_each(|_| bytes.extend(color));
    std::fs::write(file, bytes).unwrap();
}

/// A cube that nothing hides, seen from above, and where the middle of its top is.
fn pedestal(window: &mut Window) -> (EntityId, DVec3) {
    let id = window.made(|window| window.choose("Create", "Create cube"));
    window.press(Modifiers::SHIFT, Key::H);
    window.press(Modifiers::NONE, Key::F);
    window.press(Modifiers::NONE, Key::Num7);
    let transform = window.entity(id).transform;
    let top = transform.translation + DVec3::Y * 0.5 * transform.scale.y;
    (id, top)
}

fn text(window: &Window) -> String {
    text_of_scene(&PathBuf::from("scene"), window.editor().session.document.scene()).unwrap()
}

fn entities(window: &Window) -> usize {
    window.editor().session.document.scene().entities.len()
}

/// What the scene refers to.
fn files(window: &Window) -> Vec<String> {
    editor::assets::references(window.editor().session.document.scene()).into_keys().collect()
}

fn panel(window: &Window) -> Pos2 {
    window.node("Search the assets").rect().center_bottom() + egui::vec2(0.0, 40.0)
}

/// By its name in the palette.
fn command(window: &mut Window, name: &str) {
    window.press(Modifiers::COMMAND, Key::P);
    window.harness.event(egui::Event::Text(name.to_owned()));
    window.settle();
    window.press(Modifiers::NONE, Key::Enter);
}

/// Into the field that has the keyboard, over what it holds.
fn enter(window: &mut Window, text: &str) {
    window.press(Modifiers::COMMAND, Key::A);
    window.harness.event(egui::Event::Text(text.to_owned()));
    window.press(Modifiers::NONE, Key::Enter);
}

#[test]
fn an_obj_and_a_glb_dropped_on_a_surface_stand_there() {
    let Some(mut window) = open() else { return };
    let (_, top) = pedestal(&mut window);
    let (obj, model) = (window.folder().join("two.obj"), window.folder().join("chain.glb"));
    two_triangles(&obj, 1.0);
    glb(&model, &["body", "arm", "hand"]);
    for (file, count) in [(obj, 3), (model, 3)] {
        let before = entities(&window);
        let at = window.seen_at(top);
        window.drop_files(&[file], at);
        assert_eq!(entities(&window), before, "nobody waited for the file");
        assert!(window.harness.query_by_label("Cancel the import").is_some(), "it is told");
        window.until("the import", |window| entities(window) == before + count);
        let root = window.selected()[0];
        let place = window.editor().session.document.world_from_local(root).translation;
        assert!(place.distance(top) < 0.02, "{place} for {top}");
        window.press(Modifiers::COMMAND, Key::Z);
        assert_eq!(entities(&window), before, "one step");
    }
    assert!(window.project().join("assets/two/two.mtl").is_file());
    assert!(window.project().join("assets/chain/chain.glb").is_file());
    assert!(window.harness.query_by_label("assets/chain").is_some(), "the panel shows it: {}", window.told());
}

#[test]
fn a_model_dropped_beside_everything_stands_on_the_ground() {
    let Some(mut window) = open() else { return };
    let (id, top) = pedestal(&mut window);
    window.editor_mut().session.carry_out([Intent::Select(vec![id]), Intent::Delete]);
    window.settle();
    let model = window.folder().join("chain.glb");
    glb(&model, &["body"]);
    let ground = DVec3::new(top.x, 0.0, top.z);
    let at = window.seen_at(ground);
    window.drop_files(&[model], at);
    let before = entities(&window);
    window.until("the import", |window| entities(window) == before + 1);
    let place = window.entity(window.selected()[0]).transform.translation;
    assert!(place.y.abs() < 1e-6 && place.distance(ground) < 0.05, "{place} for {ground}");
}

#[test]
fn files_dropped_on_the_panel_come_into_the_project_and_not_into_the_scene() {
    let Some(mut window) = open() else { return };
    let before = text(&window);
    let (model, image) = (window.folder().join("chain.glb"), window.folder().join("red.tga"));
    glb(&model, &["body"]);
    picture(&image, [0, 0, 255]);
    let at = panel(&window);
    window.drop_files(&[model, image], at);
    window.until("both", |window| {
        window.harness.query_by_label("assets/chain").is_some()
            && window.harness.query_by_label("assets/red.tga").is_some()
    });
    assert!(window.project().join("assets/red.tga").is_file());
    assert_eq!(text(&window), before);
}

#[test]
fn broken_files_change_nothing_and_the_console_says_why() {
    let Some(mut window) = open() else { return };
    let before = text(&window);
    let listed = editor::assets::list(&window.project());
    let broken = [("a.glb", &b"glTF\x02\0\0\0"[..]), ("b.png", b"no picture"), ("c.txt", b"hello")];
    let files: Vec<PathBuf> = broken.iter().map(|(name, _)| window.folder().join(name)).collect();
    for (file, (_, bytes)) in files.iter().zip(broken) {
        std::fs::write(file, bytes).unwrap();
    }
    let at = window.scene_view().center();
    window.drop_files(&files, at);
    window.until("three errors", |window| window.errors().len() == 3);
    for (error, (name, _)) in window.errors().iter().zip(broken) {
        assert!(error.contains(name), "{error} does not name {name}");
    }
    assert_eq!(text(&window), before);
    assert_eq!(editor::assets::list(&window.project()), listed);
}

#[test]
fn cancelling_leaves_what_waits_undone() {
    let Some(mut window) = open() else { return };
    let files: Vec<PathBuf> = (0..20).map(|n| window.folder().join(format!("chain {n}.glb"))).collect();
    files.iter().for_each(|file| glb(file, &["body"]));
    let before = entities(&window);
    let at = window.scene_view().center();
    window.drop_files(&files, at);
    window.node("Cancel the import").click();
    window.settle();
    window.until("rest", |window| window.harness.query_by_label("Cancel the import").is_none());
    assert!(entities(&window) < before + 20);
    assert_eq!(window.errors(), [""; 0], "what was wished for is no error");
}

#[test]
fn a_renamed_file_keeps_its_references_and_undo_brings_its_name_back() {
    let Some(mut window) = open() else { return };
    let project = window.project();
    window.until("the list", |window| window.harness.query_by_label("assets/cornell.obj").is_some());
    assert!(files(&window).contains(&"assets/cornell.obj".to_owned()));
    let count = files(&window).len();
    window.click("assets/cornell.obj");
    command(&mut window, "rename asset");
    enter(&mut window, "box.obj");
    window.until("the rename", |window| files(window).contains(&"assets/box.obj".to_owned()));
    assert_eq!(files(&window).len(), count);
    assert!(project.join("assets/box.obj").is_file() && !project.join("assets/cornell.obj").exists());
    assert_eq!(window.errors(), [""; 0]);

    window.press(Modifiers::COMMAND, Key::Z);
    assert!(files(&window).contains(&"assets/cornell.obj".to_owned()));
    window.until("the file", |_| project.join("assets/cornell.obj").is_file());
    assert!(!project.join("assets/box.obj").exists());
}

#[test]
fn a_missing_file_is_shown_and_relinked() {
    let Some(mut window) = open() else { return };
    let project = window.project();
    std::fs::rename(project.join("assets/cornell.obj"), project.join("assets/found.obj")).unwrap();
    let is_missing = |window: &Window| window.harness.query_by_label("assets/found.obj").is_some();
    window.until("the new name", is_missing);
    command(&mut window, "relink missing");
    window.click("Use assets/found.obj");
    assert!(!files(&window).contains(&"assets/cornell.obj".to_owned()), "{:?}", files(&window));
    assert!(window.harness.query_by_label("assets/cornell.obj").is_none());
    let document = &window.editor().session.document;
    let source = |entity: &engine::scene::Entity| entity.mesh.as_ref().map(|mesh| mesh.mesh.clone());
    let sources: Vec<MeshSource> = document.scene().entities.iter().filter_map(source).collect();
    window.until("the meshes", |window| {
        sources.iter().all(|source| window.editor().assets().meshes.contains_key(source))
    });
    window.press(Modifiers::COMMAND, Key::Z);
    assert!(files(&window).contains(&"assets/cornell.obj".to_owned()), "one step");
}

#[test]
fn a_project_with_a_missing_file_opens_and_says_so() {
    let Some(window) = open() else { return };
    let project = window.project();
    std::fs::remove_file(project.join("assets/cornell.obj")).unwrap();
    let opened = editor::opened::Opened::load(&project, None).unwrap();
    let told: Vec<String> = opened.warnings.iter().map(ToString::to_string).collect();
    assert!(told.iter().any(|line| line.contains("cornell.obj") && line.contains("relink")), "{told:?}");
    assert!(!opened.document.scene().entities.is_empty());
}

/// Of a cube that is selected and has a material of its own.
fn painted(window: &mut Window) -> MaterialId {
    let (id, _) = pedestal(window);
    window.choose("Create", "Create material");
    let material = window.editor().session.document.scene().materials.last().unwrap().id;
    let edit = editor::tools::surface::assign(&window.editor().session.document, id, None, material);
    window.editor_mut().session.carry_out(edit.map(Intent::Commit));
    window.settle();
    material
}

#[test]
fn a_texture_slot_takes_a_picture_of_the_project_and_undo_takes_it_back() {
    let Some(mut window) = open() else { return };
    let material = painted(&mut window);
    picture(&window.project().join("assets/red.tga"), [0, 0, 255]);
    window.until("the list", |window| window.harness.query_by_label("assets/red.tga").is_some());
    let image = |window: &Window| {
        let material = window.editor().session.document.material(material).unwrap();
        material.albedo.texture.as_ref().map(|texture| texture.image.clone())
    };
    let red = ImageSource { file: "assets/red.tga".to_owned(), image: None };
    window.node("Color picture").scroll_to_me();
    window.settle();
    window.click("Color picture");
    window.click("Use assets/red.tga");
    assert_eq!(image(&window), Some(red.clone()));
    window.until("the pixels", |window| window.editor().assets().images.contains_key(&red));
    window.click("Clear color picture");
    assert_eq!(image(&window), None);
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(image(&window), Some(red));
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(image(&window), None);
}

#[test]
fn a_picture_is_dragged_from_the_panel_into_a_slot() {
    let Some(mut window) = open() else { return };
    let material = painted(&mut window);
    picture(&window.project().join("assets/red.tga"), [0, 0, 255]);
    window.until("the list", |window| window.harness.query_by_label("assets/red.tga").is_some());
    window.node("Normals").scroll_to_me();
    window.settle();
    let (from, to) = (window.node("assets/red.tga").rect().center(), window.node("Normals").rect().center());
    window.drag(from, to);
    let material = window.editor().session.document.material(material).unwrap().clone();
    assert_eq!(material.normal_texture.map(|texture| texture.image.file), Some("assets/red.tga".to_owned()));
    // The cube's mesh has no tangents by itself.
    let cube = MeshSource::Shape(engine::scene::shape::Shape::Cube);
    window.until("tangents", |window| {
        window.editor().assets().meshes.get(&cube).is_some_and(|mesh| mesh.tangents.is_some())
    });
}

#[test]
fn a_material_is_dragged_onto_a_cube() {
    let Some(mut window) = open() else { return };
    let (id, top) = pedestal(&mut window);
    window.choose("Create", "Create material");
    let material = window.editor().session.document.scene().materials.last().unwrap().id;
    let before = window.entity(id).mesh.as_ref().unwrap().materials.clone();
    assert_ne!(before, [material]);
    window.click("Materials");
    let name = format!("material #{}", material.0);
    window.node(&name).scroll_to_me();
    window.settle();
    let from = window.node(&name).rect().center();
    let to = window.seen_at(top);
    window.drag(from, to);
    assert_eq!(window.entity(id).mesh.as_ref().unwrap().materials, [material]);
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(window.entity(id).mesh.as_ref().unwrap().materials, before);
}

#[test]
fn a_model_is_dragged_from_the_panel_into_the_view_and_under_a_row_of_the_tree() {
    let Some(mut window) = open() else { return };
    let (id, top) = pedestal(&mut window);
    glb(&window.project().join("assets/chain.glb"), &["body"]);
    window.until("the list", |window| window.harness.query_by_label("assets/chain.glb").is_some());
    let tile = window.node("assets/chain.glb").rect().center();
    let before = entities(&window);
    let to = window.seen_at(top);
    window.drag(tile, to);
    window.until("the model", |window| entities(window) == before + 1);
    let placed = window.entity(window.selected()[0]);
    assert!(placed.transform.translation.distance(top) < 0.02, "{}", placed.transform.translation);
    assert_eq!(placed.parent, None);

    window.editor_mut().session.carry_out([Intent::Select(vec![id])]);
    let name = window.entity(id).name.clone();
    window.node(&name).scroll_to_me();
    window.settle();
    let row = window.node(&name).rect().center();
    window.drag(tile, row);
    window.until("the model", |window| entities(window) == before + 2);
    assert_eq!(window.entity(window.selected()[0]).parent, Some(id));
}

#[test]
fn thumbnails_come_by_themselves() {
    let Some(mut window) = open() else { return };
    picture(&window.project().join("assets/red.tga"), [0, 0, 255]);
    window.until("two thumbnails", |window| window.editor().thumbnails.made >= 2);
    window.click("Materials");
    let materials = window.editor().session.document.scene().materials.len() as u64;
    window
        .until("a ball for each material", |window| window.editor().thumbnails.made >= 2 + materials.min(4));
}

#[test]
fn a_file_that_changes_is_imported_again_and_keeps_what_was_edited() {
    let Some(mut window) = open() else { return };
    pedestal(&mut window);
    let file = window.folder().join("chain.glb");
    glb(&file, &["body", "hand"]);
    let before = entities(&window);
    let at = window.scene_view().center();
    window.drop_files(&[file], at);
    window.until("the import", |window| entities(window) == before + 2);
    let root = window.selected()[0];
    window.editor_mut().session.carry_out([Intent::Rename { id: root, name: "robot".to_owned() }]);
    // It is followed from the next look at the files on.
    let own = window.project().join("assets/chain/chain.glb");
    for _ in 0..150 {
        window.harness.step();
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    glb(&own, &["body", "hand", "finger"]);
    window.until("the change", |window| entities(window) == before + 3);
    assert_eq!(window.entity(root).name, "robot");
}
