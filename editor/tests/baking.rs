//! The bake beside the editing.

use std::sync::Arc;
use std::time::Duration;

use bake::Settings;
use editor::baking::{self, Badge, Baking};
use editor::document::Document;
use editor::edit::{Edit, Field};
use editor::primitives;
use engine::scene::file::Quality;
use engine::scene::import::load_assets;
use engine::scene::{EntityId, Light, Transform};
use glam::DVec3;
use tempfile::TempDir;

const CUBE: EntityId = EntityId(2);
const SUN: EntityId = EntityId(3);

fn project() -> (TempDir, Document) {
    let folder = tempfile::tempdir().unwrap();
    let document =
        Document::new_project(&folder.path().join("project"), "main", primitives::first_scene()).unwrap();
    (folder, document)
}

fn coarse() -> Settings {
    let quality = Some(Quality::Draft);
    Settings { quality, rays: Some(64), patch_length: Some(2.0), threads: Some(1), ..Settings::default() }
}

fn finished(baking: &mut Baking) -> Result<usize, String> {
    loop {
        if let Some(ended) = baking.poll() {
            return ended.map(|warnings| warnings.len());
        }
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn moved(x: f64) -> Edit {
    Edit::set(CUBE, Field::Transform(Box::new(Transform::at(DVec3::new(x, 0.5, 0.0)))))
}

#[test]
fn a_bake_is_of_the_scene_as_it_stands_and_the_badge_follows_the_edits() {
    let (_folder, mut document) = project();
    let saved = std::fs::read_to_string(document.path()).unwrap();
    let mut baking = Baking::default();
    assert_eq!(baking.badge(&document), Badge::Missing);
    document.commit(moved(1.0)).unwrap();
    baking.start(&document, coarse()).unwrap();
    assert!(baking.start(&document, coarse()).unwrap_err().contains("already"));
    assert!(baking.progress().is_some());
    finished(&mut baking).unwrap();
    assert!(baking.progress().is_none() && baking.transport().unwrap().patches.len() > 10);
    assert_eq!(std::fs::read_to_string(document.path()).unwrap(), saved, "the user's file is the user's");
    assert_eq!(baking.badge(&document), Badge::Current);

    document.commit(Edit::set(SUN, Field::Light(Some(Box::new(Light::default()))))).unwrap();
    assert_eq!(baking.badge(&document), Badge::LightOnly);
    document.commit(moved(2.0)).unwrap();
    assert!(matches!(baking.badge(&document), Badge::Stale(_)));

    // The exact answer names what changed, and an undone edit fits again.
    let (assets, _) = load_assets(document.project(), document.scene()).unwrap();
    let assets = Arc::new(assets);
    let told = |baking: &mut Baking, document: &Document| {
        baking.compare(document, &assets);
        for _ in 0..2000 {
            assert!(baking.poll().is_none());
            std::thread::sleep(Duration::from_millis(2));
            match baking.badge(document) {
                Badge::Stale(why) if why.is_empty() => {}
                known => return known,
            }
        }
        panic!("the comparison never ends");
    };
    assert_eq!(told(&mut baking, &document), Badge::Stale("changed `Cube`".to_owned()));
    assert_eq!(baking.differs().unwrap().changed.len(), 1);
    document.undo();
    assert_eq!(told(&mut baking, &document), Badge::LightOnly);
    document.undo();
    assert_eq!(baking.badge(&document), Badge::Current, "the sun is as it was baked");
    document.redo();

    let of_disk = baking::load(&document, &assets);
    let mut other = Baking::default();
    other.show(of_disk.unwrap().unwrap());
    assert_eq!(other.badge(&document), Badge::Current);
}

#[test]
fn a_cancelled_bake_keeps_what_was_shown_before() {
    let (_folder, document) = project();
    let mut baking = Baking::default();
    let slow = Settings { rays: Some(1 << 16), patch_length: Some(0.2), ..coarse() };
    baking.start(&document, slow).unwrap();
    baking.cancel();
    let error = finished(&mut baking).unwrap_err();
    assert!(error.contains("cancelled"), "{error}");
    assert!(baking.transport().is_none() && baking.badge(&document) == Badge::Missing);
    assert!(baking::load(&document, &Default::default()).unwrap().is_none());
}

#[test]
fn a_bake_that_is_refused_tells_why() {
    let (_folder, document) = project();
    let mut baking = Baking::default();
    baking.start(&document, Settings { patch_length: Some(-1.0), ..coarse() }).unwrap();
    let error = finished(&mut baking).unwrap_err();
    assert!(error.contains("patch length"), "{error}");
}

/// Writes down what it is told.
#[derive(Default)]
struct Stages(std::sync::Mutex<Vec<String>>);

impl bake::Watcher for Stages {
    fn stage(&self, name: &str, _: u64) {
        self.0.lock().unwrap().push(name.to_owned());
    }
}

#[test]
fn it_is_known_how_long_every_stage_of_a_bake_takes() {
    let folder = tempfile::tempdir().unwrap();
    let sample = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../projects/cornell");
    for file in ["project.ron", "scenes/cornell.ron", "assets/cornell.obj", "assets/cornell.mtl"] {
        let to = folder.path().join(file);
        std::fs::create_dir_all(to.parent().unwrap()).unwrap();
        std::fs::copy(sample.join(file), to).unwrap();
    }
    let stages = Stages::default();
    let few = Settings { patch_length: Some(0.2), ..coarse() };
    bake::bake(folder.path(), None, &few, &stages).unwrap();
    let stages = stages.0.into_inner().unwrap();
    assert!(stages.len() >= 8, "{stages:?}");
    for stage in stages {
        assert!(baking::Meter::knows(&stage), "{stage}");
    }
}
