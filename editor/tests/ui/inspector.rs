//! The inspector: one field, many objects.

use crate::window::{Window, open};
use editor::edit::{Edit, Field};
use editor::intents::Intent;
use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;
use engine::scene::{EntityId, Material};
use glam::{DVec3, Vec3};

/// Three cubes, each of a material of its own, selected.
fn three_cubes(window: &mut Window) -> Vec<EntityId> {
    let ids: Vec<EntityId> =
        (0..3).map(|_| window.made(|window| window.choose("Create", "Create cube"))).collect();
    let session = &mut window.editor_mut().session;
    for (number, id) in ids.iter().enumerate() {
        let material = Material {
            id: session.document.new_material_id(),
            name: format!("paint {number}"),
            ..Material::default()
        };
        let at = session.document.scene().materials.len();
        let assigned = Edit::set(*id, Field::Materials(vec![material.id]));
        session.commit(Edit::several("Paint", [Edit::InsertMaterials(vec![(at, material)]), assigned]));
    }
    session.carry_out([Intent::Select(ids.clone())]);
    window.settle();
    ids
}

#[test]
fn three_objects_get_one_color_in_one_step() {
    let Some(mut window) = open() else { return };
    let ids = three_cubes(&mut window);
    let steps = window.editor().session.document.history().undo_names().count();
    window.enter("Color green", "1/4");
    let color = |window: &Window, id: EntityId| -> Vec3 {
        let document = &window.editor().session.document;
        let material = window.entity(id).mesh.as_ref().unwrap().materials[0];
        document.material(material).unwrap().albedo.color
    };
    for id in &ids {
        assert_eq!(color(&window, *id), Vec3::new(1.0, 0.25, 1.0));
    }
    assert_eq!(window.editor().session.document.history().undo_names().count(), steps + 1);
    window.press(egui::Modifiers::COMMAND, Key::Z);
    assert_eq!(color(&window, ids[1]), Vec3::ONE);
}

#[test]
fn a_number_field_takes_arithmetic_and_units_for_all_that_is_selected() {
    let Some(mut window) = open() else { return };
    let ids = three_cubes(&mut window);
    let first = window.entity(ids[0]).transform.translation;
    window.enter("Position Y", "2*30cm + 1");
    for id in &ids {
        let place: DVec3 = window.entity(*id).transform.translation;
        assert!((place.y - 1.6).abs() < 1e-9 && place.x == first.x, "{place}");
    }
    window.enter("Position Y", "nonsense");
    assert!((window.entity(ids[0]).transform.translation.y - 1.6).abs() < 1e-9);
}

#[test]
fn a_component_is_added_and_removed() {
    let Some(mut window) = open() else { return };
    let id = window.made(|window| window.choose("Create", "Create empty"));
    window.click("Add component");
    window.click("Light");
    assert!(window.entity(id).light.is_some());
    window.click("Remove the light");
    assert!(window.entity(id).light.is_none());
}

#[test]
fn a_color_is_picked_by_its_code_and_made_brighter_than_a_display() {
    let Some(mut window) = open() else { return };
    let lamp = window.made(|window| window.choose("Create", "Create point light"));
    let color = |window: &Window| window.entity(lamp).light.as_ref().unwrap().color;
    let steps = window.steps();
    window.harness.get_by_role_and_label(Role::ColorWell, "Color").click();
    window.settle();
    window.node("Color code").focus();
    window.settle();
    window.press(Modifiers::COMMAND, Key::A);
    window.type_text("#00ff00");
    window.press(Modifiers::NONE, Key::Enter);
    assert_eq!((color(&window), window.steps()), (Vec3::Y, steps + 1));
    window.enter("Color brightness", "2*2");
    assert_eq!((color(&window), window.steps()), (Vec3::Y * 4.0, steps + 2));
    // Pulled over the square to its corner of black: one step, and the hue is kept for the way back.
    let square = window.node("Color saturation and value").rect();
    window.drag(square.center(), square.left_bottom() + egui::vec2(1.0, -1.0));
    assert!(color(&window).max_element() < 0.02 && window.steps() == steps + 3, "{}", color(&window));
}
