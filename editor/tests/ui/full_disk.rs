//! A disk that takes no more: nothing is lost, nothing is half, and it is told.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::window::{cornell, open_project};
use egui::{Key, Modifiers, Vec2};

/// Where the process whose disk is full finds its project.
const PROJECT: &str = "HOHLRAUM_TEST_DISK_IS_FULL_IN";
const NAME: &str = "full_disk::a_save_on_a_full_disk_keeps_the_old_file_whole_and_the_scene_unsaved";
/// In blocks of 512 or 1024 bytes, as the shell has them: less than the scene is long, so that writing ends midway.
const BLOCKS: u64 = 8;

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

#[test]
fn a_save_on_a_full_disk_keeps_the_old_file_whole_and_the_scene_unsaved() {
    if let Some(project) = std::env::var_os(PROJECT) {
        return save_on_a_full_disk(Path::new(&project));
    }
    let folder = tempfile::tempdir().unwrap();
    let project = cornell(folder.path());
    let scene = project.join("scenes/cornell.ron");
    let saved = std::fs::read(&scene).unwrap();
    assert!(saved.len() as u64 > BLOCKS * 1024);
    // A file that grows over the limit is refused with an error, as on a full disk, and the process lives on.
    let child = Command::new("sh")
        .args(["-c", &format!("trap '' XFSZ; ulimit -f {BLOCKS}; exec \"$0\" \"$@\"")])
        .arg(std::env::current_exe().unwrap())
        .args(["--exact", NAME, "--nocapture"])
        .env(PROJECT, &project)
        .output()
        .unwrap();
    let told = String::from_utf8_lossy(&child.stdout);
    assert!(child.status.success(), "{told}{}", String::from_utf8_lossy(&child.stderr));
    assert!(told.contains("1 passed"), "{told}");
    assert_eq!(std::fs::read(&scene).unwrap(), saved);
    assert_eq!(files(&project.join("scenes")), [scene]);
}

fn save_on_a_full_disk(project: &Path) {
    let Some(mut window) = open_project(project, None, Vec2::new(1280.0, 720.0)) else { return };
    let saved = std::fs::read(project.join("scenes/cornell.ron")).unwrap();
    let cube = window.made(|window| window.choose("Create", "Create cube"));
    window.press(Modifiers::COMMAND, Key::S);
    window.until("the error is told", |window| !window.errors().is_empty());
    let error = window.errors().remove(0);
    for part in ["scenes/cornell.ron", "not saved", "make room on the disk"] {
        assert!(error.contains(part), "{error}");
    }
    assert!(window.editor().title().contains('*'), "{}", window.editor().title());
    assert_eq!(std::fs::read(project.join("scenes/cornell.ron")).unwrap(), saved, "the old one, whole");
    assert_eq!(files(&project.join("scenes")).len(), 1, "nothing half lies beside it");

    // Editing goes on.
    window.press(Modifiers::COMMAND, Key::D);
    assert_eq!(window.steps(), 2);
    window.press(Modifiers::COMMAND, Key::Z);
    assert!(window.entity(cube).mesh.is_some());
}
