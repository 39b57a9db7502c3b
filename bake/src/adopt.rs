//! Files of others, copied into a project with all that they refer to.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use engine::scene::import::import;

/// How many folders above its own a file may refer to: `../textures` is usual, all of the disk is not.
const FOLDERS_UP: usize = 2;

/// Copies a file and what it refers to into `assets/NAME`: where it lies then, relative to the project.
pub fn adopt(project: &Path, name: &str, file: &Path) -> Result<String> {
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
    Ok(target)
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

#[cfg(test)]
mod tests {
    use super::*;

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
