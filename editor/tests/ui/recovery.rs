//! A process that is killed while something is not saved.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::window::{cornell, open_project};
use editor::document::Document;
use editor::edit::{Edit, Field};
use editor::recovery;
use egui::Vec2;
use engine::scene::EntityId;

/// Where the process that is to be killed finds its project.
const PROJECT: &str = "HOHLRAUM_TEST_KILLED_IN";
const NAME: &str = "recovery::what_a_killed_process_had_not_saved_is_offered_and_taken_over";

#[test]
fn what_a_killed_process_had_not_saved_is_offered_and_taken_over() {
    if let Some(project) = std::env::var_os(PROJECT) {
        return edit_until_killed(Path::new(&project));
    }
    let folder = tempfile::tempdir().unwrap();
    let project = cornell(folder.path());
    let saved = std::fs::read_to_string(project.join("scenes/cornell.ron")).unwrap();
    kill_while_it_edits(&project);
    assert_eq!(std::fs::read_to_string(project.join("scenes/cornell.ron")).unwrap(), saved);

    let Some(mut window) = open_project(&project, None, Vec2::new(1280.0, 720.0)) else { return };
    assert!(window.is_shown("Unsaved work was found"));
    let is_renamed = |window: &crate::window::Window| {
        window.editor().session.document.scene().entities.iter().any(|entity| entity.name == "not saved")
    };
    assert!(!is_renamed(&window));
    window.click("Recover");
    assert!(is_renamed(&window) && window.editor().title().contains('*'));
    assert!(!window.is_shown("Unsaved work was found"));
    window.press(egui::Modifiers::COMMAND, egui::Key::S);
    window.until("it is saved", |window| !window.editor().title().contains('*'));
    window.until("nothing is left to recover", |_| !recovery::path(&project, "cornell").exists());
}

/// Another process of this test opens the project, and dies where it stands.
fn kill_while_it_edits(project: &Path) {
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", NAME, "--nocapture"])
        .env(PROJECT, project)
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let kept = recovery::path(project, "cornell");
    let since = Instant::now();
    while !kept.is_file() {
        assert!(child.try_wait().unwrap().is_none(), "it ended by itself");
        assert!(since.elapsed() < Duration::from_secs(60));
        std::thread::sleep(Duration::from_millis(10));
    }
    child.kill().unwrap();
    assert!(!child.wait().unwrap().success());
}

fn edit_until_killed(project: &Path) {
    let (mut document, _) = Document::open(project, None).unwrap();
    let first: EntityId = document.scene().entities[0].id;
    document.commit(Edit::set(first, Field::Name("not saved".to_owned()))).unwrap();
    let mut now = Instant::now();
    loop {
        document.tick(now);
        now += recovery::EVERY;
        std::thread::sleep(Duration::from_millis(20));
    }
}
