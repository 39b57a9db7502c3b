//! A sheet that a plot is laid out on, in points; and how it becomes SVG and PNG. Layout is plain data, so that tests
//! can look at it, and both files show the same.

use std::sync::Once;

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use plotters::coord::Shift;
use plotters::prelude::{
    BLACK, BitMapBackend, Circle, DrawingArea, DrawingBackend, FontStyle, IntoDrawingArea, IntoFont,
    PathElement, Polygon, RGBColor, SVGBackend, WHITE,
};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color as _, FontDesc, FontFamily, TextStyle, register_font};

use crate::BakeError;

pub type Color = [u8; 3];

/// Of text and axes, of what is less important, and behind everything.
pub const INK: Color = [0x1c, 0x1f, 0x24];
pub const PALE_INK: Color = [0x5b, 0x62, 0x6b];
pub const PAPER: Color = [0xff, 0xff, 0xff];

/// Where a system has none of the first ones, the last is registered under the whole name and measures all.
const FAMILY: &str = "system-ui, Segoe UI, Roboto, Helvetica Neue, DejaVu Sans, sans-serif";
/// A point is so many of the backends' whole pixels.
const FINE: f64 = 4.0;
/// Of these, so many in each direction become one of the picture: it is twice as fine as the sheet, and smooth.
const SMOOTH: usize = 2;

/// How a backend understands the size of a font, over its em; and what centred text lacks downwards, in ems. SVG's is
/// the backend's own constant, the picture's is the font's height.
struct Type {
    size: f64,
    lift: f64,
}

const SVG_TYPE: Type = Type { size: 1.24, lift: 0.0 };
const PNG_TYPE: Type = Type { size: 1.164, lift: 0.15 };

/// Points from the upper left corner.
pub type At = [f64; 2];

#[derive(Clone, Debug, PartialEq)]
pub enum Mark {
    Line { points: Vec<At>, color: Color, width: f64 },
    Fill { points: Vec<At>, color: Color },
    Disc { at: At, radius: f64, color: Color },
    Text { at: At, text: String, size: f64, color: Color, align: Align, bold: bool },
}

/// Of text at its point; vertically it is centred there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Align {
    Left,
    Centre,
    Right,
}

/// What was laid out, in the order in which it is drawn.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sheet {
    pub size: At,
    pub marks: Vec<Mark>,
}

impl Sheet {
    pub fn new(size: At) -> Self {
        Self { size, marks: Vec::new() }
    }

    pub fn line(&mut self, points: &[At], color: Color, width: f64) {
        self.marks.push(Mark::Line { points: points.to_vec(), color, width });
    }

    /// Six points on, four off.
    pub fn dashed(&mut self, from: At, to: At, color: Color, width: f64) {
        let way = [to[0] - from[0], to[1] - from[1]];
        let length = way[0].hypot(way[1]);
        let at = |along: f64| {
            let share = (along / length).min(1.0);
            [from[0] + share * way[0], from[1] + share * way[1]]
        };
        for dash in 0..(length / 10.0).ceil() as u32 {
            let begins = f64::from(dash) * 10.0;
            self.line(&[at(begins), at(begins + 6.0)], color, width);
        }
    }

    pub fn fill(&mut self, points: &[At], color: Color) {
        self.marks.push(Mark::Fill { points: points.to_vec(), color });
    }

    pub fn rectangle(&mut self, low: At, high: At, color: Color) {
        self.fill(&[low, [high[0], low[1]], high, [low[0], high[1]]], color);
    }

    pub fn disc(&mut self, at: At, radius: f64, color: Color) {
        self.marks.push(Mark::Disc { at, radius, color });
    }

    pub fn text(&mut self, at: At, text: &str, size: f64, color: Color, align: Align) {
        self.marks.push(Mark::Text { at, text: text.to_owned(), size, color, align, bold: false });
    }

    pub fn bold(&mut self, at: At, text: &str, size: f64, color: Color, align: Align) {
        self.marks.push(Mark::Text { at, text: text.to_owned(), size, color, align, bold: true });
    }

