//! `hohlraum-bake new PROJECT --from FILE...`
//!
//! The project is built in a folder beside its place and moved there when it is whole: whatever goes wrong,
//! nothing half-written stays.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, Result};
use bake::adopt::adopt;
use engine::scene::file::{Project, save_project, save_scene};
use engine::scene::import::import;
use engine::scene::{Scene, SkyKind};
use glam::Vec3;
use serde_json::json;

use super::staging::Staging;
use crate::args::NewArgs;
use crate::print;

pub fn run(args: &NewArgs) -> Result<ExitCode> {
    let staging = Staging::beside(&args.project)?;
    let names = scene_names(&args.from);
    let mut scenes = Vec::new();
    for (file, name) in args.from.iter().zip(&names) {
        let imported = import(staging.path(), &adopt(staging.path(), name, file)?)?;
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
}
