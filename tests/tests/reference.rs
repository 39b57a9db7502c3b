//! Irradiance and light probes against an independent path tracer (`reference/` of the shared folder).

use std::path::Path;
use std::time::Instant;

use bake::{Method, Point, Settings, Silent, bake, query_points, query_probes};
use engine::scene::file::Quality;
use glam::DVec3;
use tests::project::TestProject;
use tests::shared;

struct Reference {
    points: Vec<Point>,
    irradiance: Vec<DVec3>,
    probes: Vec<DVec3>,
    coefficients: Vec<[DVec3; 9]>,
}

fn read(folder: &Path, name: &str) -> Reference {
    let table = |file: String| csv::Reader::from_path(folder.join(file)).ok();
    let mut reader = table(format!("{name}.csv")).expect("a reference table");
    let headers = reader.headers().expect("headers").clone();
    let at = |name: &str| headers.iter().position(|header| header == name).expect("a column");
    let vector = |row: &csv::StringRecord, names: [&str; 3]| -> DVec3 {
        DVec3::from_array(names.map(|name| row[at(name)].parse().expect("a number")))
    };
    let (mut points, mut irradiance) = (Vec::new(), Vec::new());
    for row in reader.records().flatten() {
        let position = vector(&row, ["x", "y", "z"]);
        points.push(Point { position, normal: vector(&row, ["nx", "ny", "nz"]) });
        irradiance.push(vector(&row, ["Er", "Eg", "Eb"]));
    }
    let (mut probes, mut coefficients): (Vec<DVec3>, Vec<[DVec3; 9]>) = (Vec::new(), Vec::new());
    const NAMES: [&str; 9] = ["L00", "L1-1", "L10", "L11", "L2-2", "L2-1", "L20", "L21", "L22"];
    if let Some(mut reader) = table(format!("{name}_probes.csv")) {
        for row in reader.records().flatten() {
            let number = |i: usize| -> f64 { row[i].parse().expect("a number") };
            let position = DVec3::new(number(0), number(1), number(2));
            if probes.last() != Some(&position) {
                probes.push(position);
                coefficients.push([DVec3::ZERO; 9]);
            }
            if let Some(k) = NAMES.iter().position(|name| *name == &row[3]) {
                coefficients.last_mut().expect("a probe")[k] = DVec3::new(number(4), number(5), number(6));
            }
        }
    }
    Reference { points, irradiance, probes, coefficients }
}

/// rms of all channels' differences over the mean of the reference; signed mean difference over it.
fn errors(got: &[DVec3], wanted: &[DVec3]) -> (f64, f64) {
    let n = 3.0 * wanted.len() as f64;
    let mean = wanted.iter().map(|w| w.element_sum()).sum::<f64>() / n;
    let square = got.iter().zip(wanted).map(|(g, w)| (*g - *w).length_squared()).sum::<f64>() / n;
    let bias = got.iter().zip(wanted).map(|(g, w)| (*g - *w).element_sum()).sum::<f64>() / n;
    (square.sqrt() / mean, bias / mean)
}

fn totals(project: &Path, points: &[Point], method: Method) -> Vec<DVec3> {
    let found = query_points(project, None, &Settings::default(), points, method).expect("a query");
    found.iter().map(|irradiance| irradiance.direct + irradiance.indirect).collect()
}

