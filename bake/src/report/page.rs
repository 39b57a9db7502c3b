//! The page: one file that needs no other, for people.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use glam::DVec3;
use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::ReportSettings;
use super::files::Told;
use super::model::{Diagram, Part, Point, Report, Split};
use super::numbers::{bytes, factor, milliseconds, plain, quantity, seconds, share, signed_share};
use super::plot::Plot;
use super::sentences;
use super::trend::Trend;

const STYLE: &str = include_str!("page.css");

/// `plots`: of the diagrams in their order, then of the split.
pub fn page(told: &Told, settings: &ReportSettings, plots: &[Plot]) -> String {
    let report = told.report;
    let title = format!("{}: error against run time", report.scene);
    let of_diagrams = report.diagrams.iter().zip(plots);
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                main {
                    (opening(report))
                    h2 { "Where the error comes from" }
                    (split(&report.split, plots.last()))
                    h2 { "Error against run time" }
                    @for (diagram, plot) in of_diagrams { (of_diagram(told, diagram, plot)) }
                    (curves(told))
                    (presets(told))
                    (advice(report))
                    (certificate(told))
                    (measured(report, settings))
                }
            }
        }
    }
    .into_string()
}

fn opening(report: &Report) -> Markup {
    html! {
        header {
            p.kicker { "Hohlraum \u{b7} error against run time" }
            h1 { (report.scene) }
        }
        @if let Some(picture) = &report.picture {
            figure {
                img alt={ "The scene " (report.scene) ", as the player draws it" }
                    src={ "data:image/png;base64," (STANDARD.encode(picture)) };
            }
        }
        div.tiles { @for (number, what) in tiles(report) { div { b { (number) } span { (what) } } } }
        @for sentence in sentences::summary(report) { p.lead { (sentence) } }
    }
}

/// The numbers that people ask for first.
fn tiles(report: &Report) -> Vec<(String, &'static str)> {
    let mut tiles = Vec::new();
    let (total, certificate) = (&report.split.total, &report.certificate);
    if total.rms > 0.0 {
        tiles.push((share(total.rms), "error, rms over mean"));
        tiles.push((signed_share(total.bias), "signed mean of the error"));
    }
    tiles.push((bytes(certificate.bytes as f64), "on disk"));
    tiles.push((factor(certificate.cavity_gain), "cavity gain"));
    if let Some(frame) = report.frame.as_ref().filter(|frame| !frame.passes.is_empty()) {
        let sum = frame.passes.iter().map(|pass| pass.median).sum();
        tiles.push((milliseconds(sum), "a frame, all passes"));
    }
    tiles
}

fn split(split: &Split, plot: Option<&Plot>) -> Markup {
    let parts = |apart: bool| split.parts.iter().filter(move |part| part.is_apart == apart);
    html! {
        p { (split.about) }
        @if let Some(plot) = plot { (drawn(plot)) }
        div.wide {
            table {
                thead { tr { th { "part" } th { "what differs" } th.n { "rms" } th.n { "signed mean" } th.n { "p99" } th.n { "max" } } }
                tbody {
                    @for part in parts(false) { (part_row(part)) }
                    tr.total { td { "total" } td { "what the player shows against the reference" } (numbers(&split.total)) }
                    @for part in parts(true) { (part_row(part)) }
                }
            }
        }
        @for sentence in sentences::of_sum(split) { p { (sentence) } }
        @if !split.worst.is_empty() { (worst(split)) }
    }
}

fn worst(split: &Split) -> Markup {
    let metres = |place: DVec3| format!("{:.3}, {:.3}, {:.3}", place.x, place.y, place.z);
    html! {
        p { (sentences::of_worst(split)) }
        div.wide {
            table {
                thead { tr { th { "place, m" } th { "normal" } th.n { "shown, W/m\u{b2}" } th.n { "reference, W/m\u{b2}" } th.n { "of all squares" } th { "mostly" } } }
                tbody {
                    @for place in &split.worst {
                        tr {
                            td { (metres(place.position)) } td { (metres(place.normal)) }
                            td.n { (plain(place.shown)) } td.n { (plain(place.reference)) } td.n { (share(place.share)) } td { (place.part) }
                        }
                    }
                }
            }
        }
    }
}

fn part_row(part: &Part) -> Markup {
    let beside = if part.is_apart { " (beside the sum)" } else { "" };
    html! {
        @match &part.left_out {
            Some(why) => tr.pale { td { (part.name) (beside) } td { (part.compared) } td colspan="4" { "not measured: " (why) } }
            None => tr { td { (part.name) (beside) } td { (part.compared) } (numbers(&part.error)) }
        }
    }
}

fn numbers(error: &super::model::Error) -> Markup {
    html! {
        td.n { (share(error.rms)) }
        td.n { (signed_share(error.bias)) }
        td.n { (share(error.p99)) }
        td.n { (share(error.max)) }
    }
}

