//! The project's files, folder by folder, and the scene's materials: what they look like, who uses them, what is missing. Out
//! of it they are dragged into the scene.

mod dialogs;
mod entry;
mod menu;
mod sources;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, Receiver};
use std::time::{Duration, Instant};

use eframe::egui;
use egui::{ScrollArea, Slider, TextEdit, Ui, vec2};
use engine::scene::{Material, MaterialId};
use glam::DVec3;

use crate::ask::Asks;
use crate::assets::{self, Asset, Carried, Kind, User, Wish};
use crate::document::Document;
use crate::icons::{self, Icon};
use crate::theme;
use crate::thumbnails::Thumbnails;
use dialogs::Dialog;

/// Where all files lie.
const ROOT: &str = "assets";
/// Others may put files into the folder.
const LIST_EVERY: Duration = Duration::from_secs(2);
/// Points of a picture's side; below the first it is a list.
const SIDES: std::ops::RangeInclusive<f32> = 32.0..=128.0;
const SMALLEST_TILE: f32 = 48.0;

pub struct AssetList {
    search: String,
    folder: String,
    /// Of the scene, instead of files.
    materials: bool,
    side: f32,
    assets: Vec<Asset>,
    /// Of this project.
    listed: Option<PathBuf>,
    listed_at: Option<Instant>,
    stale: bool,
    /// The disk is read on a thread of its own.
    listing: Option<Receiver<Vec<Asset>>>,
    users: BTreeMap<String, Vec<User>>,
    missing: Vec<String>,
    /// The document's revision of which the users are.
    revision: Option<u64>,
    selected: Option<String>,
    /// And what is typed.
    renaming: Option<(String, String)>,
    dialog: Option<Dialog>,
    /// Where models come to stand that are not dropped anywhere.
    pub pivot: DVec3,
}

impl Default for AssetList {
    fn default() -> Self {
        Self {
            search: String::new(),
            folder: ROOT.to_owned(),
            materials: false,
            side: 52.0,
            assets: Vec::new(),
            listed: None,
            listed_at: None,
            stale: false,
            listing: None,
            users: BTreeMap::new(),
            missing: Vec::new(),
            revision: None,
            selected: None,
            renaming: None,
            dialog: None,
            pivot: DVec3::ZERO,
        }
    }
}

