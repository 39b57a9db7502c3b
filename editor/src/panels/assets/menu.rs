//! What a right click offers on a file, a material, or beside them.

use eframe::egui;
use egui::Ui;
use engine::scene::{EntityId, Material, MaterialId};

use super::{AssetList, Dialog, Item};
use crate::ask::Asks;
use crate::assets::{Asset, Kind, Place, User, Wish};
use crate::command::Command;
use crate::document::Document;
use crate::edit::Edit;
use crate::intents::Intent;

impl AssetList {
    pub(super) fn menu(&mut self, ui: &mut Ui, item: Item<'_>, document: &Document, asks: &mut Asks) {
        ui.set_min_width(190.0);
        match item {
            Item::Missing(file) => {
                if ui.button("Relink\u{2026}").clicked() {
                    self.dialog = Some(Dialog::relink(file));
                }
                self.select_users(ui, file, document, asks);
            }
            Item::Material(material) => self.of_material(ui, material, document, asks),
            Item::File(asset) => self.of_file(ui, asset, document, asks),
        }
    }

    fn of_file(&mut self, ui: &mut Ui, asset: &Asset, document: &Document, asks: &mut Asks) {
        let file = &asset.file;
        if asset.kind == Kind::Folder {
            if ui.button("Open").clicked() {
                self.folder.clone_from(file);
            }
        } else {
            if asset.kind == Kind::Model {
                if ui.button("Place in the scene").clicked() {
                    asks.push(Wish::Place { file: file.clone(), place: Place::At(self.pivot) });
                }
                if ui.button("Import again").clicked() {
                    asks.push(Wish::Again { file: file.clone(), settings: None });
                }
                if ui.button("Import settings\u{2026}").clicked() {
                    self.dialog = Some(Dialog::settings(document.project(), file));
                }
                ui.separator();
            }
            self.select_users(ui, file, document, asks);
        }
        if ui.button("Rename").clicked() {
            self.begin_rename(file);
        }
        if ui.button("Delete\u{2026}").clicked() {
            let below = self.users.iter().filter(|(used, _)| crate::assets::moved(used, file, "").is_some());
            let users = below.map(|(_, users)| users.len()).sum();
            self.dialog = Some(Dialog::Delete { file: file.clone(), users });
        }
        ui.separator();
        of_folder(ui, &self.folder, asks);
    }

    fn select_users(&self, ui: &mut Ui, file: &str, document: &Document, asks: &mut Asks) {
        let users = self.users.get(file).map_or(&[][..], Vec::as_slice);
        if ui.add_enabled(!users.is_empty(), egui::Button::new("Select what uses it")).clicked() {
            asks.push(Intent::Select(entities(document, users)));
        }
    }

    fn of_material(&mut self, ui: &mut Ui, material: &Material, document: &Document, asks: &mut Asks) {
        let users = entities(document, &[User::Material(material.id)]);
        if ui.add_enabled(!users.is_empty(), egui::Button::new("Select what uses it")).clicked() {
            asks.push(Intent::Select(users.clone()));
        }
        if ui.button("Rename").clicked() {
            self.renaming = Some((material_key(material.id), material.name.clone()));
        }
        let delete = ui.add_enabled(users.is_empty(), egui::Button::new("Delete"));
        if delete.on_disabled_hover_text("Objects are made of it").clicked() {
            asks.push(Intent::Commit(Edit::RemoveMaterials(vec![material.id])));
        }
        ui.separator();
        if ui.button("Create material").clicked() {
            asks.push(Command::CreateMaterial);
        }
    }
}

pub(super) fn of_folder(ui: &mut Ui, folder: &str, asks: &mut Asks) {
    if ui.button("Import files\u{2026}").clicked() {
        asks.push(Wish::AskForImport);
    }
    if ui.button("New folder").clicked() {
        asks.push(Wish::NewFolder { below: folder.to_owned() });
    }
}

/// As entries are told apart.
pub(super) fn material_key(id: MaterialId) -> String {
    format!("material #{}", id.0)
}

pub(super) fn rename_material(material: &Material, name: String, asks: &mut Asks) {
    if !name.is_empty() && name != material.name {
        asks.push(Intent::Commit(Edit::SetMaterials(vec![Material { name, ..material.clone() }])));
    }
}

/// Those that use the file themselves, or a material that does.
fn entities(document: &Document, users: &[User]) -> Vec<EntityId> {
    let uses = |entity: &&engine::scene::Entity| {
        let materials = entity.mesh.iter().flat_map(|mesh| &mesh.materials);
        let by_material = materials.clone().any(|id| users.contains(&User::Material(*id)));
        by_material || users.contains(&User::Entity(entity.id))
    };
    document.scene().entities.iter().filter(uses).map(|entity| entity.id).collect()
}
