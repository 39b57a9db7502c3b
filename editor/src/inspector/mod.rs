//! The inspector: what is selected, component by component, one file each. Where several entities are selected, a field
//! shows what they have in common, and setting it sets it for all of them.

mod add;
pub mod arithmetic;
mod camera;
mod colour;
mod component;
mod entity;
mod fields;
mod light;
mod material;
mod mesh;
mod motion;
mod picker;
mod probes;
mod reflections;
mod sky;
mod slot;
mod subject;
mod transform;

use eframe::egui;
use egui::{ScrollArea, Ui};
use engine::scene::{Entity, EntityId};

use crate::ask::Asks;
use crate::assets::Asset;
use crate::document::Document;
use crate::edit::Field;
use crate::intents::Intent;
use crate::selection::Selection;
use crate::thumbnails::Thumbnails;
use crate::viewport::marks::icon_of;
use crate::{icons, theme};
use subject::Subject;

/// What is known of the project's files.
pub struct Files<'a> {
    pub assets: &'a [Asset],
    pub missing: &'a [String],
    pub thumbnails: &'a mut Thumbnails,
}

#[derive(Default)]
pub struct Inspector {
    /// What is being typed as a name, of whom.
    name: Option<(Vec<EntityId>, String)>,
}

impl Inspector {
    pub fn show(
        &mut self,
        ui: &mut Ui,
        (document, selection): (&Document, &Selection),
        playing: bool,
        files: &mut Files<'_>,
        asks: &mut Asks,
    ) {
        let entities: Vec<&Entity> = selection.ids().iter().filter_map(|id| document.entity(*id)).collect();
        if playing {
            ui.horizontal(|ui| {
                icons::label(ui, icons::Icon::Play, theme::accent(ui.visuals()));
                ui.weak("Playing: stop to edit");
            });
            ui.add_space(4.0);
        }
        ui.add_enabled_ui(!playing, |ui| {
            if entities.is_empty() {
                ui.weak("Nothing is selected. This is the scene's:");
                ui.add_space(4.0);
            } else {
                self.head(ui, &entities, asks);
            }
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| match entities.is_empty() {
                true => sky::show(ui, document, files, asks),
                false => components(ui, document, &entities, files, asks),
            });
        });
    }

    /// Icon, name, static and shown.
    fn head(&mut self, ui: &mut Ui, entities: &[&Entity], asks: &mut Asks) {
        ui.horizontal(|ui| {
            icons::label(ui, icon_of(entities[0]), ui.visuals().text_color());
            self.name_field(ui, entities, asks);
        });
        ui.horizontal(|ui| {
            ui.add_space(22.0);
            let shown = "Seen, and part of the light. What stands under it is hidden with it (H)";
            Subject::component(entities, |e| Some(&e.hidden), Field::Hidden, asks).tick(
                ui,
                ("Shown", shown),
                |hidden| !hidden,
                |hidden, shown| *hidden = !shown,
            );
            ui.add_space(10.0);
            let fixed = "Never moves while the scene plays: its light is baked, and it lights others";
            Subject::component(entities, |e| Some(&e.is_static), Field::Static, asks).tick(
                ui,
                ("Static", fixed),
                |fixed| *fixed,
                |fixed, new| *fixed = new,
            );
        });
        ui.add_space(2.0);
    }

    fn name_field(&mut self, ui: &mut Ui, entities: &[&Entity], asks: &mut Asks) {
        let ids: Vec<EntityId> = entities.iter().map(|entity| entity.id).collect();
        let known = match entities {
            [one] => one.name.clone(),
            many => format!("{} objects", many.len()),
        };
        let mut text = match &self.name {
            Some((of, text)) if *of == ids => text.clone(),
            _ => known.clone(),
        };
        let field = egui::TextEdit::singleline(&mut text).desired_width(f32::INFINITY);
        let response = ui.add_enabled(entities.len() == 1, field);
        response.ctx.accesskit_node_builder(response.id, |node| node.set_label("Name"));
        if response.lost_focus() {
            self.name = None;
            let name = text.trim();
            if !name.is_empty() && name != known {
                asks.push(Intent::Rename { id: ids[0], name: name.to_owned() });
            }
        } else if response.has_focus() {
            self.name = Some((ids, text));
        }
    }
}

fn components(
    ui: &mut Ui,
    document: &Document,
    entities: &[&Entity],
    files: &mut Files<'_>,
    asks: &mut Asks,
) {
    transform::show(ui, entities, asks);
    mesh::show(ui, document, entities, files, asks);
    light::show(ui, entities, asks);
    camera::show(ui, entities, asks);
    probes::light_probes(ui, entities, asks);
    probes::reflection_probe(ui, entities, asks);
    motion::show(ui, entities, asks);
    material::show(ui, document, entities, files, asks);
    add::show(ui, document, entities, asks);
}
