//! Scenes of others, all the way: imported, baked at draft, played.

use std::path::{Path, PathBuf};

use bake::{Settings, Silent, bake};
use engine::play::{Options, run};
use engine::scene::file::Quality;
use tests::project::TestProject;

#[test]
fn scenes_of_others_are_imported_baked_at_draft_and_played_for_three_frames() {
    let Some(shared) = tests::shared() else { return };
    let files = models_under(&shared.join("assets/scenes"));
    let (mut baked, mut played) = (0, 0);
    for file in &files {
        let project = TestProject::from_file(file);
        let settings = Settings { quality: Some(Quality::Draft), ..Settings::default() };
        let transport = bake(project.path(), None, &settings, &Silent)
            .unwrap_or_else(|error| panic!("{}: {error}", file.display()))
            .transport;
        let broken: Vec<_> = transport.certificate.statements().into_iter().filter(|s| !s.holds).collect();
        assert!(broken.is_empty(), "{}: {broken:?}", file.display());
        baked += 1;
        let options =
            Options { headless: true, frames: Some(3), size: [160, 120], ..Options::new(project.path()) };
        match run(&options) {
            Ok(()) => played += 1,
            Err(error) if error.to_string().contains("no GPU adapter") => println!("not run: no GPU adapter"),
            Err(error) => panic!("{}: {error}", file.display()),
        }
    }
    println!("{} scenes: {baked} baked, {played} played", files.len());
    assert!(!files.is_empty());
}

fn models_under(folder: &Path) -> Vec<PathBuf> {
    let mut entries: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    let is_model = |path: &Path| {
        let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
        ["gltf", "glb", "obj"].contains(&ending)
    };
    let of = |path: PathBuf| match path.is_dir() {
        true => models_under(&path),
        false => {
            if is_model(&path) {
                vec![path]
            } else {
                Vec::new()
            }
        }
    };
    entries.into_iter().flat_map(of).collect()
}
