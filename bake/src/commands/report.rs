//! `hohlraum-bake report PROJECT --out DIR`

use std::process::ExitCode;
use std::time::Duration;

use anyhow::Result;
use bake::progress::Bar;
use bake::report::files::{self, Told};
use bake::report::{self, Report};
use serde_json::json;

use crate::args::ReportArgs;
use crate::print;

pub fn run(args: &ReportArgs) -> Result<ExitCode> {
    let scene = super::scene_name(&args.scene.project, args.scene.name())?;
    let bar = Bar::within(Duration::from_secs_f64(args.budget));
    bar.stop_on_signals()?;
    let report = report::report(&args.scene.project, Some(&scene), &args.settings(), &bar)?;
    drop(bar);
    let told = Told::new(&report);
    let written: Vec<_> = files::names(&report).iter().map(|name| args.out.join(name)).collect();
    if args.json {
        let presets_on_front = told.presets.iter().all(|preset| preset.on_front);
        print::json(&json!({
            "scene": scene,
            "files": written,
            "holds": report.certificate.holds(),
            "presets_on_front": presets_on_front,
            "report": told,
        }));
    } else {
        print::text(&text(&report, &told));
        print::text(&format!("{}\n", args.out.join("report.html").display()));
    }
    Ok(ExitCode::SUCCESS)
}

/// What a person wants to know before opening the page.
fn text(report: &Report, told: &Told) -> String {
    let mut lines = report::summary(report);
    for advice in &report.advice {
        let (cost, error) = (advice.cost, advice.error);
        lines.push(format!("{}: {} (cost x {cost:.2}, error x {error:.2})", advice.goal, advice.change));
    }
    for preset in told.presets.iter().filter(|preset| !preset.on_front) {
        let (name, diagram) = (&preset.preset, &preset.diagram);
        let off = preset.error_factor.min(preset.x_factor);
        lines.push(format!("{name} is off the front of {diagram} by a factor of {off:.2}"));
    }
    lines.extend(report.notes.iter().map(|note| format!("note: {note}")));
    lines.push(format!("{:.0} s of {:.0} s", report.seconds, report.budget));
    lines.join("\n") + "\n"
}
