//! The player as a program: found beside this one, run with a limit of time, stopped when nobody waits for it.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::time::Duration;

use tempfile::TempDir;

use super::super::Budget;
use crate::{BakeError, Watcher};

/// How often it is looked at.
const GLANCE: Duration = Duration::from_millis(20);

pub struct Child<'a> {
    player: PathBuf,
    project: &'a Path,
    scene: &'a str,
    /// What it writes.
    folder: TempDir,
}

/// How a run ended.
#[derive(Debug, PartialEq)]
pub enum Ended {
    Well,
    /// With what it said last.
    Badly(String),
    /// After so many seconds the budget was spent.
    Stopped(f64),
}

impl<'a> Child<'a> {
    /// Or why there is none.
    pub fn new(project: &'a Path, scene: &'a str) -> Result<Self, String> {
        let own = std::env::current_exe().map_err(|error| format!("this program is not found: {error}"))?;
        let player = own.with_file_name(format!("hohlraum-play{}", std::env::consts::EXE_SUFFIX));
        if !player.is_file() {
            return Err(format!(
                "there is no hohlraum-play beside this program ({}): build it with `cargo build -p engine`",
                player.display()
            ));
        }
        let folder = TempDir::with_prefix("hohlraum-report-").map_err(|error| error.to_string())?;
        Ok(Self { player, project, scene, folder })
    }

    /// Of the folder in which it runs.
    pub fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Names of files in `args` are relative to the folder.
    pub fn run(&self, args: &[&str], budget: &Budget, watcher: &dyn Watcher) -> Result<Ended, BakeError> {
        let broken = |error: std::io::Error| Ended::Badly(error.to_string());
        let started = || -> std::io::Result<_> {
            let project = std::path::absolute(self.project)?;
            let (said, error) = (self.file("said"), File::create(self.file("said"))?);
            let mut command = Command::new(&self.player);
            command.arg(project).args(["--headless", "--scene", self.scene]).args(args);
            command.current_dir(self.folder.path());
            let streams = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(error);
            Ok((streams.spawn()?, said))
        };
        let (mut child, said) = match started() {
            Ok(started) => started,
            Err(error) => return Ok(broken(error)),
        };
        let (began, ended) = (budget.spent(), wait(&mut child, budget, watcher));
        if !matches!(ended, Ok(Some(_))) {
            // It may have ended in this moment.
            let _ = child.kill();
            let _ = child.wait();
        }
        if watcher.cancelled() {
            return Err(BakeError::Cancelled);
        }
        Ok(match ended {
            Ok(Some(status)) if status.success() => Ended::Well,
            Ok(Some(_)) => Ended::Badly(last_line(&said)),
            Ok(None) => Ended::Stopped(budget.spent() - began),
            Err(error) => broken(error),
        })
    }
}

/// None: it was not waited for to the end.
fn wait(
    child: &mut std::process::Child,
    budget: &Budget,
    watcher: &dyn Watcher,
) -> std::io::Result<Option<ExitStatus>> {
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status));
        }
        if watcher.cancelled() || budget.is_spent() {
            return Ok(None);
        }
        std::thread::sleep(GLANCE);
    }
}

fn last_line(said: &Path) -> String {
    let text = std::fs::read(said).unwrap_or_default();
    let text = String::from_utf8_lossy(&text);
    let line = text.lines().rev().find(|line| !line.trim().is_empty()).unwrap_or("nothing");
    line.trim().trim_start_matches("error: ").to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Silent;

    struct Gone;

    impl Watcher for Gone {
        fn cancelled(&self) -> bool {
            true
        }
    }

    /// Some program stands for the player.
    fn child(program: &str) -> Child<'static> {
        let folder = tempfile::tempdir().unwrap();
        Child { player: PathBuf::from(program), project: Path::new("."), scene: "main", folder }
    }

    #[test]
    fn a_program_that_is_missing_is_told() {
        let ended = child("/nowhere/at/all").run(&[], &Budget::new(10.0), &Silent).unwrap();
        assert!(matches!(ended, Ended::Badly(_)), "{ended:?}");
        let error = Child::new(Path::new("."), "main").err().expect("no player lies beside a unit test");
        assert!(error.contains("hohlraum-play") && error.contains("cargo build"), "{error}");
    }

    /// This test's own program with an argument that it does not know.
    #[test]
    fn a_program_that_fails_is_told_with_what_it_said_last() {
        let own = std::env::current_exe().unwrap();
        let ended = child(own.to_str().unwrap()).run(&["--wings"], &Budget::new(60.0), &Silent).unwrap();
        assert!(matches!(&ended, Ended::Badly(said) if said.contains("headless")), "{ended:?}");
    }

    #[test]
    fn nobody_waits_when_the_budget_is_spent_or_the_report_cancelled() {
        let own = std::env::current_exe().unwrap();
        let child = child(own.to_str().unwrap());
        let spent = child.run(&[], &Budget::new(0.0), &Silent);
        assert!(matches!(spent, Ok(Ended::Stopped(_) | Ended::Badly(_))), "{spent:?}");
        let cancelled = child.run(&[], &Budget::new(60.0), &Gone);
        assert!(matches!(cancelled, Err(BakeError::Cancelled)), "{cancelled:?}");
    }
}
