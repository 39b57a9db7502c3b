//! Exit codes: 2 is wrong usage, 1 a failed job, and both say what was wrong.

mod program;

use std::path::Path;

use engine::scene::Scene;
use engine::scene::file::{Project, save_project, save_scene};
use program::{Run, run_in};

fn run(args: &[&str]) -> Run {
    run_in(&std::env::temp_dir(), args)
}

#[test]
fn wrong_usage_exits_with_2() {
    let wrong: [&[&str]; 20] = [
        &[],
        &["p", "q"],
        &["p", "--rays", "0"],
        &["p", "--rays", "-5"],
        &["p", "--rays", "many"],
        &["p", "--patch-length", "0"],
        &["p", "--patch-length", "-0.1"],
        &["p", "--patch-length", "NaN"],
        &["p", "--patch-length", "inf"],
        &["p", "--threads", "0"],
        &["p", "--quality", "best"],
        &["p", "--unheard-of"],
        &["new"],
        &["new", "p"],
        &["new", "p", "--from", "a.obj", "--sky", "-1,0,0"],
        &["new", "p", "--from", "a.obj", "--sky", "NaN,0,0"],
        &["new", "p", "--from", "a.obj", "--sky", "1,1"],
        &["query", "p", "--points", "a.csv"],
        &["query", "p", "--out", "b.csv"],
        &["query", "p", "--points", "a.csv", "--probes", "a.csv", "--out", "b.csv"],
    ];
    for args in wrong {
        let run = run(args);
        run.failed(2, &["error", "--help"]);
        assert_eq!(run.stdout, "", "{args:?}");
    }
}

#[test]
fn a_folder_that_is_no_project_exits_with_1_and_tells_the_remedy() {
    let folder = tempfile::tempdir().unwrap();
    program::write(folder.path().join("in.csv"), "x,y,z\n0,0,0\n");
    let query: &[&str] = &["query", "nowhere", "--probes", "in.csv", "--out", "out.csv"];
    for args in [&["nowhere"][..], &["plan", "nowhere"], &["check", "nowhere"], query] {
        run_in(folder.path(), args).failed(1, &["nowhere", "is not a project", "hohlraum-bake new"]);
    }
    assert!(!folder.path().join("out.csv").exists());
}

#[test]
fn a_scene_that_the_project_does_not_have_is_named_with_those_it_has() {
    let folder = tempfile::tempdir().unwrap();
    save_empty_project(folder.path());
    let project = folder.path().to_str().unwrap();
    for args in [&[project, "--scene", "attic"][..], &["plan", project, "--scene", "attic"]] {
        run(args).failed(1, &["attic", "main"]);
    }
}

#[test]
fn a_failure_with_json_is_one_object_too() {
    let run = run(&["check", "/nowhere/at/all", "--json"]);
    assert_eq!(run.code, Some(1));
    let error = run.json()["error"].as_str().unwrap().to_owned();
    assert!(error.contains("/nowhere/at/all"), "{error}");
}

#[test]
fn a_project_with_the_name_of_a_command_is_reached_by_its_path() {
    let folder = tempfile::tempdir().unwrap();
    run_in(folder.path(), &["./plan"]).failed(1, &["./plan", "is not a project"]);
}

#[test]
fn help_names_every_command_and_option() {
    let help = run(&["--help"]).done().stdout;
    let words =
        ["new", "plan", "check", "query", "report", "--scene", "--quality", "--rays", "--patch-length"];
    for word in words.iter().chain(&["--threads", "--force", "--json"]) {
        assert!(help.contains(word), "{word} is not in: {help}");
    }
}

fn save_empty_project(folder: &Path) {
    save_project(folder, &Project::default()).unwrap();
    save_scene(folder, "main", &Scene::default()).unwrap();
}
