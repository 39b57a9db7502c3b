//! The report as its users see it: files, page, tables, exit codes.

mod program;

use std::path::{Path, PathBuf};

use engine::scene::file::{load_project, save_project};
use program::{Run, run_in};

/// A furnace in `p`.
fn folder_with_project() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    program::write_furnace(folder.path());
    run_in(folder.path(), &["new", "p", "--from", "furnace.obj"]).done();
    folder
}

fn report(folder: &Path, args: &[&str]) -> Run {
    run_in(folder, &[&["report", "p", "--quality", "draft", "--threads", "2"], args].concat())
}

#[test]
fn a_report_is_written_within_its_budget_and_says_what_it_left_out() {
    let folder = folder_with_project();
    run_in(folder.path(), &["p", "--quality", "draft"]).done();
    let run = report(folder.path(), &["--out", "deep/out", "--budget", "20", "--json"]).done();
    let told = run.json();
    assert_eq!(told["scene"], "furnace");
    let report = &told["report"];
    assert_eq!((report["budget"].as_f64(), report["quality"].as_str()), (Some(20.0), Some("draft")));
    assert!(report["seconds"].as_f64().unwrap() > 0.0);
    assert!(!report["machine"]["processor"].as_str().unwrap().is_empty());
    assert!(run.stderr.contains("left of the whole"), "{}", run.stderr);
    let missing =
        |part: &&serde_json::Value| part["left_out"].is_string() || part["error"]["rms"].is_number();
    assert!(report["split"]["parts"].as_array().unwrap().iter().all(|part| missing(&part)));

    let files: Vec<PathBuf> = told["files"]
        .as_array()
        .unwrap()
        .iter()
        .map(|file| folder.path().join(file.as_str().unwrap()))
        .collect();
    assert!(files.iter().all(|file| file.metadata().is_ok_and(|file| file.len() > 0)), "{files:?}");
    let out = folder.path().join("deep/out");
    assert_eq!(std::fs::read_dir(&out).unwrap().count(), files.len(), "nothing else lies there");
    assert_tables(&out, report);
    assert_pictures(&files);
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert_well_formed(&page);
    assert_self_contained(&page);
    assert!(page.contains("hohlraum-bake report p --scene furnace --out deep/out --budget 20"));
    let on_disk: serde_json::Value =
        serde_json::from_slice(&std::fs::read(out.join("report.json")).unwrap()).unwrap();
    assert_eq!(&on_disk, report);
}

/// A budget that is spent before anything can be measured.
#[test]
fn what_does_not_fit_is_named_and_the_page_is_there_all_the_same() {
    let folder = folder_with_project();
    run_in(folder.path(), &["p", "--quality", "draft"]).done();
    let told = report(folder.path(), &["--out", "out", "--budget", "1", "--json"]).done().json();
    let notes = told["report"]["notes"].as_array().unwrap();
    assert!(!notes.is_empty(), "{told:#}");
    assert_well_formed(&std::fs::read_to_string(folder.path().join("out/report.html")).unwrap());
}

/// Hours of rays.
#[test]
fn a_bake_that_does_not_fit_into_the_budget_is_told_with_the_remedy() {
    let folder = folder_with_project();
    let project = folder.path().join("p");
    let mut settings = load_project(&project).unwrap();
    (settings.bake.rays, settings.bake.patch_length) = (Some(1 << 20), Some(0.05));
    save_project(&project, &settings).unwrap();
    let run = report(folder.path(), &["--out", "out", "--budget", "1"]);
    run.failed(1, &["the bake alone takes more", "hohlraum-bake p --scene furnace", "--budget"]);
    assert!(!folder.path().join("out").exists());
}

#[test]
fn a_second_report_replaces_the_first() {
    let folder = folder_with_project();
    run_in(folder.path(), &["p", "--quality", "draft"]).done();
    let args = ["--out", "out", "--budget", "1"];
    report(folder.path(), &args).done();
    let page = folder.path().join("out/report.html");
    std::fs::write(&page, "old").unwrap();
    let run = report(folder.path(), &args).done();
    assert!(run.stdout.contains("report.html") && run.stdout.contains("draft"), "{}", run.stdout);
    assert!(std::fs::read_to_string(&page).unwrap().starts_with("<!DOCTYPE html>"));
}

#[test]
fn wrong_usage_exits_with_2() {
    let folder = tempfile::tempdir().unwrap();
    let wrong: [&[&str]; 7] = [
        &["report"],
        &["report", "p"],
        &["report", "--out", "out"],
        &["report", "p", "--out", "out", "--budget", "0"],
        &["report", "p", "--out", "out", "--budget", "-3"],
        &["report", "p", "--out", "out", "--budget", "NaN"],
        &["report", "p", "--out", "out", "--threads", "0"],
    ];
    for args in wrong {
        let run = run_in(folder.path(), args);
        run.failed(2, &["error", "--help"]);
        assert_eq!(run.stdout, "", "{args:?}");
    }
}

