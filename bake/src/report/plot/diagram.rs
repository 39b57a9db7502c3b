//! A work-precision diagram: cost along x, error along y, both logarithmic.
//!
//! One line and marker a method; what nothing beats as a pale staircase below; floors dashed; shipped presets ringed and
//! named. Whiskers: least and largest of a point's runs along x, the standard error of its rms along y. An error of 0 has no logarithm: it lies on a rail of its own at the bottom.

use super::super::front::{Front, is_measured, place};
use super::super::model::{Diagram, Point, Series};
use super::labels::{Box2, Taken};
use super::scale::{self, Scale, Tick};
use super::sheet::{Align, At, Color, INK, PALE_INK, PAPER, Sheet, width_of};

const SIZE: At = [760.0, 510.0];
/// Of the plot's box: left, right, bottom.
const LEFT: f64 = 74.0;
const RIGHT: f64 = SIZE[0] - 26.0;
const BOTTOM: f64 = SIZE[1] - 58.0;
/// Of the rail above the bottom, and below the lowest error.
const RAIL: f64 = 14.0;
const ABOVE_RAIL: f64 = 34.0;

/// Beyond the outermost medians, a whisker has so much room and is cut off there.
const WHISKER: f64 = 2.0;

const TEXT: f64 = 13.5;
const GRID: Color = [0xd9, 0xdd, 0xe2];
const FINE_GRID: Color = [0xef, 0xf1, 0xf4];
const PARETO: Color = [0xf3, 0xdf, 0x9a];

/// Told apart by the colour-blind too (Okabe and Ito 2008, without the pale yellow; two of Tol 2021).
pub const COLORS: [Color; 9] = [
    [0x00, 0x72, 0xb2],
    [0xd5, 0x5e, 0x00],
    [0x00, 0x9e, 0x73],
    [0xcc, 0x79, 0xa7],
    [0x56, 0xb4, 0xe9],
    [0xe6, 0x9f, 0x00],
    [0x4a, 0x4a, 0x4a],
    [0x33, 0x22, 0x88],
    [0x99, 0x99, 0x33],
];

/// Where things are.
struct Frame {
    x: Scale,
    y: Scale,
    top: f64,
    /// Of errors of 0, where there are any.
    rail: Option<f64>,
}

pub fn sheet(diagram: &Diagram, titled: bool) -> Sheet {
    let mut sheet = Sheet::new(SIZE);
    let mut top = 18.0;
    if titled {
        sheet.bold([20.0, top + 8.0], &diagram.title, 17.5, INK, Align::Left);
        top += 36.0;
    }
    let top = legend(&mut sheet, diagram, top) + 48.0;
    let frame = Frame::of(diagram, top);
    axes(&mut sheet, diagram, &frame);
    staircase(&mut sheet, diagram, &frame);
    let mut taken = Taken::default();
    for (k, series) in diagram.series.iter().enumerate() {
        curve(&mut sheet, diagram, series, k, &frame, &mut taken);
    }
    floors(&mut sheet, diagram, &frame, &mut taken);
    presets(&mut sheet, diagram, &frame, &mut taken);
    sheet
}

impl Frame {
    fn of(diagram: &Diagram, top: f64) -> Self {
        let points: Vec<(&Point, At)> = diagram
            .series
            .iter()
            .flat_map(|series| &series.points)
            .map(|point| (point, place(diagram, point)))
            .filter(|(_, at)| is_measured(at))
            .collect();
        let has_rail = points.iter().any(|(_, at)| at[1] == 0.0);
        let bottom = if has_rail { BOTTOM - ABOVE_RAIL } else { BOTTOM };
        let medians = || points.iter().map(|(_, at)| at[0]);
        let (low, high) = (medians().fold(f64::MAX, f64::min), medians().fold(0.0, f64::max));
        let whiskers = points.iter().flat_map(|(point, _)| point.x_range);
        let whiskers = whiskers.map(|x| x.max(low / WHISKER).min(high * WHISKER));
        let errors = points.iter().flat_map(|(point, at)| within_error(point, at[1]));
        let floors = diagram.floors.iter().map(|floor| floor.y);
        Self {
            x: Scale::of(medians().chain(whiskers), [LEFT, RIGHT]),
            y: Scale::of(errors.chain(floors), [bottom, top]),
            top,
            rail: has_rail.then_some(BOTTOM - RAIL),
        }
    }

    fn at(&self, [x, error]: At) -> Option<At> {
        let y = if error == 0.0 { self.rail } else { self.y.at(error) };
        Some([self.x.at(x)?, y?])
    }

    fn inside(&self) -> Box2 {
        [[LEFT + 4.0, self.top + 2.0], [RIGHT - 4.0, BOTTOM - 4.0]]
    }
}

