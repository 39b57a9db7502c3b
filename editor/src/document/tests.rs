use engine::scene::shape::Shape;
use engine::scene::{Density, Light, Material, MeshRenderer, MeshSource, Motion, Reflection, Transform};
use glam::DVec3;

use super::*;
use crate::edit::{Field, copies, tree};
use crate::primitives::{self, Primitive};

const ROOT: EntityId = EntityId(1);
const CHILD: EntityId = EntityId(2);
const LAMP: EntityId = EntityId(3);

/// Below a file: nothing can be written there.
const NOWHERE: &str = "Cargo.toml/nowhere";

/// A static root with a static child, and a lamp beside them.
fn document() -> Document {
    let mesh = MeshRenderer {
        mesh: MeshSource::Shape(Shape::Cube),
        materials: vec![MaterialId(1)],
        casts_shadows: true,
        density: Density::default(),
        reflection: Reflection { anchor: Some(LAMP), ..Reflection::default() },
    };
    let entity = |id: EntityId, name: &str| Entity { id, name: name.to_owned(), ..Entity::default() };
    let wall = Entity { is_static: true, mesh: Some(mesh), ..entity(ROOT, "wall") };
    let child = Entity { parent: Some(ROOT), transform: Transform::at(DVec3::X), ..wall.clone() };
    let child = Entity { id: CHILD, name: "shelf".to_owned(), ..child };
    let lamp = Entity { light: Some(Light::default()), ..entity(LAMP, "lamp") };
    let material = Material { id: MaterialId(1), name: "paint".to_owned(), ..Material::default() };
    let scene = Scene { materials: vec![material], entities: vec![wall, child, lamp], ..Scene::default() };
    scene.validate().unwrap();
    Document::new(Path::new(NOWHERE), "test", scene, None, Notes::default())
}

fn moved(id: EntityId, x: f64) -> Edit {
    Edit::set(id, Field::Transform(Box::new(Transform::at(DVec3::X * x))))
}

fn names(document: &Document) -> Vec<&str> {
    document.scene().entities.iter().map(|entity| entity.name.as_str()).collect()
}

#[test]
fn an_edit_is_undone_and_redone_and_dirt_follows() {
    let mut document = document();
    let before = document.scene().clone();
    assert!(!document.is_dirty() && !document.can_undo());
    document.commit(Edit::set(ROOT, Field::Name("door".to_owned()))).unwrap();
    assert!(document.is_dirty());
    assert_eq!(document.undo().as_deref(), Some("Rename \"wall\""));
    assert!(!document.is_dirty() && *document.scene() == before);
    assert_eq!(document.redo().as_deref(), Some("Rename \"wall\""));
    assert!(document.is_dirty() && names(&document)[0] == "door");
    assert_eq!(document.redo(), None);
}

#[test]
fn a_drag_is_one_step_however_many_previews_it_has() {
    let mut document = document();
    let before = document.scene().clone();
    document.begin("Move wall");
    for x in 0..100 {
        document.preview(moved(ROOT, f64::from(x)));
    }
    assert!(document.is_dirty() && document.history().undo_names().count() == 0);
    document.end().unwrap();
    assert_eq!(document.entity(ROOT).unwrap().transform.translation.x, 99.0);
    assert_eq!(document.history().undo_names().collect::<Vec<_>>(), ["Move wall"]);
    document.undo();
    assert_eq!(*document.scene(), before);
}

#[test]
fn a_cancelled_drag_leaves_no_trace() {
    let mut document = document();
    let before = document.scene().clone();
    document.begin("Move");
    document.preview(moved(ROOT, 1.0));
    document.preview(moved(LAMP, 2.0));
    assert_eq!(document.entity(ROOT).unwrap().transform, Transform::default(), "previews replace each other");
    document.cancel();
    assert!(*document.scene() == before && !document.is_dirty() && !document.can_undo());
}

#[test]
fn a_click_that_moves_nothing_is_no_step() {
    let mut document = document();
    document.commit(moved(ROOT, 0.0)).unwrap();
    document.begin("Move");
    document.preview(moved(CHILD, 5.0));
    document.preview(moved(CHILD, 1.0));
    document.end().unwrap();
    assert!(!document.can_undo() && !document.is_dirty());
}

