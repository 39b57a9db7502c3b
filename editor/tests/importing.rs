//! Files of others, brought in beside the editing.

mod models;

use std::path::{Path, PathBuf};

use editor::document::Document;
use editor::edit::{Edit, Field};
use editor::importing::{self, Failed, Job, Ready, Record, Stage};
use editor::{assets, primitives};
use engine::scene::import::settings::{ImportSettings, Normals, Structure, Up};
use engine::scene::{MeshSource, Transform};
use glam::{DVec3, Vec3};
use models::{glb, two_triangles};
use tempfile::TempDir;

fn project() -> (TempDir, Document) {
    let folder = tempfile::tempdir().unwrap();
    let document =
        Document::new_project(&folder.path().join("project"), "main", primitives::first_scene()).unwrap();
    (folder, document)
}

fn finished(mut job: Job) -> Result<Ready, Failed> {
    loop {
        if let Some(result) = job.poll() {
            return result;
        }
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
}

fn import(document: &Document, file: &Path, settings: ImportSettings) -> Result<Ready, Failed> {
    finished(Job::start(document.project(), file, settings).unwrap())
}

fn cornell() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../projects/cornell/assets/cornell.obj")
}

#[test]
fn an_obj_comes_in_with_what_it_refers_to_and_stands_where_it_was_dropped() {
    let (_folder, mut document) = project();
    let before = document.scene().clone();
    let ready = import(&document, &cornell(), ImportSettings::default()).unwrap();
    assert_eq!(ready.file, "assets/cornell/cornell.obj");
    assert!(document.project().join("assets/cornell/cornell.mtl").is_file());
    let (edit, root, record) = ready.place(&mut document, DVec3::new(1.0, 2.0, 3.0));
    document.commit(edit).unwrap();
    record.save(document.project(), "main").unwrap();
    assert_eq!(document.world_from_local(root).translation, DVec3::new(1.0, 2.0, 3.0));
    assert_eq!(document.children(Some(root)).len(), ready.scene.entities.len());
    let meshes = document.scene().entities.iter().filter_map(|entity| entity.mesh.as_ref());
    let in_file = meshes.filter(|mesh| matches!(mesh.mesh, MeshSource::File { .. }));
    assert!(
        in_file.clone().count() > 3
            && in_file.clone().all(|mesh| ready.assets.meshes.contains_key(&mesh.mesh))
    );
    assert_eq!(document.undo().as_deref(), Some("Import cornell"));
    assert_eq!(*document.scene(), before);

    let again = import(&document, &cornell(), ImportSettings::default()).unwrap();
    assert_eq!(again.file, "assets/cornell-2/cornell.obj", "a name that is taken is not taken again");
    let names: Vec<String> = assets::list(document.project()).into_iter().map(|asset| asset.file).collect();
    assert!(names.contains(&"assets/cornell-2/cornell.mtl".to_owned()) && names.len() == 6, "{names:?}");
}

#[test]
fn a_broken_file_is_told_and_changes_nothing() {
    let (folder, document) = project();
    let before = document.scene().clone();
    for (name, bytes) in [("a.glb", &b"glTF\x02\0\0\0"[..]), ("b.gltf", b"{}"), ("c.txt", b"hello")] {
        let file = folder.path().join(name);
        std::fs::write(&file, bytes).unwrap();
        let error = import(&document, &file, ImportSettings { scale: 2.0, ..Default::default() }).map(|_| ());
        assert!(error.as_ref().is_err_and(|told| told.to_string().contains(name)), "{error:?}");
        assert_eq!(assets::list(document.project()).len(), 0, "{name} left something behind");
    }
    let nowhere = import(&document, Path::new("/no/such/file.glb"), ImportSettings::default()).map(|_| ());
    assert!(nowhere.unwrap_err().to_string().contains("file.glb"));
    assert_eq!(*document.scene(), before);
    let left: Vec<_> =
        document.project().join("assets").read_dir().unwrap().flatten().map(|e| e.file_name()).collect();
    assert!(left.iter().all(|name| !name.to_string_lossy().starts_with('.')), "{left:?}");
}

