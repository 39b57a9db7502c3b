//! The scene view in the hand: handles, snapping, what lies under the mouse, what the picture shows, play.

use crate::window::{Window, open};
use editor::edit::{Edit, Field};
use editor::intents::Intent;
use egui::accesskit::Toggled;
use egui::{Key, Modifiers, PointerButton, Pos2, vec2};
use egui_kittest::kittest::{NodeT, Queryable};
use engine::render::View;
use engine::scene::{EntityId, ReflectionProbe, Transform};
use glam::DVec3;

fn cube_at(window: &mut Window, place: DVec3) -> EntityId {
    let id = window.made(|window| window.choose("Create", "Create cube"));
    let transform = Transform { scale: DVec3::splat(0.2), ..Transform::at(place) };
    window.editor_mut().session.commit(Edit::set(id, Field::Transform(Box::new(transform))));
    window.settle();
    id
}

#[test]
fn a_number_typed_while_a_handle_is_pulled_is_what_it_is_pulled_by() {
    let Some(mut window) = open() else { return };
    let id = window.made(|window| window.choose("Create", "Create cube"));
    window.press(Modifiers::NONE, Key::F);
    let (before, steps) = (window.entity(id).transform.translation, window.steps());
    let view = window.editor().scene.camera;
    let reach = window.lens().metres_per_point(window.stand().origin) * 60.0;
    let from = window.seen_at(window.stand().origin + DVec3::X * reach);
    window.hold(from, &[from + vec2(30.0, 5.0)]);
    window.type_text("-1");
    window.type_text(".25");
    assert_eq!(window.entity(id).transform.translation, before - DVec3::X * 1.25);
    window.press(Modifiers::NONE, Key::Backspace);
    assert_eq!(window.entity(id).transform.translation, before - DVec3::X * 1.2);
    // The digits are the pull's: no view of the numbers is chosen, and Enter ends it while the button is down.
    window.type_text("1");
    window.press(Modifiers::NONE, Key::Num1);
    assert_eq!(window.editor().scene.camera, view);
    window.press(Modifiers::NONE, Key::Enter);
    window.release(from + vec2(90.0, 40.0));
    assert_eq!(window.entity(id).transform.translation, before - DVec3::X * 1.21);
    assert_eq!(window.steps(), steps + 1);
}

#[test]
fn while_v_is_held_a_vertex_goes_to_the_vertex_under_the_mouse() {
    let Some(mut window) = open() else { return };
    let target = cube_at(&mut window, DVec3::new(0.1, 0.3, 0.5));
    let moved = cube_at(&mut window, DVec3::new(-0.25, 0.1, 0.5));
    window.select(&[target, moved]);
    window.press(Modifiers::NONE, Key::F);
    window.select(&[moved]);
    let steps = window.steps();
    let corner = |middle: DVec3| middle + DVec3::splat(0.1);
    let [from, to] = [moved, target]
        .map(|id| corner(window.entity(id).transform.translation))
        .map(|at| window.seen_at(at));
    window.harness.key_down(Key::V);
    window.settle();
    assert!(window.editor().scene.handling.vertex);
    window.hold(from + vec2(2.0, 1.0), &[from.lerp(to, 0.5), to + vec2(3.0, -2.0)]);
    window.settle();
    window.release(to + vec2(3.0, -2.0));
    window.harness.key_up(Key::V);
    window.settle();
    let [moved, target] = [moved, target].map(|id| window.entity(id).transform.translation);
    assert!(moved.abs_diff_eq(target, 1e-6), "{moved} {target}: two cubes of one size, corner on corner");
    assert_eq!(window.steps(), steps + 1);
    assert!(!window.editor().scene.handling.vertex, "a key that was held is over with its release");
    window.press(Modifiers::NONE, Key::V);
    assert!(window.editor().scene.handling.vertex, "one that was tapped stays");
}