fn of_diagram(told: &Told, diagram: &Diagram, plot: &Plot) -> Markup {
    html! {
        section {
            h3 { (diagram.title) }
            p { (diagram.about) }
            (drawn(plot))
            @for sentence in sentences::of_diagram(diagram, &told.presets) { p.says { (sentence) } }
            details {
                summary { "All points" }
                div.wide {
                    table {
                        thead { tr { th { "method" } th { "setting" } th.n { (diagram.x.label) } th.n { "rms" } th.n { "signed mean" } th.n { "p99" } th.n { "max" } th.n { "rms \u{b1}" } } }
                        tbody {
                            @for series in &diagram.series {
                                @for point in &series.points { (row(&series.name, point, &diagram.x.unit)) }
                            }
                        }
                    }
                }
                p.small { code { (diagram.id) ".csv" } " has them with all digits." }
            }
        }
    }
}

fn row(method: &str, point: &Point, unit: &str) -> Markup {
    html! {
        tr {
            td { (method) }
            td { (point.setting) @if let Some(preset) = &point.preset { " " b { (preset) } } }
            td.n { (quantity(point.x, unit)) }
            (numbers(&point.error))
            td.n { @if point.spread > 0.0 { (share(point.spread)) } }
        }
    }
}

/// A white card: the plot's ink is dark.
fn drawn(plot: &Plot) -> Markup {
    html! { figure.plot { (PreEscaped(&plot.untitled_svg)) } }
}

fn advice(report: &Report) -> Markup {
    html! {
        @if !report.advice.is_empty() {
            h2 { "What to change" }
            div.wide {
                table {
                    thead { tr { th { "for" } th { "change" } th.n { "cost" } th.n { "error" } } }
                    tbody {
                        @for advice in &report.advice {
                            tr {
                                td { (advice.goal) }
                                td { code { (advice.change) } }
                                td.n { "\u{d7} " (factor(advice.cost)) }
                                td.n { "\u{d7} " (factor(advice.error)) }
                            }
                        }
                    }
                }
            }
            p.small { "Factors against what is shipped, from points measured in this run." }
        }
    }
}

