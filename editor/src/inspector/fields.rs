//! Rows of the inspector: a name on the left with a tooltip, a widget on the right, all of one height and one edge.

use eframe::egui;
use egui::collapsing_header::CollapsingState;
use egui::{Color32, DragValue, Rect, Response, RichText, Role, Sense, Ui, WidgetInfo, vec2};

use super::arithmetic::{self, Unit};
use crate::icons::{self, Icon};
use crate::theme;

/// What came of a field: a new value, and whether the pull at it is over.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Touched<T> {
    pub value: Option<T>,
    /// More values will follow until it ends.
    pub dragging: bool,
    pub ended: bool,
}

/// How a number is shown and changed.
#[derive(Clone, Copy, Debug)]
pub struct Number {
    pub unit: Unit,
    /// A point of the mouse's way; relative to the value where `relative`.
    pub speed: f64,
    pub relative: bool,
    pub least: f64,
    pub most: f64,
    pub decimals: usize,
    pub shows_unit: bool,
}

impl Default for Number {
    fn default() -> Self {
        let (least, most) = (f64::NEG_INFINITY, f64::INFINITY);
        Self { unit: Unit::None, speed: 0.01, relative: false, least, most, decimals: 3, shows_unit: true }
    }
}

impl Number {
    /// 0 or more, pulled in shares of itself: intensities, ranges.
    pub fn positive(unit: Unit) -> Self {
        Self { unit, relative: true, least: 0.0, ..Self::default() }
    }

    pub fn share() -> Self {
        Self { speed: 0.004, least: 0.0, most: 1.0, ..Self::default() }
    }

    pub fn metres() -> Self {
        Self { unit: Unit::Metres, ..Self::default() }
    }

    pub fn degrees() -> Self {
        Self { unit: Unit::Degrees, speed: 0.25, decimals: 2, ..Self::default() }
    }

    /// A field for a value; `None`: what is selected has different ones.
    pub fn show(&self, ui: &mut Ui, name: &str, value: Option<f64>, width: f32) -> (Response, Touched<f64>) {
        // As good as 0, and yet 0 is a change.
        let mut new = value.unwrap_or(f64::MIN_POSITIVE);
        let mixed = value.is_none();
        let speed = if self.relative { (new.abs() * 0.01).max(0.002) } else { self.speed };
        let unit = self.unit;
        let old = new;
        let said = self.fitting(ui, new, width);
        let field = DragValue::new(&mut new)
            .speed(speed)
            .range(self.least..=self.most)
            .clamp_existing_to_range(false)
            .update_while_editing(false)
            .custom_formatter(
                move |value, _| if mixed { "\u{2014}".to_owned() } else { told(value, said.0, said.1) },
            )
            .custom_parser(move |text| arithmetic::number(text, unit));
        let response = ui.add_sized(vec2(width, theme::ROW - 2.0), field);
        response.ctx.accesskit_node_builder(response.id, |node| node.set_label(name));
        let dragging = response.dragged();
        // Who only looks into a field leaves it, and takes nothing off its last digits.
        let is_rounded = !mixed && !dragging && told(new, said.0, said.1) == told(old, said.0, said.1);
        let value = (response.changed() && !is_rounded).then_some(new);
        (response.clone(), Touched { value, dragging, ended: response.drag_stopped() })
    }

    /// As many decimals as there is room for, and the unit where all of them fit.
    fn fitting(&self, ui: &Ui, value: f64, width: f32) -> (usize, Unit) {
        let room = width - 2.0 * ui.spacing().button_padding.x;
        let font = ui.style().drag_value_text_style.resolve(ui.style());
        let fits = |decimals: usize, unit: Unit| {
            let text = told(value, decimals, unit);
            ui.painter().layout_no_wrap(text, font.clone(), Color32::WHITE).size().x <= room
        };
        if self.shows_unit && fits(self.decimals, self.unit) {
            return (self.decimals, self.unit);
        }
        let decimals = (0..=self.decimals).rev().find(|decimals| fits(*decimals, Unit::None));
        (decimals.unwrap_or(0), Unit::None)
    }
}

