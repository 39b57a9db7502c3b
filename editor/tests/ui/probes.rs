//! Light probes in the hand, and the tetrahedra between them.

use crate::window::{Window, open};
use egui::{Key, Modifiers, Pos2, vec2};
use egui_kittest::kittest::Queryable;
use engine::scene::EntityId;
use glam::{DVec3, Vec3};

/// A group at the corners of a box inside the scene's own, framed, with its probes in the hand.
fn probes() -> Option<(Window, EntityId)> {
    let mut window = open()?;
    let id = window.made(|window| window.choose("Create", "Create light probe group"));
    window.press(Modifiers::NONE, Key::F);
    window.press(Modifiers::NONE, Key::P);
    Some((window, id))
}

fn places(window: &Window, id: EntityId) -> Vec<DVec3> {
    let world = window.editor().session.document.world_from_local(id);
    let group = window.entity(id).light_probes.as_ref().unwrap();
    group.positions.iter().map(|position| world.transform_point3(position.as_dvec3())).collect()
}

fn seen(window: &Window, id: EntityId, probe: usize) -> Pos2 {
    window.seen_at(places(window, id)[probe])
}

fn chosen(window: &Window) -> Vec<usize> {
    window.editor().scene.probing.chosen.iter().copied().collect()
}

#[test]
fn a_probe_is_dragged_and_the_tetrahedra_follow_before_it_is_let_go() {
    let Some((mut window, id)) = probes() else { return };
    window.press(Modifiers::NONE, Key::T);
    let web = |window: &Window| window.editor().scene.net.web().clone();
    // The box has a group of its own, and all of them are joined.
    let last = |window: &Window| web(window).positions[web(window).positions.len() - 8..].to_vec();
    assert_eq!(last(&window), places(&window, id));
    assert!(web(&window).cells.len() > 5 && web(&window).edges.len() > 18);
    let (steps, before) = (window.steps(), places(&window, id));
    let from = seen(&window, id, 7);
    window.hold(from, &[from + vec2(20.0, -10.0), from + vec2(40.0, -20.0)]);
    window.settle();
    let during = places(&window, id);
    assert!(during[7].distance(before[7]) > 0.01 && during[..7] == before[..7], "{during:?}");
    assert_eq!(last(&window), during, "joined anew while the button is down");
    window.release(from + vec2(40.0, -20.0));
    assert_eq!((places(&window, id), window.steps()), (during, steps + 1));
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(places(&window, id), before);
    assert_eq!(last(&window), before);
}

#[test]
fn escape_gives_the_drag_of_a_probe_up() {
    let Some((mut window, id)) = probes() else { return };
    let (steps, before) = (window.steps(), places(&window, id));
    let from = seen(&window, id, 6);
    window.hold(from, &[from + vec2(30.0, 30.0)]);
    window.settle();
    assert_ne!(places(&window, id), before);
    window.press(Modifiers::NONE, Key::Escape);
    window.release(from + vec2(60.0, 60.0));
    assert_eq!((places(&window, id), window.steps()), (before, steps));
}

#[test]
fn probes_are_chosen_by_a_rectangle_copied_moved_by_the_arrow_and_deleted() {
    let Some((mut window, id)) = probes() else { return };
    // All of them, from a place where none is.
    let all: Vec<Pos2> = (0..8).map(|probe| seen(&window, id, probe)).collect();
    let low = all.iter().copied().reduce(|a, b| a.min(b)).unwrap() - vec2(16.0, 16.0);
    let high = all.iter().copied().reduce(|a, b| a.max(b)).unwrap() + vec2(16.0, 16.0);
    window.drag(low, high);
    assert_eq!(chosen(&window).len(), 8);
    window.click_at(all[0], Modifiers::NONE);
    assert_eq!(chosen(&window).len(), 8, "a click on one of them could begin to drag all");
    window.press(Modifiers::NONE, Key::Escape);
    window.click_at(all[5], Modifiers::NONE);
    assert_eq!(chosen(&window), [5]);

    window.press(Modifiers::COMMAND, Key::D);
    assert_eq!((places(&window, id).len(), chosen(&window)), (9, vec![8]));
    let place = places(&window, id)[8];
    let reach = window.lens().metres_per_point(place) * 60.0;
    let [from, to] = [place + DVec3::Y * reach, place + DVec3::Y * reach * 2.0].map(|at| window.seen_at(at));
    window.drag(from, to);
    let moved = places(&window, id)[8] - place;
    assert!((moved.y - reach).abs() < 0.1 * reach && moved.x.abs() + moved.z.abs() < 1e-5, "{moved}");
    window.press(Modifiers::NONE, Key::Delete);
    assert_eq!((places(&window, id).len(), chosen(&window).len()), (8, 0));
    assert!(window.editor().session.document.entity(id).is_some(), "the group stays");
}

