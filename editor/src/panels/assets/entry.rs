//! One of what is shown: as a tile with its picture, or as a row of a list.

use eframe::egui;
use egui::{
    Align2, Color32, FontId, Key, Rect, Response, Role, Sense, TextEdit, Ui, Vec2, WidgetInfo, pos2, vec2,
};
use engine::scene::ImageSource;

use super::{AssetList, Dialog, Item, menu, moves_into};
use crate::ask::Asks;
use crate::assets::{self, Asset, Carried, Kind, Place, Wish};
use crate::document::Document;
use crate::icons::{self, Icon};
use crate::theme;
use crate::thumbnails::{Thumbnails, fitted};

/// How an entry is drawn.
struct Look {
    /// By which screen readers, and what tells entries apart, know it.
    key: String,
    name: String,
    icon: Icon,
    color: Color32,
    picture: Option<egui::TextureId>,
    /// Behind the name in a list.
    note: String,
}

impl AssetList {
    pub(super) fn entry(
        &mut self,
        ui: &mut Ui,
        item: Item<'_>,
        (size, is_list): (Vec2, bool),
        document: &Document,
        thumbnails: &mut Thumbnails,
        asks: &mut Asks,
    ) {
        let look = self.look(ui, item, thumbnails);
        let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
        let id = ui.scope_id().with(("asset", &look.key));
        let response = ui.interact(rect, id, Sense::click_and_drag());
        let selected = self.selected.as_ref() == Some(&look.key);
        response.widget_info(|| WidgetInfo::selected(Role::ListItem, true, selected, &look.key));
        paint_back(ui, rect, &response, selected);
        let renames = self.renaming.as_ref().is_some_and(|(file, _)| *file == look.key);
        let name = if is_list { row(ui, rect, &look) } else { tile(ui, rect, &look) };
        if renames {
            self.name_field(ui, name, item, asks);
        } else {
            paint_name(ui, name, &look, is_list, selected);
        }
        if response.clicked() || response.drag_started() || response.secondary_clicked() {
            self.selected = Some(look.key.clone());
        }
        self.open(&response, item, asks);
        carry(&response, item);
        if let Item::File(Asset { file, kind: Kind::Folder, .. }) = item {
            moves_into(ui, &response, file, asks);
        }
        let tooltip = format!("{}\n{}", look.key, look.note);
        let response = response.on_hover_text(tooltip.trim_end());
        response.context_menu(|ui| self.menu(ui, item, document, asks));
    }

    fn look(&self, ui: &Ui, item: Item<'_>, thumbnails: &mut Thumbnails) -> Look {
        let (text, weak) = (ui.visuals().text_color(), theme::weak(ui.visuals()));
        match item {
            Item::Missing(file) => Look {
                key: file.to_owned(),
                name: assets::name(file).to_owned(),
                icon: Icon::Warning,
                color: ui.visuals().error_fg_color,
                picture: None,
                note: format!("missing{}", self.told_users(file)),
            },
            Item::Material(material) => Look {
                key: menu::material_key(material.id),
                name: material.name.clone(),
                icon: Icon::Material,
                color: weak,
                picture: thumbnails.material(material),
                note: String::new(),
            },
            Item::File(asset) => {
                let (icon, color, picture) = match asset.kind {
                    Kind::Folder => (Icon::Folder, weak, None),
                    Kind::Model => (Icon::Mesh, weak, thumbnails.model(&asset.file)),
                    Kind::Picture => {
                        let image = ImageSource { file: asset.file.clone(), image: None };
                        (Icon::Picture, weak, thumbnails.picture(&image))
                    }
                    Kind::Other => (Icon::File, weak, None),
                };
                let bytes = if asset.kind == Kind::Folder { String::new() } else { size(asset.bytes) };
                let note = format!("{bytes}{}", self.told_users(&asset.file));
                let color = if asset.kind == Kind::Other { weak } else { color.lerp_to_gamma(text, 0.5) };
                Look { key: asset.file.clone(), name: asset.name().to_owned(), icon, color, picture, note }
            }
        }
    }

    fn told_users(&self, file: &str) -> String {
        match self.users.get(file).map_or(0, Vec::len) {
            0 => String::new(),
            1 => ", used once".to_owned(),
            users => format!(", used {users} times"),
        }
    }

    fn open(&mut self, response: &Response, item: Item<'_>, asks: &mut Asks) {
        if !response.double_clicked() {
            return;
        }
        match item {
            Item::Missing(file) => self.dialog = Some(Dialog::relink(file)),
            Item::File(Asset { file, kind: Kind::Folder, .. }) => {
                (self.folder, self.selected) = (file.clone(), None);
                self.search.clear();
            }
            Item::File(Asset { file, kind: Kind::Model, .. }) => {
                asks.push(Wish::Place { file: file.clone(), place: Place::At(self.pivot) });
            }
            Item::File(_) | Item::Material(_) => {}
        }
    }