#[test]
fn what_a_file_could_not_hold_is_refused_and_changes_nothing() {
    let mut document = document();
    let before = document.scene().clone();
    let spin = Motion::Spin { axis: DVec3::Y, radians_per_second: 1.0 };
    for (edit, told) in [
        (moved(ROOT, f64::NAN), "position"),
        (Edit::set(ROOT, Field::Parent(Some(CHILD))), "ancestor"),
        (Edit::set(CHILD, Field::Parent(Some(EntityId(77)))), "parent"),
        (Edit::set(ROOT, Field::Motion(Some(Box::new(spin)))), "motion"),
        (Edit::Remove(vec![LAMP]), "anchor"),
        (Edit::RemoveMaterials(vec![MaterialId(1)]), "material"),
    ] {
        let error = document.commit(edit).unwrap_err().to_string();
        assert!(error.contains(told), "{error}");
        assert!(*document.scene() == before && !document.is_dirty() && !document.can_undo());
        document.indexed().validate().unwrap();
    }
}

#[test]
fn an_edit_of_what_is_not_there_does_nothing() {
    let mut document = document();
    let nobody = EntityId(1000);
    document.commit(Edit::set(nobody, Field::Hidden(true))).unwrap();
    document.commit(Edit::Remove(vec![nobody])).unwrap();
    document.commit(Edit::Order(vec![(nobody, 0)])).unwrap();
    document.commit(Edit::set(LAMP, Field::CastsShadows(false))).unwrap();
    assert!(!document.can_undo());
}

#[test]
fn a_lamp_is_free_and_a_wall_costs_a_bake() {
    let mut document = document();
    let mut stale = |edit: Edit| {
        let before = document.revision();
        document.commit(edit).unwrap();
        document.stale_since(before)
    };
    assert_eq!(stale(Edit::set(ROOT, Field::Name("x".to_owned()))), Stale::Nothing);
    assert_eq!(stale(moved(LAMP, 3.0)), Stale::Light);
    assert_eq!(stale(moved(ROOT, 3.0)), Stale::Transport);
    assert_eq!(stale(Edit::set(CHILD, Field::Static(false))), Stale::Transport);
    assert_eq!(stale(moved(CHILD, 3.0)), Stale::Light);
    assert_eq!(stale(Edit::Sky(Box::new(primitives::day()))), Stale::Transport);
    let mut paint = Material { id: MaterialId(1), name: "paint".to_owned(), ..Material::default() };
    paint.albedo.color.x = 0.5;
    assert_eq!(stale(Edit::SetMaterials(vec![paint.clone()])), Stale::Light);
    paint.double_sided = true;
    assert_eq!(stale(Edit::SetMaterials(vec![paint])), Stale::Transport);
    // What is hidden or shown beneath counts too.
    assert_eq!(stale(Edit::set(ROOT, Field::Hidden(true))), Stale::Transport);
    let before = document.revision();
    document.undo();
    assert_eq!(document.stale_since(before), Stale::Transport);
}

#[test]
fn deleting_tells_what_referred_to_it() {
    let mut document = document();
    let before = document.scene().clone();
    let (edit, warnings) = tree::delete(document.indexed(), &[LAMP]);
    assert_eq!(warnings.iter().map(|told| told.about.as_str()).collect::<Vec<_>>(), ["wall", "shelf"]);
    document.commit(edit).unwrap();
    let (edit, warnings) = tree::delete(document.indexed(), &[CHILD, ROOT]);
    assert!(warnings.is_empty());
    document.commit(edit).unwrap();
    assert!(document.scene().entities.is_empty());
    document.undo();
    document.undo();
    assert_eq!(*document.scene(), before);
    document.indexed().validate().unwrap();
}