/// Bakes and queries a scene; prints every figure; returns (rms, bias) of the method asked for.
fn judge(name: &str, quality: Quality, method: Method) -> Option<(f64, f64)> {
    let Some(shared) = shared() else {
        println!("not run: no ../shared");
        return None;
    };
    let folder = shared.join("reference");
    let reference = read(&folder, name);
    let project = TestProject::from_file(&folder.join(format!("scenes/{name}/{name}.gltf")));
    let started = Instant::now();
    let settings = Settings { quality: Some(quality), ..Settings::default() };
    let baked = bake(project.path(), None, &settings, &Silent).expect("a bake");
    let seconds = started.elapsed().as_secs_f64();
    let certificate = &baked.transport.certificate;
    assert!(certificate.holds(), "{:#?}", certificate.statements());
    let mut result = None;
    for (label, other) in [("receivers", Method::Receivers), ("gather", Method::Gather)] {
        if label == "gather" && method == Method::Receivers {
            continue;
        }
        let (rms, bias) = errors(&totals(project.path(), &reference.points, other), &reference.irradiance);
        println!(
            "{name} {quality} {label}: rms {:.3} %, bias {:+.3} %, bake {seconds:.1} s, {} patches, {} receivers, {} rays",
            rms * 100.0,
            bias * 100.0,
            certificate.patches,
            certificate.receivers,
            certificate.rays
        );
        if other == method {
            result = Some((rms, bias));
        }
    }
    if !reference.probes.is_empty() && method == Method::Gather {
        let found =
            query_probes(project.path(), None, &Settings::default(), &reference.probes).expect("a query");
        let differences = found
            .iter()
            .zip(&reference.coefficients)
            .flat_map(|(f, r)| (0..9).map(|k| (f[k].as_dvec3() - r[k]).length_squared()).collect::<Vec<_>>());
        let n = reference.probes.len() as f64;
        let rms = (differences.sum::<f64>() / (27.0 * n)).sqrt();
        let mean = reference.coefficients.iter().map(|c| c[0].element_sum()).sum::<f64>() / (3.0 * n);
        println!("{name} {quality} probes: rms {:.3} % of mean L00", rms / mean * 100.0);
        assert!(rms / mean <= 0.02);
    }
    result
}

fn assert_within(result: Option<(f64, f64)>, rms: f64, bias: f64) {
    if let Some((found_rms, found_bias)) = result {
        assert!(found_rms <= rms && found_bias.abs() <= bias, "rms {found_rms}, bias {found_bias}");
    }
}

#[test]
fn cornell_at_standard_quality_is_within_3_percent_at_its_receivers() {
    assert_within(judge("cornell", Quality::Standard, Method::Receivers), 0.03, 0.008);
}

#[test]
fn two_rooms_at_standard_quality_is_within_3_percent_at_its_receivers() {
    assert_within(judge("two_rooms", Quality::Standard, Method::Receivers), 0.03, 0.008);
}

#[test]
fn lamps_at_standard_quality_is_within_3_percent_at_its_receivers() {
    assert_within(judge("lamps", Quality::Standard, Method::Receivers), 0.03, 0.008);
}

#[test]
fn cornell_at_fine_quality_is_within_1_percent_by_a_final_gather() {
    assert_within(judge("cornell", Quality::Fine, Method::Gather), 0.01, 0.003);
}

#[test]
fn two_rooms_at_fine_quality_is_within_1_percent_by_a_final_gather() {
    assert_within(judge("two_rooms", Quality::Fine, Method::Gather), 0.01, 0.003);
}

#[test]
fn lamps_at_fine_quality_is_within_1_percent_by_a_final_gather() {
    assert_within(judge("lamps", Quality::Fine, Method::Gather), 0.01, 0.003);
}

#[test]
fn a_furnace_is_two_pi_everywhere_at_every_quality() {
    let Some(shared) = shared() else {
        println!("not run: no ../shared");
        return;
    };
    let folder = shared.join("reference");
    let reference = read(&folder, "furnace05");
    let project = TestProject::from_file(&folder.join("scenes/furnace05/furnace05.gltf"));
    for quality in [Quality::Draft, Quality::Standard] {
        let settings = Settings { quality: Some(quality), ..Settings::default() };
        bake(project.path(), None, &settings, &Silent).expect("a bake");
        for method in [Method::Receivers, Method::Gather] {
            for found in totals(project.path(), &reference.points, method) {
                assert!((found - DVec3::splat(std::f64::consts::TAU)).abs().max_element() < 1e-3, "{found}");
            }
        }
    }
    let probes =
        query_probes(project.path(), None, &Settings::default(), &reference.probes).expect("a query");
    for probe in probes {
        assert!((probe[0].x - 7.089_815).abs() < 1e-3, "{}", probe[0]);
        assert!(probe[1..].iter().all(|l| l.abs().max_element() < 0.02), "{probe:?}");
    }
}
