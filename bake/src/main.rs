//! `hohlraum-bake`: run, or print the error chain and choose an exit code.

mod args;
mod commands;
mod print;

use std::process::ExitCode;

use anyhow::Error;
use args::{Arguments, Command};
use clap::Parser;

fn main() -> ExitCode {
    let arguments = Arguments::parse(); // wrong usage ends here, with 2
    let (json, done) = run(arguments);
    match done {
        Ok(code) => code,
        Err(error) => failed(&error, json),
    }
}

/// Whether the answer is JSON, and how it went.
fn run(arguments: Arguments) -> (bool, Result<ExitCode, Error>) {
    match (arguments.command, arguments.scene) {
        (Some(Command::New(args)), _) => (args.json, commands::new::run(&args)),
        (Some(Command::Plan(args)), _) => (args.json, commands::plan::run(&args)),
        (Some(Command::Check(args)), _) => (args.json, commands::check::run(&args)),
        (Some(Command::Query(args)), _) => (args.json, commands::query::run(&args)),
        (Some(Command::Report(args)), _) => (args.json, commands::report::run(&args)),
        (None, Some(scene)) => (arguments.bake.json, commands::bake::run(&scene, &arguments.bake)),
        (None, None) => (false, Err(anyhow::anyhow!("which project?"))), // clap asks for it before
    }
}

fn failed(error: &Error, json: bool) -> ExitCode {
    let told = bake::chain::told(error.as_ref());
    eprintln!("error: {told}");
    if json {
        print::json(&serde_json::json!({ "error": told }));
    }
    ExitCode::from(1)
}
