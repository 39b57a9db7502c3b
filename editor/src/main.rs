//! `hohlraum [PROJECT]`: run, or print the error chain and choose an exit code.

mod start;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;

/// Opens a project in the editor; where there is no display, bakes it where that is needed and plays it into files
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
