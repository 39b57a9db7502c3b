//! Where the error comes from: by part its rms, and its signed mean as a waterfall that ends at the total.

use super::super::model::{Error, Split};
use super::super::numbers::{share, signed_share};
use super::sheet::{Align, At, Color, INK, PALE_INK, Sheet, width_of};

const WIDTH: f64 = 760.0;
const ROW: f64 = 32.0;
const TEXT: f64 = 13.5;
const MARGIN: f64 = 20.0;
/// Between columns, and for the numbers beside bars.
const GAP: f64 = 26.0;
const NUMBER: f64 = 74.0;
/// Half its height.
const BAR: f64 = 9.0;

const RMS: Color = [0x9c, 0xc3, 0xe0];
const TOTAL_RMS: Color = [0x00, 0x72, 0xb2];
const MORE: Color = [0xd5, 0x5e, 0x00];
const LESS: Color = [0x00, 0x9e, 0x73];
const GRID: Color = [0xd9, 0xdd, 0xe2];
const BAND: Color = [0xf6, 0xf7, 0xf9];

struct Row<'a> {
    name: &'a str,
    error: Error,
    /// Of the signed mean, in shares.
    from: f64,
    to: f64,
    is_measured: bool,
    is_total: bool,
}

pub fn sheet(split: &Split, titled: bool) -> Sheet {
    let rows = rows(split);
    let top = if titled { 84.0 } else { 44.0 };
    let mut sheet = Sheet::new([WIDTH, top + ROW * rows.len() as f64 + 14.0]);
    if titled {
        sheet.bold([MARGIN, 26.0], "Where the error comes from", 17.5, INK, Align::Left);
    }
    let names = rows.iter().map(|row| width_of(row.name, TEXT, true)).fold(0.0, f64::max).min(250.0);
    let first = MARGIN + names + GAP;
    let half = (WIDTH - MARGIN - first - GAP) / 2.0;
    let (rms, bias) = ([first, first + half], [first + half + GAP, WIDTH - MARGIN]);
    sheet.text([rms[0], top - 20.0], "rms over mean", TEXT, PALE_INK, Align::Left);
    sheet.text([bias[0], top - 20.0], "signed mean, adding up", TEXT, PALE_INK, Align::Left);
    let (rms_scale, bias_scale) = (rms_scale(&rows, rms), bias_scale(&rows, bias));
    let zero = bias_scale(0.0);
    let (first_row, last_row) = (top, top + ROW * rows.len() as f64);
    sheet.rectangle([MARGIN - 8.0, last_row - ROW], [WIDTH - MARGIN + 8.0, last_row], BAND);
    sheet.line(&[[zero, first_row], [zero, last_row]], GRID, 1.0);
    for (k, row) in rows.iter().enumerate() {
        let y = top + ROW * (k as f64 + 0.5);
        draw_row(&mut sheet, row, y, rms[0], &rms_scale, &bias_scale);
        // From where this bar ends to where the next one begins.
        let x = bias_scale(row.to);
        let begins = if row.is_measured { y + BAR } else { y - BAR };
        if k + 2 < rows.len() {
            sheet.line(&[[x, begins], [x, y + ROW - BAR]], PALE_INK, 1.0);
        }
    }
    sheet
}

fn rows(split: &Split) -> Vec<Row<'_>> {
    let mut reached = 0.0;
    let mut rows: Vec<Row> = split
        .parts
        .iter()
        .filter(|part| !part.is_apart)
        .map(|part| {
            let from = reached;
            reached += finite(part.error.bias);
            let is_measured = part.left_out.is_none();
            Row { name: &part.name, error: part.error, from, to: reached, is_measured, is_total: false }
        })
        .collect();
    let to = finite(split.total.bias);
    rows.push(Row { name: "total", error: split.total, from: 0.0, to, is_measured: true, is_total: true });
    rows
}

fn draw_row(
    sheet: &mut Sheet,
    row: &Row,
    y: f64,
    left: f64,
    rms_scale: &dyn Fn(f64) -> f64,
    bias_scale: &dyn Fn(f64) -> f64,
) {
    let bar = |sheet: &mut Sheet, from: f64, to: f64, color: Color| {
        let (low, high) = (from.min(to), from.max(to).max(from.min(to) + 1.0));
        sheet.rectangle([low, y - BAR], [high, y + BAR], color);
    };
    let name = if row.is_total { Sheet::bold } else { Sheet::text };
    name(sheet, [MARGIN, y], row.name, TEXT, if row.is_measured { INK } else { PALE_INK }, Align::Left);
    if !row.is_measured {
        sheet.text([left, y], "not measured", TEXT, PALE_INK, Align::Left);
        return;
    }
    let rms = rms_scale(finite(row.error.rms));
    bar(sheet, left, rms, if row.is_total { TOTAL_RMS } else { RMS });
    sheet.text([rms + 7.0, y], &share(row.error.rms), TEXT, INK, Align::Left);
    let (from, to) = (bias_scale(row.from), bias_scale(row.to));
    bar(sheet, from, to, if row.to > row.from { MORE } else { LESS });
    sheet.text([from.max(to) + 7.0, y], &signed_share(row.error.bias), TEXT, INK, Align::Left);
}

fn rms_scale(rows: &[Row], [from, to]: At) -> impl Fn(f64) -> f64 + use<> {
    let most = rows.iter().map(|row| finite(row.error.rms)).fold(0.0, f64::max);
    let unit = if most > 0.0 { (to - from - NUMBER) / most } else { 0.0 };
    move |value| from + value * unit
}

/// Room for all that is reached on the way, and for a number behind.
fn bias_scale(rows: &[Row], [from, to]: At) -> impl Fn(f64) -> f64 + use<> {
    let reached = || rows.iter().flat_map(|row| [row.from, row.to]);
    let (low, high) = (reached().fold(0.0, f64::min), reached().fold(0.0, f64::max));
    let unit = if high > low { (to - from - NUMBER - 6.0) / (high - low) } else { 0.0 };
    move |value| from + (value - low) * unit
}

fn finite(value: f64) -> f64 {
    if value.is_finite() { value } else { 0.0 }
}
