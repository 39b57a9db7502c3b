//! `query`: what is wrong with a row is told by file, line and column; answers keep the rows' order.

mod program;

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use engine::scene::Scene;
use engine::scene::file::{Project, save_project, save_scene};
use program::{Run, run_in, write, write_furnace};
use tempfile::TempDir;

#[test]
fn a_bad_row_is_named_by_file_line_and_column() {
    let cases = [
        ("x,y,z,nx,ny,nz\n0,0,0,0,1,0\n\n0,abc,0,0,1,0\n", vec!["in.csv", "line 4", "column y", "abc"]),
        ("x,y,z,nx,ny,nz\n0,0,0,0,1\n", vec!["in.csv", "line 2", "column nz"]),
        ("x,y,z,nx,ny,nz\n0,0,NaN,0,1,0\n", vec!["in.csv", "line 2", "column z", "NaN"]),
        ("x,y,z,nx,ny,nz\n0,0,0,0,0,0\n", vec!["in.csv", "line 2", "nx,ny,nz"]),
        ("x,y,z,nx,ny\n0,0,0,0,1\n", vec!["in.csv", "column `nz`"]),
        ("", vec!["in.csv", "column `x`"]),
    ];
    for (csv, says) in cases {
        let folder = empty_project();
        query(folder.path(), "--points", csv).failed(1, &says);
        assert!(!folder.path().join("out.csv").exists(), "{csv}");
    }
}

#[test]
fn a_missing_bake_is_told_with_the_command_that_makes_it() {
    let folder = furnace_project();
    query(folder.path(), "--points", "x,y,z,nx,ny,nz\n0,-1,0,0,1,0\n")
        .failed(1, &["furnace", "hohlraum-bake"]);
    run_in(folder.path(), &["check", "p"]).failed(1, &["furnace", "hohlraum-bake"]);
}

#[test]
fn a_closed_furnace_is_baked_checked_and_asked() {
    let folder = furnace_project();
    let bake = ["p", "--quality", "draft", "--patch-length", "0.5", "--json"];
    let first = run_in(folder.path(), &bake).done().json();
    assert_eq!((&first["unchanged"], &first["holds"]), (&false.into(), &true.into()), "{first}");
    let again = run_in(folder.path(), &bake).done().json();
    assert_eq!(again["unchanged"], true);
    assert_eq!(again["certificate"]["transport_hash"], first["certificate"]["transport_hash"]);

    let checked = run_in(folder.path(), &["check", "p", "--quality", "draft", "--json"]).done().json();
    assert_eq!(checked["holds"], true, "{checked}");
    let plan = run_in(folder.path(), &["plan", "p", "--quality", "draft", "--json"]).done().json();
    assert!(plan["patches"].as_u64() > Some(0), "{plan}");

    // Irradiance 2 pi everywhere: the walls' own pi at once, as much again by bounces.
    for method in ["receivers", "gather"] {
        let answers = points_answered(folder.path(), method);
        for row in answers {
            assert_eq!(row[..6], [0.25, -1.0, 0.5, 0.0, 1.0, 0.0]);
            let (direct, indirect, all) = (row[6], row[9], row[12]);
            assert!((direct - PI).abs() < 0.02 * PI, "{method}: direct {direct}");
            assert!((indirect - PI).abs() < 0.02 * PI, "{method}: indirect {indirect}");
            assert!((all - direct - indirect).abs() < 1e-6, "{method}");
        }
    }
}

#[test]
fn probes_in_a_furnace_see_the_same_radiance_all_around() {
    let folder = furnace_project();
    run_in(folder.path(), &["p", "--quality", "draft", "--patch-length", "0.5"]).done();
    write(folder.path().join("in.csv"), "z,name,x,y\n0.1,here,0.2,0.3\n");
    let args = ["query", "p", "--quality", "draft", "--probes", "in.csv", "--out", "out.csv"];
    run_in(folder.path(), &args).done();
    let text = std::fs::read_to_string(folder.path().join("out.csv")).unwrap();
    assert!(text.starts_with("x,y,z,L00_r,L00_g,L00_b,L1-1_r,"), "{text}");
    let row = &numbers(&text)[0];
    assert_eq!(row[..3], [0.2, 0.3, 0.1]);
    // Radiance 2 in all directions: L00 = 2 sqrt(4 pi).
    assert!((row[3] - 2.0 * (4.0 * PI).sqrt()).abs() < 0.02 * row[3], "{row:?}");
    assert!(row[6..].iter().all(|l| l.abs() < 0.1), "{row:?}");
}

#[test]
fn a_point_that_lies_on_nothing_is_named_by_its_row() {
    let folder = furnace_project();
    run_in(folder.path(), &["p", "--patch-length", "0.5"]).done();
    let csv = "x,y,z,nx,ny,nz\n0,-1,0,0,1,0\n0,0,0,0,1,0\n";
    query(folder.path(), "--points", csv).failed(1, &["in.csv", "2"]);
}

fn points_answered(folder: &Path, method: &str) -> Vec<Vec<f64>> {
    let csv = "name,nx,ny,nz,x,y,z\nfloor,0,1,0,0.25,-1,0.5\n";
    write(folder.join("in.csv"), csv);
    let args =
        ["query", "p", "--quality", "draft", "--points", "in.csv", "--out", "out.csv", "--method", method];
    run_in(folder, &args).done();
    let text = std::fs::read_to_string(folder.join("out.csv")).unwrap();
    let header = "x,y,z,nx,ny,nz,direct_r,direct_g,direct_b,indirect_r,indirect_g,indirect_b,Er,Eg,Eb\n";
    assert!(text.starts_with(header), "{text}");
    numbers(&text)
}

fn numbers(csv: &str) -> Vec<Vec<f64>> {
    csv.lines().skip(1).map(|line| line.split(',').map(|number| number.parse().unwrap()).collect()).collect()
}

fn query(folder: &Path, what: &str, csv: &str) -> Run {
    write(folder.join("in.csv"), csv);
    run_in(folder, &["query", "p", what, "in.csv", "--out", "out.csv"])
}

fn empty_project() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let project: PathBuf = folder.path().join("p");
    save_project(&project, &Project::default()).unwrap();
    save_scene(&project, "main", &Scene::default()).unwrap();
    folder
}

fn furnace_project() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    write_furnace(folder.path());
    run_in(folder.path(), &["new", "p", "--from", "furnace.obj"]).done();
    folder
}
