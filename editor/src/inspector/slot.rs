//! A place of a material for a picture: what it shows, chosen among the project's pictures, dropped there, or taken out.

use std::sync::Arc;

use eframe::egui;
use egui::{
    Align2, Color32, FontId, Popup, Rect, Response, Role, ScrollArea, Sense, Ui, WidgetInfo, pos2, vec2,
};
use engine::scene::{ImageSource, Material, Texture};

use super::Files;
use super::fields;
use super::material::Materials;
use crate::assets::{self, Carried, Kind};
use crate::icons::{self, Icon};
use crate::theme;
use crate::thumbnails::fitted;

/// Which of a material's pictures.
pub struct Slot {
    name: &'static str,
    tooltip: &'static str,
    get: fn(&Material) -> Option<&Texture>,
    place: fn(&mut Material) -> &mut Option<Texture>,
}

pub const COLOR: Slot = Slot {
    name: "Color picture",
    tooltip: "Times the color; sRGB. Its alpha is times the opacity",
    get: |material| material.albedo.texture.as_ref(),
    place: |material| &mut material.albedo.texture,
};

pub const METAL: Slot = Slot {
    name: "Metal, roughness",
    tooltip: "Roughness in green, metallic in blue; times the two numbers above",
    get: |material| material.metallic_roughness_texture.as_ref(),
    place: |material| &mut material.metallic_roughness_texture,
};

pub const NORMALS: Slot = Slot {
    name: "Normals",
    tooltip: "A normal map with +Y up, as glTF has it",
    get: |material| material.normal_texture.as_ref(),
    place: |material| &mut material.normal_texture,
};

pub const EMISSION: Slot = Slot {
    name: "Emission picture",
    tooltip: "Times the color of emission; sRGB",
    get: |material| material.emission.texture.as_ref(),
    place: |material| &mut material.emission.texture,
};

pub fn show(ui: &mut Ui, of: &mut Materials<'_>, slot: &Slot, files: &mut Files<'_>) {
    let shared = of.shared(|material| (slot.get)(material).map(|texture| texture.image.clone()));
    if let Some(image) = field(ui, (slot.name, slot.tooltip), shared.as_ref(), files) {
        of.set_now(image, |material, image| assign((slot.place)(material), image));
    }
}

/// A row for a picture, or none. `shared`: what all have, `None`: they differ. Returns what is chosen instead.
pub fn field(
    ui: &mut Ui,
    (name, tooltip): (&str, &str),
    shared: Option<&Option<ImageSource>>,
    files: &mut Files<'_>,
) -> Option<Option<ImageSource>> {
    fields::row(ui, name, tooltip, |ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        let has_one = shared != Some(&None);
        let room = ui.available_width() - if has_one { 20.0 } else { 0.0 };
        let (rect, response) = ui.allocate_exact_size(vec2(room, theme::ROW), Sense::click());
        response.widget_info(|| WidgetInfo::labeled(Role::Button, ui.is_enabled(), name));
        paint(ui, rect, &response, shared, files);
        let chosen = choose(ui, &response, tooltip, shared, files).map(Some);
        let is_picture = |carried: &Carried| matches!(carried, Carried::File { kind: Kind::Picture, .. });
        let dropped = carried(ui, &response, is_picture).and_then(|carried| match &*carried {
            Carried::File { file, .. } => Some(Some(ImageSource { file: file.clone(), image: None })),
            Carried::Material(_) => None,
        });
        let name = format!("Clear {}", name.to_lowercase());
        let cleared = has_one && fields::small_button(ui, Icon::Close, &name).clicked();
        chosen.or(dropped).or(cleared.then_some(None))
    })
}

/// How a picture lies on the surface stays when another takes its place.
fn assign(texture: &mut Option<Texture>, image: Option<ImageSource>) {
    *texture = match (texture.take(), image) {
        (_, None) => None,
        (Some(old), Some(image)) => Some(Texture { image, ..old }),
        (None, Some(image)) => Some(Texture::new(image)),
    };
}

/// What is dragged over a widget and can be dropped there is shown; what was just dropped is given.
pub fn carried(ui: &Ui, response: &Response, takes: impl Fn(&Carried) -> bool) -> Option<Arc<Carried>> {
    response.dnd_hover_payload::<Carried>().filter(|carried| takes(carried))?;
    let accent = egui::Stroke::new(2.0, theme::accent(ui.visuals()));
    ui.painter().rect_stroke(response.rect, 3.0, accent, egui::StrokeKind::Inside);
    response.dnd_release_payload::<Carried>()
}