    fn name_field(&mut self, ui: &mut Ui, rect: Rect, item: Item<'_>, asks: &mut Asks) {
        let Some((key, name)) = &mut self.renaming else { return };
        let field = TextEdit::singleline(name).margin(egui::Margin::symmetric(3, 1));
        let response = ui.put(rect, field);
        response.ctx.accesskit_node_builder(response.id, |node| node.set_label("New name"));
        if ui.input(|input| input.key_pressed(Key::Escape)) {
            self.renaming = None;
        } else if response.lost_focus() {
            let (key, name) = (std::mem::take(key), name.trim().to_owned());
            self.renaming = None;
            match item {
                Item::Material(material) => menu::rename_material(material, name, asks),
                _ => rename(&key, &name, asks),
            }
        } else {
            response.request_focus();
        }
    }
}

fn rename(file: &str, name: &str, asks: &mut Asks) {
    if name.is_empty() || name == assets::name(file) {
        return;
    }
    if name.contains(['/', '\\', ':']) {
        let why = format!("`{name}` is no name for a file: leave out / \\ :");
        return asks.push(Wish::Refuse { file: file.to_owned(), why });
    }
    asks.push(Wish::Move { from: file.to_owned(), to: format!("{}/{name}", assets::folder(file)) });
}

fn carry(response: &Response, item: Item<'_>) {
    match item {
        Item::File(Asset { file, kind, .. }) => {
            response.dnd_set_drag_payload(Carried::File { file: file.clone(), kind: *kind });
        }
        Item::Material(material) => response.dnd_set_drag_payload(Carried::Material(material.id)),
        Item::Missing(_) => {}
    }
}

fn paint_back(ui: &Ui, rect: Rect, response: &Response, selected: bool) {
    let visuals = ui.visuals();
    let fill = match (selected, response.hovered()) {
        (true, _) => visuals.selection.bg_fill,
        (false, true) => visuals.widgets.inactive.bg_fill.gamma_multiply(0.6),
        (false, false) => return,
    };
    ui.painter().rect_filled(rect, 4.0, fill);
}

/// Returns the place of the name.
fn tile(ui: &Ui, rect: Rect, look: &Look) -> Rect {
    let side = rect.width() - 16.0;
    let picture = Rect::from_min_size(rect.min + vec2(8.0, 5.0), Vec2::splat(side));
    paint_picture(ui, picture, look, (side / 40.0).clamp(1.2, 2.4));
    Rect::from_min_max(pos2(rect.left() + 3.0, rect.bottom() - 20.0), rect.max - vec2(3.0, 2.0))
}

fn row(ui: &Ui, rect: Rect, look: &Look) -> Rect {
    let side = rect.height() - 4.0;
    let picture = Rect::from_min_size(rect.min + vec2(4.0, 2.0), Vec2::splat(side));
    paint_picture(ui, picture, look, 0.9);
    let note = ui.painter().text(
        pos2(rect.right() - 8.0, rect.center().y),
        Align2::RIGHT_CENTER,
        &look.note,
        FontId::proportional(11.0),
        theme::weak(ui.visuals()),
    );
    Rect::from_min_max(pos2(picture.right() + 6.0, rect.top()), pos2(note.left() - 8.0, rect.bottom()))
}

/// Until there is one, or where there is none, the icon of its kind.
fn paint_picture(ui: &Ui, rect: Rect, look: &Look, scale: f32) {
    match look.picture {
        Some(texture) => {
            let uv = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            let shown = fitted(ui.ctx(), rect, texture);
            ui.painter().image(texture, shown, uv, Color32::WHITE);
        }
        None => icons::paint_scaled(ui.painter(), rect, look.icon, look.color, scale),
    }
}

fn paint_name(ui: &Ui, rect: Rect, look: &Look, is_list: bool, selected: bool) {
    let visuals = ui.visuals();
    let color = if selected { visuals.selection.stroke.color } else { visuals.text_color() };
    let color = if look.icon == Icon::Warning && !selected { visuals.error_fg_color } else { color };
    let mut job = egui::text::LayoutJob::simple_singleline(
        look.name.clone(),
        FontId::proportional(if is_list { 13.0 } else { 12.0 }),
        color,
    );
    job.wrap = egui::text::TextWrapping::truncate_at_width(rect.width());
    let galley = ui.painter().layout_job(job);
    let left = if is_list { rect.left() } else { rect.center().x - galley.size().x * 0.5 };
    let at = pos2(left, rect.center().y - galley.size().y * 0.5);
    ui.painter().galley(at, galley, color);
}

fn size(bytes: u64) -> String {
    match bytes {
        0..1000 => format!("{bytes} B"),
        1000..1_000_000 => format!("{:.1} kB", bytes as f64 / 1e3),
        _ => format!("{:.1} MB", bytes as f64 / 1e6),
    }
}