#[test]
fn a_click_sets_a_probe_before_the_surface_under_it() {
    let Some((mut window, id)) = probes() else { return };
    window.editor_mut().scene.probing.offset = 0.1;
    window.press(Modifiers::NONE, Key::Home);
    window.press(Modifiers::NONE, Key::Num7);
    window.click("Add");
    let (at, before) = (window.seen_at(DVec3::new(0.25, 0.0, 0.3)), places(&window, id).len());
    window.click_at(at, Modifiers::NONE);
    assert_eq!((places(&window, id).len(), chosen(&window)), (before + 1, vec![before]));
    let new = places(&window, id)[before];
    assert!(window.seen_at(new).distance(at) < 12.0, "above what was clicked, seen from above");
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(places(&window, id).len(), before);
}

#[test]
fn a_box_is_filled_with_a_grid_in_one_step() {
    let Some((mut window, id)) = probes() else { return };
    let steps = window.steps();
    let [low, high] = [places(&window, id)[0], places(&window, id)[7]];
    window.editor_mut().scene.probing.spacing = (high.x - low.x) / 4.0;
    window.settle();
    window.click("Fill the box with a grid");
    assert_eq!((places(&window, id).len(), window.steps()), (125, steps + 1));
    window.press(Modifiers::NONE, Key::T);
    assert!(window.editor().scene.net.web().cells.len() >= 64 * 5);
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(places(&window, id).len(), 8);
}

#[test]
fn a_slice_goes_through_the_tetrahedra_and_is_dragged_by_its_handle() {
    let Some((mut window, _)) = probes() else { return };
    window.press(Modifiers::NONE, Key::Q);
    window.press(Modifiers::SHIFT, Key::T);
    let plane = |window: &Window| window.editor().scene.net.plane.unwrap();
    let all = window.editor().scene.net.web().positions.clone();
    let low = all.iter().copied().reduce(DVec3::min).unwrap();
    let high = all.iter().copied().reduce(DVec3::max).unwrap();
    let (middle, tall) = ((low + high) * 0.5, high.y - low.y);
    assert!(plane(&window).axis == 1 && (plane(&window).offset - middle.y).abs() < 1e-6);
    let heights = |window: &Window| -> Vec<f64> {
        window.editor().scene.net.slice().unwrap().cuts.iter().map(|cut| cut.at.y).collect()
    };
    assert!(heights(&window).len() >= 8 && window.editor().scene.net.slice().unwrap().triangles.len() >= 8);
    let cuts = &window.editor().scene.net.slice().unwrap().cuts;
    let held = cuts.iter().map(|cut| cut.at).sum::<DVec3>() / cuts.len() as f64;
    let grip = held + DVec3::Y * window.lens().metres_per_point(held) * 40.0;
    let [from, to] = [grip, grip + DVec3::Y * tall * 0.15].map(|at| window.seen_at(at));
    window.drag(from, to);
    assert!((plane(&window).offset - middle.y - tall * 0.15).abs() < 0.01 * tall, "{:?}", plane(&window));
    assert!(heights(&window).iter().all(|y| (y - plane(&window).offset).abs() < 1e-6));
    window.click("Slice across Z");
    assert!(plane(&window).axis == 2 && (plane(&window).offset - middle.z).abs() < 1e-6);
    window.press(Modifiers::SHIFT, Key::T);
    assert!(window.harness.query_by_label("Place of the slice").is_none());
}

#[test]
fn where_there_are_no_probes_the_bar_offers_to_make_some() {
    let Some(mut window) = open() else { return };
    let without = window.editor().session.document.scene().entities.iter().all(|e| e.light_probes.is_none());
    window.press(Modifiers::NONE, Key::P);
    if without {
        let id = window.made(|window| window.click("Create light probe group"));
        assert!(window.entity(id).light_probes.as_ref().unwrap().positions.contains(&Vec3::ONE));
    }
    assert!(window.harness.query_by_label("Add").is_some());
}
