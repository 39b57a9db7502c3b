//! Files of others: real models, real scenes, and files made to break readers.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use engine::scene::assets::Assets;
use engine::scene::import::{Imported, import, load_assets};
use engine::scene::{SceneError, Warning};

#[test]
fn reference_scenes_are_read_whole() {
    let Some(shared) = tests::shared() else { return };
    let files = files_under(&shared.join("reference/scenes"), &["gltf"]);
    assert!(!files.is_empty());
    for file in files {
        let (project, name) = split(&file);
        let (imported, assets, warnings) = read(project, name).unwrap();
        assert!(imported.warnings.is_empty() && warnings.is_empty(), "{:?} {warnings:?}", imported.warnings);
        assert!(!assets.meshes.is_empty(), "{}", file.display());
    }
}

/// Models that need what cannot be read, and what the message has to say.
const REFUSED_MODELS: &[(&str, &str)] =
    &[("BoxDraco.gltf", "KHR_draco_mesh_compression"), ("BoxMeshopt.glb", "EXT_meshopt_compression")];

#[test]
fn models_of_others_are_read_or_refused_for_a_reason() {
    let Some(shared) = tests::shared() else { return };
    let root = shared.join("assets/models");
    let mut refused = Vec::new();
    let files = files_under(&root, &["gltf", "glb", "obj"]);
    for path in &files {
        let name = path.strip_prefix(&root).unwrap().to_str().unwrap();
        if let Err(error) = read(&root, name) {
            let message = error.to_string();
            assert!(message.contains(path.file_name().unwrap().to_str().unwrap()), "{message}");
            refused.push(message);
        }
    }
    println!("models: imported {}, refused {}", files.len() - refused.len(), refused.len());
    let expected = |message: &&String| {
        !REFUSED_MODELS.iter().any(|(file, why)| message.contains(file) && message.contains(why))
    };
    let unexpected: Vec<_> = refused.iter().filter(expected).collect();
    assert!(unexpected.is_empty(), "{unexpected:#?}");
}

#[test]
fn scenes_of_others_are_read() {
    let Some(shared) = tests::shared() else { return };
    let root = shared.join("assets/scenes");
    let files = files_under(&root, &["gltf", "glb", "obj"]);
    for path in &files {
        let name = path.strip_prefix(&root).unwrap().to_str().unwrap();
        let (imported, assets, warnings) = read(&root, name).unwrap();
        let triangles: usize = assets.meshes.values().map(|mesh| mesh.indices.len() / 3).sum();
        assert!(triangles > 0, "{name}");
        for warning in imported.warnings.iter().chain(&warnings) {
            println!("{warning}");
        }
    }
    println!("scenes: imported {}", files.len());
}

#[test]
fn malformed_files_are_survived() {
    let Some(shared) = tests::shared() else { return };
    let root = shared.join("assets/malformed");
    let files = files_under(&root, &["gltf", "glb", "obj"]);
    let (mut imported, mut refused, mut broken) = (0, 0, Vec::new());
    for path in &files {
        let (project, name) = split(path);
        match catch_unwind(AssertUnwindSafe(|| read(project, name))) {
            Ok(Ok(_)) => imported += 1,
            Ok(Err(error)) if error.to_string().contains(name) => refused += 1,
            Ok(Err(error)) => broken.push(format!("{name} is not named: {error}")),
            Err(_) => broken.push(format!("{} panicked", path.display())),
        }
    }
    println!("malformed: imported {imported}, refused {refused}");
    assert!(broken.is_empty(), "{broken:#?}");
}

/// Imports a file and loads what the scene refers to.
fn read(project: &Path, file: &str) -> Result<(Imported, Assets, Vec<Warning>), SceneError> {
    let imported = import(project, file)?;
    let (assets, warnings) = load_assets(project, &imported.scene)?;
    for mesh in assets.meshes.values() {
        mesh.validate().unwrap_or_else(|message| panic!("{file}: {message}"));
    }
    Ok((imported, assets, warnings))
}

fn split(path: &Path) -> (&Path, &str) {
    (path.parent().unwrap(), path.file_name().unwrap().to_str().unwrap())
}

/// In alphabetical order; an empty list of endings takes all.
fn files_under(folder: &Path, endings: &[&str]) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            let ending = path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
            if path.is_dir() {
                folders.push(path);
            } else if endings.is_empty() || ending.is_some_and(|ending| endings.contains(&ending.as_str())) {
                files.push(path);
            }
        }
    }
    files.sort();
    files
}
