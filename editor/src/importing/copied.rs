//! Files of others, copied into the project: gone again unless what was made of them is kept.

use std::path::{Path, PathBuf};

use engine::scene::ImageSource;
use engine::scene::import::settings::stem;

use super::load;

/// A file and what it refers to, in the project; gone again unless it is kept.
pub struct Copied {
    /// A folder, or a file alone.
    place: PathBuf,
    /// Relative to the project.
    pub file: String,
    kept: bool,
}

impl Copied {
    /// Into a folder of its own, that moves to its place when it is whole.
    pub fn of(project: &Path, source: &Path) -> anyhow::Result<Self> {
        let assets = project.join("assets");
        std::fs::create_dir_all(&assets)?;
        let staging = tempfile::Builder::new().prefix(".import-").tempdir_in(&assets)?;
        let name = usable(&stem(&source.file_name().unwrap_or_default().to_string_lossy()));
        let staged = bake::adopt::adopt(staging.path(), &name, source)?;
        let (place, free) = move_in(&staging.path().join("assets").join(&name), &assets, &name)?;
        let below = staged.strip_prefix(&format!("assets/{name}/")).unwrap_or(&staged).to_owned();
        Ok(Self { place, file: format!("assets/{free}/{below}"), kept: false })
    }

    /// Straight into `assets`, if it can be read.
    pub fn picture(project: &Path, source: &Path) -> Result<Self, String> {
        let told = |error: std::io::Error| format!("{}: {error}", source.display());
        let name = source.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let beside = ImageSource { file: name.clone(), image: None };
        load::picture(source.parent().unwrap_or(Path::new("")), &beside)?;
        let assets = project.join("assets");
        std::fs::create_dir_all(&assets).map_err(told)?;
        let ending = name.rsplit_once('.').map_or(String::new(), |(_, ending)| format!(".{ending}"));
        let (place, free) = free_place(&assets, &usable(&stem(&name)), &ending).map_err(|e| e.to_string())?;
        std::fs::copy(source, &place).map_err(told)?;
        Ok(Self { place, file: format!("assets/{free}"), kept: false })
    }

    pub fn keep(mut self) {
        self.kept = true;
    }
}

impl Drop for Copied {
    fn drop(&mut self) {
        if !self.kept {
            let _ = if self.place.is_dir() {
                std::fs::remove_dir_all(&self.place)
            } else {
                std::fs::remove_file(&self.place)
            };
        }
    }
}

fn move_in(staged: &Path, assets: &Path, name: &str) -> anyhow::Result<(PathBuf, String)> {
    let (place, free) = free_place(assets, name, "")?;
    std::fs::rename(staged, &place)?;
    Ok((place, free))
}

/// The first name that is free: `chair`, `chair-2`, `chair-3`.
fn free_place(assets: &Path, name: &str, ending: &str) -> anyhow::Result<(PathBuf, String)> {
    let numbered = (2..10_000).map(|n| format!("{name}-{n}{ending}"));
    let mut names = std::iter::once(format!("{name}{ending}")).chain(numbered);
    let free = names.find(|free| !assets.join(free).exists());
    let free = free.ok_or_else(|| anyhow::anyhow!("{}: no name is left for `{name}`", assets.display()))?;
    Ok((assets.join(&free), free))
}

/// As a folder's name on every system.
fn usable(stem: &str) -> String {
    let replaced = |c: char| if c.is_control() || r#"/\<>:"|?*"#.contains(c) { '_' } else { c };
    let name: String = stem.chars().map(replaced).collect();
    let name = name.trim_matches([' ', '.']);
    if name.is_empty() { "model".to_owned() } else { name.to_owned() }
}
