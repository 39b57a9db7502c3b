//! `hohlraum-bake check PROJECT`

use std::process::ExitCode;

use anyhow::Result;
use engine::transport::file;
use serde_json::json;

use crate::args::CheckArgs;
use crate::print;

pub fn run(args: &CheckArgs) -> Result<ExitCode> {
    let scene = super::scene_name(&args.scene.project, args.scene.name())?;
    let certificate = bake::check(&args.scene.project, Some(&scene), &args.scene.settings())?;
    let sections = file::sections(&file::path(&args.scene.project, &scene))?;
    if args.json {
        print::json(&json!({
            "scene": scene,
            "holds": certificate.holds(),
            "statements": certificate.statements(),
            "certificate": certificate,
            "sections": sections,
        }));
    } else {
        print::text(&print::certificate(&certificate));
    }
    Ok(print::verdict(&certificate))
}
