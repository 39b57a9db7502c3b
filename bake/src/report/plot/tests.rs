//! What plots hold, and that nothing measured, however odd, keeps one from being drawn.

use super::super::model::{Axis, Diagram, Error, Floor, Norm, Part, Point, Series, Split};
use super::sheet::{Mark, Sheet};
use super::{diagram, of_diagram, of_split, split};

fn point(setting: &str, x: f64, rms: f64, preset: Option<&str>) -> Point {
    Point {
        setting: setting.to_owned(),
        x,
        x_range: [0.85 * x, 1.2 * x],
        runs: 3,
        spread: 0.1 * rms,
        error: Error { rms, bias: -0.1 * rms, p99: 3.0 * rms, max: 9.0 * rms },
        preset: preset.map(str::to_owned),
    }
}

pub fn example() -> Diagram {
    let rays: Vec<Point> = [1.0, 2.0, 4.0, 8.0, 16.0]
        .into_iter()
        .zip([Some("draft"), None, Some("standard"), None, Some("fine")])
        .map(|(k, preset): (f64, _)| point(&format!("{k} rays"), 0.1 * k, 0.02 / k, preset))
        .collect();
    let plain: Vec<Point> =
        [1.0, 4.0, 16.0, 64.0].map(|k: f64| point("", 0.09 * k, 0.06 / k.sqrt(), None)).into();
    Diagram {
        id: "rays".to_owned(),
        title: "Form factors: rays".to_owned(),
        about: "How wrong form factors are after so many seconds of rays.".to_owned(),
        x: Axis { label: "time of the rays".to_owned(), unit: "s".to_owned() },
        y: Axis { label: "error of irradiance, rms over mean".to_owned(), unit: String::new() },
        norm: Norm::Rms,
        series: vec![
            Series::new("Sobol points, pooled and balanced", rays),
            Series::new("plain ray caster", plain),
        ],
        floors: vec![Floor { name: "noise of the reference".to_owned(), y: 7e-4 }],
    }
}

pub fn example_split() -> Split {
    let part = |name: &str, rms: f64, bias: f64| Part {
        name: name.to_owned(),
        compared: "one and the other".to_owned(),
        error: Error { rms, bias, p99: 3.0 * rms, max: 9.0 * rms },
        left_out: None,
        is_apart: false,
    };
    let left_out = Part { left_out: Some("no GPU".to_owned()), ..part("GPU against CPU", 0.0, 0.0) };
    let probes = Part { is_apart: true, ..part("light probes", 1.4, 0.17) };
    let parts =
        vec![part("discretisation", 0.012, -0.004), part("form factors", 0.003, 0.0015), left_out, probes];
    let total = part("", 0.0124, -0.0025).error;
    Split { parts, total, ..Split::default() }
}

/// Every coordinate of a sheet is on it, with a little beyond for the width of lines.
#[track_caller]
fn assert_on_sheet(sheet: &Sheet, what: &str) {
    let near = |at: &[f64; 2]| (0..2).all(|k| at[k] > -20.0 && at[k] < sheet.size[k] + 20.0);
    for mark in &sheet.marks {
        let inside = match mark {
            Mark::Line { points, .. } | Mark::Fill { points, .. } => points.iter().all(near),
            Mark::Disc { at, .. } | Mark::Text { at, .. } => near(at),
        };
        assert!(inside, "{what}: {mark:?}");
    }
}

/// The longest line of this colour.
fn longest(sheet: &Sheet, wanted: [u8; 3]) -> usize {
    let lines = sheet.marks.iter().filter_map(|mark| match mark {
        Mark::Line { points, color, .. } if *color == wanted => Some(points.len()),
        _ => None,
    });
    lines.max().unwrap_or(0)
}

fn texts(sheet: &Sheet) -> Vec<String> {
    let text = |mark: &'_ Mark| match mark {
        Mark::Text { text, .. } => Some(text.clone()),
        _ => None,
    };
    sheet.marks.iter().filter_map(text).collect()
}

#[test]
fn a_diagram_has_a_line_a_method_and_names_every_preset_floor_and_method() {
    let sheet = diagram::sheet(&example(), true);
    assert_eq!([0, 1].map(|k| longest(&sheet, diagram::COLORS[k])), [5, 4]);
    let texts = texts(&sheet);
    for name in
        ["draft", "standard", "fine", "noise of the reference", "plain ray caster", "Form factors: rays"]
    {
        assert_eq!(texts.iter().filter(|text| *text == name).count(), 1, "{name} in {texts:?}");
    }
    assert!(
        texts.iter().any(|text| text == "time of the rays [s]") && texts.iter().any(|text| text == "1 %"),
        "{texts:?}"
    );
    assert_on_sheet(&sheet, "example");
}

