//! Light probe groups and reflection probes.

use eframe::egui::Ui;
use engine::scene::{Entity, Faces, LightProbeGroup, ReflectionProbe, Refresh};
use glam::DVec3;

use super::arithmetic::Unit;
use super::component::{Can, component};
use super::fields::{self, Number};
use super::subject::Subject;
use crate::ask::Asks;
use crate::edit::Field;
use crate::icons::Icon;

const REFRESH: [(Refresh, &str); 3] = [
    (Refresh::Baked, "Baked"),
    (Refresh::OnChange, "When something changes"),
    (Refresh::EveryFrame, "Every picture"),
];
const FACES: [(Faces, &str); 2] = [(Faces::AllAtOnce, "All at once"), (Faces::Sliced, "One a picture")];
const RESOLUTIONS: [(u32, &str); 6] =
    [(16, "16"), (32, "32"), (64, "64"), (128, "128"), (256, "256"), (512, "512")];

pub fn light_probes<'a>(ui: &mut Ui, entities: &[&'a Entity], asks: &'a mut Asks) {
    let field = |group| Field::LightProbes(Some(Box::new(group)));
    let mut of = Subject::component(entities, |e| e.light_probes.as_ref(), field, asks);
    if of.is_empty() {
        return;
    }
    let count = of.shared(|group: &LightProbeGroup| group.positions.len());
    of = of.usually(super::add::eight_probes());
    let can = Can::all(of.can_paste(ui));
    let wish = component(ui, Icon::LightProbes, "Light probes", can, |ui| {
        fields::row(
            ui,
            "Probes",
            "Points at which the light from all around is known, for what moves",
            |ui| {
                ui.label(count.map_or("\u{2014}".to_owned(), |count| count.to_string()));
            },
        );
    });
    of.fulfil(ui, wish, Field::LightProbes(None));
}

pub fn reflection_probe<'a>(ui: &mut Ui, entities: &[&'a Entity], asks: &'a mut Asks) {
    let field = |probe| Field::ReflectionProbe(Some(Box::new(probe)));
    let mut of = Subject::component(entities, |e| e.reflection_probe.as_ref(), field, asks);
    if of.is_empty() {
        return;
    }
    of = of.usually(ReflectionProbe::default());
    let can = Can::all(of.can_paste(ui));
    let wish = component(ui, Icon::ReflectionProbe, "Reflection probe", can, |ui| {
        let size = "Of the box in which it is used, metres in its own space";
        let metres = Number { least: 0.001, ..Number::metres() };
        of.vector(
            ui,
            ("Size", size),
            &metres,
            |p| p.half_size.as_dvec3() * 2.0,
            |p, axis, v| {
                p.half_size[axis] = (v * 0.5) as f32;
            },
        );
        let get = |p: &ReflectionProbe| -> DVec3 { p.offset.as_dvec3() };
        let middle = "Middle of the box, from the probe, metres in its own space";
        of.vector(ui, ("Box offset", middle), &Number::metres(), get, |p, axis, v| p.offset[axis] = v as f32);
        let fade = Number { least: 0.0, ..Number::metres() };
        let blend = "Beyond the box, over which it fades. Thicker than a wall, it reaches the next room";
        of.number(
            ui,
            ("Fades over", blend),
            &fade,
            |p| p.blend_distance.into(),
            |p, v| p.blend_distance = v as f32,
        );
        let follows = "Reflections follow the walls of the box instead of lying at infinity";
        of.toggle(ui, ("Box projection", follows), |p| p.box_projection, |p, on| p.box_projection = on);
        let whole = Number { speed: 0.1, decimals: 0, least: -1000.0, most: 1000.0, ..Number::default() };
        let wins = "The higher one wins where boxes overlap";
        of.number(
            ui,
            ("Importance", wins),
            &whole,
            |p| p.importance.into(),
            |p, v| p.importance = v.round() as i32,
        );
        of.choice(
            ui,
            ("Resolution", "Pixels along a face of its cube"),
            &RESOLUTIONS,
            |p| p.resolution,
            |p, v| p.resolution = v,
        );
        of.choice(
            ui,
            ("Taken", "When its picture is taken anew"),
            &REFRESH,
            |p| p.refresh,
            |p, v| p.refresh = v,
        );
        of.choice(ui, ("Faces", "How many of the six at once"), &FACES, |p| p.faces, |p, v| p.faces = v);
        let near = Number { least: 0.0001, ..Number::positive(Unit::Metres) };
        of.number(
            ui,
            ("Near", "What is nearer is not seen, metres"),
            &near,
            |p| p.near.into(),
            |p, v| p.near = v as f32,
        );
    });
    of.fulfil(ui, wish, Field::ReflectionProbe(None));
}