    /// With a title for those who cannot see it.
    pub fn svg(&self, title: &str) -> Result<String, BakeError> {
        let mut svg = String::new();
        {
            let area = SVGBackend::with_string(&mut svg, self.pixels()).into_drawing_area();
            self.draw(&area, &SVG_TYPE)?;
            area.present().map_err(failed)?;
        }
        let [width, height] = self.size;
        let (fine_width, fine_height) = self.pixels();
        let shown = svg.find('>').map_or(svg.as_str(), |end| &svg[end + 1..]);
        Ok(format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {fine_width} {fine_height}\">\n<title>{}</title>{shown}",
            escaped(title)
        ))
    }

    /// Twice as many pixels as the sheet has points.
    pub fn png(&self) -> Result<Vec<u8>, BakeError> {
        let (width, height) = self.pixels();
        let mut fine = vec![0; 3 * width as usize * height as usize];
        {
            let area = BitMapBackend::with_buffer(&mut fine, (width, height)).into_drawing_area();
            self.draw(&area, &PNG_TYPE)?;
            area.present().map_err(failed)?;
        }
        let (width, height) = (width as usize / SMOOTH, height as usize / SMOOTH);
        let mut png = Vec::new();
        let pixels = smoothed(&fine, width, height);
        PngEncoder::new(&mut png)
            .write_image(&pixels, width as u32, height as u32, ExtendedColorType::Rgb8)
            .map_err(failed)?;
        Ok(png)
    }

    fn pixels(&self) -> (u32, u32) {
        ((self.size[0] * FINE) as u32, (self.size[1] * FINE) as u32)
    }

    fn draw<Backend: DrawingBackend>(
        &self,
        area: &DrawingArea<Backend, Shift>,
        kind: &Type,
    ) -> Result<(), BakeError> {
        register_fonts();
        area.fill(&WHITE).map_err(failed)?;
        self.marks.iter().try_for_each(|mark| draw(area, kind, mark))
    }
}

fn draw<Backend: DrawingBackend>(
    area: &DrawingArea<Backend, Shift>,
    kind: &Type,
    mark: &Mark,
) -> Result<(), BakeError> {
    let drawn = match mark {
        Mark::Line { points, color, width } => {
            let style = rgb(*color).stroke_width((width * FINE).round().max(1.0) as u32);
            let points = pixels(points);
            if points.len() < 2 {
                return Ok(());
            }
            area.draw(&PathElement::new(points, style))
        }
        Mark::Fill { points, color } => area.draw(&Polygon::new(pixels(points), rgb(*color))),
        Mark::Disc { at, radius, color } => {
            area.draw(&Circle::new(pixel(*at), (radius * FINE) as i32, rgb(*color).filled()))
        }
        Mark::Text { at, text, size, color, align, bold } => {
            let horizontal = match align {
                Align::Left => HPos::Left,
                Align::Centre => HPos::Center,
                Align::Right => HPos::Right,
            };
            let (font, color) = (font(size * kind.size * FINE, *bold), rgb(*color));
            let style = TextStyle::from(font).color(&color).pos(Pos::new(horizontal, VPos::Center));
            area.draw_text(text, &style, pixel([at[0], at[1] + kind.lift * size]))
        }
    };
    drawn.map_err(failed)
}

/// Of a text in points.
pub fn width_of(text: &str, size: f64, bold: bool) -> f64 {
    register_fonts();
    // Measured large: the answer is in whole pixels.
    let measured = font(1000.0 * PNG_TYPE.size, bold).layout_box(text);
    measured.map_or(0.6 * size * text.chars().count() as f64, |(low, high)| {
        f64::from(high.0 - low.0) * size / 1000.0
    })
}

fn font(size: f64, bold: bool) -> FontDesc<'static> {
    let style = if bold { FontStyle::Bold } else { FontStyle::Normal };
    (FontFamily::Name(FAMILY), size, style).into_font()
}

/// Under the name of the family that SVG asks for.
fn register_fonts() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        // Both are sound; if they were not, drawing text would fail with a message.
        let _ = register_font(FAMILY, FontStyle::Normal, dejavu::sans::regular());
        let _ = register_font(FAMILY, FontStyle::Bold, dejavu::sans::bold());
    });
}

/// Without repetitions, which have no direction.
fn pixels(points: &[At]) -> Vec<(i32, i32)> {
    let mut pixels: Vec<_> = points.iter().copied().map(pixel).collect();
    pixels.dedup();
    pixels
}

/// What is no number lies outside.
fn pixel([x, y]: At) -> (i32, i32) {
    let whole = |value: f64| {
        if value.is_nan() { -1 } else { (value * FINE).round().clamp(-1e5, 1e5) as i32 }
    };
    (whole(x), whole(y))
}

/// Means of squares of [`SMOOTH`] pixels.
fn smoothed(fine: &[u8], width: usize, height: usize) -> Vec<u8> {
    let row = 3 * width * SMOOTH;
    let mean = |x: usize, y: usize, channel: usize| {
        let square = (0..SMOOTH * SMOOTH).map(|k| {
            let at = (y * SMOOTH + k / SMOOTH) * row + (x * SMOOTH + k % SMOOTH) * 3 + channel;
            u32::from(fine[at])
        });
        (square.sum::<u32>() / (SMOOTH * SMOOTH) as u32) as u8
    };
    (0..height)
        .flat_map(|y| (0..width).flat_map(move |x| (0..3).map(move |channel| (x, y, channel))))
        .map(|(x, y, channel)| mean(x, y, channel))
        .collect()
}

fn rgb([red, green, blue]: Color) -> RGBColor {
    if [red, green, blue] == [0; 3] { BLACK } else { RGBColor(red, green, blue) }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

fn failed(error: impl std::fmt::Display) -> BakeError {
    BakeError::Other(format!("a plot was not drawn: {error}"))
}