/// Every method that has more than one point, and a floor to fall to.
fn curves(told: &Told) -> Markup {
    let curves: Vec<&Trend> = told.trends.iter().filter(|trend| trend.is_curve()).collect();
    let reached =
        |trend: &Trend| if trend.reaches { "yes" } else { trend.ends.as_deref().unwrap_or("yes") }.to_owned();
    let is = |trend: &Trend| match (trend.falls, trend.reaches) {
        (true, true) => "yes",
        (false, true) => "rises on the way",
        (true, false) => "ends above",
        (false, false) => "rises, ends above",
    };
    html! {
        @if !curves.is_empty() {
            h2 { "The curves and their floors" }
            p { (sentences::of_curves(&told.trends)) " A rise counts where it is more than the standard error of the rms over the evaluation points." }
            details {
                summary { "All curves" }
                div.wide {
                    table {
                        thead { tr { th { "in" } th { "method" } th.n { "least error" } th.n { "floor" } th { "which floor" } th.n { "times the floor" } th { "falls until within twice its floor" } } }
                        tbody {
                            @for trend in curves {
                                tr {
                                    td { @if let Some(title) = title(told, &trend.diagram) { (title) } }
                                    td { (trend.series) }
                                    td.n { (share(trend.least)) }
                                    td.n { (share(trend.floor)) }
                                    td { (trend.floor_name) }
                                    td.n { (factor(trend.least / trend.floor)) }
                                    td { (verdict(trend.holds(), &reached(trend), is(trend))) }
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

fn title<'a>(told: &'a Told, id: &str) -> Option<&'a String> {
    told.report.diagrams.iter().find(|diagram| diagram.id == id).map(|found| &found.title)
}

fn presets(told: &Told) -> Markup {
    html! {
        @if !told.presets.is_empty() {
            h2 { "The shipped settings" }
            p { (sentences::of_presets(&told.presets)) }
            div.wide {
                table {
                    thead { tr { th { "preset" } th { "in" } th { "setting" } th.n { "runs" } th.n { "error over the front's" } th.n { "cost over the front's" } th { "on the front" } } }
                    tbody {
                        @for preset in &told.presets {
                            tr {
                                td { b { (preset.preset) } }
                                td { @if let Some(title) = title(told, &preset.diagram) { (title) } }
                                td { (preset.series) ", " (preset.setting) }
                                td.n { (preset.runs) }
                                td.n { (factor(preset.error_factor)) }
                                td.n { (factor(preset.x_factor)) }
                                td { (verdict(preset.on_front, "yes", "no")) }
                            }
                        }
                    }
                }
            }
            p.small { "On the front: within 15 % of it, in cost or in error; between measured points the front is interpolated." }
        }
    }
}

fn certificate(told: &Told) -> Markup {
    let certificate = &told.report.certificate;
    let limit = |limit: f64| if limit == f64::MAX { "none".to_owned() } else { plain(limit) };
    html! {
        h2 { "The certificate" }
        p {
            (certificate.patches) " patches, " (certificate.receivers) " receivers, " (certificate.probes) " light probes, "
            (certificate.rays_per_row) " rays a row, patch length " (plain(certificate.base_length)) " m. "
            "Predicted noise of irradiance: " (share(certificate.noise[0])) " in the median."
        }
        div.wide {
            table {
                thead { tr { th { "statement" } th.n { "value" } th.n { "limit" } th { "holds" } } }
                tbody {
                    @for statement in &told.statements {
                        tr {
                            td { (statement.what) }
                            td.n { (plain(statement.value)) }
                            td.n { (limit(statement.limit)) }
                            td { (verdict(statement.holds, "yes", "broken")) }
                        }
                    }
                }
            }
        }
        (list("Left out", &certificate.left_out))
        (list("Warnings", &certificate.warnings))
        p.small { "Transport hash " code { (certificate.transport_hash) } }
    }
}

fn verdict(holds: bool, yes: &str, no: &str) -> Markup {
    html! { @if holds { span.yes { (yes) } } @else { span.no { (no) } } }
}

fn measured(report: &Report, settings: &ReportSettings) -> Markup {
    let machine = &report.machine;
    let timing = match machine.timing.as_deref() {
        Some("gpu") => "passes timed by the GPU",
        _ => "passes timed by the CPU, to record them",
    };
    html! {
        h2 { "How it was measured" }
        dl {
            dt { "Processor" } dd { (machine.processor) ", " (machine.threads) " threads used, " (bytes(machine.memory as f64)) " of memory" }
            dt { "System" } dd { (machine.system) }
            dt { "Drawn with" }
            dd { @match &machine.adapter { Some(adapter) => { (adapter) ", " (timing) } None => "nothing" } }
            dt { "Time" } dd { (seconds(report.seconds)) " of " (seconds(report.budget)) }
            @if !report.seeds.is_empty() {
                dt { "Seeds" }
                dd { @for (k, (what, seed)) in report.seeds.iter().enumerate() { @if k > 0 { ", " } (what) " " (seed) } }
            }
        }
        (passes(report))
        (list("Notes", &report.notes))
        h3 { "Again" }
        pre { (command(report, settings)) }
    }
}

fn passes(report: &Report) -> Markup {
    html! {
        @if let Some(frame) = &report.frame {
            details {
                summary { "Passes of a frame" }
                table {
                    thead { tr { th { "pass" } th.n { "median" } th.n { "p99" } } }
                    tbody {
                        @for pass in frame.passes.iter().chain(&frame.whole) {
                            tr { td { (pass.name) } td.n { (milliseconds(pass.median)) } td.n { (milliseconds(pass.p99)) } }
                        }
                    }
                }
                @if let Some(bound) = frame.bound {
                    p.small { "Radiosity is solved to within " (share(bound)) " of its largest, as the runtime bounds it." }
                }
            }
        }
    }
}

fn list(title: &str, lines: &[String]) -> Markup {
    html! { @if !lines.is_empty() { h3 { (title) } ul { @for line in lines { li { (line) } } } } }
}

/// What repeats the report.
fn command(report: &Report, settings: &ReportSettings) -> String {
    let quoted = |text: &str| {
        if text.contains(|c: char| c.is_whitespace() || "'\"$&;()".contains(c)) {
            format!("'{}'", text.replace('\'', "'\\''"))
        } else {
            text.to_owned()
        }
    };
    let mut command = format!(
        "hohlraum-bake report {} --scene {} --out {} --budget {}",
        quoted(&report.project),
        quoted(&report.scene),
        quoted(&settings.out.display().to_string()),
        settings.budget
    );
    if let Some(quality) = settings.quality {
        command += &format!(" --quality {quality}");
    }
    if let Some(threads) = settings.threads {
        command += &format!(" --threads {threads}");
    }
    command
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;

    #[test]
    fn the_command_that_repeats_it_is_quoted_where_a_shell_asks_for_it() {
        let report = Report { project: "my rooms".to_owned(), scene: "hall".to_owned(), ..Report::default() };
        let out = PathBuf::from("out");
        let settings = ReportSettings { quality: None, threads: Some(2), budget: 60.0, out };
        let wanted = "hohlraum-bake report 'my rooms' --scene hall --out out --budget 60 --threads 2";
        assert_eq!(command(&report, &settings), wanted);
    }
}
