//! Scenes and projects: opened, made, saved under another name, and left.

use std::path::PathBuf;

use crate::window::{Window, cornell, open, open_project};
use editor::log::Level;
use egui::{Key, Modifiers, Vec2};
use egui_kittest::kittest::Queryable;
use engine::scene::EntityId;
use engine::scene::file::{scene_names, scene_path};

fn project(window: &Window) -> PathBuf {
    window.editor().session.document.project().to_owned()
}

fn name(window: &Window) -> String {
    window.editor().session.document.name().to_owned()
}

fn cube(window: &mut Window) -> EntityId {
    window.made(|window| window.choose("Create", "Create cube"))
}

const ALL: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);

#[test]
fn a_scene_is_saved_under_another_name_and_both_are_there() {
    let Some(mut window) = open() else { return };
    let before = std::fs::read_to_string(window.editor().session.document.path()).unwrap();
    let id = cube(&mut window);
    window.editor_mut().session.document.set_locked(&[id], true);
    window.press(ALL, Key::S);
    window.press(Modifiers::COMMAND, Key::A);
    window.type_text("cornell");
    window.until("the name is known to be taken", |window| window.is_shown("There is one of that name"));
    window.press(Modifiers::COMMAND, Key::A);
    window.type_text("with a cube");
    window.press(Modifiers::NONE, Key::Enter);
    window.until("it is saved", |window| name(window) == "with a cube");
    assert!(window.editor().title().starts_with("with a cube \u{2013}"), "{}", window.editor().title());
    assert_eq!(scene_names(&project(&window)).unwrap(), ["cornell", "with a cube"]);
    let other = scene_path(&project(&window), "cornell");
    assert_eq!(std::fs::read_to_string(other).unwrap(), before, "the first is as it was");
    assert!(window.editor().session.document.is_locked(id));
}

#[test]
fn a_new_scene_is_made_and_the_first_one_opened_again() {
    let Some(mut window) = open() else { return };
    let first = window.scene_text();
    window.press(Modifiers::COMMAND, Key::N);
    window.type_text("attic");
    window.press(Modifiers::NONE, Key::Enter);
    window.until("it is opened", |window| name(window) == "attic");
    assert_ne!(window.scene_text(), first);
    window.press(ALL, Key::O);
    window.until("the scenes are listed", |window| window.is_shown("cornell"));
    window.click("cornell");
    window.until("it is opened", |window| name(window) == "cornell");
    assert_eq!(window.scene_text(), first);
}

#[test]
fn a_new_project_is_made_and_the_last_one_is_offered_again() {
    let folder = tempfile::tempdir().unwrap();
    let project_of_cornell = cornell(folder.path());
    let home = folder.path().join("home");
    let size = Vec2::new(1280.0, 720.0);
    let Some(mut window) = open_project(&project_of_cornell, Some(&home), size) else { return };
    window.choose("File", "New project");
    window.type_text("house");
    window.press(Modifiers::NONE, Key::Enter);
    let house = folder.path().join("house");
    window.until("it is opened", |window| project(window) == house);
    assert!(house.join("project.ron").is_file() && name(&window) == "main");
    window.press(Modifiers::COMMAND, Key::O);
    let folder_of_cornell = project_of_cornell.display().to_string();
    let is_listed = |window: &Window| window.harness.query_by_label_contains(&folder_of_cornell).is_some();
    window.until("projects are listed", is_listed);
    window.harness.get_by_label_contains(&folder_of_cornell).click();
    window.until("it is opened", |window| project(window) == project_of_cornell);
}

#[test]
fn what_is_no_project_is_told_and_the_scene_stays_open() {
    let Some(mut window) = open() else { return };
    let before = window.scene_text();
    window.press(Modifiers::COMMAND, Key::O);
    window.type_text("/nowhere/at all");
    window.press(Modifiers::NONE, Key::Enter);
    let told = |window: &Window| {
        let errors = window.editor().session.log.filtered(&[Level::Error], "is not a project");
        errors.len() == 1
    };
    window.until("the error is told", told);
    assert_eq!(window.scene_text(), before);
}

