//! Colours: linear RGB of any brightness, and the colour of what glows by its temperature.

use eframe::egui;
use egui::{Color32, Rgba, Sense, Ui, vec2};
use glam::Vec3;

use super::arithmetic::Unit;
use super::fields::{self, Number, Touched};
use super::picker;
use super::subject::Subject;
use crate::theme;

/// A patch of the colour that opens a picker, and its three numbers beside it.
pub fn row<K: Clone, C: Clone>(
    ui: &mut Ui,
    of: &mut Subject<'_, K, C>,
    (name, tooltip): (&str, &str),
    get: impl Fn(&C) -> Vec3,
    set: impl Fn(&mut C, Vec3),
) {
    let (shared, usual) = (of.shared(&get), of.reset_to(&get));
    let (touched, is_reset) = fields::resettable(ui, name, tooltip, usual.is_some(), |ui| {
        let patch =
            patch(ui, name, shared.or_else(|| of.first().map(&get)).unwrap_or_default(), shared.is_none());
        ui.add_space(2.0);
        let gap = 3.0;
        ui.spacing_mut().item_spacing.x = gap;
        ui.spacing_mut().button_padding.x = 2.0;
        let width = ((ui.available_width() - 2.0 * gap) / 3.0).max(24.0);
        let number = Number { least: 0.0, speed: 0.004, ..Number::default() };
        let parts = [0, 1, 2].map(|part| {
            let value = of.shared(|component| get(component)[part]).map(f64::from);
            number.show(ui, &format!("{name} {}", ["red", "green", "blue"][part]), value, width).1
        });
        (patch, parts)
    });
    of.set(&touched.0, &set);
    for (part, touched) in touched.1.iter().enumerate() {
        of.set(touched, |component, value| {
            let mut color = get(component);
            color[part] = value as f32;
            set(component, color);
        });
    }
    of.reset(usual, is_reset, set);
}

/// What is brighter than a display is picked at its brightest, and stays as bright as it was.
fn patch(ui: &mut Ui, name: &str, color: Vec3, mixed: bool) -> Touched<Vec3> {
    let most = color.max_element().max(1.0);
    let shown = color / most;
    let fill: Color32 = Rgba::from_rgb(shown.x, shown.y, shown.z).into();
    let (rect, response) = ui.allocate_exact_size(vec2(36.0, theme::ROW - 4.0), Sense::click());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::ColorWell, ui.is_enabled(), name));
    ui.painter().rect_filled(rect, 3.0, fill);
    let line = if response.hovered() { theme::accent(ui.visuals()) } else { theme::line(ui.visuals()) };
    ui.painter().rect_stroke(rect, 3.0, egui::Stroke::new(1.0, line), egui::StrokeKind::Inside);
    if mixed {
        let font = egui::FontId::proportional(12.0);
        ui.painter().text(
            rect.center(),
            egui::Align2::CENTER_CENTER,
            "\u{2014}",
            font,
            Color32::from_gray(128),
        );
    }
    let popup = egui::Popup::menu(&response).close_behavior(egui::PopupCloseBehavior::CloseOnClickOutside);
    popup.show(|ui| picker::show(ui, name, color)).map_or(Touched::default(), |shown| shown.inner)
}

/// Sets a colour as bright as it was.
pub fn kelvin<K: Clone, C: Clone>(
    ui: &mut Ui,
    of: &mut Subject<'_, K, C>,
    get: impl Fn(&C) -> Vec3,
    set: impl Fn(&mut C, Vec3),
) {
    // Looked for once where all have one colour: lamps can be many.
    let now = match of.shared(&get) {
        Some(color) => Some(nearest_kelvin(color)),
        None => of.shared(|component| nearest_kelvin(get(component))),
    };
    let number = Number {
        unit: Unit::Kelvin,
        speed: 10.0,
        least: 1000.0,
        most: 20000.0,
        decimals: 0,
        ..Number::default()
    };
    let tooltip =
        "The colour of a black body: 2700 K is a bulb, 6500 K daylight. A dash: the colour is none of those";
    let touched = fields::row(ui, "Temperature", tooltip, |ui| {
        let width = ui.available_width();
        number.show(ui, "Temperature", now.flatten(), width).1
    });
    of.set(&touched, |component, kelvin| {
        let color = get(component);
        set(component, black_body(kelvin) * color.max_element());
    });
}