/// Without zeros at the end.
pub fn told(value: f64, decimals: usize, unit: Unit) -> String {
    let text = format!("{value:.decimals$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    let text = if text == "-0" { "0" } else { text };
    format!("{text}{}", unit.suffix())
}

/// Left of a name: room for the arrow that resets its field.
const GUTTER: f32 = 14.0;

/// A name and what belongs to it.
pub fn row<R>(ui: &mut Ui, name: &str, tooltip: &str, widget: impl FnOnce(&mut Ui) -> R) -> R {
    resettable(ui, name, tooltip, false, widget).0
}

/// The same with an arrow before the name where the value `is_changed`. Returns whether it was pressed.
pub fn resettable<R>(
    ui: &mut Ui,
    name: &str,
    tooltip: &str,
    is_changed: bool,
    widget: impl FnOnce(&mut Ui) -> R,
) -> (R, bool) {
    ui.horizontal(|ui| {
        ui.set_min_height(theme::ROW - 2.0);
        let width = theme::NAMES.min(ui.available_width() * 0.45);
        let gap = std::mem::take(&mut ui.spacing_mut().item_spacing.x);
        let is_reset = reset_arrow(ui, name, is_changed);
        ui.spacing_mut().item_spacing.x = gap;
        let size = vec2(width - GUTTER, theme::ROW - 2.0);
        let (rect, response) = ui.allocate_exact_size(size, egui::Sense::hover());
        let font = egui::TextStyle::Body.resolve(ui.style());
        let color = ui.visuals().text_color();
        let painter = ui.painter().with_clip_rect(rect.intersect(ui.clip_rect()));
        painter.text(rect.left_center(), egui::Align2::LEFT_CENTER, name, font, color);
        response.on_hover_ui(|ui| {
            ui.label(RichText::new(name).strong());
            ui.label(tooltip);
        });
        (widget(ui), is_reset)
    })
    .inner
}

fn reset_arrow(ui: &mut Ui, name: &str, is_changed: bool) -> bool {
    let sense = if is_changed { Sense::click() } else { Sense::hover() };
    let (rect, response) = ui.allocate_exact_size(vec2(GUTTER, theme::ROW - 2.0), sense);
    if !is_changed {
        return false;
    }
    let told = format!("Reset {}", name.to_lowercase());
    response.widget_info(|| WidgetInfo::labeled(Role::Button, ui.is_enabled(), &told));
    let is_lit = response.hovered() || response.has_focus();
    let color = if is_lit { theme::accent(ui.visuals()) } else { theme::weak(ui.visuals()) };
    icons::paint_scaled(ui.painter(), rect.translate(vec2(-1.0, 0.0)), Icon::Reset, color, 0.62);
    response.on_hover_text(told).clicked()
}

/// Three numbers side by side, x, y and z.
pub fn vector(ui: &mut Ui, name: &str, number: &Number, values: [Option<f64>; 3]) -> [Touched<f64>; 3] {
    let gap = 3.0;
    let letter = 11.0;
    // Its name's tooltip tells the unit, once for all three.
    let bare = Number { shows_unit: false, ..*number };
    let width = ((ui.available_width() - 2.0 * gap) / 3.0 - letter).max(24.0);
    ui.spacing_mut().item_spacing.x = gap;
    ui.spacing_mut().button_padding.x = 2.0;
    [0, 1, 2].map(|axis| {
        ui.scope(|ui| {
            ui.spacing_mut().item_spacing.x = 0.0;
            let (rect, _) = ui.allocate_exact_size(vec2(letter, theme::ROW - 2.0), egui::Sense::hover());
            let font = egui::FontId::proportional(11.0);
            let letter = ["X", "Y", "Z"][axis];
            ui.painter().text(
                rect.left_center(),
                egui::Align2::LEFT_CENTER,
                letter,
                font,
                axis_color(ui, axis),
            );
            bare.show(ui, &format!("{name} {letter}"), values[axis], width).1
        })
        .inner
    })
}

fn axis_color(ui: &Ui, axis: usize) -> Color32 {
    let color = theme::AXES[axis];
    if ui.visuals().dark_mode { color } else { color.lerp_to_gamma(Color32::BLACK, 0.3) }
}

/// A part with its fields, which can be folded. `remove`: the tooltip of the button that takes it off. Returns whether
/// that was pressed.
pub fn section(
    ui: &mut Ui,
    icon: Icon,
    name: &str,
    remove: Option<&str>,
    fields: impl FnOnce(&mut Ui),
) -> bool {
    let room = if remove.is_some() { 24.0 } else { 0.0 };
    let button = |ui: &mut Ui| remove.is_some_and(|told| small_button(ui, Icon::Close, told).clicked());
    folded(ui, icon, name, room, button, fields)
}

/// `room`: points that the buttons at the end of the head take. Gives what they give.
pub fn folded<R>(
    ui: &mut Ui,
    icon: Icon,
    name: &str,
    room: f32,
    buttons: impl FnOnce(&mut Ui) -> R,
    fields: impl FnOnce(&mut Ui),
) -> R {
    // Fields of the same name in other parts are others.
    ui.push_id(("component", name), |ui| head_and_fields(ui, icon, name, room, buttons, fields)).inner
}

fn head_and_fields<R>(
    ui: &mut Ui,
    icon: Icon,
    name: &str,
    room: f32,
    buttons: impl FnOnce(&mut Ui) -> R,
    fields: impl FnOnce(&mut Ui),
) -> R {
    let id = ui.make_persistent_id("fields");
    let mut state = CollapsingState::load_with_default_open(ui.ctx(), id, true);
    let line = theme::line(ui.visuals());
    let left = ui.cursor().left_top();
    ui.painter().hline(left.x..=left.x + ui.available_width(), left.y, egui::Stroke::new(1.0, line));
    ui.add_space(5.0);
    let given = ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let width = ui.available_width() - room;
        let (rect, head) = ui.allocate_exact_size(vec2(width, theme::ROW - 2.0), Sense::click());
        head.widget_info(|| WidgetInfo::labeled(Role::Button, true, name));
        paint_head(ui, rect, &head, state.is_open(), icon, name);
        if head.clicked() {
            state.toggle(ui);
        }
        buttons(ui)
    });
    state.show_body_unindented(ui, |ui| {
        ui.spacing_mut().item_spacing.y = 3.0;
        fields(ui);
        ui.add_space(5.0);
    });
    state.store(ui.ctx());
    given.inner
}

