//! Picks a colour: a square of saturation and value under a strip of hues, how bright it is beyond what a display shows,
//! and its code. All in HSV of display values, as painting programs have it (Smith 1978).

use eframe::egui;
use egui::ecolor::{Hsva, HsvaGamma};
use egui::{Color32, Mesh, Pos2, Rect, Response, Rgba, Role, Sense, Stroke, Ui, WidgetInfo, pos2, vec2};
use glam::Vec3;

use super::fields::{Number, Touched};
use crate::theme;

const WIDTH: f32 = 220.0;

/// A linear colour of any brightness. `name`: what screen readers say before each part.
pub fn show(ui: &mut Ui, name: &str, color: Vec3) -> Touched<Vec3> {
    ui.reset_style(); // fields in a menu have no edge
    // Above 1 it is brighter than a display: what is picked stays as bright.
    let most = color.max_element().max(1.0);
    let id = ui.scope_id().with(name);
    let mut picked = remembered(ui, id, color / most);
    let square = square(ui, &mut picked);
    square.widget_info(|| WidgetInfo::labeled(Role::Slider, true, format!("{name} saturation and value")));
    ui.add_space(2.0);
    let hues = hues(ui, &mut picked);
    hues.widget_info(|| WidgetInfo::labeled(Role::Slider, true, format!("{name} hue")));
    let mut touched = pulled(&square, &hues);
    if square.is_pointer_button_down_on() || hues.is_pointer_button_down_on() || touched.ended {
        let new = rgb(picked);
        ui.data_mut(|data| data.insert_temp(id, (picked, new)));
        touched.value = Some(new * most);
    }
    ui.add_space(4.0);
    for other in [brightness(ui, name, color), code(ui, name, color / most, most)] {
        if other.value.is_some() || other.ended {
            touched = other;
        }
    }
    touched
}

/// A grey has every hue: the one that was picked is kept as long as the colour is what came of it.
fn remembered(ui: &Ui, id: egui::Id, color: Vec3) -> HsvaGamma {
    let kept: Option<(HsvaGamma, Vec3)> = ui.data(|data| data.get_temp(id));
    match kept {
        Some((picked, made)) if made.abs_diff_eq(color, 1e-4) => picked,
        _ => Hsva::from_rgb(color.to_array()).into(),
    }
}

fn rgb(picked: HsvaGamma) -> Vec3 {
    Vec3::from(Hsva::from(picked).to_rgb())
}

fn pulled(square: &Response, hues: &Response) -> Touched<Vec3> {
    let any = |is_so: fn(&Response) -> bool| is_so(square) || is_so(hues);
    let ended = any(Response::drag_stopped) || any(Response::clicked);
    Touched { value: None, dragging: any(Response::is_pointer_button_down_on), ended }
}

/// Where in a rectangle the mouse pulls, in shares of it.
fn pull(response: &Response) -> Option<[f32; 2]> {
    let is_held = response.is_pointer_button_down_on() || response.drag_stopped() || response.clicked();
    let at = response.interact_pointer_pos().filter(|_| is_held)? - response.rect.min;
    Some([at.x / response.rect.width(), at.y / response.rect.height()].map(|share| share.clamp(0.0, 1.0)))
}

fn square(ui: &mut Ui, picked: &mut HsvaGamma) -> Response {
    const CELLS: u32 = 12;
    let (rect, response) = ui.allocate_exact_size(vec2(WIDTH, 140.0), Sense::click_and_drag());
    if let Some([s, down]) = pull(&response) {
        (picked.s, picked.v) = (s, 1.0 - down);
    }
    let hue = picked.h;
    let color = |s: f32, down: f32| HsvaGamma { h: hue, s, v: 1.0 - down, a: 1.0 };
    ui.painter().add(gradient(rect, [CELLS, CELLS], color));
    let at = rect.min + vec2(picked.s * rect.width(), (1.0 - picked.v) * rect.height());
    let ring = if picked.v > 0.6 && picked.s < 0.6 { Color32::BLACK } else { Color32::WHITE };
    ui.painter_at(rect).circle(at, 5.0, Color32::from(*picked), Stroke::new(1.5, ring));
    response
}

fn hues(ui: &mut Ui, picked: &mut HsvaGamma) -> Response {
    let (rect, response) = ui.allocate_exact_size(vec2(WIDTH, 14.0), Sense::click_and_drag());
    if let Some([h, _]) = pull(&response) {
        // The last hue is the first again, and the mark stays where it was put.
        picked.h = h.min(0.9999);
    }
    ui.painter().add(gradient(rect, [36, 1], |h, _| HsvaGamma { h, s: 1.0, v: 1.0, a: 1.0 }));
    let mark = rect.left() + picked.h * rect.width();
    let mark = Rect::from_center_size(pos2(mark, rect.center().y), vec2(4.0, rect.height() + 2.0));
    let line = Stroke::new(1.0, Color32::BLACK);
    ui.painter().rect(mark, 1.0, Color32::WHITE, line, egui::StrokeKind::Inside);
    response
}

