//! Files of others: real models, real scenes, and files made to break readers.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use engine::scene::assets::Assets;
use engine::scene::import::{Imported, import, load_assets};
use engine::scene::{Albedo, ImageSource, Material, Scene, SceneError, Texture, Warning};

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

/// Models that need what cannot be read, or that came without their buffers, and what the message has to say.
const REFUSED_MODELS: &[(&str, &str)] = &[
    ("BoxDraco.gltf", "KHR_draco_mesh_compression"),
    ("BoxMeshopt.glb", "EXT_meshopt_compression"),
    ("encoded-uris.gltf", "buffer-unencoded/@file#.bin: No such file"),
    ("mesh-sparse.gltf", "sparse places that do not ascend"), // on purpose
    ("texcoord-flip-short-material.glb", "KHR_mesh_quantization"),
    ("pirate.glb", "EXT_meshopt_compression"),
];

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
    assert_eq!(refused.len(), REFUSED_MODELS.len(), "{refused:#?}");
    for (message, (file, why)) in refused.iter().zip(REFUSED_MODELS) {
        assert!(message.contains(file) && message.contains(why), "{message}");
    }
}

#[test]
fn triangles_are_as_many_as_other_readers_found() {
    let Some(shared) = tests::shared() else { return };
    let root = shared.join("assets");
    let manifest = std::fs::read_to_string(root.join("MANIFEST.md")).unwrap();
    let mut compared = 0;
    for (file, expected) in manifest.lines().filter_map(counted) {
        let Ok((_, assets, _)) = read(&root, file) else { continue };
        let found: usize = assets.meshes.values().map(|mesh| mesh.indices.len() / 3).sum();
        assert_eq!(found, expected, "{file}");
        compared += 1;
    }
    println!("compared the triangles of {compared} files");
    assert!(compared > 60);
}

/// A file of the manifest's tables (file | bytes | triangles ...) and its triangles.
fn counted(row: &str) -> Option<(&str, usize)> {
    let mut cells = row.strip_prefix('|')?.split('|').map(str::trim);
    let (file, _, triangles) = (cells.next()?, cells.next()?, cells.next()?);
    Some((file, triangles.split(' ').next()?.parse().ok()?))
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

#[test]
fn broken_and_odd_pictures_are_survived() {
    let Some(shared) = tests::shared() else { return };
    for set in ["image-bad", "image-formats"] {
        let root = shared.join("assets/malformed").join(set);
        let files = files_under(&root, &[]);
        let (mut decoded, mut broken) = (0, Vec::new());
        for path in &files {
            let file = path.strip_prefix(&root).unwrap().to_str().unwrap().to_owned();
            match catch_unwind(AssertUnwindSafe(|| load_assets(&root, &showing(&file)).unwrap())) {
                Ok((assets, warnings)) if assets.images.is_empty() => {
                    assert!(warnings[0].to_string().contains(&file))
                }
                Ok(_) => decoded += 1,
                Err(_) => broken.push(file),
            }
        }
        println!("{set}: decoded {decoded}, refused {}", files.len() - decoded);
        assert!(broken.is_empty() && decoded > 0, "{broken:#?}");
    }
}

/// A scene of one material with this picture.
fn showing(file: &str) -> Scene {
    let image = ImageSource { file: file.to_owned(), image: None };
    let albedo = Albedo { texture: Some(Texture::new(image)), ..Albedo::default() };
    Scene { materials: vec![Material { albedo, ..Material::default() }], ..Scene::default() }
}

#[test]
fn what_the_validator_finds_valid_is_read() {
    let Some(shared) = tests::shared() else { return };
    let (mut valid, mut refused) = (0, Vec::new());
    for path in files_under(&shared.join("assets/malformed/gltf-validator"), &["gltf", "glb"]) {
        let Ok(report) = std::fs::read_to_string(format!("{}.report.json", path.display())) else { continue };
        let report: serde_json::Value = serde_json::from_str(&report).unwrap();
        if report["issues"]["numErrors"] != 0 {
            continue;
        }
        let (project, name) = split(&path);
        valid += 1;
        refused.extend(read(project, name).err().map(|error| error.to_string()));
    }
    println!("valid by the validator: {valid}, refused {}", refused.len());
    // One asks for a reader of glTF 2.1, one for a buffer out of the web.
    let [newer, web] = &refused[..] else { panic!("{refused:#?}") };
    assert!(newer.contains("min_version_valid.gltf") && web.contains("http://"), "{refused:?}");
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