#[test]
fn both_files_show_the_sheet() {
    let plot = of_diagram(&example()).unwrap();
    for (svg, titles) in [(&plot.svg, 2), (&plot.untitled_svg, 1)] {
        assert!(svg.starts_with("<svg xmlns=") && svg.trim_end().ends_with("</svg>"));
        assert_eq!(svg.matches("Form factors: rays").count(), titles);
        assert!(svg.matches("<polyline").count() > 20 && !svg.contains("NaN"));
    }
    let picture = image::load_from_memory(&plot.png).unwrap().to_rgb8();
    assert_eq!(picture.dimensions(), (1520, 1020));
    for color in &diagram::COLORS[..2] {
        let count = picture.pixels().filter(|pixel| pixel.0 == *color).count();
        assert!(count > 500, "{count} pixels of {color:?}");
    }
}

#[test]
fn one_run_that_took_for_ever_does_not_stretch_the_axis() {
    let mut slow = example();
    slow.series[0].points[0].x_range = [1e-9, 1e9];
    let sheet = diagram::sheet(&slow, true);
    assert_on_sheet(&sheet, "slow");
    assert!(!texts(&sheet).iter().any(|text| text.contains("10⁻⁵")), "{:?}", texts(&sheet));
}

#[test]
fn bytes_are_told_in_their_units() {
    let mut bytes = example();
    bytes.x.unit = "bytes".to_owned();
    bytes.series.iter_mut().flat_map(|series| &mut series.points).for_each(|point| point.x *= 1e7);
    let texts = diagram::sheet(&bytes, true);
    assert!(self::texts(&texts).iter().any(|text| text == "1 MB"), "{texts:?}");
}

#[test]
fn errors_of_nothing_lie_on_a_rail_below_all_others() {
    let mut none = example();
    none.series[0].points[4].error = Error::default();
    let sheet = diagram::sheet(&none, false);
    let mut lines = sheet.marks.iter().filter_map(|mark| match mark {
        Mark::Line { points, color, .. } if *color == diagram::COLORS[0] && points.len() == 5 => Some(points),
        _ => None,
    });
    let line = lines.next_back().unwrap();
    assert!(line[..4].iter().all(|at| at[1] < line[4][1] - 10.0), "{line:?}");
    assert!(
        texts(&sheet).iter().any(|text| text == "0")
            && !texts(&diagram::sheet(&example(), false)).iter().any(|text| text == "0")
    );
    assert_on_sheet(&sheet, "rail");
}

#[test]
fn whatever_was_measured_is_drawn() {
    let odd = [0.0, -1.0, f64::NAN, f64::INFINITY, f64::MIN_POSITIVE, f64::MAX, 1.0];
    let mut diagrams = vec![Diagram::default()];
    for x in odd {
        for rms in odd {
            let mut diagram = example();
            diagram.series[0].points = vec![point("odd", x, rms, Some("odd")); 2];
            diagram.floors[0].y = rms;
            diagrams.push(diagram);
        }
        let points = vec![point("alone", x, x, Some("alone"))];
        diagrams.push(Diagram { series: vec![Series::new("alone", points)], ..Diagram::default() });
    }
    for diagram in &diagrams {
        assert_on_sheet(&diagram::sheet(diagram, true), &format!("{diagram:?}"));
    }
    for value in odd {
        let mut split = example_split();
        split.parts[0].error = Error { rms: value.abs(), bias: value, p99: value, max: value };
        assert_on_sheet(&split::sheet(&split, true), &format!("{split:?}"));
    }
    of_diagram(&diagrams[0]).unwrap();
    of_split(&Split::default()).unwrap();
}

#[test]
fn the_split_shows_every_part_its_numbers_and_the_total() {
    let sheet = split::sheet(&example_split(), true);
    let texts = texts(&sheet);
    for text in
        ["discretisation", "form factors", "GPU against CPU", "not measured", "total", "1.2 %", "−0.25 %"]
    {
        assert!(texts.iter().any(|found| found == text), "{text} in {texts:?}");
    }
    assert!(
        !texts.iter().any(|text| text == "light probes"),
        "what is beside the sum is not in its picture: {texts:?}"
    );
    assert_on_sheet(&sheet, "split");
    assert!(of_split(&example_split()).unwrap().svg.contains("+0.15 %"));
}
