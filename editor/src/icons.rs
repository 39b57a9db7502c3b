//! Small pictures for buttons and lists, drawn of lines on a square of 16 points, so that they are sharp at any scale
//! and in any theme.

use eframe::egui;
use egui::{
    Color32, Painter, Pos2, Rect, Response, Role, Sense, Shape, Stroke, Ui, Vec2, WidgetInfo, pos2, vec2,
};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Icon {
    View,
    Move,
    Rotate,
    Scale,
    Global,
    Local,
    Pivot,
    Centre,
    Snap,
    Brush,
    Play,
    Pause,
    Step,
    Stop,
    Empty,
    Mesh,
    Sun,
    Lamp,
    Spot,
    Camera,
    LightProbes,
    ReflectionProbe,
    Sky,
    Eye,
    EyeShut,
    Lock,
    Unlock,
    Plus,
    Search,
    Close,
    Check,
    More,
    Folder,
    File,
    Picture,
    Material,
    Info,
    Warning,
    Error,
    Bake,
    Grid,
    Reset,
    Orthographic,
    Perspective,
}

enum Part {
    /// From point to point.
    Open(&'static [(f32, f32)]),
    Closed(&'static [(f32, f32)]),
    Filled(&'static [(f32, f32)]),
    Circle(f32, f32, f32),
    Disc(f32, f32, f32),
}

use Part::{Circle, Closed, Disc, Filled, Open};

fn parts(icon: Icon) -> &'static [Part] {
    match icon {
        Icon::View => &[
            Open(&[(2.0, 8.0), (5.0, 4.8), (8.0, 4.0), (11.0, 4.8), (14.0, 8.0)]),
            Open(&[(2.0, 8.0), (5.0, 11.2), (8.0, 12.0), (11.0, 11.2), (14.0, 8.0)]),
            Disc(8.0, 8.0, 2.2),
        ],
        Icon::Move => &[
            Open(&[(8.0, 2.0), (8.0, 14.0)]),
            Open(&[(2.0, 8.0), (14.0, 8.0)]),
            Open(&[(6.0, 4.0), (8.0, 2.0), (10.0, 4.0)]),
            Open(&[(6.0, 12.0), (8.0, 14.0), (10.0, 12.0)]),
            Open(&[(4.0, 6.0), (2.0, 8.0), (4.0, 10.0)]),
            Open(&[(12.0, 6.0), (14.0, 8.0), (12.0, 10.0)]),
        ],
        Icon::Rotate => &[
            Open(&[
                (13.2, 9.0),
                (12.2, 11.6),
                (9.9, 13.1),
                (7.2, 13.2),
                (4.7, 11.9),
                (3.1, 9.6),
                (3.1, 6.8),
                (4.5, 4.4),
                (6.8, 3.0),
                (9.4, 3.0),
                (11.7, 4.2),
                (13.0, 6.0),
            ]),
            Open(&[(13.4, 2.6), (13.2, 6.2), (9.8, 5.8)]),
        ],
        Icon::Scale => &[
            Closed(&[(2.5, 8.5), (7.5, 8.5), (7.5, 13.5), (2.5, 13.5)]),
            Open(&[(8.5, 2.5), (13.5, 2.5), (13.5, 7.5)]),
            Open(&[(13.5, 2.5), (9.0, 7.0)]),
        ],
        Icon::Global | Icon::Sky => &[
            Circle(8.0, 8.0, 5.7),
            Open(&[(2.4, 8.0), (13.6, 8.0)]),
            Open(&[(8.0, 2.3), (5.8, 4.8), (5.2, 8.0), (5.8, 11.2), (8.0, 13.7)]),
            Open(&[(8.0, 2.3), (10.2, 4.8), (10.8, 8.0), (10.2, 11.2), (8.0, 13.7)]),
        ],
        Icon::Local | Icon::Mesh => &[
            Closed(&[(8.0, 1.8), (13.4, 4.9), (13.4, 11.1), (8.0, 14.2), (2.6, 11.1), (2.6, 4.9)]),
            Open(&[(2.6, 4.9), (8.0, 8.0), (13.4, 4.9)]),
            Open(&[(8.0, 8.0), (8.0, 14.2)]),
        ],
        Icon::Pivot => &[
            Circle(4.6, 11.4, 2.0),
            Open(&[(6.0, 10.0), (12.8, 3.2)]),
            Open(&[(9.4, 3.0), (13.0, 3.0), (13.0, 6.6)]),
        ],
        Icon::Centre => &[Closed(&[(2.8, 2.8), (13.2, 2.8), (13.2, 13.2), (2.8, 13.2)]), Disc(8.0, 8.0, 2.0)],
        Icon::Snap => &[
            Open(&[
                (3.0, 2.5),
                (3.0, 8.5),
                (4.2, 11.4),
                (6.6, 13.1),
                (9.4, 13.1),
                (11.8, 11.4),
                (13.0, 8.5),
                (13.0, 2.5),
                (10.0, 2.5),
                (10.0, 8.5),
                (9.2, 9.9),
                (8.0, 10.4),
                (6.8, 9.9),
                (6.0, 8.5),
                (6.0, 2.5),
                (3.0, 2.5),
            ]),
            Open(&[(3.0, 5.5), (6.0, 5.5)]),
            Open(&[(10.0, 5.5), (13.0, 5.5)]),
        ],
        Icon::Play => &[Filled(&[(4.5, 2.5), (13.0, 8.0), (4.5, 13.5)])],
        Icon::Pause => &[
            Filled(&[(4.0, 3.0), (6.8, 3.0), (6.8, 13.0), (4.0, 13.0)]),
            Filled(&[(9.2, 3.0), (12.0, 3.0), (12.0, 13.0), (9.2, 13.0)]),
        ],
        Icon::Step => &[
            Filled(&[(3.5, 3.0), (10.0, 8.0), (3.5, 13.0)]),
            Filled(&[(10.8, 3.0), (12.8, 3.0), (12.8, 13.0), (10.8, 13.0)]),
        ],
        Icon::Stop => &[Filled(&[(3.8, 3.8), (12.2, 3.8), (12.2, 12.2), (3.8, 12.2)])],
        Icon::Empty => &[
            Open(&[(8.0, 9.0), (8.0, 2.5)]),
            Open(&[(8.0, 9.0), (13.4, 12.4)]),
            Open(&[(8.0, 9.0), (2.6, 12.4)]),
        ],
        Icon::Sun => &[
            Circle(8.0, 8.0, 2.9),
            Open(&[(8.0, 1.6), (8.0, 3.2)]),
            Open(&[(8.0, 12.8), (8.0, 14.4)]),
            Open(&[(1.6, 8.0), (3.2, 8.0)]),
            Open(&[(12.8, 8.0), (14.4, 8.0)]),
            Open(&[(3.5, 3.5), (4.6, 4.6)]),
            Open(&[(11.4, 11.4), (12.5, 12.5)]),
            Open(&[(3.5, 12.5), (4.6, 11.4)]),
            Open(&[(11.4, 4.6), (12.5, 3.5)]),
        ],
        Icon::Lamp => &[
            Open(&[
                (6.2, 11.0),
                (6.0, 9.6),
                (4.4, 7.8),
                (4.2, 5.6),
                (5.4, 3.4),
                (8.0, 2.4),
                (10.6, 3.4),
                (11.8, 5.6),
                (11.6, 7.8),
                (10.0, 9.6),
                (9.8, 11.0),
                (6.2, 11.0),
            ]),
            Open(&[(6.4, 12.6), (9.6, 12.6)]),
            Open(&[(7.0, 14.1), (9.0, 14.1)]),
        ],
        Icon::Spot => &[
            Closed(&[(6.0, 2.5), (10.0, 2.5), (11.4, 7.0), (4.6, 7.0)]),
            Open(&[(8.0, 9.0), (8.0, 13.5)]),
            Open(&[(5.0, 9.0), (3.0, 13.0)]),
            Open(&[(11.0, 9.0), (13.0, 13.0)]),
        ],
        Icon::Camera => &[
            Closed(&[(1.8, 4.6), (10.0, 4.6), (10.0, 11.8), (1.8, 11.8)]),
            Closed(&[(10.0, 7.2), (14.2, 4.9), (14.2, 11.5), (10.0, 9.2)]),
        ],
        Icon::Brush => &[
            Open(&[(13.6, 2.4), (7.4, 8.6)]),
            Open(&[(12.0, 2.0), (6.2, 7.8)]),
            Open(&[(14.0, 4.0), (8.2, 9.8)]),
            Filled(&[
                (5.9, 8.4),
                (7.6, 10.1),
                (7.0, 12.2),
                (4.6, 13.4),
                (2.2, 13.6),
                (3.2, 12.0),
                (3.8, 9.8),
            ]),
        ],
        Icon::LightProbes => &[
            Open(&[(4.0, 4.5), (12.0, 3.5), (8.5, 12.5), (4.0, 4.5)]),
            Disc(4.0, 4.5, 2.1),
            Disc(12.0, 3.5, 2.1),
            Disc(8.5, 12.5, 2.1),
        ],
        Icon::ReflectionProbe | Icon::Material => {
            &[Circle(8.0, 8.0, 5.7), Open(&[(4.6, 7.4), (5.4, 5.6), (7.2, 4.6)])]
        }
        Icon::Eye => &[
            Open(&[(2.0, 8.0), (5.0, 4.8), (8.0, 4.0), (11.0, 4.8), (14.0, 8.0)]),
            Open(&[(2.0, 8.0), (5.0, 11.2), (8.0, 12.0), (11.0, 11.2), (14.0, 8.0)]),
            Circle(8.0, 8.0, 1.8),
        ],
        Icon::EyeShut => &[
            Open(&[(2.0, 7.0), (5.0, 9.8), (8.0, 10.6), (11.0, 9.8), (14.0, 7.0)]),
            Open(&[(4.4, 9.6), (3.4, 11.4)]),
            Open(&[(8.0, 10.6), (8.0, 12.7)]),
            Open(&[(11.6, 9.6), (12.6, 11.4)]),
        ],
        Icon::Lock => &[
            Closed(&[(3.6, 7.4), (12.4, 7.4), (12.4, 13.4), (3.6, 13.4)]),
            Open(&[(5.4, 7.4), (5.4, 4.8), (6.4, 3.2), (8.0, 2.6), (9.6, 3.2), (10.6, 4.8), (10.6, 7.4)]),
        ],
        Icon::Unlock => &[
            Closed(&[(3.6, 7.4), (12.4, 7.4), (12.4, 13.4), (3.6, 13.4)]),
            Open(&[(5.4, 7.4), (5.4, 4.2), (6.4, 2.6), (8.0, 2.0), (9.6, 2.6), (10.4, 3.8)]),
        ],
        Icon::Plus => &[Open(&[(8.0, 3.0), (8.0, 13.0)]), Open(&[(3.0, 8.0), (13.0, 8.0)])],
        Icon::Search => &[Circle(6.8, 6.8, 4.2), Open(&[(9.9, 9.9), (13.6, 13.6)])],
        Icon::Close => &[Open(&[(4.0, 4.0), (12.0, 12.0)]), Open(&[(12.0, 4.0), (4.0, 12.0)])],
        Icon::Check => &[Open(&[(3.5, 8.5), (6.5, 11.5), (12.5, 4.5)])],
        Icon::More => &[Disc(8.0, 3.5, 1.2), Disc(8.0, 8.0, 1.2), Disc(8.0, 12.5, 1.2)],
        Icon::Folder => {
            &[Closed(&[(1.8, 3.4), (6.2, 3.4), (7.8, 5.2), (14.2, 5.2), (14.2, 12.8), (1.8, 12.8)])]
        }
        Icon::File => &[
            Closed(&[(3.6, 1.8), (9.6, 1.8), (12.6, 4.8), (12.6, 14.2), (3.6, 14.2)]),
            Open(&[(9.4, 2.0), (9.4, 5.0), (12.4, 5.0)]),
        ],
        Icon::Picture => &[
            Closed(&[(2.0, 3.0), (14.0, 3.0), (14.0, 13.0), (2.0, 13.0)]),
            Open(&[(2.4, 11.6), (6.2, 7.6), (9.0, 10.4), (11.0, 8.6), (13.8, 11.2)]),
            Disc(10.6, 5.8, 1.2),
        ],
        Icon::Info => &[Circle(8.0, 8.0, 6.0), Open(&[(8.0, 7.2), (8.0, 11.6)]), Disc(8.0, 4.9, 0.95)],
        Icon::Warning => &[
            Closed(&[(8.0, 2.0), (14.6, 13.4), (1.4, 13.4)]),
            Open(&[(8.0, 6.2), (8.0, 9.8)]),
            Disc(8.0, 11.7, 0.9),
        ],
        Icon::Error => {
            &[Circle(8.0, 8.0, 6.0), Open(&[(5.6, 5.6), (10.4, 10.4)]), Open(&[(10.4, 5.6), (5.6, 10.4)])]
        }
        Icon::Bake => &[
            Closed(&[(2.5, 2.5), (13.5, 2.5), (13.5, 13.5), (2.5, 13.5)]),
            Open(&[(2.5, 8.0), (13.5, 8.0)]),
            Open(&[(8.0, 2.5), (8.0, 13.5)]),
            Filled(&[(3.6, 3.6), (6.9, 3.6), (6.9, 6.9), (3.6, 6.9)]),
            Filled(&[(9.1, 9.1), (12.4, 9.1), (12.4, 12.4), (9.1, 12.4)]),
        ],
        Icon::Grid => &[
            Closed(&[(2.5, 2.5), (13.5, 2.5), (13.5, 13.5), (2.5, 13.5)]),
            Open(&[(6.2, 2.5), (6.2, 13.5)]),
            Open(&[(9.8, 2.5), (9.8, 13.5)]),
            Open(&[(2.5, 6.2), (13.5, 6.2)]),
            Open(&[(2.5, 9.8), (13.5, 9.8)]),
        ],
        Icon::Reset => &[
            Open(&[
                (3.4, 6.2),
                (5.6, 3.8),
                (8.6, 3.0),
                (11.6, 4.2),
                (13.2, 7.0),
                (12.8, 10.2),
                (10.6, 12.6),
                (7.4, 13.0),
                (4.6, 11.6),
            ]),
            Open(&[(2.8, 2.8), (3.2, 6.4), (6.8, 6.2)]),
        ],
        Icon::Orthographic => &[
            Open(&[(2.5, 4.0), (13.5, 4.0)]),
            Open(&[(2.5, 8.0), (13.5, 8.0)]),
            Open(&[(2.5, 12.0), (13.5, 12.0)]),
        ],
        Icon::Perspective => &[
            Open(&[(2.0, 8.0), (14.0, 3.0)]),
            Open(&[(2.0, 8.0), (14.0, 8.0)]),
            Open(&[(2.0, 8.0), (14.0, 13.0)]),
        ],
    }
}

/// Draws it into the middle of a rectangle, 16 points wide times `scale`.
pub fn paint_scaled(painter: &Painter, rect: Rect, icon: Icon, color: Color32, scale: f32) {
    let corner = rect.center() - Vec2::splat(8.0 * scale);
    let at = |&(x, y): &(f32, f32)| -> Pos2 { pos2(corner.x + x * scale, corner.y + y * scale) };
    let stroke = Stroke::new(1.25 * scale, color);
    for part in parts(icon) {
        let line = |points: &[(f32, f32)]| points.iter().map(at).collect::<Vec<_>>();
        painter.add(match part {
            Open(points) => Shape::line(line(points), stroke),
            Closed(points) => Shape::closed_line(line(points), stroke),
            Filled(points) => Shape::convex_polygon(line(points), color, Stroke::NONE),
            Circle(x, y, radius) => Shape::circle_stroke(at(&(*x, *y)), radius * scale, stroke),
            Disc(x, y, radius) => Shape::circle_filled(at(&(*x, *y)), radius * scale, color),
        });
    }
}

pub fn paint(painter: &Painter, rect: Rect, icon: Icon, color: Color32) {
    paint_scaled(painter, rect, icon, color, 1.0);
}

/// A square button with a picture; `name` is what screen readers say, and the first line of the tooltip.
pub fn button(ui: &mut Ui, icon: Icon, name: &str, tooltip: &str, selected: bool) -> Response {
    let (rect, response) = ui.allocate_exact_size(vec2(26.0, 22.0), Sense::click());
    response.widget_info(|| WidgetInfo::selected(Role::Button, ui.is_enabled(), selected, name));
    draw_button(ui, rect, &response, icon, selected);
    response.on_hover_ui(|ui| {
        ui.label(egui::RichText::new(name).strong());
        if !tooltip.is_empty() {
            ui.label(tooltip);
        }
    })
}

fn draw_button(ui: &Ui, rect: Rect, response: &Response, icon: Icon, selected: bool) {
    let visuals = ui.style().interact_selectable(response, selected);
    if selected || response.hovered() || response.has_focus() {
        ui.painter().rect_filled(rect, visuals.corner_radius, visuals.weak_bg_fill);
    }
    if response.has_focus() {
        let stroke = Stroke::new(1.0, crate::theme::accent(ui.visuals()));
        ui.painter().rect_stroke(rect, visuals.corner_radius, stroke, egui::StrokeKind::Inside);
    }
    let color =
        if ui.is_enabled() { visuals.text_color() } else { ui.visuals().gray_out(visuals.text_color()) };
    paint(ui.painter(), rect, icon, color);
}

/// Only the picture, as wide as a row is high.
pub fn label(ui: &mut Ui, icon: Icon, color: Color32) {
    let (rect, _) = ui.allocate_exact_size(vec2(16.0, 16.0), Sense::hover());
    paint(ui.painter(), rect, icon, color);
}
