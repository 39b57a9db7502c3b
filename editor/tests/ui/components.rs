//! Components as wholes: added, copied, pasted, reset, removed; and fields that go back to what they were at first.

use crate::window::{Window, open};
use editor::intents::Intent;
use editor::log::Level;
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;
use engine::scene::{EntityId, Motion};

fn empty(window: &mut Window) -> EntityId {
    window.made(|window| window.choose("Create", "Create empty"))
}

fn select(window: &mut Window, ids: &[EntityId]) {
    window.editor_mut().session.carry_out([Intent::Select(ids.to_vec())]);
    window.settle();
}

fn add(window: &mut Window, component: &str) {
    let button = window.harness.get_by_label("Add component");
    button.scroll_to_me();
    window.settle();
    window.click("Add component");
    // The last: heads of components may have the same name.
    window.harness.query_all_by_label(component).last().unwrap().click();
    window.settle();
}

fn press(window: &mut Window, name: &str) {
    window.harness.get_by_label(name).scroll_to_me();
    window.settle();
    window.click(name);
}

#[test]
fn every_component_is_added_and_removed_and_undo_brings_it_back() {
    let Some(mut window) = open() else { return };
    let id = empty(&mut window);
    let has = |window: &Window| {
        let entity = window.entity(id);
        [
            entity.mesh.is_some(),
            entity.light.is_some(),
            entity.camera.is_some(),
            entity.light_probes.is_some(),
            entity.reflection_probe.is_some(),
            entity.motion.is_some(),
        ]
    };
    let names = ["Mesh", "Light", "Camera", "Light probes", "Reflection probe", "Motion"];
    for (at, name) in names.into_iter().enumerate() {
        add(&mut window, name);
        let expected = [0, 1, 2, 3, 4, 5].map(|other| other <= at);
        assert_eq!(has(&window), expected, "{name}");
    }
    for (at, name) in names.into_iter().enumerate() {
        press(&mut window, &format!("Remove the {}", name.to_lowercase()));
        let told = window.editor().session.log.filtered(&[Level::Error], "");
        assert!(!has(&window)[at], "{name} {told:?}");
        window.press(Modifiers::COMMAND, Key::Z);
        assert!(has(&window)[at], "{name}");
    }
}

#[test]
fn a_copied_component_is_pasted_over_others_and_onto_what_has_none() {
    let Some(mut window) = open() else { return };
    let lamp = window.made(|window| window.choose("Create", "Create point light"));
    window.enter("Intensity", "42");
    press(&mut window, "More for the light");
    window.click("Copy the light");
    let others = [0, 1].map(|_| window.made(|window| window.choose("Create", "Create spot light")));
    select(&mut window, &others);
    press(&mut window, "More for the light");
    window.click("Paste its values");
    let bare = empty(&mut window);
    add(&mut window, "What was copied");
    let light = window.entity(lamp).light.clone();
    assert_eq!(light.as_ref().unwrap().intensity, 42.0);
    assert!(others.iter().chain([&bare]).all(|id| window.entity(*id).light == light));
}

#[test]
fn a_field_goes_back_to_what_it_was_at_first() {
    let Some(mut window) = open() else { return };
    let ids = [0, 1].map(|_| window.made(|window| window.choose("Create", "Create spot light")));
    select(&mut window, &ids);
    window.enter("Inner angle", "3");
    window.enter("Scale Y", "4");
    press(&mut window, "Reset inner angle");
    press(&mut window, "Reset scale");
    for id in ids {
        let entity = window.entity(id);
        assert_eq!(entity.transform.scale, glam::DVec3::ONE);
        let usual = engine::scene::LightKind::Spot { inner: 0.35, outer: 0.5 };
        assert_eq!(entity.light.as_ref().unwrap().kind, usual);
    }
    assert!(!window.is_shown("Reset scale"), "it is as at first");
    window.enter("Intensity", "1");
    press(&mut window, "More for the light");
    window.click("Reset all of it");
    assert_eq!(window.entity(ids[0]).light.as_ref().unwrap().intensity, 10.0);
}

#[test]
fn something_is_made_to_go_along_a_path_and_look_ahead() {
    let Some(mut window) = open() else { return };
    let id = empty(&mut window);
    add(&mut window, "Motion");
    press(&mut window, "Moves");
    window.click("Along a path");
    press(&mut window, "Add point");
    window.enter("Point 3 Y", "2");
    window.enter("There and back", "12");
    press(&mut window, "Looks ahead");
    let Some(Motion::PingPong { points, seconds, look }) = window.entity(id).motion.clone() else {
        panic!("{:?}", window.entity(id).motion)
    };
    assert!(points.len() == 3 && points[2].y == 2.0 && seconds == 12.0 && look);
    press(&mut window, "Moves");
    window.click("Turns");
    window.enter("Speed", "0.25 turn");
    let Some(Motion::Spin { radians_per_second, .. }) = window.entity(id).motion else { panic!() };
    assert!((radians_per_second - std::f64::consts::FRAC_PI_2).abs() < 1e-9);
}

#[test]
fn what_is_static_is_not_given_a_motion() {
    let Some(mut window) = open() else { return };
    let id = window.made(|window| window.choose("Create", "Create cube"));
    assert!(window.entity(id).is_static);
    add(&mut window, "Motion");
    assert!(window.entity(id).motion.is_none());
}

#[test]
fn values_that_differ_are_shown_as_such_and_stay_until_they_are_set() {
    let Some(mut window) = open() else { return };
    let ids = [0, 1].map(|_| window.made(|window| window.choose("Create", "Create point light")));
    let usual = window.entity(ids[0]).light.as_ref().unwrap().intensity;
    select(&mut window, &ids[1..]);
    window.enter("Intensity", "7");
    window.enter("Position X", "5");
    select(&mut window, &ids);
    let said = |window: &Window, field: &str| {
        let node = window.harness.get_by_role_and_label(egui::accesskit::Role::SpinButton, field);
        use egui_kittest::kittest::NodeT;
        node.accesskit_node().value().unwrap_or_default()
    };
    assert_eq!(said(&window, "Intensity"), "\u{2014}");
    assert_eq!(said(&window, "Position X"), "\u{2014}");
    window.enter("Position Y", "1");
    let [a, b] = ids.map(|id| window.entity(id).clone());
    assert_ne!(a.transform.translation.x, b.transform.translation.x);
    assert_eq!((a.transform.translation.y, b.transform.translation.y), (1.0, 1.0));
    assert_eq!([a, b].map(|entity| entity.light.unwrap().intensity), [usual, 7.0]);
}
