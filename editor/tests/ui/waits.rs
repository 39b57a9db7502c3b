//! Nothing makes the person wait: what the GPU, a disk or another renderer has to say is taken when it is there.

use crate::window::{Window, open};
use editor::edit::{Edit, Field};
use editor::intents::Intent;
use egui::{Event, Key, Modifiers, PointerButton, Pos2, vec2};
use engine::scene::{Entity, EntityId, Light, Transform};
use glam::DVec3;

/// Two cubes beside each other, and where they are seen.
fn two_cubes(window: &mut Window) -> [(EntityId, Pos2); 2] {
    let cubes = [-0.2, 0.2].map(|x| {
        let id = window.made(|window| window.choose("Create", "Create cube"));
        let transform = Transform { scale: DVec3::splat(0.2), ..Transform::at(DVec3::new(x, 0.5, 0.4)) };
        window.editor_mut().session.commit(Edit::set(id, Field::Transform(Box::new(transform))));
        id
    });
    window.select(&cubes);
    window.press(Modifiers::NONE, Key::F);
    window.select(&[]);
    window.until("settled", |window| window.editor().scene.picture.is_settled());
    cubes.map(|id| (id, window.seen_at(window.entity(id).transform.translation)))
}

/// In two pictures; what comes of it is not waited for.
fn click(window: &mut Window, at: Pos2, modifiers: Modifiers) {
    window.harness.hover_at(at);
    window.harness.step();
    for pressed in [true, false] {
        let button = PointerButton::Primary;
        window
            .harness
            .event_modifiers(Event::PointerButton { pos: at, button, pressed, modifiers }, modifiers);
        window.harness.step();
    }
}

/// What the window's own thread has waited for the GPU.
fn waits(window: &Window) -> u64 {
    window.editor().stage().gpu().waits_here()
}

#[test]
fn clicks_boxes_and_lists_are_answered_without_waiting_for_the_gpu() {
    let Some(mut window) = open() else { return };
    let [(left, at_left), (right, at_right)] = two_cubes(&mut window);
    let before = waits(&window);
    click(&mut window, at_left, Modifiers::NONE);
    window.settle();
    assert_eq!(window.selected(), [left]);
    window.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::A);
    assert!(window.selected().is_empty());
    let (low, high) = (at_left.min(at_right) - vec2(90.0, 90.0), at_left.max(at_right) + vec2(90.0, 90.0));
    window.drag(low, high);
    assert!([left, right].iter().all(|id| window.selected().contains(id)), "{:?}", window.selected());
    for pressed in [true, false] {
        let (button, modifiers) = (PointerButton::Secondary, Modifiers::NONE);
        window.harness.hover_at(at_right);
        window.harness.event(Event::PointerButton { pos: at_right, button, pressed, modifiers });
        window.harness.step();
    }
    window.settle();
    assert!(window.is_shown("Under the mouse"));
    assert_eq!(waits(&window), before);
    window.editor().stage().gpu().wait().unwrap();
    assert_eq!(waits(&window), before + 1, "one that waits is counted");
}

#[test]
fn what_is_asked_after_a_click_is_done_when_the_click_is_answered() {
    let Some(mut window) = open() else { return };
    let [(left, at_left), (right, at_right)] = two_cubes(&mut window);
    window.select(&[right]);
    click(&mut window, at_left, Modifiers::NONE);
    window.harness.key_press(Key::Delete);
    window.settle();
    let is_there = |window: &Window, id| window.editor().session.document.entity(id).is_some();
    assert!(!is_there(&window, left) && is_there(&window, right), "the one that was clicked is deleted");
    window.press(Modifiers::COMMAND, Key::Z);
    assert!(is_there(&window, left));
    window.select(&[]);
    click(&mut window, at_left, Modifiers::NONE);
    click(&mut window, at_right, Modifiers::SHIFT);
    window.settle();
    assert_eq!(window.selected(), [left, right]);
}

#[test]
fn a_click_on_what_is_gone_when_it_is_answered_selects_nothing() {
    let Some(mut window) = open() else { return };
    let [(left, at_left), _] = two_cubes(&mut window);
    click(&mut window, at_left, Modifiers::NONE);
    window.editor_mut().session.carry_out([Intent::Select(vec![left]), Intent::Delete]);
    window.settle();
    let selected = window.selected();
    assert!(selected.iter().all(|id| window.editor().session.document.entity(*id).is_some()), "{selected:?}");
    assert!(!selected.contains(&left));
    assert!(window.errors().is_empty(), "{:?}", window.errors());
}

