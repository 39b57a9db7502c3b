//! `hohlraum-bake new PROJECT --from FILE...`
//!
//! The project is built in a folder beside its place and moved there when it is whole: whatever goes wrong,
//! nothing half-written stays.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, Result, bail};
use engine::scene::file::{Project, save_project, save_scene};
use engine::scene::import::{Imported, import};
use engine::scene::{Scene, SkyKind};
use glam::Vec3;
use serde_json::json;

use super::staging::Staging;
use crate::args::NewArgs;
use crate::print;

/// How many folders above its own a file may refer to: `../textures` is usual, all of the disk is not.
const FOLDERS_UP: usize = 2;

pub fn run(args: &NewArgs) -> Result<ExitCode> {
    let staging = Staging::beside(&args.project)?;
    let names = scene_names(&args.from);
    let mut scenes = Vec::new();
    for (file, name) in args.from.iter().zip(&names) {
        let imported = add(staging.path(), name, file)?;
        let scene = with_sky(imported.scene, args.sky);
        scene.validate().with_context(|| file.display().to_string())?;
        save_scene(staging.path(), name, &scene)?;
        imported.warnings.iter().for_each(|warning| eprintln!("warning: {warning}"));
        let warnings: Vec<_> = imported.warnings.iter().map(ToString::to_string).collect();
        scenes.push(
            json!({ "name": name, "from": file, "entities": scene.entities.len(), "warnings": warnings }),
        );
    }
    save_project(staging.path(), &Project { default_scene: names[0].clone(), ..Project::default() })?;
    staging.install()?;

    let project = &args.project;
    if args.json {
        print::json(&json!({ "project": project, "default_scene": names[0], "scenes": scenes }));
    } else {
        let list = names.join(", ");
        let project = project.display();
        print::text(&format!("{project}: {list}; bake with `hohlraum-bake {project}`\n"));
    }
    Ok(ExitCode::SUCCESS)
}

/// Copies a file and what it refers to into `assets/NAME`, and reads it there.
fn add(project: &Path, name: &str, file: &Path) -> Result<Imported> {
    let source = absolute(file)?;
    let root = source.ancestors().skip(1).take(FOLDERS_UP + 1).last().unwrap_or(&source);
    let companions = import(root, &slashes(source.strip_prefix(root)?)?)?.companions;

    let target = target(name, &source, &companions)?;
    copy(&source, &project.join(&target))?;
    let (from, to) = (source.parent().unwrap_or(root), project.join(&target));
    for companion in &companions {
        let beside = from.join(companion);
        // What is missing was an error or a warning of the import.
        if beside.is_file() {
            copy(&beside, &normal(&to.with_file_name(companion)))?;
        }
    }
    Ok(import(project, &target)?)
}

/// Without `..`. A link keeps its own name: what it refers to lies beside the link.
fn absolute(file: &Path) -> Result<PathBuf> {
    let named = || file.display().to_string();
    if !file.metadata().with_context(named)?.is_file() {
        bail!("{}: is no file", named());
    }
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    Ok(folder.canonicalize().with_context(named)?.join(file.file_name().with_context(named)?))
}

/// Where the file goes: below as many of its own folders as its companions climb, so that `..` leads where it
/// did and still stays inside `assets/NAME`.
fn target(name: &str, source: &Path, companions: &[String]) -> Result<String> {
    let climbs = |companion: &String| companion.split('/').take_while(|part| *part == "..").count();
    let up = companions.iter().map(climbs).max().unwrap_or(0);
    let below = source.ancestors().nth(up + 1).context("a file refers to a place outside the disk")?;
    Ok(format!("assets/{name}/{}", slashes(source.strip_prefix(below)?)?))
}

/// Without `..`: a folder that it leads through need not exist.
fn normal(path: &Path) -> PathBuf {
    path.components().fold(PathBuf::new(), |mut normal, part| {
        match part {
            std::path::Component::ParentDir => drop(normal.pop()),
            part => normal.push(part),
        }
        normal
    })
}

fn copy(from: &Path, to: &Path) -> Result<()> {
    std::fs::create_dir_all(to.parent().unwrap_or(to)).with_context(|| to.display().to_string())?;
    let mut source = std::fs::File::open(from).with_context(|| from.display().to_string())?;
    let mut target = std::fs::File::create(to).with_context(|| to.display().to_string())?;
    // Not `fs::copy`, which would make read-only files of read-only ones.
    std::io::copy(&mut source, &mut target).with_context(|| to.display().to_string())?;
    target.sync_all().with_context(|| to.display().to_string())
}

fn slashes(path: &Path) -> Result<String> {
    let parts = path.iter().map(|part| part.to_str());
    let parts: Option<Vec<_>> = parts.collect();
    Ok(parts.with_context(|| format!("{}: its name is no Unicode; rename it", path.display()))?.join("/"))
}

fn with_sky(mut scene: Scene, radiance: Option<Vec3>) -> Scene {
    if let Some(radiance) = radiance {
        scene.sky.kind = SkyKind::Constant { radiance };
    }
    scene
}

/// The files' stems, made usable as file names everywhere, each once.
fn scene_names(files: &[PathBuf]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for file in files {
        let stem = usable(&file.file_stem().unwrap_or_default().to_string_lossy());
        let numbered = (2..).map(|n| format!("{stem}-{n}"));
        let taken = |name: &String| names.iter().any(|other| other.to_lowercase() == name.to_lowercase());
        let name = std::iter::once(stem.clone()).chain(numbered).find(|name| !taken(name));
        names.push(name.unwrap_or(stem));
    }
    names
}

fn usable(stem: &str) -> String {
    let replaced = |c: char| if c.is_control() || r#"/\<>:"|?*"#.contains(c) { '_' } else { c };
    let name: String = stem.chars().map(replaced).collect();
    let name = name.trim_matches([' ', '.']);
    if name.is_empty() { "scene".to_owned() } else { name.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_are_named_by_stems_each_once() {
        let files = ["a/Box.gltf", "b/box.obj", "..glb", "x:y?.obj", "Box.glb"].map(PathBuf::from);
        assert_eq!(scene_names(&files), ["Box", "box-2", "scene", "x_y_", "Box-3"]);
    }

    #[test]
    fn a_file_that_climbs_keeps_its_folders() {
        let source = Path::new("/models/kit/chair/chair.gltf");
        let at = |companions: &[&str]| {
            target("chair", source, &companions.iter().map(|&c| c.to_owned()).collect::<Vec<_>>()).unwrap()
        };
        assert_eq!(at(&["chair.bin", "maps/a.png"]), "assets/chair/chair.gltf");
        assert_eq!(at(&["../textures/a.png"]), "assets/chair/chair/chair.gltf");
        assert_eq!(at(&["../../a.png", "b.png"]), "assets/chair/kit/chair/chair.gltf");
        assert_eq!(
            normal(Path::new("p/assets/chair/chair/../textures/a.png")),
            Path::new("p/assets/chair/textures/a.png")
        );
    }
}