fn paint_head(ui: &Ui, rect: Rect, head: &Response, open: bool, icon: Icon, name: &str) {
    let color = if head.hovered() { ui.visuals().strong_text_color() } else { ui.visuals().text_color() };
    theme::focus_ring(ui, rect, head);
    let c = rect.left_center() + vec2(6.0, 0.0);
    let points = match open {
        true => vec![c + vec2(-4.0, -2.0), c + vec2(4.0, -2.0), c + vec2(0.0, 3.0)],
        false => vec![c + vec2(-2.0, -4.0), c + vec2(3.0, 0.0), c + vec2(-2.0, 4.0)],
    };
    ui.painter().add(egui::Shape::convex_polygon(points, theme::weak(ui.visuals()), egui::Stroke::NONE));
    let place = Rect::from_center_size(rect.left_center() + vec2(23.0, 0.0), vec2(16.0, 16.0));
    icons::paint_scaled(ui.painter(), place, icon, color, 0.85);
    let font = egui::FontId::proportional(13.5);
    let color = ui.visuals().strong_text_color();
    ui.painter().text(rect.left_center() + vec2(37.0, 0.0), egui::Align2::LEFT_CENTER, name, font, color);
}

/// A picture without a frame, for the end of a row; `name` is its tooltip too.
pub fn small_button(ui: &mut Ui, icon: Icon, name: &str) -> Response {
    let (rect, response) = ui.allocate_exact_size(vec2(18.0, theme::ROW - 2.0), Sense::click());
    response.widget_info(|| WidgetInfo::labeled(Role::Button, ui.is_enabled(), name));
    let color = if response.hovered() { ui.visuals().strong_text_color() } else { theme::weak(ui.visuals()) };
    theme::focus_ring(ui, rect, &response);
    icons::paint_scaled(ui.painter(), rect, icon, color, 0.7);
    response.on_hover_text(name)
}