/// What is submitted waits for what was submitted before: a picture that is drawn while a question waits for its turn
/// would make the question wait for it too.
#[test]
fn no_picture_is_drawn_while_a_click_waits_for_the_one_before() {
    let Some(mut window) = open() else { return };
    let [(left, at_left), _] = two_cubes(&mut window);
    let mut waited = 0;
    for n in 0..8 {
        window.select(&[]);
        // Another light: pictures until it has settled.
        let lamp = window.made(|window| window.choose("Create", "Create point light"));
        window.select(&[]);
        click(&mut window, at_left, if n % 2 == 0 { Modifiers::NONE } else { Modifiers::SHIFT });
        while window.editor().is_seeking() {
            let (was_behind, before) = (window.editor().is_behind(), window.editor().scene.picture.count);
            window.harness.step();
            if was_behind && window.editor().is_behind() {
                assert_eq!(window.editor().scene.picture.count, before);
                waited += 1;
            }
        }
        assert_eq!(window.selected(), [left]);
        window.select(&[lamp]);
        window.harness.key_press(Key::Delete);
        window.settle();
    }
    println!("{waited} pictures of the editor without a picture of the scene");
}

fn open_new_scene(window: &mut Window, name: &str) {
    window.press(Modifiers::COMMAND, Key::N);
    window.type_text(name);
    window.harness.key_press(Key::Enter);
    while !window.editor().is_opening() {
        window.harness.step();
    }
}

#[test]
fn another_document_is_opened_with_a_renderer_that_the_window_did_not_make() {
    let Some(mut window) = open() else { return };
    let here = std::thread::current().id();
    assert_eq!(window.editor().stage().made_on(), here, "the first, before there is a window");
    let before = waits(&window);
    open_new_scene(&mut window, "attic");
    window.harness.step();
    assert!(window.is_shown("Opening") || !window.editor().is_opening());
    window.until("it is opened", |window| window.editor().session.document.name() == "attic");
    assert_ne!(window.editor().stage().made_on(), here);
    assert_eq!((window.editor().scene.picture.error.clone(), waits(&window)), (None, before));
    window.until("settled", |window| window.editor().scene.picture.is_settled());
}

#[test]
fn opening_is_given_up_and_what_was_open_stays() {
    let Some(mut window) = open() else { return };
    let (before, name) = (window.scene_text(), window.editor().session.document.name().to_owned());
    open_new_scene(&mut window, "attic");
    window.harness.key_press(Key::Escape);
    window.harness.step();
    assert!(!window.editor().is_opening());
    std::thread::sleep(std::time::Duration::from_millis(300));
    window.settle();
    assert_eq!((window.scene_text(), window.editor().session.document.name()), (before, name.as_str()));
    assert!(window.told().contains("given up"), "{}", window.told());
    window.made(|window| window.choose("Create", "Create cube"));
}

#[test]
fn a_crowd_of_lamps_that_cast_shadows_comes_to_rest() {
    let Some(mut window) = open() else { return };
    let lamps = (0..20_u32).map(|n| {
        let place = DVec3::new(-0.4 + 0.2 * f64::from(n % 5), 0.9, -0.4 + 0.25 * f64::from(n / 5));
        let light = Light { casts_shadows: true, ..Light::default() };
        let id = EntityId(9000 + u64::from(n));
        let name = format!("lamp {n}");
        Entity { id, name, light: Some(light), transform: Transform::at(place), ..Entity::default() }
    });
    let at = window.editor().session.document.scene().entities.len();
    let edit = Edit::Insert(lamps.enumerate().map(|(n, lamp)| (at + n, lamp)).collect());
    assert!(window.editor_mut().session.commit(edit));
    let mut steps = 0;
    loop {
        window.harness.step();
        steps += 1;
        if window.harness.output().viewport_output[&egui::ViewportId::ROOT].repaint_delay
            > std::time::Duration::ZERO
        {
            break;
        }
        assert!(steps < 600, "{:?}", window.editor().scene.picture.drawn);
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    // At rest nothing is drawn any more.
    let count = window.editor().scene.picture.count;
    window.harness.run_steps(5);
    assert_eq!(window.editor().scene.picture.count, count);
    assert_eq!(window.editor().scene.picture.error, None);
}
