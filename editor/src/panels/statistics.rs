//! What pictures cost, and what of the scene there is.

use eframe::egui;
use egui::{Grid, RichText, ScrollArea, Ui};

use crate::scenery::Scenery;
use crate::viewport::{Picture, Stage};

pub fn show(ui: &mut Ui, stage: &Stage, picture: &Picture, scenery: &Scenery<'_>) {
    ScrollArea::both().auto_shrink(false).show(ui, |ui| {
        ui.horizontal_top(|ui| {
            column(ui, "Picture", &of_picture(stage, picture));
            ui.add_space(28.0);
            column(ui, "Scene", &of_scene(scenery));
            ui.add_space(28.0);
            column(ui, "Light", &of_light(stage, picture));
            ui.add_space(28.0);
            column(ui, "GPU memory", &of_memory(stage));
        });
    });
}

type Row = (&'static str, String);

fn column(ui: &mut Ui, name: &str, rows: &[Row]) {
    ui.vertical(|ui| {
        ui.label(RichText::new(name).strong());
        Grid::new(name).num_columns(2).spacing(egui::vec2(14.0, 2.0)).show(ui, |ui| {
            for (name, value) in rows {
                ui.weak(*name);
                ui.label(value);
                ui.end_row();
            }
        });
    });
}

fn of_picture(stage: &Stage, picture: &Picture) -> Vec<Row> {
    vec![
        ("Device", stage.gpu().name()),
        ("Processor", format!("{:.1} ms", picture.took.as_secs_f64() * 1e3)),
        ("Draws", picture.drawn.draws.to_string()),
        ("Of them shadows", picture.drawn.shadow_draws.to_string()),
        ("Pictures so far", picture.count.to_string()),
    ]
}

fn of_scene(scenery: &Scenery<'_>) -> Vec<Row> {
    let entities = &scenery.scene.entities;
    let meshes = entities.iter().filter_map(|entity| scenery.assets.meshes.get(&entity.mesh.as_ref()?.mesh));
    let triangles: usize = meshes.map(|mesh| mesh.indices.len() / 3).sum();
    vec![
        ("Objects", entities.len().to_string()),
        ("Lights", entities.iter().filter(|entity| entity.light.is_some()).count().to_string()),
        ("Materials", scenery.scene.materials.len().to_string()),
        ("Triangles", triangles.to_string()),
    ]
}

fn of_light(stage: &Stage, picture: &Picture) -> Vec<Row> {
    let transport = stage.transport();
    let bound = picture.drawn.bound.map_or("\u{2013}".to_owned(), |bound| format!("{:.2} %", bound * 100.0));
    vec![
        ("Patches", transport.patches.len().to_string()),
        ("Light probes", transport.probes.len().to_string()),
        ("Bounces this picture", picture.drawn.products.to_string()),
        ("Error at most", bound),
    ]
}

fn of_memory(stage: &Stage) -> Vec<Row> {
    let bytes = stage.renderer.bytes();
    let mut rows: Vec<Row> =
        bytes.iter().map(|(what, bytes)| (*what, format!("{:.2} MB", *bytes as f64 / 1e6))).collect();
    let all: u64 = bytes.iter().map(|(_, bytes)| bytes).sum();
    rows.push(("All", format!("{:.2} MB", all as f64 / 1e6)));
    rows
}
