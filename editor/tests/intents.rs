//! What panels wish for, carried out on the scene, and what is refused told in the console.

use editor::document::Document;
use editor::edit::{Edit, Field};
use editor::intents::{Intent, Session};
use editor::log::{Level, Log, Source};
use editor::primitives::{self, Primitive};
use engine::scene::{EntityId, Transform};
use glam::DVec3;
use tempfile::TempDir;

const FLOOR: EntityId = EntityId(1);
const CUBE: EntityId = EntityId(2);
const SUN: EntityId = EntityId(3);

fn session() -> (TempDir, Session) {
    let folder = tempfile::tempdir().unwrap();
    let document =
        Document::new_project(&folder.path().join("project"), "main", primitives::first_scene()).unwrap();
    (folder, Session::new(document, Log::default()))
}

fn moved(x: f64) -> Edit {
    Edit::set(CUBE, Field::Transform(Box::new(Transform::at(DVec3::X * x))))
}

#[test]
fn a_person_creates_moves_parents_duplicates_and_takes_all_of_it_back() {
    let (_folder, mut session) = session();
    let before = session.document.scene().clone();
    session.carry_out([Intent::Create {
        primitive: Primitive::Cube,
        place: DVec3::X,
        size: 1.0,
        parent: None,
    }]);
    let cube = session.selection.active().unwrap();
    session.carry_out([
        Intent::Begin("Move".to_owned()),
        Intent::Preview(moved(3.0)),
        Intent::Preview(moved(4.0)),
        Intent::End,
    ]);
    session.carry_out([
        Intent::Reparent { ids: vec![cube], parent: Some(SUN), before: None },
        Intent::Duplicate,
    ]);
    let copy = session.selection.active().unwrap();
    assert_ne!(copy, cube);
    assert_eq!(session.document.children(Some(SUN)), [cube, copy]);
    let name = |session: &Session, id| session.document.entity(id).unwrap().name.clone();
    assert_eq!((name(&session, cube), name(&session, copy)), ("Cube 2".to_owned(), "Cube 3".to_owned()));
    session.carry_out([Intent::Undo, Intent::Undo, Intent::Undo, Intent::Undo, Intent::Undo]);
    assert!(*session.document.scene() == before && !session.document.is_dirty());
    session.carry_out([Intent::Redo, Intent::Redo, Intent::Redo, Intent::Redo]);
    assert_eq!(session.document.entity(CUBE).unwrap().transform.translation.x, 4.0);
    assert!(session.document.entity(copy).is_some() && !session.document.can_redo());
}

#[test]
fn what_is_refused_is_told_once_and_leads_to_its_entity() {
    let (_folder, mut session) = session();
    let before = session.document.scene().clone();
    session.carry_out([
        Intent::Commit(moved(f64::NAN)),
        Intent::Reparent { ids: vec![SUN], parent: Some(SUN), before: None },
        Intent::Paste { text: "nonsense".to_owned(), parent: None },
    ]);
    let errors = session.log.filtered(&[Level::Error], "");
    assert_eq!(errors.len(), 3, "{errors:?}");
    assert_eq!(errors[0].source, Source::Entity(CUBE));
    assert_eq!(*session.document.scene(), before);
    // A drag that was left open ends in something that no file may hold: undo takes it back and says why.
    session.carry_out([Intent::Preview(moved(f64::NAN)), Intent::Undo]);
    assert_eq!(session.log.count(Level::Error), 4);
    assert_eq!(*session.document.scene(), before);
}

#[test]
fn hidden_locked_and_static_are_set_and_shown_again() {
    let (_folder, mut session) = session();
    session.carry_out([
        Intent::Reparent { ids: vec![CUBE], parent: Some(FLOOR), before: None },
        Intent::Static { ids: vec![FLOOR], is_static: false, with_children: true },
    ]);
    assert!(session.document.scene().entities.iter().all(|entity| !entity.is_static));
    session.carry_out([Intent::Isolate(vec![CUBE])]);
    let hidden = |session: &Session| {
        let hidden = session.document.scene().entities.iter().filter(|entity| entity.hidden);
        hidden.map(|entity| entity.id).collect::<Vec<_>>()
    };
    assert_eq!(hidden(&session), [SUN, EntityId(4)], "what carries it stays");
    session.carry_out([Intent::ShowAll, Intent::Hide { ids: vec![SUN], hidden: true }]);
    assert_eq!(hidden(&session), [SUN]);
    session.carry_out([Intent::Lock { ids: vec![FLOOR], locked: true }, Intent::SelectAll]);
    assert_eq!(session.selection.ids(), [CUBE, SUN, EntityId(4)]);
    session.carry_out([Intent::Select(vec![SUN]), Intent::InvertSelection]);
    assert_eq!(session.selection.ids(), [CUBE, EntityId(4)]);
}

#[test]
fn what_is_cut_is_pasted_again_and_what_is_deleted_is_not_selected() {
    let (_folder, mut session) = session();
    session.carry_out([Intent::Select(vec![SUN]), Intent::Cut]);
    assert!(session.document.entity(SUN).is_none() && session.selection.is_empty());
    assert_eq!(session.log.count(Level::Warning), 1, "the sky's sun is gone");
    let text = session.copied.take().unwrap();
    session.carry_out([Intent::Paste { text, parent: Some(CUBE) }]);
    let sun = session.selection.active().unwrap();
    assert!(session.document.entity(sun).unwrap().light.is_some());
    assert_eq!(session.document.children(Some(CUBE)), [sun]);
    session.carry_out([Intent::Undo, Intent::Undo]);
    assert!(session.selection.is_empty() && session.document.entity(SUN).is_some());
}
