//! Ctrl-C ends a bake soon, and what it traced is of use to the next one.
#![cfg(unix)]

mod program;

use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

#[test]
fn ctrl_c_stops_a_bake_within_seconds() {
    let folder = tempfile::tempdir().unwrap();
    program::write_furnace(folder.path());
    program::run_in(folder.path(), &["new", "p", "--from", "furnace.obj"]).done();
    // Hours of work.
    let mut bake = Command::new(env!("CARGO_BIN_EXE_hohlraum-bake"))
        .args(["p", "--rays", "100000000", "--patch-length", "0.1"])
        .current_dir(folder.path())
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut told = BufReader::new(bake.stderr.take().unwrap()).lines().map(Result::unwrap);
    let first = told.next().expect("a stage is told");
    assert!(!first.contains("error"), "{first}");

    let pid = bake.id().to_string();
    assert!(Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
    let asked = Instant::now();
    let rest: Vec<String> = told.collect();
    assert_eq!(bake.wait().unwrap().code(), Some(1), "{rest:?}");
    assert!(asked.elapsed() < Duration::from_secs(10), "{:?}", asked.elapsed());
    assert!(rest.iter().any(|line| line.contains("cancelled")), "{rest:?}");
}