#[test]
fn a_cancelled_import_leaves_nothing_behind() {
    let (_folder, document) = project();
    let job = Job::start(document.project(), &cornell(), ImportSettings::default()).unwrap();
    job.cancel();
    let result = finished(job);
    // It may have been done before it was told.
    if let Err(failed) = result {
        assert_eq!(failed, Failed::Cancelled);
        assert!(assets::list(document.project()).is_empty());
    }
    assert!(Stage::Copying < Stage::Done && Stage::Copying.share() < Stage::Loading.share());
}

#[test]
fn settings_scale_turn_and_join_what_is_imported() {
    let (folder, mut document) = project();
    let file = folder.path().join("two.obj");
    two_triangles(&file, 5.0);
    let settings = ImportSettings { scale: 0.1, up: Up::Z, ..ImportSettings::default() };
    let ready = import(&document, &file, settings).unwrap();
    let (edit, root, _) = ready.place(&mut document, DVec3::ZERO);
    document.commit(edit).unwrap();
    let low = document.children(Some(root))[0];
    let up = document.world_from_local(low).transform_vector3(DVec3::Z);
    assert!(up.abs_diff_eq(DVec3::Y * 0.1, 1e-12), "{up}");
    assert!(document.project().join("assets/two/two.obj.import.ron").is_file());

    let one = ImportSettings { structure: Structure::One, normals: Normals::Smooth, ..settings };
    let ready = import(&document, &file, one).unwrap();
    assert_eq!(ready.scene.entities.len(), 1);
    let renderer = ready.scene.entities[0].mesh.as_ref().unwrap();
    assert_eq!(renderer.materials.len(), 2);
    let mesh = &ready.assets.meshes[&renderer.mesh];
    mesh.validate().unwrap();
    assert_eq!((mesh.primitives.len(), mesh.positions.len()), (2, 6));
    let top = mesh.positions.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
    assert!((top.y - 0.5).abs() < 1e-6, "5 units up along Z are half a metre along Y: {top}");
    assert!(mesh.normals.iter().all(|normal| normal.abs_diff_eq(Vec3::Y, 1e-6)), "{:?}", mesh.normals);
}

#[test]
fn a_glb_keeps_its_hierarchy() {
    let (folder, mut document) = project();
    let file = folder.path().join("chain.glb");
    glb(&file, &["body", "arm", "hand"]);
    let ready = import(&document, &file, ImportSettings::default()).unwrap();
    let (edit, root, _) = ready.place(&mut document, DVec3::Y);
    document.commit(edit).unwrap();
    let names: Vec<&str> = document
        .indexed()
        .subtree(root)
        .iter()
        .map(|id| document.entity(*id).unwrap().name.as_str())
        .collect();
    assert_eq!(names, ["body", "arm", "hand"]);
    assert_eq!(document.world_from_local(root).translation, DVec3::Y);
}

