//! What a report becomes on disk: all of it at the end, each file in one piece.
//!
//! ```text
//! report.html        the page
//! report.json        everything on it
//! ID.csv .svg .png   each diagram
//! split.csv .svg .png, advice.csv
//! picture.png        as the player draws the scene
//! ```

use std::path::Path;

use engine::scene::SceneError;
use engine::scene::file::write_atomically;
use engine::transport::certificate::Statement;
use serde::Serialize;

use super::front::{Verdict, verdicts};
use super::model::Report;
use super::trend::{Trend, trends};
use super::{ReportSettings, csv, page, plot};
use crate::{BakeError, Watcher};

/// A file's name and what is in it.
pub type File = (String, Vec<u8>);

/// The report with what follows from it.
#[derive(Serialize)]
pub struct Told<'a> {
    #[serde(flatten)]
    pub report: &'a Report,
    pub statements: Vec<Statement>,
    pub presets: Vec<Verdict>,
    pub trends: Vec<Trend>,
    /// Whether the parts of the error add up to it.
    pub adds_up: bool,
}

impl<'a> Told<'a> {
    pub fn new(report: &'a Report) -> Self {
        Self {
            report,
            statements: report.certificate.statements(),
            presets: verdicts(&report.diagrams),
            trends: trends(&report.diagrams),
            adds_up: report.split.adds_up(),
        }
    }
}

/// Says before minutes of work where the folder cannot be made or written to; makes nothing.
pub fn can_be_written(out: &Path) -> Result<(), BakeError> {
    let there = out.ancestors().find(|folder| folder.exists()).unwrap_or(Path::new("."));
    tempfile::tempfile_in(there).map(drop).map_err(|error| {
        BakeError::Other(format!(
            "{}: no report can be written there ({error}); choose another folder with --out",
            out.display()
        ))
    })
}

/// All files, none written yet.
pub fn of(report: &Report, settings: &ReportSettings, watcher: &dyn Watcher) -> Result<Vec<File>, BakeError> {
    watcher.stage("page", report.diagrams.len() as u64 + 2);
    let mut plots = Vec::new();
    let mut files: Vec<File> = Vec::new();
    for diagram in &report.diagrams {
        if watcher.cancelled() {
            return Err(BakeError::Cancelled);
        }
        plots.push(plot::of_diagram(diagram)?);
        files.push((format!("{}.csv", diagram.id), csv::diagram(diagram)?));
        watcher.advance(1, 0);
    }
    plots.push(plot::of_split(&report.split)?);
    watcher.advance(1, 0);
    files.push(("split.csv".to_owned(), csv::split(&report.split)?));
    files.push(("advice.csv".to_owned(), csv::advice(&report.advice)?));
    for plot in &plots {
        files.push((format!("{}.svg", plot.id), plot.svg.clone().into_bytes()));
        files.push((format!("{}.png", plot.id), plot.png.clone()));
    }
    files.extend(report.picture.clone().map(|picture| ("picture.png".to_owned(), picture)));
    let told = Told::new(report);
    let json = serde_json::to_vec_pretty(&told);
    let json = json.map_err(|error| BakeError::Other(format!("the report was not told: {error}")))?;
    files.push(("report.json".to_owned(), json));
    files.push(("report.html".to_owned(), page::page(&told, settings, &plots).into_bytes()));
    watcher.advance(1, 0);
    Ok(files)
}

/// In the order of [`of`], the page last.
pub fn names(report: &Report) -> Vec<String> {
    let ids = || report.diagrams.iter().map(|diagram| diagram.id.as_str());
    let tables = ids().chain(["split", "advice"]).map(|id| format!("{id}.csv"));
    let plots = ids().chain(["split"]).flat_map(|id| [format!("{id}.svg"), format!("{id}.png")]);
    let picture = report.picture.as_ref().map(|_| "picture.png".to_owned());
    let told = ["report.json", "report.html"].map(str::to_owned);
    tables.chain(plots).chain(picture).chain(told).collect()
}

pub fn write(out: &Path, files: &[File]) -> Result<(), BakeError> {
    let write = |(name, bytes): &File| -> Result<(), SceneError> { write_atomically(&out.join(name), bytes) };
    Ok(files.iter().try_for_each(write)?)
}

#[cfg(test)]
mod tests {
    use super::super::model::Diagram;
    use super::*;
    use crate::Silent;

    fn settings(out: &Path) -> ReportSettings {
        ReportSettings { quality: None, threads: None, budget: 1.0, out: out.to_owned() }
    }

    #[test]
    fn what_is_written_is_what_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let diagram = Diagram { id: "rays".to_owned(), ..Diagram::default() };
        let report = Report { diagrams: vec![diagram], picture: Some(vec![1]), ..Report::default() };
        let files = of(&report, &settings(folder.path()), &Silent).unwrap();
        let named: Vec<String> = files.iter().map(|(name, _)| name.clone()).collect();
        assert_eq!(named, names(&report));
        write(folder.path(), &files).unwrap();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), named.len());
        let json: serde_json::Value =
            serde_json::from_slice(&std::fs::read(folder.path().join("report.json")).unwrap()).unwrap();
        assert_eq!(json["diagrams"][0]["id"], "rays");
        assert_eq!(json["statements"].as_array().unwrap().len(), report.certificate.statements().len());
    }

    #[test]
    fn a_folder_that_cannot_be_made_is_told_with_the_remedy() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        std::fs::write(&file, "").unwrap();
        let error = can_be_written(&file.join("deep")).unwrap_err().to_string();
        assert!(error.contains("file") && error.contains("--out"), "{error}");
        can_be_written(&folder.path().join("deep/er")).unwrap();
        assert!(!folder.path().join("deep").exists());
        can_be_written(Path::new("deep/er")).unwrap();
    }
}
