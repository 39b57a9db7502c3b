//! A mesh: its source, its materials, and how it takes part in the light.

use eframe::egui::{ComboBox, RichText, Ui};
use engine::scene::shape::Shape;
use engine::scene::{Density, Entity, EntityId, Material, MaterialId, MeshRenderer, MeshSource, Reflection};

use super::component::{Can, component};
use super::fields::{self, Number};
use super::reflections;
use super::subject::Subject;
use crate::ask::Asks;
use crate::document::Document;
use crate::edit::Field;
use crate::icons::Icon;

const SHAPES: [(Shape, &str); 5] = [
    (Shape::Cube, "Cube"),
    (Shape::Sphere, "Sphere"),
    (Shape::Cylinder, "Cylinder"),
    (Shape::Plane, "Plane"),
    (Shape::Quad, "Quad"),
];

pub type Meshes<'a> = Subject<'a, EntityId, MeshRenderer>;

pub fn show<'a>(ui: &mut Ui, document: &Document, entities: &[&'a Entity], asks: &'a mut Asks) {
    let field = |mesh| Field::Mesh(Some(Box::new(mesh)));
    let mut of = Subject::component(entities, |e| e.mesh.as_ref(), field, asks);
    if of.is_empty() {
        return;
    }
    // Which mesh and which materials is nobody's habit: these stay.
    let usual = of.first().map(|mesh| MeshRenderer {
        casts_shadows: true,
        density: Density::default(),
        reflection: Reflection::default(),
        ..mesh.clone()
    });
    let can = Can { reset: entities.len() == 1, ..Can::all(of.can_paste(ui)) };
    of = usual.into_iter().fold(of, Subject::usually);
    let wish = component(ui, Icon::Mesh, "Mesh", can, |ui| {
        source(ui, &mut of);
        let slots = of.shared(|mesh| mesh.materials.len()).unwrap_or(0);
        for slot in 0..slots {
            material(ui, &mut of, document, slot, slots);
        }
        let shadows = "Blocks the light of lamps and suns";
        of.toggle(ui, ("Casts shadows", shadows), |m| m.casts_shadows, |m, on| m.casts_shadows = on);
        let density = "Patches along an edge, against the scene's: 2 halves their size. What is brushed on comes on top";
        let number = Number { least: 1.0 / 16.0, most: 16.0, relative: true, ..Number::default() };
        of.number(
            ui,
            ("Density", density),
            &number,
            |m| m.density.scale.into(),
            |m, v| m.density.scale = v as f32,
        );
        let reflections = "Of what reflection probes show on it";
        let number = Number { least: 0.0, most: 4.0, ..Number::share() };
        of.number(
            ui,
            ("Reflections", reflections),
            &number,
            |m| m.reflection.strength.into(),
            |m, v| {
                m.reflection.strength = v as f32;
            },
        );
        reflections::show(ui, &mut of, document);
    });
    of.fulfil(ui, wish, Field::Mesh(None));
}

/// Shapes can be exchanged; what came from a file is named.
fn source(ui: &mut Ui, of: &mut Meshes<'_>) {
    let shape = |mesh: &MeshRenderer| match mesh.mesh {
        MeshSource::Shape(shape) => Some(shape),
        MeshSource::File { .. } => None,
    };
    match of.shared(|mesh| mesh.mesh.clone()) {
        Some(MeshSource::File { file, mesh }) => {
            fields::row(ui, "Source", "The file that the mesh is read from", |ui| {
                ui.label(RichText::new(format!("{file}, mesh {mesh}"))).on_hover_text(file);
            })
        }
        _ if of.shared(|mesh| shape(mesh).is_some()) == Some(true) => {
            let set = |mesh: &mut MeshRenderer, shape: Shape| {
                mesh.mesh = MeshSource::Shape(shape);
                mesh.density.painted.clear();
            };
            of.choice(
                ui,
                ("Shape", "A metre across before it is scaled"),
                &SHAPES,
                |m| shape(m).unwrap_or(Shape::Cube),
                set,
            );
        }
        _ => fields::row(ui, "Source", "What is selected has different meshes", |ui| {
            ui.weak("\u{2014}");
        }),
    }
}

fn material(ui: &mut Ui, of: &mut Meshes<'_>, document: &Document, slot: usize, slots: usize) {
    let name = if slots == 1 { "Material".to_owned() } else { format!("Material {}", slot + 1) };
    let shared = of.shared(|mesh| mesh.materials[slot]);
    let named =
        |id: MaterialId| document.material(id).map_or("missing", |material: &Material| &material.name);
    let mut chosen = None;
    fields::row(ui, &name, "What its surface is made of; materials are shared", |ui| {
        let shown = ComboBox::from_id_salt(&name)
            .selected_text(shared.map_or("\u{2014}", named))
            .width(ui.available_width())
            .truncate()
            .show_ui(ui, |ui| {
                for material in &document.scene().materials {
                    if ui.selectable_label(shared == Some(material.id), &material.name).clicked() {
                        chosen = Some(material.id);
                    }
                }
            });
        let id = shown.response.id;
        ui.ctx().accesskit_node_builder(id, |node| node.set_label(name.clone()));
    });
    if let Some(id) = chosen {
        of.set_now(id, |mesh, id| mesh.materials[slot] = id);
    }
}
