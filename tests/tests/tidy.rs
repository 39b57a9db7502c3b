//! The house rules that a reader relies on: what lies where, and that the README tells it truly.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use tests::source::workspace;

const AT_THE_TOP: [&str; 10] = [
    "Cargo.lock",
    "Cargo.toml",
    "LICENSE",
    "README.md",
    "bake",
    "editor",
    "engine",
    "projects",
    "shaders",
    "tests",
];

/// What builds and runs leave there; git ignores it.
const LEFT_BY_BUILDS: [&str; 2] = ["target", "out"];

#[test]
fn nothing_unexpected_lies_at_the_top() {
    let entries = std::fs::read_dir(workspace()).unwrap();
    for name in entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()) {
        let expected = AT_THE_TOP.contains(&name.as_str()) || LEFT_BY_BUILDS.contains(&name.as_str());
        assert!(expected || name.starts_with('.'), "`{name}` belongs into one of {AT_THE_TOP:?}");
    }
    for name in ["README.md", "LICENSE", ".ci/run"] {
        assert!(workspace().join(name).is_file(), "{name}");
    }
}

#[test]
fn the_readmes_map_names_every_folder() {
    let readme = readme();
    for root in ["engine/src", "bake/src", "editor/src", "shaders", "projects"] {
        let depth = if root == "projects" { 1 } else { usize::MAX };
        for folder in folders(&workspace().join(root), depth) {
            let name = folder.file_name().unwrap().to_str().unwrap();
            let (alone, below) = (format!("{name}/"), format!("/{name}/"));
            let told = readme.split([' ', ',', '\n']).any(|word| word == alone || word.ends_with(&below));
            assert!(told, "README.md does not name {}", folder.display());
        }
    }
}

#[test]
fn the_readmes_links_lead_somewhere() {
    let readme = readme();
    let anchors: Vec<_> = readme.lines().filter(|line| line.starts_with('#')).map(anchor).collect();
    for link in readme.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
        match link.strip_prefix('#') {
            Some(anchor) => assert!(anchors.iter().any(|other| other == anchor), "#{anchor}"),
            None if link.contains("://") => {}
            None => assert!(workspace().join(link).exists(), "{link}"),
        }
    }
}

#[test]
fn the_workspace_has_one_feature() {
    let mut features = Vec::new();
    for package in packages() {
        let name = package["name"].as_str().unwrap().to_owned();
        let named = package["features"].as_object().unwrap().keys().filter(|feature| *feature != "default");
        features.extend(named.map(|feature| format!("{name}/{feature}")));
    }
    assert_eq!(features, ["engine/gpu"]);
}

#[test]
fn every_package_obeys_the_workspaces_lints() {
    let packages = packages();
    assert_eq!(packages.len(), 4);
    for package in packages {
        let manifest = package["manifest_path"].as_str().unwrap();
        let text = std::fs::read_to_string(manifest).unwrap();
        assert!(text.contains("[lints]\nworkspace = true"), "{manifest}");
    }
}

fn packages() -> Vec<serde_json::Value> {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--offline", "--no-deps", "--format-version", "1"])
        .current_dir(workspace())
        .stdin(Stdio::null())
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    metadata["packages"].as_array().unwrap().clone()
}

fn readme() -> String {
    std::fs::read_to_string(workspace().join("README.md")).unwrap()
}

/// As GitHub makes anchors of headings.
fn anchor(heading: &str) -> String {
    let kept = |c: &char| c.is_alphanumeric() || " -_".contains(*c);
    let text: String = heading.trim_start_matches('#').trim().to_lowercase().chars().filter(kept).collect();
    text.replace(' ', "-")
}

fn folders(root: &Path, depth: usize) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(root) else { return Vec::new() };
    let mut found = Vec::new();
    for path in entries.map(|entry| entry.unwrap().path()).filter(|path| path.is_dir()) {
        if depth > 1 {
            found.extend(folders(&path, depth - 1));
        }
        found.push(path);
    }
    found
}