#[test]
fn a_new_parent_keeps_the_place_in_the_world() {
    let mut document = document();
    let turned = Transform {
        translation: DVec3::new(1.0, 2.0, 3.0),
        rotation: glam::DQuat::from_rotation_y(0.7),
        scale: DVec3::splat(2.0),
    };
    document.commit(Edit::set(ROOT, Field::Transform(Box::new(turned)))).unwrap();
    let world = document.world_from_local(LAMP);
    let (edit, warnings) = tree::reparent(document.indexed(), &[LAMP], Some(ROOT), Some(CHILD)).unwrap();
    assert!(warnings.is_empty());
    document.commit(edit).unwrap();
    assert_eq!(document.children(Some(ROOT)), [LAMP, CHILD]);
    assert!(document.world_from_local(LAMP).abs_diff_eq(world, 1e-12));
    document.indexed().validate().unwrap();

    let told = tree::reparent(document.indexed(), &[ROOT], Some(LAMP), None).unwrap_err();
    assert!(told.contains("`wall`"), "{told}");
    let squeezed = Transform { scale: DVec3::new(1.0, 5.0, 1.0), ..turned };
    document.commit(Edit::set(ROOT, Field::Transform(Box::new(squeezed)))).unwrap();
    let tilt = Transform { rotation: glam::DQuat::from_rotation_x(0.5), ..Transform::default() };
    document.commit(Edit::set(LAMP, Field::Transform(Box::new(tilt)))).unwrap();
    let (_, warnings) = tree::reparent(document.indexed(), &[LAMP], None, None).unwrap();
    assert!(warnings[0].message.contains("sheared"), "{warnings:?}");
}

#[test]
fn order_among_siblings_takes_children_along() {
    let mut document = document();
    let (edit, _) = tree::reparent(document.indexed(), &[LAMP], None, Some(ROOT)).unwrap();
    document.commit(edit).unwrap();
    assert_eq!(names(&document), ["lamp", "wall", "shelf"]);
    let (edit, _) = tree::reparent(document.indexed(), &[ROOT], None, Some(LAMP)).unwrap();
    document.commit(edit).unwrap();
    assert_eq!(names(&document), ["wall", "shelf", "lamp"]);
    assert_eq!(document.history().undo_names().next(), Some("Reorder \"wall\""));
    document.undo();
    document.undo();
    assert_eq!(names(&document), ["wall", "shelf", "lamp"]);
}

#[test]
fn copies_have_names_of_their_own_and_refer_to_each_other() {
    let mut document = document();
    document.commit(tree::reparent(document.indexed(), &[LAMP], Some(ROOT), None).unwrap().0).unwrap();
    let mut next = 100;
    let mut new_id = || {
        next += 1;
        EntityId(next)
    };
    let edit = copies::duplicate(document.indexed(), &[ROOT, CHILD], &mut new_id);
    document.commit(edit).unwrap();
    assert_eq!(names(&document), ["wall", "shelf", "lamp", "wall 2", "shelf", "lamp"]);
    let copy = &document.scene().entities[4];
    assert_eq!(copy.parent, Some(document.scene().entities[3].id));
    let anchor = copy.mesh.as_ref().unwrap().reflection.anchor;
    assert_eq!(anchor, Some(document.scene().entities[5].id), "the copy refers to the copied lamp");
    assert_eq!(document.undo().as_deref(), Some("Duplicate \"wall\""));
    // Ids of what is gone are not given again.
    assert!(document.new_entity_id().0 > 103);
}

#[test]
fn everything_in_the_create_menu_makes_a_scene_that_a_file_can_hold() {
    let mut document = document();
    let before = document.scene().clone();
    for primitive in Primitive::ALL {
        let (edit, id) = primitives::create(&mut document, primitive, (DVec3::Y, 1.0), Some(ROOT));
        document.commit(edit).unwrap();
        if let Some(id) = id {
            let place = document.world_from_local(id).translation;
            assert!(place.abs_diff_eq(DVec3::Y, 1e-12), "{primitive:?} {place}");
        }
    }
    assert_eq!(document.scene().materials.len(), 2, "shapes share one material");
    while document.undo().is_some() {}
    assert_eq!(*document.scene(), before);
    primitives::first_scene().validate().unwrap();
}