#[test]
fn a_project_a_scene_or_a_folder_that_is_not_there_exits_with_1_and_tells_the_remedy() {
    let folder = folder_with_project();
    run_in(folder.path(), &["report", "nowhere", "--out", "out"])
        .failed(1, &["nowhere", "is not a project", "hohlraum-bake new"]);
    report(folder.path(), &["--out", "out", "--scene", "attic"]).failed(1, &["attic", "furnace"]);
    assert!(!folder.path().join("out").exists());
    program::write(folder.path().join("file"), "not a folder");
    let run = report(folder.path(), &["--out", "file/out", "--json"]);
    run.failed(1, &["file/out", "choose another folder with --out"]);
    assert!(run.json()["error"].as_str().unwrap().contains("file/out"));
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_a_report_soon_and_leaves_no_file() {
    use std::io::{BufRead, BufReader};
    use std::process::{Command, Stdio};

    let folder = folder_with_project();
    let mut report = Command::new(env!("CARGO_BIN_EXE_hohlraum-bake"))
        .args(["report", "p", "--out", "out", "--budget", "600"])
        .current_dir(folder.path())
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut told = BufReader::new(report.stderr.take().unwrap()).lines().map(Result::unwrap);
    let first = told.next().expect("a stage is told");
    assert!(!first.contains("error"), "{first}");
    let pid = report.id().to_string();
    assert!(Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
    let rest: Vec<String> = told.collect();
    assert_eq!(report.wait().unwrap().code(), Some(1), "{rest:?}");
    assert!(rest.iter().any(|line| line.contains("no report was written")), "{rest:?}");
    assert!(!folder.path().join("out").exists());
}

/// Every table has its columns, and a row a point.
#[track_caller]
fn assert_tables(out: &Path, report: &serde_json::Value) {
    let lines = |name: &str| -> Vec<String> {
        let text = std::fs::read_to_string(out.join(name)).unwrap();
        text.lines().map(str::to_owned).collect()
    };
    for diagram in report["diagrams"].as_array().unwrap() {
        let lines = lines(&format!("{}.csv", diagram["id"].as_str().unwrap()));
        assert_eq!(
            lines[0],
            "method,setting,x,x_least,x_largest,runs,rms,bias,p99,max,preset,on_front,rms_error"
        );
        let series = diagram["series"].as_array().unwrap();
        let points: usize = series.iter().map(|series| series["points"].as_array().unwrap().len()).sum();
        assert_eq!(lines.len(), 1 + points);
    }
    let split = lines("split.csv");
    assert_eq!(split[0], "part,compared,rms,bias,p99,max,left_out");
    assert_eq!(split.iter().filter(|line| line.starts_with("total,")).count(), 1);
    assert_eq!(split.len(), 2 + report["split"]["parts"].as_array().unwrap().len());
    assert_eq!(lines("advice.csv")[0], "goal,change,cost,error");
}

#[track_caller]
fn assert_pictures(files: &[PathBuf]) {
    let of = |end: &str| {
        files.iter().filter(|file| file.extension().is_some_and(|e| e == end)).collect::<Vec<_>>()
    };
    let (plots, pictures) = (of("svg"), of("png"));
    assert!(!plots.is_empty() && pictures.len() >= plots.len());
    for picture in pictures {
        let picture = image::open(picture).unwrap();
        assert!(picture.width() >= 960 && picture.height() >= 300, "{picture:?}");
    }
    for plot in plots {
        let text = std::fs::read_to_string(plot).unwrap();
        assert!(text.contains("viewBox") && !text.contains("NaN"), "{}", plot.display());
        assert_well_formed(&text);
    }
}

/// Every element that is opened is closed, in order.
#[track_caller]
fn assert_well_formed(text: &str) {
    const VOID: [&str; 3] = ["meta", "img", "br"];
    let mut open: Vec<&str> = Vec::new();
    let mut rest = text;
    while let Some(start) = rest.find('<') {
        let end = rest[start..].find('>').expect("a tag ends") + start;
        let tag = &rest[start + 1..end];
        assert_eq!(tag.matches('"').count() % 2, 0, "{tag}");
        rest = &rest[end + 1..];
        let name = tag.split([' ', '\n', '/']).next().unwrap();
        match tag.strip_prefix('/') {
            Some(closed) => assert_eq!(open.pop(), Some(closed)),
            None if tag.starts_with('!') || tag.ends_with('/') || VOID.contains(&name) => {}
            None => open.push(name),
        }
    }
    assert_eq!(open, [""; 0]);
}

/// Nothing is fetched from anywhere.
#[track_caller]
fn assert_self_contained(page: &str) {
    for source in page.split("src=\"").skip(1) {
        assert!(source.starts_with("data:image/png;base64,"), "{}", &source[..40]);
    }
    let outside = page.replace("http://www.w3.org/2000/svg", "");
    for word in ["<script", "<link", "<iframe", "@import", "url(", "http://", "https://", "href="] {
        assert!(!outside.contains(word), "{word}");
    }
}
