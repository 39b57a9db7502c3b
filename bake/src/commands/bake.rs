//! `hohlraum-bake PROJECT`

use std::process::ExitCode;

use anyhow::Result;
use bake::progress::Bar;
use serde_json::json;

use crate::args::{BakeArgs, SceneArgs};
use crate::print;

pub fn run(of: &SceneArgs, args: &BakeArgs) -> Result<ExitCode> {
    let scene = super::scene_name(&of.project, of.name())?;
    let settings = args.rays.settings(of, args.force);
    let bar = Bar::new();
    bar.stop_on_signals()?;
    let baked = bake::bake(&of.project, Some(&scene), &settings, &bar)?;
    drop(bar);

    let certificate = &baked.transport.certificate;
    if args.json {
        print::json(&json!({
            "scene": scene,
            "file": baked.file,
            "unchanged": baked.unchanged,
            "holds": certificate.holds(),
            "statements": certificate.statements(),
            "certificate": certificate,
            "sections": engine::transport::file::sections(&baked.file)?,
            "warnings": baked.warnings.iter().map(ToString::to_string).collect::<Vec<_>>(),
        }));
    } else {
        print::text(&print::certificate(certificate));
        let state = if baked.unchanged { "unchanged, no ray was traced" } else { "written" };
        print::text(&format!("{}: {state}\n", baked.file.display()));
    }
    baked.warnings.iter().for_each(|warning| eprintln!("warning: {warning}"));
    Ok(print::verdict(certificate))
}
