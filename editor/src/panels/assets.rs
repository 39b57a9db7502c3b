//! The project's files: what there is, who uses it, and what is missing. A click selects the objects that use a file.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::mpsc::{self, Receiver};

use eframe::egui;
use egui::{Label, RichText, ScrollArea, Sense, TextEdit, Ui, vec2};
use engine::scene::EntityId;

use crate::ask::Asks;
use crate::assets::{self, Asset, Kind, User};
use crate::document::Document;
use crate::icons::{self, Icon};
use crate::intents::Intent;
use crate::theme;

#[derive(Default)]
pub struct AssetList {
    search: String,
    assets: Vec<Asset>,
    /// Of this project.
    listed: Option<PathBuf>,
    /// The disk is read on a thread of its own.
    listing: Option<Receiver<Vec<Asset>>>,
    users: BTreeMap<String, Vec<User>>,
    missing: Vec<String>,
    /// The document's revision of which the users are.
    revision: Option<u64>,
}

impl AssetList {
    pub fn show(&mut self, ui: &mut Ui, document: &Document, asks: &mut Asks) {
        self.follow(ui, document);
        self.bar(ui);
        let found = assets::search(&self.assets, &self.search);
        if found.is_empty() && self.missing.is_empty() {
            ui.weak(if self.assets.is_empty() { "The project has no files yet" } else { "No such file" });
            return;
        }
        ui.spacing_mut().item_spacing.y = 0.0;
        let rows = self.missing.len() + found.len();
        ScrollArea::vertical().auto_shrink(false).show_rows(ui, theme::ROW - 2.0, rows, |ui, range| {
            for at in range {
                match self.missing.get(at) {
                    Some(file) => self.row(ui, document, file, None, asks),
                    None => {
                        let asset = found[at - self.missing.len()];
                        self.row(ui, document, &asset.file, Some(asset), asks);
                    }
                }
            }
        });
    }

    fn follow(&mut self, ui: &Ui, document: &Document) {
        if self.listed.as_deref() != Some(document.project()) {
            self.list(document);
        }
        if let Some(listed) = self.listing.as_ref().and_then(|listing| listing.try_recv().ok()) {
            (self.assets, self.listing, self.revision) = (listed, None, None);
        }
        if self.listing.is_some() {
            ui.ctx().request_repaint_after(std::time::Duration::from_millis(50));
        }
        if self.revision != Some(document.revision()) && !document.is_dragging() {
            self.revision = Some(document.revision());
            self.users = assets::references(document.scene());
            let is_there = |file: &String| self.assets.iter().any(|asset| asset.file == *file);
            self.missing = match self.listing.is_some() {
                true => Vec::new(),
                false => self.users.keys().filter(|file| !is_there(file)).cloned().collect(),
            };
        }
    }

    fn list(&mut self, document: &Document) {
        let project = document.project().to_owned();
        let (sender, receiver) = mpsc::channel();
        (self.listed, self.listing) = (Some(project.clone()), Some(receiver));
        std::thread::spawn(move || {
            // Nobody waits any more where the panel is gone.
            let _ = sender.send(assets::list(&project));
        });
    }

    fn bar(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            let field = TextEdit::singleline(&mut self.search).hint_text("Search");
            let field = ui.add_sized(vec2(200.0, theme::ROW - 2.0), field);
            field.ctx.accesskit_node_builder(field.id, |node| node.set_label("Search the assets"));
            if icons::button(ui, Icon::Reset, "Refresh", "Reads the folder again", false).clicked() {
                self.listed = None;
            }
        });
        ui.add_space(3.0);
    }

    fn row(&self, ui: &mut Ui, document: &Document, file: &str, asset: Option<&Asset>, asks: &mut Asks) {
        ui.horizontal(|ui| {
            ui.set_min_height(theme::ROW - 2.0);
            let (icon, color) = match asset.map(|asset| asset.kind) {
                None => (Icon::Warning, ui.visuals().error_fg_color),
                Some(Kind::Folder) => (Icon::Folder, theme::weak(ui.visuals())),
                Some(Kind::Model) => (Icon::Mesh, ui.visuals().text_color()),
                Some(Kind::Picture) => (Icon::Picture, ui.visuals().text_color()),
                Some(Kind::Other) => (Icon::File, theme::weak(ui.visuals())),
            };
            icons::label(ui, icon, color);
            let users = self.users.get(file).map_or(&[][..], Vec::as_slice);
            let name = Label::new(RichText::new(file).color(ui.visuals().text_color())).truncate();
            let response = ui.add(name.sense(Sense::click()));
            let told = match (asset, users.len()) {
                (None, _) => "missing".to_owned(),
                (Some(Asset { kind: Kind::Folder, .. }), _) => String::new(),
                (Some(asset), 0) => size(asset.bytes),
                (Some(asset), users) => format!("{}, used {users} times", size(asset.bytes)),
            };
            ui.label(RichText::new(told).small().color(theme::weak(ui.visuals())));
            if response.clicked() && !users.is_empty() {
                asks.push(Intent::Select(entities(document, users)));
            }
        });
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

fn size(bytes: u64) -> String {
    match bytes {
        0..1000 => format!("{bytes} B"),
        1000..1_000_000 => format!("{:.1} kB", bytes as f64 / 1e3),
        _ => format!("{:.1} MB", bytes as f64 / 1e6),
    }
}
