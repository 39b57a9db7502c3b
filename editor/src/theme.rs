//! How the editor looks: two palettes, one spacing, one size of text. Grey surfaces keep the eye on the picture; the one
//! accent says what is selected or pressed.

use eframe::egui;
use egui::{
    Color32, CornerRadius, FontFamily, FontId, Margin, Rect, Response, Shadow, Stroke, StrokeKind, Style,
    TextStyle, Theme, Ui, Visuals, vec2,
};

/// Height of a row in lists, of a field, of a button in a bar; points.
pub const ROW: f32 = 22.0;
/// Width that the names of fields take up in the inspector.
pub const NAMES: f32 = 116.0;

/// Of one theme, from the back to the front.
struct Palette {
    bars: Color32,
    panel: Color32,
    field: Color32,
    widget: Color32,
    hovered: Color32,
    pressed: Color32,
    line: Color32,
    text: Color32,
    strong: Color32,
    weak: Color32,
    accent: Color32,
    selection: Color32,
    on_selection: Color32,
    warning: Color32,
    error: Color32,
}

const fn rgb(hex: u32) -> Color32 {
    Color32::from_rgb((hex >> 16) as u8, (hex >> 8) as u8, hex as u8)
}

const DARK: Palette = Palette {
    bars: rgb(0x1b1c1f),
    panel: rgb(0x26282c),
    field: rgb(0x1c1d20),
    widget: rgb(0x35383e),
    hovered: rgb(0x42464d),
    pressed: rgb(0x4d525b),
    line: rgb(0x17181a),
    text: rgb(0xcdd0d5),
    strong: rgb(0xf2f3f5),
    weak: rgb(0x8f959e),
    accent: rgb(0x4a90e2),
    selection: rgb(0x2c5688),
    on_selection: rgb(0xffffff),
    warning: rgb(0xe6b450),
    error: rgb(0xf0716a),
};

const LIGHT: Palette = Palette {
    bars: rgb(0xc6c9ce),
    panel: rgb(0xe9ebee),
    field: rgb(0xfafbfc),
    widget: rgb(0xd5d8dd),
    hovered: rgb(0xc7ccd3),
    pressed: rgb(0xb6bcc5),
    line: rgb(0xb4b9c0),
    text: rgb(0x2a2d32),
    strong: rgb(0x0d0e10),
    weak: rgb(0x60666f),
    accent: rgb(0x2469c4),
    selection: rgb(0xa9caf2),
    on_selection: rgb(0x0d0e10),
    warning: rgb(0x9a6700),
    error: rgb(0xc0322b),
};

/// Both themes; which one is shown is the user's.
pub fn install(ctx: &egui::Context) {
    for (theme, palette) in [(Theme::Dark, &DARK), (Theme::Light, &LIGHT)] {
        ctx.style_mut_of(theme, |style| apply(style, palette));
    }
}

fn apply(style: &mut Style, palette: &Palette) {
    style.text_styles = [
        (TextStyle::Heading, FontId::new(15.0, FontFamily::Proportional)),
        (TextStyle::Body, FontId::new(13.0, FontFamily::Proportional)),
        (TextStyle::Button, FontId::new(13.0, FontFamily::Proportional)),
        (TextStyle::Small, FontId::new(11.0, FontFamily::Proportional)),
        (TextStyle::Monospace, FontId::new(12.0, FontFamily::Monospace)),
    ]
    .into();
    let spacing = &mut style.spacing;
    spacing.item_spacing = vec2(6.0, 4.0);
    spacing.button_padding = vec2(7.0, 2.0);
    spacing.interact_size = vec2(32.0, ROW - 2.0);
    spacing.window_margin = Margin::same(10);
    spacing.menu_margin = Margin::same(5);
    spacing.indent = 14.0;
    spacing.icon_width = 15.0;
    spacing.icon_width_inner = 8.0;
    spacing.combo_width = 60.0;
    spacing.tooltip_width = 320.0;
    spacing.scroll = egui::style::ScrollStyle::solid();
    spacing.scroll.bar_width = 8.0;
    spacing.scroll.bar_inner_margin = 2.0;
    spacing.scroll.bar_outer_margin = 0.0;
    style.interaction.tooltip_delay = 0.45;
    style.interaction.selectable_labels = false;
    style.drag_value_text_style = TextStyle::Body;
    style.animation_time = 0.08;
    visuals(&mut style.visuals, palette);
}