#[test]
fn what_is_dropped_stands_on_what_is_below() {
    let Some(mut window) = open() else { return };
    let id = cube_at(&mut window, DVec3::new(0.0, 0.9, 0.0));
    window.press(Modifiers::NONE, Key::PageDown);
    let place = window.entity(id).transform.translation;
    assert!(place.y > 0.05 && place.y < 0.9 && place.x == 0.0, "{place}");
    let once = place;
    window.press(Modifiers::NONE, Key::PageDown);
    assert!(window.entity(id).transform.translation.abs_diff_eq(once, 1e-6));
}

fn right_click(window: &mut Window, at: Pos2) {
    for pressed in [true, false] {
        let (button, modifiers) = (PointerButton::Secondary, Modifiers::NONE);
        window.harness.hover_at(at);
        window.harness.event(egui::Event::PointerButton { pos: at, button, pressed, modifiers });
        window.harness.step();
    }
    window.settle();
}

#[test]
fn a_right_click_lists_what_lies_under_the_mouse_after_a_flight_too() {
    let Some(mut window) = open() else { return };
    let behind = cube_at(&mut window, DVec3::new(0.0, 0.5, 0.0));
    let before = cube_at(&mut window, DVec3::new(0.0, 0.5, 0.3));
    window.editor_mut().session.carry_out([Intent::Rename { id: behind, name: "behind".into() }]);
    window.editor_mut().session.carry_out([Intent::Rename { id: before, name: "before".into() }]);
    window.select(&[behind, before]);
    window.press(Modifiers::NONE, Key::F);
    window.press(Modifiers::NONE, Key::Num1);
    window.select(&[]);
    let at = window.seen_at(DVec3::new(0.02, 0.52, 0.3));
    // Looking about with the right button is no click, and does not swallow the next one.
    let (button, modifiers) = (PointerButton::Secondary, Modifiers::NONE);
    window.harness.hover_at(at);
    window.harness.event(egui::Event::PointerButton { pos: at, button, pressed: true, modifiers });
    window.harness.step();
    window.harness.hover_at(at + vec2(30.0, 0.0));
    window.harness.step();
    window.harness.hover_at(at);
    window.harness.event(egui::Event::PointerButton { pos: at, button, pressed: false, modifiers });
    window.settle();
    assert!(window.harness.query_by_label("Under the mouse").is_none());
    window.press(Modifiers::NONE, Key::Num1);
    right_click(&mut window, at);
    assert!(window.harness.query_by_label("Under the mouse").is_some());
    window.harness.get_all_by_label("behind").last().unwrap().click();
    window.settle();
    assert_eq!(window.selected(), [behind]);
}

#[test]
fn keys_choose_what_of_the_light_the_picture_shows() {
    let Some(mut window) = open() else { return };
    let keys = [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5, Key::Num6, Key::Num7, Key::Num8];
    let keys = keys.into_iter().chain([Key::Num9]);
    let views = [
        View::Composite,
        View::Direct,
        View::Indirect,
        View::Reflection,
        View::Albedo,
        View::Normal,
        View::Patches,
        View::Density,
        View::Headlight,
    ];
    for (key, view) in keys.zip(views) {
        window.press(Modifiers::ALT, key);
        assert_eq!(window.editor().scene.view, view);
        assert_eq!(window.editor().scene.picture.error, None);
    }
}

#[test]
fn a_light_at_the_eye_is_switched_in_the_bar_and_is_a_draw_mode_among_others() {
    let Some(mut window) = open() else { return };
    let is_on = |window: &Window| window.node("Headlight").accesskit_node().toggled() == Some(Toggled::True);
    assert!(!is_on(&window));
    window.click("Headlight");
    assert!(is_on(&window));
    assert_eq!(window.editor().scene.view, View::Headlight);
    assert_eq!(window.editor().scene.picture.error, None);
    window.press(Modifiers::ALT, Key::Num5);
    assert!(!is_on(&window));
    window.press(Modifiers::ALT, Key::Num9);
    window.click("Headlight");
    assert_eq!(window.editor().scene.view, View::Composite);
}

