//! The density brush, and the bake beside the editing.

use crate::window::{Window, open};
use editor::edit::{Edit, Field};
use egui::{Key, Modifiers, Pos2, vec2};
use egui_kittest::kittest::Queryable;
use engine::scene::{EntityId, Transform};
use glam::DVec3;

fn painted(window: &Window, id: EntityId) -> Vec<f32> {
    window.entity(id).mesh.as_ref().unwrap().density.painted.clone()
}

fn patches(window: &mut Window) -> usize {
    let revision = window.editor().session.document.revision();
    window.until("patches", |window| {
        let patching = window.editor().scene.patching();
        !patching.is_busy() && patching.patches().is_some()
    });
    assert_eq!(window.editor().session.document.revision(), revision);
    window.editor().scene.patching().patches().unwrap().count
}

/// The floor from above, with the brush in the hand.
fn brush() -> Option<(Window, EntityId, Pos2)> {
    let mut window = open()?;
    let floor = window.named("floor");
    let at = window.editor().session.document.world_from_local(floor).translation;
    window.select(&[floor]);
    window.press(Modifiers::NONE, Key::F);
    window.press(Modifiers::NONE, Key::Num7);
    let scenery = window.editor().scenery();
    let (low, high) = scenery.extent(|entity| entity.id == floor).unwrap();
    let corner = low.lerp(high, 0.12).with_y(at.y.max(high.y));
    window.press(Modifiers::NONE, Key::B);
    let place = window.seen_at(corner);
    Some((window, floor, place))
}

#[test]
fn a_stroke_of_the_brush_is_saved_in_the_mesh_is_one_step_and_makes_more_patches() {
    let Some((mut window, floor, from)) = brush() else { return };
    let (steps, before) = (window.steps(), patches(&mut window));
    assert!(before > 100, "{before}");
    window.hold(from, &[from + vec2(10.0, -3.0), from + vec2(25.0, -6.0)]);
    let during = painted(&window, floor);
    assert!(during.iter().any(|density| *density > 1.05), "{during:?}");
    window.release(from + vec2(25.0, -6.0));
    assert_eq!(window.steps(), steps + 1);
    assert_eq!(window.editor().session.document.history().undo_names().next(), Some("Paint density"));
    assert!(patches(&mut window) > before);
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(painted(&window, floor), Vec::<f32>::new());
    assert_eq!(patches(&mut window), before);
}

#[test]
fn strokes_erase_and_smooth_what_was_painted() {
    let Some((mut window, floor, from)) = brush() else { return };
    let way = [from + vec2(12.0, -3.0), from + vec2(3.0, 2.0), from + vec2(14.0, -2.0)];
    window.hold(from, &way);
    window.release(way[2]);
    let rough = painted(&window, floor);
    let spread = |painted: &[f32]| {
        let most = painted.iter().copied().fold(0.0, f32::max);
        most / painted.iter().copied().fold(f32::INFINITY, f32::min)
    };
    window.click("Smooth");
    window.editor_mut().scene.painting.brush.radius = 5.0;
    window.hold(from, &way);
    window.release(way[2]);
    let smooth = painted(&window, floor);
    assert!(spread(&smooth) < spread(&rough), "{rough:?} {smooth:?}");
    window.click("Erase");
    for _ in 0..8 {
        window.hold(from, &way);
        window.release(way[2]);
    }
    let erased = painted(&window, floor);
    let most = |painted: &[f32]| painted.iter().copied().fold(0.0, f32::max);
    assert!(most(&erased) < most(&smooth) && most(&erased) < 1.2, "{smooth:?} {erased:?}");
}

#[test]
fn brackets_change_the_size_of_the_brush_and_escape_gives_a_stroke_up() {
    let Some((mut window, floor, from)) = brush() else { return };
    let radius = |window: &Window| window.editor().scene.painting.brush.radius;
    let first = radius(&window);
    window.press(Modifiers::NONE, Key::CloseBracket);
    assert_eq!(radius(&window), first * 1.25);
    window.press(Modifiers::NONE, Key::OpenBracket);
    assert!((radius(&window) - first).abs() < 1e-12);
    let strength = window.editor().scene.painting.brush.strength;
    window.press(Modifiers::SHIFT, Key::OpenBracket);
    assert!(
        window.editor().scene.painting.brush.strength < strength && (radius(&window) - first).abs() < 1e-12
    );

    let steps = window.steps();
    window.hold(from, &[from + vec2(10.0, 0.0)]);
    window.settle();
    assert!(!painted(&window, floor).is_empty());
    window.press(Modifiers::NONE, Key::Escape);
    window.release(from);
    assert_eq!((painted(&window, floor), window.steps()), (Vec::new(), steps));
}

/// A bake of few patches.
fn coarse(window: &Window) {
    let project = window.editor().session.document.project().join("project.ron");
    let text = std::fs::read_to_string(&project).unwrap();
    std::fs::write(project, text.replace("quality: standard,", "quality: draft,")).unwrap();
}

fn is_relit(window: &Window) -> bool {
    let is_baking = window.harness.query_by_label("Cancel").is_some();
    !is_baking && !window.editor().stage().is_relighting()
}

#[test]
fn a_bake_goes_on_beside_the_editing_and_its_light_is_swapped_in_when_it_is_ready() {
    let Some(mut window) = open() else { return };
    coarse(&window);
    let cube = window.made(|window| window.choose("Create", "Create cube"));
    let transform = Transform { scale: DVec3::splat(0.2), ..Transform::at(DVec3::new(0.0, 0.7, 0.3)) };
    window.editor_mut().session.commit(Edit::set(cube, Field::Transform(Box::new(transform))));
    window.settle();
    assert!(window.harness.query_by_label("Not baked").is_some());
    let before = window.editor().stage().transport().patches.len();
    window.node("Bake").click();
    window.harness.step();
    window.harness.step();
    assert!(window.harness.query_by_label("Cancel").is_some(), "it is told how far it is");

    // Meanwhile the cube is moved, and pictures are drawn.
    let moved = Transform { translation: DVec3::new(0.2, 0.7, 0.3), ..transform };
    window.editor_mut().session.commit(Edit::set(cube, Field::Transform(Box::new(moved))));
    let count = window.editor().scene.picture.count;
    window.settle();
    assert!(window.editor().scene.picture.count > count);
    window.until("light", is_relit);
    window.settle();
    assert!(window.editor().stage().transport().patches.len() > before.max(50));
    assert_eq!(window.editor().scene.picture.error, None);
    assert!(window.editor().scenery().displaced.contains(&cube), "the bake has it where it was");
    assert!(window.harness.query_by_label("Bake is stale").is_some());

    // Where it was baked, all fits; a lamp is no matter of the bake.
    window.press(Modifiers::COMMAND, Key::Z);
    window.until("current", |window| window.harness.query_by_label("Light is current").is_some());
    assert!(!window.editor().scenery().displaced.contains(&cube));
    window.choose("Create", "Create point light");
    assert!(window.harness.query_by_label("Light is current").is_some());
}

#[test]
fn a_cancelled_bake_leaves_the_light_as_it_was() {
    let Some(mut window) = open() else { return };
    window.click("Bake");
    window.click("Cancel");
    window.until("over", is_relit);
    window.settle();
    assert!(window.harness.query_by_label("Not baked").is_some());
    assert!(window.editor().stage().transport().patches.is_empty());
}