/// Rows of methods above everything else; returns where they end.
fn legend(sheet: &mut Sheet, diagram: &Diagram, top: f64) -> f64 {
    let names = diagram.series.iter().map(|series| series.name.as_str());
    let (mut at, mut y) = (20.0, top);
    for (k, name) in names.chain(["Pareto front"]).enumerate() {
        let width = 34.0 + width_of(name, TEXT, false);
        if at > 20.0 && at + width > RIGHT {
            (at, y) = (20.0, y + 22.0);
        }
        let (from, to) = ([at, y], [at + 26.0, y]);
        if k == diagram.series.len() {
            sheet.line(&[from, to], PARETO, 7.0);
        } else {
            sheet.line(&[from, to], color(k), 2.5);
            marker(sheet, [at + 13.0, y], k, 5.0, color(k));
        }
        sheet.text([at + 34.0, y], name, TEXT, INK, Align::Left);
        at += width + 22.0;
    }
    y
}

fn axes(sheet: &mut Sheet, diagram: &Diagram, frame: &Frame) {
    let is_bytes = diagram.x.unit == "bytes";
    let xs = frame.x.ticks(if is_bytes { scale::bytes } else { scale::number });
    let ys = frame.y.ticks(scale::share);
    let along = |tick: &Tick| [[tick.at, frame.top], [tick.at, BOTTOM]];
    let across = |tick: &Tick| [[LEFT, tick.at], [RIGHT, tick.at]];
    for decades in [false, true] {
        let color = if decades { GRID } else { FINE_GRID };
        let mine = |tick: &&Tick| tick.is_decade == decades;
        xs.iter().filter(mine).for_each(|tick| sheet.line(&along(tick), color, 1.0));
        ys.iter().filter(mine).for_each(|tick| sheet.line(&across(tick), color, 1.0));
    }
    for tick in &xs {
        sheet.text([tick.at, BOTTOM + 15.0], &tick.label, TEXT, PALE_INK, Align::Centre);
    }
    for tick in &ys {
        sheet.text([LEFT - 9.0, tick.at], &tick.label, TEXT, PALE_INK, Align::Right);
    }
    if let Some(rail) = frame.rail {
        sheet.dashed([LEFT, rail - RAIL - 4.0], [RIGHT, rail - RAIL - 4.0], PALE_INK, 1.0);
        sheet.line(&[[LEFT, rail], [RIGHT, rail]], GRID, 1.0);
        sheet.text([LEFT - 9.0, rail], "0", TEXT, PALE_INK, Align::Right);
    }
    sheet.line(&[[LEFT, frame.top], [LEFT, BOTTOM], [RIGHT, BOTTOM]], PALE_INK, 1.25);
    sheet.text([(LEFT + RIGHT) / 2.0, SIZE[1] - 18.0], &axis(&diagram.x), TEXT, INK, Align::Centre);
    sheet.text([20.0, frame.top - 18.0], &axis(&diagram.y), TEXT, INK, Align::Left);
}

fn axis(axis: &super::super::model::Axis) -> String {
    if axis.unit.is_empty() || axis.unit == "bytes" {
        axis.label.clone()
    } else {
        format!("{} [{}]", axis.label, axis.unit)
    }
}

/// From each point of the front the error stays as it is until the next one.
fn staircase(sheet: &mut Sheet, diagram: &Diagram, frame: &Frame) {
    let front: Vec<At> = Front::of(diagram).0.into_iter().filter_map(|point| frame.at(point)).collect();
    let (Some(first), Some(last)) = (front.first(), front.last()) else { return };
    let mut stairs = vec![[first[0], frame.top]];
    for pair in front.windows(2) {
        stairs.extend([pair[0], [pair[1][0], pair[0][1]]]);
    }
    stairs.extend([*last, [RIGHT, last[1]]]);
    sheet.line(&stairs, PARETO, 7.0);
}

fn curve(sheet: &mut Sheet, diagram: &Diagram, series: &Series, k: usize, frame: &Frame, taken: &mut Taken) {
    let placed = |point| {
        let at = place(diagram, point);
        let errors = within_error(point, at[1]);
        is_measured(&at).then_some([frame.at(at)?, point.x_range, errors])
    };
    let placed: Vec<[[f64; 2]; 3]> = series.points.iter().filter_map(placed).collect();
    let line: Vec<At> = placed.iter().map(|[at, ..]| *at).collect();
    taken.add_line(&line);
    if line.len() > 1 {
        sheet.line(&line, color(k), 2.5);
    }
    for [at, costs, errors] in placed {
        if let [Some(from), Some(to)] = costs.map(|x| frame.x.at(x)) {
            let [from, to] = [from, to].map(|x| [x.clamp(LEFT, RIGHT), at[1]]);
            whisker(sheet, from, to, color(k));
        }
        if let [Some(from), Some(to)] = errors.map(|y| frame.y.at(y)) {
            let [from, to] = [from, to].map(|y| [at[0], y.clamp(frame.top, BOTTOM)]);
            whisker(sheet, from, to, color(k));
        }
        marker(sheet, at, k, 5.0, color(k));
    }
}