#[test]
fn edges_of_all_meshes_lie_over_the_picture_while_they_are_asked_for() {
    let Some(mut window) = open() else { return };
    window.until("settled", |window| window.editor().scene.picture.is_settled());
    let draws = |window: &Window| window.editor().scene.picture.drawn.draws;
    let without = draws(&window);
    window.press(Modifiers::ALT, Key::W);
    let meshes = window.editor().session.document.scene().entities.iter().filter(|e| e.mesh.is_some());
    let meshes = meshes.count() as u32;
    assert!(draws(&window) >= without + meshes, "{} {without} {meshes}", draws(&window));
    assert_eq!(window.editor().scene.picture.error, None);
    window.click("Wireframe");
    assert_eq!(draws(&window), without);
}

#[test]
fn a_selected_camera_shows_what_it_sees_and_is_looked_through() {
    let Some(mut window) = open() else { return };
    assert!(window.harness.query_by_label("Camera preview").is_none());
    let camera = window.named("camera");
    window.select(&[camera]);
    let rect = window.node("Camera preview").rect();
    assert!(window.scene_view().contains_rect(rect) && rect.width() > 100.0, "{rect}");
    window.press(Modifiers::NONE, Key::Num7);
    window.press(Modifiers::NONE, Key::Num0);
    let place = window.editor().session.document.world_from_local(camera).translation;
    assert!(window.editor().scene.camera.position().abs_diff_eq(place, 1e-6));
}

#[test]
fn a_reflection_probes_box_is_pulled_by_its_faces() {
    let Some(mut window) = open() else { return };
    let id = window.made(|window| window.choose("Create", "Create reflection probe"));
    let small = ReflectionProbe { half_size: glam::Vec3::splat(0.3), ..ReflectionProbe::default() };
    window.editor_mut().session.commit(Edit::set(id, Field::ReflectionProbe(Some(Box::new(small)))));
    window.settle();
    window.press(Modifiers::NONE, Key::F);
    let steps = window.steps();
    let middle = window.stand().origin;
    let [from, to] = [0.3, 0.5].map(|x| window.seen_at(middle + DVec3::X * x));
    window.drag(from, to);
    let probe = |window: &Window| window.entity(id).reflection_probe.clone().unwrap();
    let pulled = probe(&window);
    assert!((pulled.half_size.x - 0.4).abs() < 0.01 && (pulled.offset.x - 0.1).abs() < 0.01, "{pulled:?}");
    assert_eq!((pulled.half_size.y, pulled.offset.y), (0.3, 0.0));
    assert_eq!(window.steps(), steps + 1);
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(probe(&window).half_size.x, 0.3);
}

#[test]
fn the_scene_view_goes_on_during_play_which_pauses_and_goes_step_by_step() {
    let Some(mut window) = open() else { return };
    window.press(Modifiers::NONE, Key::F5);
    window.press(Modifiers::COMMAND, Key::Num2);
    assert!(window.harness.query_by_label("Scene view").is_some());
    let now = |window: &Window| (window.editor().scenery().time, window.editor().scene.picture.count);
    let (time, count) = now(&window);
    std::thread::sleep(std::time::Duration::from_millis(30));
    window.settle();
    assert!(now(&window).0 > time && now(&window).1 > count, "it plays and is drawn");
    let camera = window.editor().scene.camera;
    window.press(Modifiers::NONE, Key::Num7);
    assert_ne!(window.editor().scene.camera, camera, "and is moved through");

    window.press(Modifiers::NONE, Key::F6);
    let stopped = now(&window).0;
    std::thread::sleep(std::time::Duration::from_millis(30));
    window.settle();
    assert_eq!(now(&window).0, stopped);
    window.press(Modifiers::NONE, Key::F7);
    let stepped = now(&window).0;
    assert!(stepped > stopped && stepped < stopped + 0.1, "{stopped} {stepped}");
    window.settle();
    assert_eq!(now(&window).0, stepped);
    window.press(Modifiers::NONE, Key::F5);
    assert!(!window.editor().scenery().is_playing);
}