/// `None`: what is selected has different ones.
fn paint(
    ui: &Ui,
    rect: Rect,
    response: &Response,
    shared: Option<&Option<ImageSource>>,
    files: &mut Files<'_>,
) {
    let visuals = ui.visuals();
    let hovered = response.hovered() && ui.is_enabled();
    ui.painter().rect_filled(
        rect,
        3.0,
        if hovered { visuals.widgets.hovered.bg_fill } else { visuals.extreme_bg_color },
    );
    let side = rect.height() - 4.0;
    let picture = Rect::from_min_size(rect.min + vec2(2.0, 2.0), vec2(side, side));
    let mut color = visuals.text_color();
    let text = match shared {
        None => "\u{2014}".to_owned(),
        Some(None) => {
            color = theme::weak(visuals);
            "None".to_owned()
        }
        Some(Some(image)) if files.missing.contains(&image.file) => {
            color = visuals.error_fg_color;
            format!("{} is missing", assets::name(&image.file))
        }
        Some(Some(image)) => name(image),
    };
    match shared.and_then(|image| files.thumbnails.picture(image.as_ref()?)) {
        Some(texture) => paint_texture(ui, picture, texture),
        None => icons::paint_scaled(ui.painter(), picture, Icon::Picture, theme::weak(visuals), 0.8),
    }
    let left = picture.right() + 5.0;
    let painter = ui.painter().with_clip_rect(rect.with_max_x(rect.right() - 3.0).intersect(ui.clip_rect()));
    painter.text(pos2(left, rect.center().y), Align2::LEFT_CENTER, text, FontId::proportional(13.0), color);
    if hovered {
        ui.ctx().set_cursor_icon(egui::CursorIcon::PointingHand);
    }
}

fn paint_texture(ui: &Ui, rect: Rect, texture: egui::TextureId) {
    let uv = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
    ui.painter().image(texture, fitted(ui.ctx(), rect, texture), uv, Color32::WHITE);
}

fn name(image: &ImageSource) -> String {
    let file = assets::name(&image.file);
    image.image.map_or(file.to_owned(), |n| format!("{file}, picture {n}"))
}

/// A list of the project's pictures under the slot.
fn choose(
    ui: &Ui,
    response: &Response,
    tooltip: &str,
    shared: Option<&Option<ImageSource>>,
    files: &mut Files<'_>,
) -> Option<ImageSource> {
    let mut chosen = None;
    Popup::menu(response).width(240.0).show(|ui| {
        ui.weak(tooltip);
        ui.separator();
        let pictures: Vec<&str> = files
            .assets
            .iter()
            .filter(|asset| asset.kind == Kind::Picture)
            .map(|asset| asset.file.as_str())
            .collect();
        if pictures.is_empty() {
            ui.label("The project has no pictures yet: drop some on the window.");
        }
        let height = 34.0;
        ScrollArea::vertical().max_height(260.0).show_rows(ui, height, pictures.len(), |ui, range| {
            for file in &pictures[range] {
                let image = ImageSource { file: (*file).to_owned(), image: None };
                let is_chosen = shared.is_some_and(|shared| shared.as_ref() == Some(&image));
                if entry(ui, height, &image, is_chosen, files).clicked() {
                    chosen = Some(image);
                }
            }
        });
    });
    if ui.is_enabled() { chosen } else { None }
}

fn entry(ui: &mut Ui, height: f32, image: &ImageSource, is_chosen: bool, files: &mut Files<'_>) -> Response {
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), height), Sense::click());
    let label = format!("Use {}", image.file);
    response.widget_info(|| WidgetInfo::selected(Role::ListItem, true, is_chosen, &label));
    let visuals = ui.visuals();
    if is_chosen || response.hovered() {
        let fill = if is_chosen { visuals.selection.bg_fill } else { visuals.widgets.hovered.bg_fill };
        ui.painter().rect_filled(rect, 3.0, fill);
    }
    let picture = Rect::from_min_size(rect.min + vec2(3.0, 2.0), vec2(height - 4.0, height - 4.0));
    match files.thumbnails.picture(image) {
        Some(texture) => paint_texture(ui, picture, texture),
        None => icons::paint(ui.painter(), picture, Icon::Picture, theme::weak(visuals)),
    }
    let painter = ui.painter().with_clip_rect(rect.intersect(ui.clip_rect()));
    let at = pos2(picture.right() + 8.0, rect.center().y);
    painter.text(
        at,
        Align2::LEFT_CENTER,
        assets::name(&image.file),
        FontId::proportional(13.0),
        visuals.text_color(),
    );
    response.on_hover_text(&image.file)
}
