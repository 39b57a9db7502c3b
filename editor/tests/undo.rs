//! Random edits, undone and redone: the scene's file is the same, byte for byte.

use std::path::Path;

use editor::document::Document;
use editor::edit::{Edit, Field, Stale, copies, tree};
use editor::primitives::{self, Primitive};
use engine::scene::assets::Assets;
use engine::scene::file::{Quality, text_of_scene};
use engine::scene::{
    Density, Entity, EntityId, Light, LightProbeGroup, Material, MaterialId, MeshSource, Motion, Scene,
    Transform, shape,
};
use engine::transport::key::{BakeWith, Input, inputs};
use glam::{DQuat, DVec3, Vec3};
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

/// Numbers that choose an edit: of any scene they make one that it may refuse.
type Choice = (u8, u64, u64, f64);

fn text(document: &Document) -> String {
    text_of_scene(Path::new("scene"), document.scene()).unwrap()
}

/// The n-th entity, round and round.
fn any(document: &Document, n: u64) -> EntityId {
    let entities = &document.scene().entities;
    entities.get(n as usize % entities.len().max(1)).map_or(EntityId(0), |entity| entity.id)
}

fn any_material(document: &Document, n: u64) -> Option<Material> {
    let materials = &document.scene().materials;
    materials.get(n as usize % materials.len().max(1)).cloned()
}

fn edit(document: &mut Document, (kind, a, b, x): Choice) -> Edit {
    let (one, other) = (any(document, a), any(document, b));
    let set = |field| Edit::set(one, field);
    match kind {
        0 => set(Field::Name(format!("name {b}"))),
        1 => set(Field::Transform(Box::new(Transform {
            translation: DVec3::new(x, -x, 1.0),
            rotation: DQuat::from_rotation_y(x),
            scale: DVec3::splat(1.0 + x * x),
        }))),
        2 => set(Field::Static(b % 2 == 0)),
        3 => set(Field::Hidden(b % 2 == 0)),
        4 => set(Field::Light((b % 3 > 0).then(Box::default))),
        5 => set(Field::LightProbes(
            (b % 2 > 0).then(|| Box::new(LightProbeGroup { positions: vec![Vec3::X] })),
        )),
        6 => {
            set(Field::Density(Box::new(Density { scale: 2.0, painted: vec![x as f32; (b % 50) as usize] })))
        }
        7 => set(Field::Motion(
            (b % 2 > 0).then(|| Box::new(Motion::Spin { axis: DVec3::Y, radians_per_second: x })),
        )),
        8 => tree::delete(document.indexed(), &[one, other]).0,
        9 | 10 => tree::reparent(document.indexed(), &[one], Some(other), None)
            .map_or(Edit::Set(vec![]), |made| made.0),
        11 => tree::reparent(document.indexed(), &[one], None, Some(other))
            .map_or(Edit::Set(vec![]), |made| made.0),
        12 if document.scene().entities.len() < 60 => {
            let mut new_id = document.id_giver();
            copies::duplicate(document.indexed(), &[one, other], &mut new_id)
        }
        13 => Edit::Sky(Box::new(if b % 2 > 0 { primitives::day() } else { Default::default() })),
        14 => {
            let Some(mut material) = any_material(document, a) else { return Edit::Set(vec![]) };
            material.albedo.color = Vec3::splat(x.abs() as f32 % 1.0);
            material.double_sided = b % 2 > 0;
            Edit::SetMaterials(vec![material])
        }
        15 => {
            let id = document.new_material_id();
            let new = Material { id, name: format!("m{b}"), ..Material::default() };
            Edit::several(
                "Assign",
                [Edit::InsertMaterials(vec![(b as usize % 3, new)]), set(Field::Materials(vec![id]))],
            )
        }
        16 => Edit::RemoveMaterials(vec![MaterialId(b as u32 % 5)]),
        _ => {
            let primitive = Primitive::ALL[b as usize % Primitive::ALL.len()];
            primitives::create(document, primitive, (DVec3::splat(x), 1.0), (a % 2 > 0).then_some(other)).0
        }
    }
}

fn choices(many: usize) -> impl Strategy<Value = Vec<Choice>> {
    prop::collection::vec((0..24u8, any_u64(), any_u64(), -3.0..3.0f64), many..=many)
}

fn any_u64() -> std::ops::Range<u64> {
    0..1000
}

/// Of so many cases, the same each time.
fn runner(cases: u32) -> TestRunner {
    let config = Config { cases, failure_persistence: None, ..Config::default() };
    TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha))
}

fn document(folder: &Path) -> Document {
    Document::new_project(&folder.join("project"), "main", primitives::first_scene()).unwrap()
}

#[test]
fn five_hundred_random_edits_undone_give_the_same_file_and_redone_the_same_again() {
    const STEPS: usize = 500;
    runner(3)
        .run(&choices(2 * STEPS), |choices| {
            let folder = tempfile::tempdir().unwrap();
            let mut document = document(folder.path());
            let (before, mut texts) = (text(&document), Vec::new());
            for (n, choice) in choices.into_iter().enumerate() {
                // Some are refused, and some change nothing.
                if texts.len() == STEPS {
                    break;
                }
                let made = edit(&mut document, choice);
                if n % 7 == 0 {
                    document.begin("Drag");
                    document.preview(Edit::set(EntityId(1), Field::Hidden(true)));
                    document.preview(made);
                    let _ = document.end(); // refused or not
                } else {
                    let _ = document.commit(made);
                }
                document.indexed().validate().map_err(TestCaseError::fail)?;
                document.scene().validate().map_err(|error| TestCaseError::fail(error.to_string()))?;
                if document.history().undo_names().count() > texts.len() {
                    texts.push(text(&document));
                }
            }
            let last = text(&document);
            prop_assert_eq!(texts.len(), STEPS);
            for expected in texts.iter().rev().skip(1).chain([&before]) {
                document.undo().unwrap();
                prop_assert_eq!(&text(&document), expected);
            }
            prop_assert!(document.undo().is_none() && !document.is_dirty());
            document.indexed().validate().map_err(TestCaseError::fail)?;
            while document.redo().is_some() {}
            prop_assert_eq!(text(&document), last);
            document.indexed().validate().map_err(TestCaseError::fail)?;
            document.history().validate().map_err(TestCaseError::fail)
        })
        .unwrap();
}

