//! What is dragged out of the assets panel and dropped into the scene view: models come to stand under the mouse, materials
//! and pictures are given to the surface there.

use eframe::egui;
use egui::{Align2, Color32, FontId, Rect, Response, Stroke, Ui, vec2};
use engine::scene::{ImageSource, Texture};
use glam::DVec3;

use super::Seen;
use crate::ask::Asks;
use crate::assets::{self, Carried, Kind, Place, Wish};
use crate::edit::Edit;
use crate::intents::Intent;
use crate::lens::Lens;
use crate::theme;
use crate::tools::hit::{Caster, Hit};
use crate::tools::surface;

pub(super) fn show(
    ui: &Ui,
    response: &Response,
    lens: &Lens,
    seen: &Seen<'_>,
    pivot: DVec3,
    caster: &mut Caster,
    asks: &mut Asks,
) {
    let from_desktop = ui.input(|input| !input.raw.hovered_files.is_empty());
    let Some(at) = ui.input(|input| input.pointer.latest_pos()).filter(|at| lens.rect.contains(*at)) else {
        return if from_desktop {
            paint_frame(ui, lens.rect)
        };
    };
    if from_desktop {
        paint_frame(ui, lens.rect);
    }
    let Some(carried) = response.dnd_hover_payload::<Carried>().filter(|_| !seen.scenery.is_playing) else {
        return;
    };
    let ray = lens.ray(at);
    let hit = caster.cast(&seen.scenery, &ray, |_| true);
    let place = surface::place(hit.as_ref(), &ray, pivot.distance(lens.eye.position));
    tell(
        ui,
        lens,
        at,
        &told(&carried, hit.as_ref(), seen),
        matches!(*carried, Carried::File { kind: Kind::Model, .. }).then_some(place),
    );
    if response.dnd_release_payload::<Carried>().is_some() {
        drop_it(&carried, hit.as_ref(), place, seen, asks);
    }
}

fn drop_it(carried: &Carried, hit: Option<&Hit>, place: DVec3, seen: &Seen<'_>, asks: &mut Asks) {
    match (carried, hit) {
        (Carried::File { file, kind: Kind::Model }, _) => {
            asks.push(Wish::Place { file: file.clone(), place: Place::At(place) });
        }
        (Carried::Material(material), Some(hit)) => {
            let edit = surface::assign(seen.document, hit.entity, Some(hit.primitive), *material);
            edit.into_iter().for_each(|edit| asks.push(Intent::Commit(edit)));
        }
        (Carried::File { file, kind: Kind::Picture }, Some(hit)) => {
            let edit = surface_picture(seen, hit, file);
            edit.into_iter().for_each(|edit| asks.push(Intent::Commit(edit)));
        }
        _ => {}
    }
}

/// The picture becomes the color of the material that is shown there.
fn surface_picture(seen: &Seen<'_>, hit: &Hit, file: &str) -> Option<Edit> {
    let id = surface::material_at(seen.document, hit)?;
    let mut material = seen.document.material(id)?.clone();
    material.albedo.texture = Some(Texture::new(ImageSource { file: file.to_owned(), image: None }));
    Some(Edit::several("Assign picture", [Edit::SetMaterials(vec![material])]))
}

/// What letting go would do.
fn told(carried: &Carried, hit: Option<&Hit>, seen: &Seen<'_>) -> String {
    let name =
        |hit: &Hit| seen.document.entity(hit.entity).map_or(String::new(), |entity| entity.name.clone());
    match (carried, hit) {
        (Carried::File { file, kind: Kind::Model }, _) => format!("Place {}", assets::name(file)),
        (Carried::File { kind: Kind::Picture, .. }, Some(hit)) => format!("Color picture of {}", name(hit)),
        (Carried::Material(_), Some(hit)) => format!("Material of {}", name(hit)),
        (Carried::File { kind: Kind::Picture, .. } | Carried::Material(_), None) => {
            "Drop it onto an object".to_owned()
        }
        (Carried::File { .. }, _) => "This is nothing that a scene shows".to_owned(),
    }
}

/// `place`: where something would come to stand.
fn tell(ui: &Ui, lens: &Lens, at: egui::Pos2, text: &str, place: Option<DVec3>) {
    let painter = ui.painter_at(lens.rect);
    let accent = theme::accent(ui.visuals());
    if let Some((seen, _)) = place.and_then(|place| lens.project(place)) {
        painter.circle_stroke(seen, 7.0, Stroke::new(2.0, accent));
        painter.circle_filled(seen, 2.5, accent);
    }
    let galley = painter.layout_no_wrap(text.to_owned(), FontId::proportional(13.0), Color32::WHITE);
    let back = Rect::from_min_size(at + vec2(18.0, 10.0), galley.size()).expand2(vec2(6.0, 3.0));
    painter.rect_filled(back, 4.0, Color32::from_black_alpha(190));
    painter.galley(back.min + vec2(6.0, 3.0), galley, Color32::WHITE);
}

fn paint_frame(ui: &Ui, rect: Rect) {
    let (painter, accent) = (ui.painter_at(rect), theme::accent(ui.visuals()));
    painter.rect_stroke(rect, 0.0, Stroke::new(3.0, accent), egui::StrokeKind::Inside);
    let at = rect.center_bottom() - vec2(0.0, 26.0);
    let font = FontId::proportional(14.0);
    let text = "Drop here to place it in the scene, elsewhere to bring it into the project";
    let galley = painter.layout_no_wrap(text.to_owned(), font, Color32::WHITE);
    let back = Align2::CENTER_CENTER.anchor_size(at, galley.size()).expand2(vec2(8.0, 4.0));
    painter.rect_filled(back, 4.0, Color32::from_black_alpha(190));
    painter.galley(back.min + vec2(8.0, 4.0), galley, Color32::WHITE);
}