/// An error and its standard error: from, to.
fn within_error(point: &Point, error: f64) -> [f64; 2] {
    [error - point.spread, error + point.spread]
}

/// With an end across; what is hidden by the marker is not drawn.
fn whisker(sheet: &mut Sheet, from: At, to: At, color: Color) {
    let along = [to[0] - from[0], to[1] - from[1]];
    let length = along[0].hypot(along[1]);
    if length <= 2.0 {
        return;
    }
    let across = [-4.0 * along[1] / length, 4.0 * along[0] / length];
    sheet.line(&[from, to], color, 1.0);
    for end in [from, to] {
        let ends = [1.0, -1.0].map(|sign| [end[0] + sign * across[0], end[1] + sign * across[1]]);
        sheet.line(&ends, color, 1.0);
    }
}

fn floors(sheet: &mut Sheet, diagram: &Diagram, frame: &Frame, taken: &mut Taken) {
    for floor in &diagram.floors {
        let Some(y) = frame.y.at(floor.y) else { continue };
        sheet.dashed([LEFT, y], [RIGHT, y], INK, 1.25);
        let width = width_of(&floor.name, TEXT - 1.0, false);
        let ends = [RIGHT - 6.0 - width, LEFT + 8.0, (LEFT + RIGHT - width) / 2.0];
        let places: Vec<Box2> = ends
            .into_iter()
            .flat_map(|x| [[[x, y - 20.0], [x + width, y - 3.0]], [[x, y + 4.0], [x + width, y + 20.0]]])
            .collect();
        write(sheet, &floor.name, INK, &places, frame, taken);
        taken.add_line(&[[LEFT, y], [RIGHT, y]]);
    }
}

fn presets(sheet: &mut Sheet, diagram: &Diagram, frame: &Frame, taken: &mut Taken) {
    for (k, series) in diagram.series.iter().enumerate() {
        for point in &series.points {
            let Some(preset) = &point.preset else { continue };
            let at = place(diagram, point);
            let Some([x, y]) = frame.at(at).filter(|_| is_measured(&at)) else { continue };
            sheet.disc([x, y], 11.0, INK);
            sheet.disc([x, y], 9.0, PAPER);
            marker(sheet, [x, y], k, 5.0, color(k));
            let width = width_of(preset, TEXT, true);
            let around = |dx: f64, dy: f64| {
                let left = if dx < 0.0 { x + dx - width } else { x + dx };
                [[left, y + dy - 9.0], [left + width, y + dy + 9.0]]
            };
            let places = [
                around(13.0, -13.0),
                around(13.0, 14.0),
                around(-13.0, 14.0),
                around(-13.0, -13.0),
                around(15.0, 0.0),
            ]
            .into_iter()
            .chain([around(-15.0, 0.0), around(12.0, -28.0), around(-12.0, 28.0)]);
            write_bold(sheet, preset, &places.collect::<Vec<_>>(), frame, taken);
        }
    }
}

fn write(sheet: &mut Sheet, text: &str, color: Color, places: &[Box2], frame: &Frame, taken: &mut Taken) {
    if let Some(best) = taken.place(places, frame.inside()) {
        let [low, high] = places[best];
        sheet.text([low[0], (low[1] + high[1]) / 2.0], text, TEXT - 1.0, color, Align::Left);
    }
}

fn write_bold(sheet: &mut Sheet, text: &str, places: &[Box2], frame: &Frame, taken: &mut Taken) {
    if let Some(best) = taken.place(places, frame.inside()) {
        let [low, high] = places[best];
        sheet.bold([low[0], (low[1] + high[1]) / 2.0], text, TEXT, INK, Align::Left);
    }
}

fn color(k: usize) -> Color {
    COLORS[k % COLORS.len()]
}

/// A disc, a square, a diamond, a triangle up, one down, a bar, in turn.
fn marker(sheet: &mut Sheet, [x, y]: At, k: usize, radius: f64, color: Color) {
    let r = radius;
    let corners: &[At] = match k % 6 {
        0 => return sheet.disc([x, y], r, color),
        1 => &[[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]],
        2 => &[[0.0, -1.3], [1.3, 0.0], [0.0, 1.3], [-1.3, 0.0]],
        3 => &[[0.0, -1.2], [1.2, 0.9], [-1.2, 0.9]],
        4 => &[[0.0, 1.2], [1.2, -0.9], [-1.2, -0.9]],
        _ => &[[-0.5, -1.3], [0.5, -1.3], [0.5, 1.3], [-0.5, 1.3]],
    };
    let corners: Vec<At> = corners.iter().map(|[dx, dy]| [x + r * dx, y + r * dy]).collect();
    sheet.fill(&corners, color);
}