/// Colours at the corners of cells; `color` of the shares to the right and down.
fn gradient(rect: Rect, [columns, rows]: [u32; 2], color: impl Fn(f32, f32) -> HsvaGamma) -> Mesh {
    let mut mesh = Mesh::default();
    for row in 0..=rows {
        for column in 0..=columns {
            let (x, y) = (column as f32 / columns as f32, row as f32 / rows as f32);
            let place: Pos2 = rect.min + vec2(x * rect.width(), y * rect.height());
            mesh.colored_vertex(place, color(x, y).into());
        }
    }
    for row in 0..rows {
        for column in 0..columns {
            let [a, c] = [row, row + 1].map(|row| row * (columns + 1) + column);
            mesh.add_triangle(a, a + 1, c);
            mesh.add_triangle(a + 1, c, c + 1);
        }
    }
    mesh
}

/// Of its largest part: more than 1 is brighter than a display shows.
fn brightness(ui: &mut Ui, name: &str, color: Vec3) -> Touched<Vec3> {
    let now = color.max_element();
    let touched = line(ui, "Brightness", "Its largest part: 1 is as bright as a display", |ui| {
        let number = Number { relative: true, least: 0.0, ..Number::default() };
        number.show(ui, &format!("{name} brightness"), Some(now.into()), ui.available_width()).1
    });
    let scaled =
        |value: f64| if now > 0.0 { color * (value as f32 / now) } else { Vec3::splat(value as f32) };
    Touched { value: touched.value.map(scaled), dragging: touched.dragging, ended: touched.ended }
}

/// As the web writes it, of what a display shows.
fn code(ui: &mut Ui, name: &str, shown: Vec3, most: f32) -> Touched<Vec3> {
    let id = ui.scope_id().with((name, "code"));
    let [r, g, b, _] = Color32::from(Hsva::from_rgb(shown.to_array())).to_array();
    let now = format!("{r:02x}{g:02x}{b:02x}");
    let mut text: String = ui.data(|data| data.get_temp(id)).unwrap_or_else(|| now.clone());
    let field = line(ui, "Code", "Red, green and blue as on the web: ff8800", |ui| {
        let field = egui::TextEdit::singleline(&mut text).desired_width(ui.available_width() - 8.0);
        ui.add(field)
    });
    field.ctx.accesskit_node_builder(field.id, |node| node.set_label(format!("{name} code")));
    if field.has_focus() {
        ui.data_mut(|data| data.insert_temp(id, text));
        return Touched::default();
    }
    ui.data_mut(|data| data.remove::<String>(id));
    let new = read(&text).filter(|_| field.lost_focus() && text != now);
    Touched { value: new.map(|new| new * most), dragging: false, ended: false }
}

fn line<R>(ui: &mut Ui, name: &str, tooltip: &str, widget: impl FnOnce(&mut Ui) -> R) -> R {
    ui.horizontal(|ui| {
        ui.set_width(WIDTH);
        let (rect, label) = ui.allocate_exact_size(vec2(70.0, theme::ROW - 2.0), Sense::hover());
        let font = egui::TextStyle::Body.resolve(ui.style());
        let color = ui.visuals().text_color();
        ui.painter().text(rect.left_center(), egui::Align2::LEFT_CENTER, name, font, color);
        label.on_hover_text(tooltip);
        widget(ui)
    })
    .inner
}

/// Linear, from `ff8800`, with `#` or without. `None`: it is no code.
fn read(text: &str) -> Option<Vec3> {
    let digits = text.trim().trim_start_matches('#');
    let is_code = digits.len() == 6 && digits.bytes().all(|digit| digit.is_ascii_hexdigit());
    let [0, r, g, b] = u32::from_str_radix(digits, 16).ok().filter(|_| is_code)?.to_be_bytes() else {
        return None;
    };
    let linear = Rgba::from(Color32::from_rgb(r, g, b));
    Some(Vec3::new(linear.r(), linear.g(), linear.b()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_read_as_the_web_writes_them() {
        assert_eq!(read("#ffffff"), Some(Vec3::ONE));
        let grey = read("808080").unwrap();
        // sRGB, IEC 61966-2-1: 128 of 255 is 0.2159 of the light.
        assert!(grey.abs_diff_eq(Vec3::splat(0.2159), 1e-3), "{grey}");
        assert!(["", "fff", "gggggg", "+fffff", "1234567"].iter().all(|text| read(text).is_none()));
    }

    #[test]
    fn a_color_that_is_picked_is_the_one_that_is_shown() {
        for color in [Vec3::new(0.7, 0.25, 0.1), Vec3::splat(0.5), Vec3::ZERO, Vec3::X] {
            let back = rgb(Hsva::from_rgb(color.to_array()).into());
            assert!(back.abs_diff_eq(color, 1e-4), "{color} {back}");
        }
    }
}
