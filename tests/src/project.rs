//! Projects made for a test, in a folder that goes with it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use engine::scene::file::{Project, save_project, save_scene};
use engine::scene::import::import;
use engine::scene::{Feature, Forced, Scene};

/// A project whose scene is called `main`.
pub struct TestProject {
    folder: tempfile::TempDir,
}

impl TestProject {
    /// Of a scene that needs no files. All that a bake may leave out is in it: tests read light probes where nothing
    /// moves, and rows where nothing shines.
    pub fn of(scene: &Scene) -> Self {
        use Feature::{BlackPatches, LightProbes, Matrix, SkyPatches, UnlitPatches};
        let baked = [LightProbes, SkyPatches, BlackPatches, UnlitPatches, Matrix];
        Self::forcing(scene, baked.map(|feature| (feature, Forced::In)).into())
    }

    /// The same where the author says other things of features, or nothing.
    pub fn forcing(scene: &Scene, features: BTreeMap<Feature, Forced>) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let settings = Project { features, ..Project::default() };
        save_project(folder.path(), &settings).expect("project.ron");
        save_scene(folder.path(), "main", scene).expect("the scene");
        Self { folder }
    }

    /// Of a model file, with everything that lies beside it.
    pub fn from_file(file: &Path) -> Self {
        let project = Self::of(&Scene::default());
        let assets = project.path().join("assets");
        if file.extension().is_some_and(|ending| ending == "glb") {
            std::fs::create_dir_all(&assets).expect("a folder"); // all in one file
            std::fs::copy(file, assets.join(file.file_name().expect("a name"))).expect("a copy");
        } else {
            copy_folder(file.parent().expect("a folder"), &assets);
        }
        let name = format!("assets/{}", file.file_name().expect("a name").to_string_lossy());
        let imported = import(project.path(), &name).expect("an import");
        save_scene(project.path(), "main", &imported.scene).expect("the scene");
        project
    }

    /// Of a project on disk, without what was baked of it.
    pub fn copy_of(project: &Path) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        std::fs::copy(project.join("project.ron"), folder.path().join("project.ron")).expect("a copy");
        for part in ["scenes", "assets"] {
            copy_folder(&project.join(part), &folder.path().join(part));
        }
        Self { folder }
    }

    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    pub fn scene(&self) -> Scene {
        engine::scene::file::load_scene(self.path(), "main").expect("the scene")
    }

    pub fn save(&self, scene: &Scene) {
        save_scene(self.path(), "main", scene).expect("the scene");
    }

    pub fn light_file(&self) -> PathBuf {
        engine::transport::file::path(self.path(), "main")
    }
}

fn copy_folder(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).expect("a folder");
    for entry in std::fs::read_dir(from).expect("a folder").flatten() {
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy_folder(&entry.path(), &target);
        } else {
            std::fs::write(&target, std::fs::read(entry.path()).expect("a file")).expect("a copy");
        }
    }
}
