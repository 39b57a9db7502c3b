//! A document and its file: saved whole or not at all, kept for a crash, and watched for what others do.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use editor::document::{Document, Event, SaveError};
use editor::edit::{Edit, Field};
use editor::recovery;
use editor::watch::Changed;
use editor::{clipboard, primitives};
use engine::scene::file::{load_scene, scene_path};
use engine::scene::{EntityId, MeshSource};
use tempfile::TempDir;

const CUBE: EntityId = EntityId(2);

fn project() -> (TempDir, PathBuf, Document) {
    let folder = tempfile::tempdir().unwrap();
    let project = folder.path().join("project");
    let document = Document::new_project(&project, "main", primitives::first_scene()).unwrap();
    (folder, project, document)
}

fn rename(document: &mut Document, name: &str) {
    document.commit(Edit::set(CUBE, Field::Name(name.to_owned()))).unwrap();
}

fn name(document: &Document) -> &str {
    &document.entity(CUBE).unwrap().name
}

/// Ticks, a second of the document's time each, until this happened.
fn await_event(document: &mut Document, now: &mut Instant, wanted: impl Fn(&Event) -> bool) {
    loop {
        *now += Duration::from_secs(1);
        if document.tick(*now).iter().any(&wanted) {
            return;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn what_is_saved_and_opened_again_is_the_same() {
    let (_folder, project, mut document) = project();
    rename(&mut document, "die");
    document.save().unwrap();
    assert!(!document.is_dirty());
    let (again, warnings) = Document::open(&project, None).unwrap();
    assert!(again.scene() == document.scene() && warnings.is_empty() && again.name() == "main");
    document.undo();
    assert!(document.is_dirty(), "undo leads away from what was saved");
    document.redo();
    assert!(!document.is_dirty());
    document.save_as("other").unwrap();
    assert_eq!(document.name(), "other");
    assert!(matches!(document.save_as("main"), Err(SaveError::Exists { .. })));
    for broken in ["", "a/b", "..", "a?", " a"] {
        assert!(matches!(document.save_as(broken), Err(SaveError::Name(_))), "{broken}");
    }
    assert_eq!(document.name(), "other");
    assert!(Document::new_project(&project, "third", primitives::first_scene()).is_err());
}

#[test]
fn a_folder_that_cannot_be_written_keeps_the_document_dirty_and_says_so() {
    let (_folder, project, mut document) = project();
    rename(&mut document, "die");
    // A file where the folder of scenes was: nobody can write there, whoever they are.
    std::fs::remove_dir_all(project.join("scenes")).unwrap();
    std::fs::write(project.join("scenes"), "in the way").unwrap();
    let error = document.save().unwrap_err().to_string();
    assert!(document.is_dirty());
    assert!(error.contains("main.ron") && error.contains("not saved"), "{error}");
    document.save_in_background();
    let mut now = Instant::now();
    await_event(&mut document, &mut now, |event| matches!(event, Event::Saved(Err(SaveError::Disk { .. }))));
    assert!(document.is_dirty() && !document.is_saving());
    std::fs::remove_file(project.join("scenes")).unwrap();
    document.save().unwrap();
    assert!(!document.is_dirty());
}

#[test]
fn a_scene_of_a_newer_version_is_refused_and_left_untouched() {
    let (_folder, project, document) = project();
    drop(document);
    let newer = "(version: 99, scene: (materials: []), something: new)";
    std::fs::write(scene_path(&project, "main"), newer).unwrap();
    let error = Document::open(&project, None).err().unwrap().to_string();
    assert!(error.contains("version 99") && error.contains("main.ron"), "{error}");
    assert_eq!(std::fs::read_to_string(scene_path(&project, "main")).unwrap(), newer);
}

#[test]
fn what_another_program_wrote_is_noticed_not_overwritten_and_reloaded() {
    let (_folder, project, mut document) = project();
    let mut now = Instant::now();
    document.tick(now);
    let mut other = document.scene().clone();
    other.entities[1].name = "theirs".to_owned();
    rename(&mut document, "ours");
    engine::scene::file::save_scene(&project, "main", &other).unwrap();
    await_event(&mut document, &mut now, |event| matches!(event, Event::SceneChanged(Changed::Written)));
    assert!(matches!(document.save(), Err(SaveError::ChangedOutside { .. })));
    assert_eq!(load_scene(&project, "main").unwrap(), other, "left as it is");
    document.reload().unwrap();
    assert!(name(&document) == "theirs" && !document.is_dirty());
    document.undo();
    assert!(name(&document) == "ours" && document.is_dirty());
    document.save().unwrap();
    assert_eq!(load_scene(&project, "main").unwrap().entities[1].name, "ours");
}

#[test]
fn a_save_in_the_background_is_of_what_was_there_when_it_was_asked_for() {
    let (_folder, project, mut document) = project();
    rename(&mut document, "first");
    document.save_in_background();
    rename(&mut document, "second");
    let mut now = Instant::now();
    await_event(&mut document, &mut now, |event| matches!(event, Event::Saved(Ok(()))));
    assert!(document.is_dirty());
    assert_eq!(load_scene(&project, "main").unwrap().entities[1].name, "first");
    document.save_in_background();
    document.save_in_background();
    document.save().unwrap();
    assert!(!document.is_dirty());
    assert_eq!(load_scene(&project, "main").unwrap().entities[1].name, "second");
}

#[test]
fn work_that_was_not_saved_is_kept_every_minute_and_offered_at_the_next_start() {
    let (_folder, project, mut document) = project();
    rename(&mut document, "kept");
    let start = Instant::now();
    document.tick(start);
    document.tick(start + Duration::from_secs(59));
    document.tick(start + Duration::from_secs(61));
    rename(&mut document, "lost");
    // Killed: nothing of it runs any more.
    std::mem::forget(document);
    let path = recovery::path(&project, "main");
    while !path.is_file() {
        std::thread::sleep(Duration::from_millis(5));
    }
    let (mut document, warnings) = Document::open(&project, None).unwrap();
    assert!(warnings.is_empty() && name(&document) == "Cube");
    assert!(document.recovery().is_some());
    document.recover().unwrap();
    assert!(name(&document) == "kept" && document.is_dirty() && document.recovery().is_none());
    assert_eq!(document.history().undo_names().next(), Some("Recover"));
    document.save().unwrap();
    drop(document);
    assert!(!path.exists(), "a clean save needs no recovery");
    assert!(Document::open(&project, None).unwrap().0.recovery().is_none());
}

#[test]
fn a_panic_keeps_what_was_not_saved_and_a_chosen_end_does_not() {
    let (_folder, project, document) = project();
    drop(document);
    let crashed = std::panic::catch_unwind(|| {
        let (mut document, _) = Document::open(&project, None).unwrap();
        rename(&mut document, "kept");
        panic!("as a bug would");
    });
    assert!(crashed.is_err());
    let (mut document, _) = Document::open(&project, None).unwrap();
    document.recover().unwrap();
    assert_eq!(name(&document), "kept");
    document.close();
    assert!(!recovery::path(&project, "main").exists());
    let (mut document, _) = Document::open(&project, None).unwrap();
    assert!(document.recovery().is_none());
    rename(&mut document, "not wanted");
    document.close();
    assert!(Document::open(&project, None).unwrap().0.recovery().is_none());
}

#[test]
fn a_damaged_recovery_is_told_and_stops_nothing() {
    let (_folder, project, document) = project();
    drop(document);
    let path = recovery::path(&project, "main");
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    std::fs::write(&path, "(version: 1, sce").unwrap();
    let (document, warnings) = Document::open(&project, None).unwrap();
    assert!(document.recovery().is_none() && warnings.len() == 1, "{warnings:?}");
    assert!(warnings[0].message.contains("recovery"), "{warnings:?}");
}

#[test]
fn locks_are_noted_beside_the_project_and_not_in_the_scene() {
    let (_folder, project, mut document) = project();
    let before = std::fs::read_to_string(document.path()).unwrap();
    document.set_locked(&[CUBE], true);
    assert!(document.is_locked(CUBE) && !document.is_dirty());
    let given = document.new_entity_id();
    document.save().unwrap();
    assert_eq!(std::fs::read_to_string(document.path()).unwrap(), before);
    drop(document);
    let (mut document, _) = Document::open(&project, None).unwrap();
    assert!(document.is_locked(CUBE) && !document.is_locked(EntityId(1)));
    assert!(document.new_entity_id() > given, "an id is never given twice, in another session either");
}

#[test]
fn what_is_copied_can_be_pasted_here_and_into_another_project() {
    let (_folder, _, mut document) = project();
    let sun = EntityId(3);
    let mut mesh = document.entity(CUBE).unwrap().mesh.clone().unwrap();
    mesh.reflection.anchor = Some(sun);
    document.commit(Edit::set(CUBE, Field::Mesh(Some(Box::new(mesh.clone()))))).unwrap();
    let text = clipboard::copy(&document, &[CUBE]).unwrap();
    assert!(clipboard::can_paste(&text) && !clipboard::can_paste("a letter"));
    let (edit, top, warnings) = clipboard::paste(&mut document, &text, Some(sun)).unwrap();
    assert!(warnings.is_empty() && top.len() == 1);
    document.commit(edit).unwrap();
    let copy = document.entity(top[0]).unwrap();
    assert_eq!((copy.parent, copy.mesh.as_ref()), (Some(sun), Some(&mesh)), "the same material and anchor");

    let (_folder, _, mut other) = project();
    other.commit(Edit::Remove(vec![CUBE])).unwrap();
    let materials = other.scene().materials.len();
    mesh.mesh = MeshSource::File { file: "assets/gone.glb".to_owned(), mesh: 0 };
    document.commit(Edit::set(CUBE, Field::Mesh(Some(Box::new(mesh))))).unwrap();
    let text = clipboard::copy(&document, &[CUBE]).unwrap();
    let (edit, top, warnings) = clipboard::paste(&mut other, &text, None).unwrap();
    assert_eq!(warnings.len(), 2, "the anchor and the file: {warnings:?}");
    other.commit(edit).unwrap();
    assert_eq!(other.entity(top[0]).unwrap().mesh.as_ref().unwrap().reflection.anchor, None);
    assert_eq!(other.scene().materials.len(), materials, "the same plaster is there");
}

#[test]
fn what_no_copy_made_is_refused_by_paste() {
    let (_folder, _, mut document) = project();
    let before = document.scene().clone();
    let text = clipboard::copy(&document, &[CUBE]).unwrap();
    let nan = text.replace("translation: (0.0, 0.5, 0.0)", "translation: (NaN, 0.5, 0.0)");
    assert_ne!(nan, text);
    for broken in [
        "hohlraum_clipboard",
        "",
        &text[..text.len() / 2],
        &text.replace("hohlraum_clipboard: 1", "hohlraum_clipboard: 2"),
        &text.replace("materials: [1]", "materials: [77]"),
        &nan,
    ] {
        assert!(clipboard::paste(&mut document, broken, None).is_err(), "{broken}");
    }
    assert_eq!(*document.scene(), before);
}