#[test]
fn leaving_asks_about_what_is_not_saved() {
    let Some(mut window) = open() else { return };
    window.press(Modifiers::COMMAND, Key::N);
    window.type_text("attic");
    window.press(Modifiers::NONE, Key::Enter);
    window.until("it is opened", |window| name(window) == "attic");
    cube(&mut window);
    let changed = window.scene_text();
    let to_cornell = |window: &mut Window| {
        window.press(ALL, Key::O);
        window.until("the scenes are listed", |window| window.is_shown("cornell"));
        window.click("cornell");
    };
    to_cornell(&mut window);
    assert!(window.is_shown("Save `attic` first?"));
    window.click("Cancel");
    assert!(name(&window) == "attic" && window.scene_text() == changed);
    to_cornell(&mut window);
    window.click("Save");
    window.until("the other is opened", |window| name(window) == "cornell");
    let saved = std::fs::read_to_string(scene_path(&project(&window), "attic")).unwrap();
    assert_eq!(saved, changed);
    cube(&mut window);
    window.press(ALL, Key::O);
    window.until("the scenes are listed", |window| window.is_shown("attic"));
    window.click("attic");
    window.click("Discard");
    window.until("the other is opened", |window| name(window) == "attic");
    assert_eq!(window.scene_text(), changed);
}

#[test]
fn a_scene_that_cannot_be_written_stays_unsaved_and_says_so() {
    let Some(mut window) = open() else { return };
    cube(&mut window);
    let scenes = project(&window).join("scenes");
    let away = project(&window).join("away");
    std::fs::rename(&scenes, &away).unwrap();
    std::fs::write(&scenes, "a file where the folder was").unwrap();
    window.press(Modifiers::COMMAND, Key::S);
    let told =
        |window: &Window| !window.editor().session.log.filtered(&[Level::Error], "not saved").is_empty();
    window.until("the error is told", told);
    assert!(window.editor().title().contains('*'));
    std::fs::remove_file(&scenes).unwrap();
    std::fs::rename(&away, &scenes).unwrap();
    window.press(Modifiers::COMMAND, Key::S);
    window.until("it is saved", |window| !window.editor().title().contains('*'));
}

#[test]
fn what_another_program_wrote_is_offered_and_taken_or_replaced() {
    let Some(mut window) = open() else { return };
    let path = window.editor().session.document.path();
    let text = std::fs::read_to_string(&path).unwrap();
    let first = window.editor().session.document.scene().entities[0].name.clone();
    let theirs = text.replacen(&format!("name: \"{first}\""), "name: \"theirs\"", 1);
    assert_ne!(theirs, text);
    std::fs::write(&path, &theirs).unwrap();
    let told = |window: &Window| {
        !window.editor().session.log.filtered(&[Level::Warning], "Another program").is_empty()
    };
    window.until("the change is told", told);
    window.click("Reload");
    let is_theirs = |window: &Window| window.editor().session.document.scene().entities[0].name == "theirs";
    window.until("it is reloaded", is_theirs);
    assert!(!window.editor().title().contains('*') && !window.is_shown("Keep mine"));
    window.press(Modifiers::COMMAND, Key::Z);
    assert!(!is_theirs(&window), "undo brings back what was there");
    std::fs::write(&path, theirs.replace("theirs", "theirs again")).unwrap();
    window.until("the change is offered", |window| window.is_shown("Keep mine"));
    window.click("Keep mine");
    assert!(window.editor().title().contains('*'));
    window.press(Modifiers::COMMAND, Key::S);
    window.until("it is saved", |window| !window.editor().title().contains('*'));
    assert_eq!(std::fs::read_to_string(&path).unwrap(), window.scene_text());
}
