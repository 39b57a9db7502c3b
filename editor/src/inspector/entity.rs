//! A field that names another entity, found by a few letters of its name.

use eframe::egui;
use egui::{ComboBox, PopupCloseBehavior, TextEdit, Ui};
use engine::scene::{Entity, EntityId};

use super::fields;
use crate::document::Document;

/// Entries that are listed; the search finds the rest.
const MOST: usize = 30;

/// How a field asks for an entity.
pub struct Question<'a> {
    pub name: &'a str,
    pub tooltip: &'a str,
    /// What it is called to name none.
    pub none: &'a str,
    pub fits: fn(&Entity) -> bool,
}

/// Gives what was chosen: an entity, or none. `shared`: what all that is selected names, if they agree.
pub fn field(
    ui: &mut Ui,
    question: &Question<'_>,
    document: &Document,
    shared: Option<Option<EntityId>>,
) -> Option<Option<EntityId>> {
    let named = |id: EntityId| document.entity(id).map_or("missing", |entity| entity.name.as_str());
    let said = shared.map_or("\u{2014}", |chosen| chosen.map_or(question.none, named));
    fields::row(ui, question.name, question.tooltip, |ui| {
        let shown = ComboBox::from_id_salt(question.name)
            .selected_text(said)
            .width(ui.available_width())
            .truncate()
            .close_behavior(PopupCloseBehavior::CloseOnClickOutside)
            .show_ui(ui, |ui| list(ui, question, document, shared));
        let id = shown.response.id;
        ui.ctx().accesskit_node_builder(id, |node| node.set_label(question.name));
        shown.inner.flatten()
    })
}

fn list(
    ui: &mut Ui,
    question: &Question<'_>,
    document: &Document,
    shared: Option<Option<EntityId>>,
) -> Option<Option<EntityId>> {
    let letters = search(ui, question.name);
    let mut chosen = None;
    if ui.selectable_label(shared == Some(None), question.none).clicked() {
        chosen = Some(None);
    }
    let fits = |entity: &&Entity| (question.fits)(entity) && entity.name.to_lowercase().contains(&letters);
    let mut found = document.scene().entities.iter().filter(fits);
    for entity in found.by_ref().take(MOST) {
        if ui.selectable_label(shared == Some(Some(entity.id)), &entity.name).clicked() {
            chosen = Some(Some(entity.id));
        }
    }
    if found.next().is_some() {
        ui.weak("More: type letters of a name");
    }
    if chosen.is_some() {
        ui.close();
    }
    chosen
}

/// What is typed, in small letters; kept while the list is open.
fn search(ui: &mut Ui, name: &str) -> String {
    let place = ui.make_persistent_id(("letters", name));
    let mut letters: String = ui.data(|data| data.get_temp(place)).unwrap_or_default();
    let field = ui.add(TextEdit::singleline(&mut letters).hint_text("Search").desired_width(f32::INFINITY));
    field.ctx.accesskit_node_builder(field.id, |node| node.set_label(format!("Search for {name}")));
    ui.data_mut(|data| data.insert_temp(place, letters.clone()));
    letters.to_lowercase()
}
