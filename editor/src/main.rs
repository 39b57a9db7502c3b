//! `hohlraum [PROJECT]`: run, or print the error chain and choose an exit code.

mod start;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;

/// Opens a project: bakes it where that is needed, then plays it
#[derive(Debug, Parser)]
#[command(name = "hohlraum", version)]
struct Arguments {
    /// The project's folder; the Cornell box where nothing is said
    project: Option<PathBuf>,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    match start::run(arguments.project) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {}", bake::chain::told(error.as_ref()));
            ExitCode::from(1)
        }
    }
}
