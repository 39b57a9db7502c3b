//! `hohlraum-bake plan PROJECT`

use std::process::ExitCode;

use anyhow::Result;

use crate::args::PlanArgs;
use crate::print;

pub fn run(args: &PlanArgs) -> Result<ExitCode> {
    let settings = args.rays.settings(&args.scene, false);
    let plan = bake::plan(&args.scene.project, args.scene.name(), &settings)?;
    if args.json {
        print::json(&plan);
    } else {
        print::text(&print::plan(&plan));
    }
    plan.warnings.iter().for_each(|warning| eprintln!("warning: {warning}"));
    Ok(ExitCode::SUCCESS)
}