#[test]
fn importing_again_takes_what_the_file_changed_and_keeps_what_the_user_did() {
    let (folder, mut document) = project();
    let file = folder.path().join("chain.glb");
    glb(&file, &["body", "arm", "hand"]);
    let ready = import(&document, &file, ImportSettings::default()).unwrap();
    let (edit, root, record) = ready.place(&mut document, DVec3::Y);
    document.commit(edit).unwrap();
    record.save(document.project(), "main").unwrap();
    let hand = *document.indexed().subtree(root).last().unwrap();
    let material = document.entity(hand).unwrap().mesh.as_ref().unwrap().materials[0];

    let moved = Transform::at(DVec3::X);
    let mut paint = document.material(material).unwrap().clone();
    paint.albedo.color = Vec3::X;
    document.commit(Edit::set(hand, Field::Transform(Box::new(moved)))).unwrap();
    document.commit(Edit::SetMaterials(vec![paint.clone()])).unwrap();

    let own = document.project().join(&ready.file);
    glb(&own, &["body", "arm", "hand"]);
    let ready = import(&document, &own, ImportSettings::default()).unwrap();
    assert_eq!(ready.file, record.file, "what lies in the project is read where it is");
    let records = Record::all(document.project(), "main", &ready.file);
    assert_eq!(records, std::slice::from_ref(&record));
    let (edit, same, warnings) = importing::reimport(&mut document, &records[0], &ready);
    assert!(warnings.is_empty() && same == record);
    let before = document.scene().clone();
    document.commit(edit).unwrap();
    assert_eq!(*document.scene(), before, "nothing in the file changed");

    glb(&own, &["body", "leg", "foot"]);
    let ready = import(&document, &own, ImportSettings::default()).unwrap();
    let (edit, next, warnings) = importing::reimport(&mut document, &record, &ready);
    document.commit(edit).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    let names: Vec<&str> = document
        .indexed()
        .subtree(root)
        .iter()
        .map(|id| document.entity(*id).unwrap().name.as_str())
        .collect();
    assert_eq!(names, ["body", "leg", "foot"]);
    assert_eq!(document.material(material), Some(&paint), "a colour by hand stays");
    document.undo();
    assert!(document.entity(hand).is_some() && *document.scene() == before);
    document.redo();

    let leg = document.children(Some(root))[0];
    document.commit(Edit::set(leg, Field::Transform(Box::new(moved)))).unwrap();
    glb(&own, &["body", "leg", "foot", "toe"]);
    let ready = import(&document, &own, ImportSettings::default()).unwrap();
    let (edit, _, _) = importing::reimport(&mut document, &next, &ready);
    document.commit(edit).unwrap();
    assert_eq!(document.entity(leg).unwrap().transform, moved, "a place by hand stays");
    let foot = document.children(Some(leg))[0];
    assert!(document.entity(foot).unwrap().mesh.is_none(), "the mesh went on to the toe");
    assert_eq!(document.children(Some(foot)).len(), 1);
    assert_eq!(document.world_from_local(root).translation, DVec3::Y, "the root stays where it was put");
}

#[test]
fn a_renamed_file_keeps_its_references_and_a_missing_one_is_relinked() {
    let (folder, mut document) = project();
    let file = folder.path().join("two.obj");
    two_triangles(&file, 5.0);
    let settings = ImportSettings { scale: 2.0, ..ImportSettings::default() };
    let ready = import(&document, &file, settings).unwrap();
    let (edit, _, _) = ready.place(&mut document, DVec3::ZERO);
    document.commit(edit).unwrap();
    document.save().unwrap();
    let project = document.project().to_owned();
    assert!(assets::missing(&project, document.scene()).is_empty());

    let elsewhere = assets::rename(&project, "assets/two", "assets/kit/pair").unwrap();
    assert_eq!(elsewhere, ["main"], "the saved scene names it");
    let missing = assets::missing(&project, document.scene());
    assert_eq!((missing.len(), missing[0].0.as_str(), missing[0].1.len()), (1, "assets/two/two.obj", 2));
    document.commit(assets::relink(document.scene(), "assets/two", "assets/kit/pair")).unwrap();
    assert!(assets::missing(&project, document.scene()).is_empty());
    document.undo();
    assert_eq!(assets::missing(&project, document.scene()).len(), 1);
    document.redo();
    assets::rename(&project, "assets/kit/pair/two.obj", "assets/kit/pair/three.obj").unwrap();
    assert!(project.join("assets/kit/pair/three.obj.import.ron").is_file(), "settings go along");

    for (from, to) in [
        ("assets/kit", "assets/../kit"),
        ("assets/kit", "elsewhere/kit"),
        ("project.ron", "assets/project.ron"),
        ("assets/kit/pair", "assets/kit"),
        ("assets/nothing", "assets/something"),
    ] {
        assert!(assets::rename(&project, from, to).is_err(), "{from} to {to}");
    }
    let unknown = assets::relink(document.scene(), "assets/nothing", "assets/x");
    document.commit(unknown).unwrap();
    assert_eq!(document.history().undo_names().count(), 2, "no reference, no step");
}
