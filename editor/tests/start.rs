//! The start-up: from a project to pictures, without a display.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// A copy of the Cornell box that is baked coarsely.
fn cornell(folder: &Path) -> PathBuf {
    let sample = Path::new(env!("CARGO_MANIFEST_DIR")).join("../projects/cornell");
    let project = folder.join("cornell");
    for file in ["project.ron", "scenes/cornell.ron", "assets/cornell.obj", "assets/cornell.mtl"] {
        let to = project.join(file);
        std::fs::create_dir_all(to.parent().unwrap()).unwrap();
        std::fs::copy(sample.join(file), to).unwrap();
    }
    let settings = std::fs::read_to_string(project.join("project.ron")).unwrap();
    assert!(settings.contains("quality: standard"));
    std::fs::write(project.join("project.ron"), settings.replace("standard", "draft")).unwrap();
    project
}

fn hohlraum(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hohlraum"))
        .args(args)
        .current_dir(folder)
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .stdin(Stdio::null())
        .output()
        .unwrap()
}

#[test]
fn without_a_display_a_project_is_baked_and_played_into_files() {
    let folder = tempfile::tempdir().unwrap();
    let project = cornell(folder.path());
    let run = hohlraum(folder.path(), &["cornell"]);
    let (told, complained) = (String::from_utf8(run.stdout).unwrap(), String::from_utf8(run.stderr).unwrap());
    assert!(project.join("baked/cornell").is_dir(), "{complained}");
    if complained.contains("no GPU adapter") {
        assert!(complained.contains("apt") && run.status.code() == Some(1), "{complained}");
        println!("not run: no GPU adapter");
        return;
    }
    assert!(run.status.success(), "{complained}");
    for word in ["pictures:", "statistics:", "certificate:"] {
        assert!(told.contains(word), "{told}");
    }
    assert!(project.join("out/stats.json").is_file());
    let pictures = std::fs::read_dir(project.join("out")).unwrap().flatten();
    let pictures = pictures.filter(|entry| entry.path().extension().is_some_and(|ending| ending == "png"));
    assert!(pictures.count() >= 12);
}

#[test]
fn what_is_no_project_is_told_with_the_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let run = hohlraum(folder.path(), &["nowhere"]);
    let complained = String::from_utf8(run.stderr).unwrap();
    assert_eq!(run.status.code(), Some(1), "{complained}");
    assert!(complained.contains("nowhere") && complained.contains("hohlraum-bake new"), "{complained}");
}

#[test]
fn wrong_usage_exits_with_2() {
    let run = hohlraum(&std::env::temp_dir(), &["a", "b"]);
    assert_eq!(run.status.code(), Some(2));
}