/// The baker's own list of what a bake depends on.
fn baked(scene: &Scene) -> Vec<Input> {
    let mut assets = Assets::default();
    for renderer in scene.entities.iter().filter_map(|entity| entity.mesh.as_ref()) {
        if let MeshSource::Shape(shape) = renderer.mesh {
            assets.meshes.entry(renderer.mesh.clone()).or_insert_with(|| shape::mesh(shape).into());
        }
    }
    let mut inputs = inputs(
        scene,
        &assets,
        &BakeWith { quality: Quality::Draft, rays: 1, length: 1.0 },
        &Default::default(),
    );
    inputs.iter_mut().for_each(|input| input.name.clear());
    inputs.sort_by_key(|input| (input.what as u8, input.entity));
    inputs
}

#[test]
fn no_edit_that_the_baker_minds_is_called_free() {
    let (mut free, mut dear) = (0, 0);
    let counts = (&mut free, &mut dear);
    let counts = std::cell::RefCell::new(counts);
    runner(8)
        .run(&choices(120), |choices| {
            let folder = tempfile::tempdir().unwrap();
            let mut document = document(folder.path());
            let mut before = baked(document.scene());
            for choice in choices {
                let made = edit(&mut document, choice);
                let revision = document.revision();
                let told = format!("{made:?}");
                let _ = document.commit(made);
                let after = baked(document.scene());
                let stale = document.stale_since(revision);
                prop_assert!(before == after || stale == Stale::Transport, "{stale:?}: {told}");
                let mut counts = counts.borrow_mut();
                *counts.0 += u32::from(stale < Stale::Transport);
                *counts.1 += u32::from(before != after);
                before = after;
            }
            Ok(())
        })
        .unwrap();
    println!("{free} edits were free, {dear} cost a bake");
    assert!(free > 100 && dear > 100, "both happen: {free} {dear}");
}

/// So many entities, each under the one before it by its number divided by ten.
fn crowd(many: u64) -> Scene {
    let light = |id: u64| id.is_multiple_of(3).then(Light::default);
    let parent = |id: u64| (id / 10 > 0).then_some(EntityId(id / 10));
    let entity = |id| Entity {
        id: EntityId(id),
        name: format!("entity {id}"),
        parent: parent(id),
        light: light(id),
        ..Entity::default()
    };
    Scene { entities: (1..=many).map(entity).collect(), ..Scene::default() }
}

#[test]
fn a_step_in_a_scene_of_five_thousand_holds_what_it_changed_and_no_more() {
    let folder = tempfile::tempdir().unwrap();
    let mut document = Document::new_project(&folder.path().join("p"), "main", crowd(5000)).unwrap();
    let scene_bytes = 5000 * size_of::<Entity>();
    let mut step = |make: &dyn Fn(&mut Document) -> Edit| {
        let before = document.history().bytes();
        let place = document.scene().entities.as_ptr();
        let made = make(&mut document);
        document.commit(made).unwrap();
        assert_eq!(document.scene().entities.as_ptr(), place, "the list stays where it is");
        document.history().bytes() - before
    };
    let id = EntityId(4321);
    assert!(step(&|_| Edit::set(id, Field::Name("other".to_owned()))) < 300);
    assert!(step(&|_| Edit::set(id, Field::Transform(Box::new(Transform::at(DVec3::X))))) < 500);
    assert!(step(&|_| Edit::set(id, Field::Light(Some(Box::default())))) < 500);
    assert!(step(&|document| tree::delete(document.indexed(), &[id]).0) < 3000);
    assert!(
        step(&|document| tree::reparent(document.indexed(), &[EntityId(4000)], Some(EntityId(3)), None)
            .unwrap()
            .0)
            < 1000
    );
    assert!(
        step(&|document| tree::reparent(
            document.indexed(),
            &[EntityId(4000)],
            Some(EntityId(3)),
            Some(EntityId(30))
        )
        .unwrap()
        .0) < 1000
    );
    let all: Vec<EntityId> = (1..=5000).map(EntityId).collect();
    assert!(
        step(&|_| Edit::Set(all.iter().map(|id| (*id, Field::Hidden(true))).collect())) < scene_bytes / 10
    );
    assert!(size_of::<Edit>() <= 64);
    assert!(size_of::<Field>() <= 40);
}

#[test]
fn undo_is_unlimited_until_its_memory_is_spent_and_then_the_oldest_steps_go() {
    let folder = tempfile::tempdir().unwrap();
    let mut document = Document::new_project(&folder.path().join("p"), "main", crowd(10)).unwrap();
    document.limit_history(64 << 10);
    for n in 0..2000 {
        document.commit(Edit::set(EntityId(1), Field::Name(format!("name {n}")))).unwrap();
        assert!(document.history().bytes() <= 64 << 10);
    }
    let kept = document.history().undo_names().count();
    assert_eq!(kept + document.history().spilled, 2000);
    assert!(kept > 100, "{kept}");
    assert!((0..kept).all(|_| document.undo().is_some()) && document.undo().is_none());
    assert_eq!(document.entity(EntityId(1)).unwrap().name, format!("name {}", 1999 - kept));
    assert!(document.is_dirty(), "the saved state is out of reach");
}