/// One of what is shown.
#[derive(Clone, Copy)]
enum Item<'a> {
    /// The scene refers to it, the project does not have it.
    Missing(&'a str),
    File(&'a Asset),
    Material(&'a Material),
}

/// What others do about files.
impl AssetList {
    /// With every picture, shown or not. Returns whether what is missing was just found anew.
    pub fn follow(&mut self, document: &mut Document) -> bool {
        if self.listed.as_deref() != Some(document.project()) {
            (self.folder, self.selected) = (ROOT.to_owned(), None);
            (self.assets, self.missing, self.revision, self.listed_at) = Default::default();
            self.list(document);
        } else if self.listing.is_none() && (self.stale || self.is_old()) {
            self.list(document);
        }
        let is_fresh = self.take_listing();
        let changed = self.revision != Some(document.revision()) && !document.is_dragging();
        if changed {
            self.revision = Some(document.revision());
            self.users = assets::references(document.scene());
            document.follow(self.users.keys().cloned());
        }
        if (changed || is_fresh) && self.listed_at.is_some() {
            let is_there = |file: &String| self.has(file);
            let missing: Vec<String> = self.users.keys().filter(|file| !is_there(file)).cloned().collect();
            // Not as long as the list may be older than the scene.
            if is_fresh || missing.is_empty() {
                self.missing = missing;
            } else {
                self.refresh();
            }
        }
        is_fresh
    }

    fn is_old(&self) -> bool {
        self.listed_at.is_some_and(|at| at.elapsed() > LIST_EVERY)
    }

    fn take_listing(&mut self) -> bool {
        let Some(listed) = self.listing.as_ref().and_then(|listing| listing.try_recv().ok()) else {
            return false;
        };
        (self.assets, self.listing, self.listed_at) = (listed, None, Some(Instant::now()));
        true
    }

    fn list(&mut self, document: &Document) {
        let project = document.project().to_owned();
        let (sender, receiver) = mpsc::channel();
        (self.listed, self.listing, self.stale) = (Some(project.clone()), Some(receiver), false);
        std::thread::spawn(move || {
            // Nobody waits any more where the panel is gone.
            let _ = sender.send(assets::list(&project));
        });
    }

    /// The folder is read again soon: something in it has changed.
    pub fn refresh(&mut self) {
        (self.listing, self.stale) = (None, true);
    }

    pub fn missing(&self) -> &[String] {
        &self.missing
    }

    pub fn has(&self, file: &str) -> bool {
        self.assets.iter().any(|asset| asset.file == file)
    }

    /// By the scene.
    pub fn is_used(&self, file: &str) -> bool {
        self.users.contains_key(file)
    }

    /// It is being read.
    pub fn is_listing(&self) -> bool {
        self.listing.is_some()
    }

    pub fn assets(&self) -> &[Asset] {
        &self.assets
    }

    pub fn selected(&self) -> Option<&str> {
        self.selected.as_deref()
    }

    /// A file or folder has another name: what is shown and selected follows.
    pub fn moved(&mut self, from: &str, to: &str) {
        for path in [Some(&mut self.folder), self.selected.as_mut()].into_iter().flatten() {
            if let Some(new) = assets::moved(path, from, to) {
                *path = new;
            }
        }
    }

    pub fn begin_rename(&mut self, file: &str) {
        self.selected = Some(file.to_owned());
        self.renaming = Some((file.to_owned(), assets::name(file).to_owned()));
    }

    pub fn rename_selected(&mut self) {
        if let Some(file) = self.selected.clone() {
            self.begin_rename(&file);
        }
    }

    /// The first file that is missing is asked about.
    pub fn relink_missing(&mut self) {
        self.dialog = self.missing.first().map(|file| Dialog::relink(file));
    }

    pub fn ask_for_relink(&mut self, from: &str) {
        self.dialog = Some(Dialog::relink(from));
    }

    /// Its folder is shown and it is selected, where the project has it; `file` may lie anywhere, or be a bare name.
    pub fn reveal(&mut self, project: &Path, file: &Path) {
        let inside = file.strip_prefix(project).unwrap_or(file);
        let parts: Vec<_> = inside.iter().map(|part| part.to_string_lossy()).collect();
        let inside = parts.join("/");
        let is_it = |asset: &&Asset| asset.file == inside || assets::name(&asset.file) == inside;
        let Some(found) = self.assets.iter().find(is_it).map(|asset| asset.file.clone()) else { return };
        self.folder = found.rsplit_once('/').map_or(ROOT, |(folder, _)| folder).to_owned();
        (self.materials, self.selected) = (false, Some(found));
        self.search.clear();
    }

    pub fn reveal_material(&mut self, material: MaterialId) {
        (self.materials, self.selected) = (true, Some(menu::material_key(material)));
        self.search.clear();
    }

    /// The search field takes the keyboard.
    pub fn focus_search(&self, ui: &Ui) {
        ui.memory_mut(|memory| memory.request_focus(search_id()));
    }

    /// Which files from elsewhere are to be read, and how.
    pub fn ask_for_import(&mut self) {
        self.dialog = Some(Dialog::import());
    }

    pub fn show_dialog(&mut self, ui: &Ui, document: &Document, asks: &mut Asks) {
        let Some(mut dialog) = self.dialog.take() else { return };
        if dialog.show(ui, self, document, asks) {
            self.dialog = self.dialog.take().or(Some(dialog));
        }
    }

    pub fn has_dialog(&self) -> bool {
        self.dialog.is_some()
    }
}

fn search_id() -> egui::Id {
    egui::Id::unique("assets search")
}

/// The panel.
impl AssetList {
    pub fn show(&mut self, ui: &mut Ui, document: &Document, thumbnails: &mut Thumbnails, asks: &mut Asks) {
        self.bar(ui, asks);
        let assets = std::mem::take(&mut self.assets);
        let missing = std::mem::take(&mut self.missing);
        let items = self.items(&assets, &missing, document);
        if items.is_empty() {
            ui.add_space(10.0);
            ui.vertical_centered(|ui| ui.weak(self.told_empty(&assets)));
        } else {
            self.entries(ui, &items, document, thumbnails, asks);
        }
        (self.assets, self.missing) = (assets, missing);
    }

    fn told_empty(&self, assets: &[Asset]) -> &'static str {
        match (self.search.is_empty(), self.materials, assets.is_empty()) {
            (false, ..) => "Nothing of that name",
            (_, true, _) => "The scene has no materials yet",
            (_, _, true) => "Drop models and pictures here: glTF, GLB, OBJ, PNG, JPEG, HDR",
            _ => "An empty folder",
        }
    }

    fn items<'a>(&self, assets: &'a [Asset], missing: &'a [String], document: &'a Document) -> Vec<Item<'a>> {
        let text = self.search.to_lowercase();
        let holds = |name: &str| name.to_lowercase().contains(&text);
        if self.materials {
            let materials = document.scene().materials.iter();
            return materials.filter(|material| holds(&material.name)).map(Item::Material).collect();
        }
        let lost = missing.iter().filter(|file| holds(file)).map(|file| Item::Missing(file));
        let is_here = |asset: &&Asset| match text.is_empty() {
            true => assets::folder(&asset.file) == self.folder,
            false => asset.kind != Kind::Folder && holds(asset.name()),
        };
        lost.chain(assets.iter().filter(is_here).map(Item::File)).collect()
    }

    fn entries(
        &mut self,
        ui: &mut Ui,
        items: &[Item<'_>],
        document: &Document,
        thumbnails: &mut Thumbnails,
        asks: &mut Asks,
    ) {
        let is_list = self.side < SMALLEST_TILE;
        let gap = if is_list { 0.0 } else { 4.0 };
        let room = ui.available_width() - 10.0;
        let size = match is_list {
            true => vec2(room, theme::ROW),
            false => vec2(self.side + 16.0, self.side + 26.0),
        };
        let columns = if is_list { 1 } else { (((room + gap) / (size.x + gap)) as usize).max(1) };
        ui.spacing_mut().item_spacing = egui::Vec2::splat(gap);
        let rows = items.len().div_ceil(columns);
        ScrollArea::vertical().auto_shrink(false).show_rows(ui, size.y, rows, |ui, range| {
            for row in range {
                ui.horizontal(|ui| {
                    for item in items.iter().skip(row * columns).take(columns) {
                        self.entry(ui, *item, (size, is_list), document, thumbnails, asks);
                    }
                });
            }
            self.beside(ui, asks);
        });
    }

    /// What is dropped beside all entries goes into the folder.
    fn beside(&mut self, ui: &mut Ui, asks: &mut Asks) {
        let rect = ui.clip_rect();
        let below = egui::Rect::from_min_max(egui::pos2(rect.left(), ui.min_rect().bottom()), rect.max);
        if below.height() < 4.0 {
            return;
        }
        let response = ui.interact(below, ui.scope_id().with("beside"), egui::Sense::click());
        if response.clicked() {
            self.selected = None;
        }
        let folder = self.folder.clone();
        response.context_menu(|ui| menu::of_folder(ui, &folder, asks));
    }

    fn bar(&mut self, ui: &mut Ui, asks: &mut Asks) {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 3.0;
            ui.selectable_value(&mut self.materials, false, "Files")
                .on_hover_text("What lies in the project's folder `assets`");
            ui.selectable_value(&mut self.materials, true, "Materials")
                .on_hover_text("The scene's: drag one onto an object");
            ui.add_space(6.0);
            if !self.materials {
                self.breadcrumb(ui, asks);
            }
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| self.controls(ui, asks));
        });
        ui.add_space(3.0);
    }

    /// From the right.
    fn controls(&mut self, ui: &mut Ui, asks: &mut Asks) {
        if icons::button(ui, Icon::Reset, "Refresh", "Reads the folder again", false).clicked() {
            self.refresh();
        }
        let tooltip = "Brings models and pictures into the project (Ctrl+Shift+I)";
        if icons::button(ui, Icon::Plus, "Import files", tooltip, false).clicked() {
            asks.push(Wish::AskForImport);
        }
        ui.spacing_mut().slider_width = 70.0;
        let slider = ui.add(Slider::new(&mut self.side, SIDES).show_value(false));
        slider.ctx.accesskit_node_builder(slider.id, |node| node.set_label("Size of pictures"));
        slider.on_hover_text("Size of pictures; the smallest is a list");
        let field = TextEdit::singleline(&mut self.search).id(search_id()).hint_text("Search");
        let width = ui.available_width().clamp(40.0, 150.0);
        let field = ui.add_sized(vec2(width, theme::ROW - 2.0), field);
        field.ctx.accesskit_node_builder(field.id, |node| node.set_label("Search the assets"));
    }

    /// The folder's path: a click goes up, what is dropped on a part moves there.
    fn breadcrumb(&mut self, ui: &mut Ui, asks: &mut Asks) {
        let folder = self.folder.clone();
        let mut path = String::new();
        for part in folder.split('/') {
            if !path.is_empty() {
                ui.weak("/");
                path.push('/');
            }
            path.push_str(part);
            let button = egui::Button::new(part).frame_when_inactive(false).min_size(vec2(0.0, 18.0));
            let response = ui.add(button);
            response.ctx.accesskit_node_builder(response.id, |node| node.set_label(format!("Folder {path}")));
            if response.clicked() {
                (self.folder, self.selected) = (path.clone(), None);
            }
            moves_into(ui, &response, &path, asks);
        }
    }
}

/// What is dropped on a folder moves into it.
fn moves_into(ui: &Ui, response: &egui::Response, folder: &str, asks: &mut Asks) {
    let into = |file: &str| format!("{folder}/{}", assets::name(file));
    let moves = |carried: &Carried| match carried {
        Carried::File { file, .. } => assets::folder(file) != folder && file != folder,
        Carried::Material(_) => false,
    };
    if response.dnd_hover_payload::<Carried>().is_some_and(|carried| moves(&carried)) {
        let accent = egui::Stroke::new(2.0, theme::accent(ui.visuals()));
        ui.painter().rect_stroke(response.rect, 3.0, accent, egui::StrokeKind::Inside);
    }
    let Some(carried) = response.dnd_release_payload::<Carried>() else { return };
    if let Carried::File { file, .. } = &*carried
        && moves(&carried)
    {
        asks.push(Wish::Move { from: file.clone(), to: into(file) });
    }
}
