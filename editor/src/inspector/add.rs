//! The button that gives what is selected another component.

use eframe::egui::{self, Ui};
use engine::scene::{Camera, Entity, Light, LightProbeGroup, ReflectionProbe};
use glam::Vec3;

use crate::ask::Asks;
use crate::edit::{Edit, Field};
use crate::intents::Intent;

/// What it is called, who has it already, and what is added.
type Entry = (&'static str, fn(&Entity) -> bool, fn() -> Field);

const ENTRIES: [Entry; 4] = [
    (
        "Light",
        |e| e.light.is_some(),
        || Field::Light(Some(Box::new(Light { intensity: 10.0, ..Light::default() }))),
    ),
    ("Camera", |e| e.camera.is_some(), || Field::Camera(Some(Box::new(Camera::default())))),
    (
        "Light probes",
        |e| e.light_probes.is_some(),
        || {
            let corner =
                |n: u32| Vec3::from([0, 1, 2].map(|axis| if n >> axis & 1 == 0 { -1.0 } else { 1.0 }));
            Field::LightProbes(Some(Box::new(LightProbeGroup { positions: (0..8).map(corner).collect() })))
        },
    ),
    (
        "Reflection probe",
        |e| e.reflection_probe.is_some(),
        || Field::ReflectionProbe(Some(Box::new(ReflectionProbe::default()))),
    ),
];

pub fn show(ui: &mut Ui, entities: &[&Entity], asks: &mut Asks) {
    ui.add_space(8.0);
    ui.vertical_centered(|ui| {
        ui.menu_button("Add component", |ui| {
            for (name, has, field) in ENTRIES {
                let lacks: Vec<&&Entity> = entities.iter().filter(|entity| !has(entity)).collect();
                if ui.add_enabled(!lacks.is_empty(), egui::Button::new(name)).clicked() {
                    let set = lacks.iter().map(|entity| (entity.id, field())).collect();
                    let title = format!("Add {}", name.to_lowercase());
                    asks.push(Intent::Commit(Edit::several(title, [Edit::Set(set)])));
                    ui.close();
                }
            }
        });
    });
    ui.add_space(8.0);
}
