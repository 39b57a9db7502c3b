//! The button that gives what is selected another component: a new one, or the one that was copied.

use eframe::egui::{self, Ui};
use engine::scene::{Camera, Entity, EntityId, Light, LightProbeGroup, MaterialId, ReflectionProbe};
use glam::Vec3;

use super::{component, motion};
use crate::ask::Asks;
use crate::document::Document;
use crate::edit::{Edit, Field};
use crate::intents::Intent;
use crate::primitives;

/// Has an entity one?
type Has = fn(&Entity) -> bool;
/// What it is called, who has it already, and what is added.
type Entry = (&'static str, Has, fn() -> Field);

const ENTRIES: [Entry; 5] = [
    (
        "Light",
        |e| e.light.is_some(),
        || Field::Light(Some(Box::new(Light { intensity: 10.0, ..Light::default() }))),
    ),
    ("Camera", |e| e.camera.is_some(), || Field::Camera(Some(Box::new(Camera::default())))),
    ("Light probes", |e| e.light_probes.is_some(), || Field::LightProbes(Some(Box::new(eight_probes())))),
    (
        "Reflection probe",
        |e| e.reflection_probe.is_some(),
        || Field::ReflectionProbe(Some(Box::new(ReflectionProbe::default()))),
    ),
    ("Motion", |e| e.motion.is_some() || e.is_static, || Field::Motion(Some(Box::new(motion::spin())))),
];

/// The corners of two metres.
pub fn eight_probes() -> LightProbeGroup {
    let corner = |n: u32| Vec3::from([0, 1, 2].map(|axis| if n >> axis & 1 == 0 { -1.0 } else { 1.0 }));
    LightProbeGroup { positions: (0..8).map(corner).collect() }
}

pub fn show(ui: &mut Ui, document: &Document, entities: &[&Entity], asks: &mut Asks) {
    ui.add_space(8.0);
    ui.vertical_centered(|ui| {
        ui.menu_button("Add component", |ui| {
            mesh(ui, document, entities, asks);
            for (name, has, field) in ENTRIES {
                entry(ui, name, lacking(entities, has), field(), asks);
            }
            if let Some((has, field)) = component::copied(ui).and_then(carried) {
                ui.separator();
                entry(ui, "What was copied", lacking(entities, has), field, asks);
            }
        });
    });
    ui.add_space(8.0);
}

fn lacking(entities: &[&Entity], has: Has) -> Vec<EntityId> {
    entities.iter().filter(|entity| !has(entity)).map(|entity| entity.id).collect()
}

fn entry(ui: &mut Ui, name: &str, lacking: Vec<EntityId>, field: Field, asks: &mut Asks) {
    let why_not = "What is selected has one already, or is static and never moves";
    let button = ui.add_enabled(!lacking.is_empty(), egui::Button::new(name));
    if button.on_disabled_hover_text(why_not).clicked() {
        let set = lacking.into_iter().map(|id| (id, field.clone())).collect();
        asks.push(Intent::Commit(Edit::several(format!("Add {}", name.to_lowercase()), [Edit::Set(set)])));
        ui.close();
    }
}

/// A cube, of the scene's first material: nothing is drawn without one.
fn mesh(ui: &mut Ui, document: &Document, entities: &[&Entity], asks: &mut Asks) {
    let lacking = lacking(entities, |entity| entity.mesh.is_some());
    if ui.add_enabled(!lacking.is_empty(), egui::Button::new("Mesh")).clicked() {
        let first = document.scene().materials.first();
        let (material, new) = match first {
            Some(material) => (material.id, None),
            None => {
                (MaterialId(1), Some(Edit::InsertMaterials(vec![(0, primitives::plaster(MaterialId(1)))])))
            }
        };
        let cube = Field::Mesh(Some(Box::new(primitives::cube(material))));
        let set = Edit::Set(lacking.into_iter().map(|id| (id, cube.clone())).collect());
        asks.push(Intent::Commit(Edit::several("Add mesh", new.into_iter().chain([set]))));
        ui.close();
    }
}

/// A component that was copied, and who has one like it. `None`: a transform, which everything has.
fn carried(copied: Field) -> Option<(Has, Field)> {
    let has: Has = match &copied {
        Field::Mesh(_) => |e| e.mesh.is_some(),
        Field::Light(_) => |e| e.light.is_some(),
        Field::Camera(_) => |e| e.camera.is_some(),
        Field::LightProbes(_) => |e| e.light_probes.is_some(),
        Field::ReflectionProbe(_) => |e| e.reflection_probe.is_some(),
        Field::Motion(_) => |e| e.motion.is_some(),
        _ => return None,
    };
    Some((has, copied))
}