/// Linear sRGB of a black body, its largest part 1. The chromaticity is the fit of Kim and others to the Planckian locus
/// (US patent 7 024 034, 2002), continued below 1667 K by its own edge.
pub fn black_body(kelvin: f64) -> Vec3 {
    let t = 1e3 / kelvin.clamp(1667.0, 25000.0);
    let x = match kelvin < 4000.0 {
        true => ((-0.2661239 * t - 0.2343589) * t + 0.8776956) * t + 0.179910,
        false => ((-3.0258469 * t + 2.1070379) * t + 0.2226347) * t + 0.240390,
    };
    let y = match kelvin {
        ..2222.0 => ((-1.1063814 * x - 1.34811020) * x + 2.18555832) * x - 0.20219683,
        ..4000.0 => ((-0.9549476 * x - 1.37418593) * x + 2.09137015) * x - 0.16748867,
        _ => ((3.0817580 * x - 5.87338670) * x + 3.75112997) * x - 0.37001483,
    };
    let [big_x, big_z] = [x / y, (1.0 - x - y) / y];
    // XYZ to linear sRGB (IEC 61966-2-1), Y = 1.
    let rgb = [
        3.2404542 * big_x - 1.5371385 - 0.4985314 * big_z,
        -0.9692660 * big_x + 1.8760108 + 0.0415560 * big_z,
        0.0556434 * big_x - 0.2040259 + 1.0572252 * big_z,
    ];
    let most = rgb.iter().copied().fold(0.0, f64::max);
    Vec3::from(rgb.map(|part| (part.max(0.0) / most) as f32))
}

/// `None`: no black body has the colour.
fn nearest_kelvin(color: Vec3) -> Option<f64> {
    let most = color.max_element();
    let color = (most > 0.0).then(|| color / most)?;
    let apart = |kelvin: f64| black_body(kelvin).distance(color);
    // In steps of the reciprocal, which the eye tells apart evenly.
    let steps = (0..=400)
        .map(|step| 1e6 / (1e6 / 20000.0 + (1e6 / 1700.0 - 1e6 / 20000.0) * f64::from(step) / 400.0));
    let nearest = steps.min_by(|a, b| apart(*a).total_cmp(&apart(*b)))?;
    let mut kelvin = nearest;
    for width in [40.0, 5.0, 0.5] {
        let around = (-20..=20).map(|off| kelvin + f64::from(off) * width * 0.1);
        kelvin = around.min_by(|a, b| apart(*a).total_cmp(&apart(*b)))?;
    }
    (apart(kelvin) < 0.02).then_some(kelvin.round())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_black_body_is_red_when_cool_white_at_daylight_and_blue_when_hot() {
        let cool = black_body(2000.0);
        assert!(cool.x == 1.0 && cool.z < 0.1);
        assert!(black_body(6500.0).min_element() > 0.9);
        let hot = black_body(15000.0);
        assert!(hot.z == 1.0 && hot.x < 0.7);
    }

    #[test]
    fn a_temperature_that_was_set_is_read_again() {
        for kelvin in [1800.0, 2700.0, 4000.0, 6500.0, 9000.0] {
            let found = nearest_kelvin(black_body(kelvin) * 7.0).unwrap();
            assert!((found / kelvin - 1.0).abs() < 0.02, "{kelvin} {found}");
        }
        assert_eq!(nearest_kelvin(Vec3::new(0.0, 1.0, 0.0)), None);
        assert_eq!(nearest_kelvin(Vec3::ZERO), None);
    }
}
