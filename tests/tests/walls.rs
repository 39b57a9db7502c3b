//! The walls between crates and rooms. What is absent is what keeps each of them small: the bake runs where there is
//! no GPU, the scene knows nothing of light transport, the GPU craft knows nothing of either.

use std::path::Path;
use std::process::{Command, Stdio};

use tests::source::{files, read, workspace};

/// engine's rooms, and the rooms that each may name.
const ROOMS: [(&str, &[&str]); 5] = [
    ("scene", &[]),
    ("transport", &["scene"]),
    ("gpu", &[]),
    ("render", &["scene", "transport", "gpu"]),
    ("play", &["scene", "transport", "gpu", "render"]),
];

/// The rooms' files that write to disk; `play` writes pictures and statistics where it is told to. What is authored; light,
/// and the two files of it that belong together.
const WRITERS: [&str; 3] = ["scene/file.rs", "transport/file.rs", "transport/file/pair.rs"];

#[test]
fn rooms_name_only_the_rooms_below_them() {
    for (room, may_name) in ROOMS {
        for file in room_files(room) {
            let source = read(&file);
            let forbidden: Vec<_> = source
                .rooms(depth(&file))
                .filter(|named| ROOMS.iter().any(|(other, _)| other == named))
                .filter(|named| *named != room && !may_name.contains(named))
                .collect();
            assert!(forbidden.is_empty(), "{} names {forbidden:?}", file.display());
        }
    }
}

#[test]
fn engine_knows_nothing_of_its_users() {
    let crates = dependencies("engine", "normal,build,dev");
    assert!(has(&crates, "wgpu"), "the tree is read: {crates:?}");
    for absent in ["bake", "editor", "egui", "eframe"] {
        assert!(!has(&crates, absent), "engine depends on {absent}");
    }
}

#[test]
fn the_player_is_built_from_engine_alone_and_the_others_exist() {
    let players = packages_with_binary("hohlraum-play");
    assert_eq!(players, ["engine"]);
    for package in players {
        let crates = dependencies(&package, "normal,build");
        assert!(has(&crates, "winit"), "the player has a window: {crates:?}");
        for absent in ["bake", "editor", "egui", "eframe"] {
            assert!(!has(&crates, absent), "{package} depends on {absent}");
        }
    }
    // What is looked for is there under these names.
    let editor = dependencies("editor", "normal,build");
    for there in ["engine", "bake"] {
        assert!(has(&editor, there), "{there} goes by another name: {editor:?}");
    }
    assert_eq!(["hohlraum", "hohlraum-bake"].map(packages_with_binary), [["editor"], ["bake"]]);
}

#[test]
fn the_bake_needs_no_gpu_and_no_window() {
    let crates = dependencies("bake", "normal,build");
    assert!(has(&crates, "obvhs"), "the tree is read: {crates:?}");
    for absent in ["wgpu", "wgpu-core", "wgpu-hal", "naga", "naga_oil", "winit", "egui", "editor"] {
        assert!(!has(&crates, absent), "bake depends on {absent}");
    }
}

#[test]
fn engine_writes_what_is_authored_and_light_and_nothing_else() {
    for file in ROOMS.iter().filter(|(room, _)| *room != "play").flat_map(|(room, _)| room_files(room)) {
        let source = read(&file);
        let calls: [&[&str]; 10] = [
            &["fs", "write"],
            &["fs", "copy"],
            &["fs", "rename"],
            &["fs", "remove_file"],
            &["fs", "remove_dir_all"],
            &["fs", "create_dir"],
            &["fs", "create_dir_all"],
            &["File", "create"],
            &["OpenOptions"],
            &["tempfile"],
        ];
        let writes = calls.iter().any(|call| source.names(call));
        let may = WRITERS.iter().any(|writer| file.ends_with(writer));
        assert!(may || !writes, "{} writes to disk", file.display());
    }
}

#[test]
fn what_is_edited_knows_nothing_of_windows() {
    let source = workspace().join("editor/src");
    let rooms =
        ["document", "edit", "command", "importing", "baking"].map(|room| files(&source.join(room), "rs"));
    let names =
        ["assets", "clipboard", "history", "intents", "log", "primitives", "recent", "recovery", "selection"];
    let single = names.map(|name| source.join(name).with_extension("rs"));
    for file in rooms.into_iter().flatten().chain(single) {
        let source = read(&file);
        for window in ["egui", "eframe", "winit", "wgpu"] {
            assert!(!source.names(&[window]), "{} names {window}", file.display());
        }
    }
}

/// They ask; threads do it, and what came of it is taken with a later picture.
#[test]
fn what_draws_the_editor_waits_for_no_disk_no_import_no_gpu_and_no_bake() {
    let source = workspace().join("editor/src");
    let rooms = ["panels", "inspector", "tools", "viewport", "gizmo", "app"];
    let all: Vec<_> = rooms.into_iter().flat_map(|room| files(&source.join(room), "rs")).collect();
    assert!(all.len() > 30);
    for file in all {
        let source = read(&file);
        let calls: [&[&str]; 9] = [
            &["fs"],
            &["File", "open"],
            &["File", "create"],
            &["load_assets"],
            &["PollType"],
            &["texture", "read"],
            &["buffer", "read"],
            &["bake", "bake_scene"],
            &["bake", "bake"],
        ];
        let waits = calls.iter().any(|call| source.names(call));
        assert!(!waits, "{} reads, imports, bakes or waits for the GPU by itself", file.display());
    }
}

#[test]
fn configuration_never_hides_in_function_bodies() {
    for package in ["engine", "bake", "editor", "tests"] {
        for file in files(&workspace().join(package), "rs") {
            assert_eq!(read(&file).cfgs_in_bodies, 0, "{}", file.display());
        }
    }
}

fn room_files(room: &str) -> Vec<std::path::PathBuf> {
    let rooms = workspace().join("engine/src");
    let files = files(&rooms.join(room), "rs");
    assert!(!files.is_empty(), "engine has no room `{room}`");
    files
}

/// Modules from the crate's root down to the file: scene/mod.rs 1, scene/import/obj.rs 3.
fn depth(file: &Path) -> usize {
    let below = file.strip_prefix(workspace().join("engine/src")).unwrap();
    below.components().count() - usize::from(below.ends_with("mod.rs"))
}

/// Names of all crates that a package of the workspace is built from.
fn dependencies(package: &str, edges: &str) -> Vec<String> {
    let output = Command::new(env!("CARGO"))
        .args(["tree", "--offline", "--prefix", "none", "--format", "{p}", "-p", package, "-e", edges])
        .current_dir(workspace())
        .stdin(Stdio::null())
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    let others = text.lines().skip(1).filter_map(|line| line.split(' ').next());
    others.map(str::to_owned).collect()
}

/// Packages of the workspace that build a program of this name.
fn packages_with_binary(name: &str) -> Vec<String> {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--offline", "--no-deps", "--format-version", "1"])
        .current_dir(workspace())
        .stdin(Stdio::null())
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let about: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let has_it = |package: &&serde_json::Value| {
        let targets = package["targets"].as_array().unwrap().iter();
        targets.clone().any(|target| target["name"] == name && target["kind"][0] == "bin")
    };
    let packages = about["packages"].as_array().unwrap().iter().filter(has_it);
    packages.map(|package| package["name"].as_str().unwrap().to_owned()).collect()
}

fn has(crates: &[String], name: &str) -> bool {
    crates.iter().any(|other| other == name)
}