fn visuals(visuals: &mut Visuals, palette: &Palette) {
    let corner = CornerRadius::same(3);
    visuals.weak_text_color = Some(palette.weak);
    visuals.hyperlink_color = palette.accent;
    visuals.faint_bg_color = palette.panel.lerp_to_gamma(palette.widget, 0.25);
    visuals.extreme_bg_color = palette.field;
    visuals.text_edit_bg_color = Some(palette.field);
    visuals.code_bg_color = palette.field;
    visuals.warn_fg_color = palette.warning;
    visuals.error_fg_color = palette.error;
    visuals.panel_fill = palette.panel;
    visuals.window_fill = palette.panel.lerp_to_gamma(palette.bars, 0.25);
    visuals.window_stroke = Stroke::new(1.0, palette.line);
    visuals.window_corner_radius = CornerRadius::same(5);
    visuals.menu_corner_radius = CornerRadius::same(4);
    let shadow = Shadow { offset: [0, 4], blur: 14, spread: 0, color: Color32::from_black_alpha(90) };
    (visuals.window_shadow, visuals.popup_shadow) = (shadow, shadow);
    visuals.selection.bg_fill = palette.selection;
    visuals.selection.stroke = Stroke::new(1.0, palette.on_selection);
    visuals.slider_trailing_fill = true;
    visuals.collapsing_header_frame = false;
    visuals.indent_has_left_vline = false;
    visuals.striped = false;
    visuals.resize_corner_size = 10.0;
    let states = [
        (&mut visuals.widgets.noninteractive, palette.panel, palette.line, palette.text),
        (&mut visuals.widgets.inactive, palette.widget, palette.widget, palette.text),
        (&mut visuals.widgets.hovered, palette.hovered, palette.hovered, palette.strong),
        (&mut visuals.widgets.active, palette.pressed, palette.accent, palette.strong),
        (&mut visuals.widgets.open, palette.hovered, palette.hovered, palette.strong),
    ];
    for (state, fill, line, text) in states {
        state.bg_fill = fill;
        state.weak_bg_fill = fill;
        state.bg_stroke = Stroke::new(1.0, line);
        state.fg_stroke = Stroke::new(1.0, text);
        state.corner_radius = corner;
        state.expansion = 0.0;
    }
}

fn palette(visuals: &Visuals) -> &'static Palette {
    if visuals.dark_mode { &DARK } else { &LIGHT }
}

/// A dialog over everything, with room around what it says.
pub fn dialog(ui: &Ui, name: &str) -> egui::Modal {
    let frame = egui::Frame::popup(ui.style()).inner_margin(Margin::symmetric(16, 14));
    egui::Modal::new(egui::Id::unique(name)).frame(frame)
}

/// Behind menus, toolbar, tabs and status.
pub fn bars(visuals: &Visuals) -> Color32 {
    palette(visuals).bars
}

pub fn accent(visuals: &Visuals) -> Color32 {
    palette(visuals).accent
}

pub fn line(visuals: &Visuals) -> Color32 {
    palette(visuals).line
}

pub fn weak(visuals: &Visuals) -> Color32 {
    palette(visuals).weak
}

/// x, y and z, as everybody paints them; and light enough for text.
pub const AXES: [Color32; 3] = [rgb(0xe5534b), rgb(0x7cb342), rgb(0x4a8ff0)];
/// What is grasped or about to be.
pub const GRASPED: Color32 = rgb(0xffd24a);
/// As the outline in the scene view.
pub const SELECTED: Color32 = rgb(0xff9421);

/// Where the keyboard is.
pub fn focus_ring(ui: &Ui, rect: Rect, response: &Response) {
    if response.has_focus() {
        let stroke = Stroke::new(1.0, accent(ui.visuals()));
        ui.painter().rect_stroke(rect, 3.0, stroke, StrokeKind::Inside);
    }
}

/// A frame that fills a panel.
pub fn panel(style: &Style) -> egui::Frame {
    egui::Frame::new().fill(style.visuals.panel_fill).inner_margin(Margin::symmetric(6, 5))
}

/// A frame that fills a bar.
pub fn bar(style: &Style) -> egui::Frame {
    egui::Frame::new().fill(bars(&style.visuals)).inner_margin(Margin::symmetric(8, 3))
}
