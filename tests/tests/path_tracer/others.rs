//! Against an independent path tracer, where `../shared/reference` is: the same answers, to both sides' errors.

use bake::Silent;
use bake::reference::{PathTracer, Surfaces};
use glam::DVec3;
use tests::project::TestProject;
use tests::shared;
use tests::table::{self, Table};

use crate::{assert_consistent, with_error};

fn open(name: &str) -> Option<(PathTracer, Table)> {
    let folder = shared()?.join("reference");
    let project = TestProject::from_file(&folder.join(format!("scenes/{name}/{name}.gltf")));
    let tracer = PathTracer::open(project.path(), None, Surfaces::Diffuse).expect("a scene");
    Some((tracer, table::read(&folder, name)))
}

/// rms of the differences over the mean, and rms of each side's error.
fn shares(found: &[[DVec3; 2]], wanted: &[[DVec3; 2]]) -> [f64; 3] {
    let count = 3.0 * wanted.len() as f64;
    let mean = wanted.iter().map(|[wanted, _]| wanted.element_sum()).sum::<f64>() / count;
    let rms = |squares: f64| 100.0 * (squares / count).sqrt() / mean;
    let of = |side: &[[DVec3; 2]]| rms(side.iter().map(|[_, sigma]| sigma.length_squared()).sum());
    let pairs = found.iter().zip(wanted);
    [rms(pairs.map(|(f, w)| (f[0] - w[0]).length_squared()).sum()), of(found), of(wanted)]
}

fn assert_irradiance(name: &str, paths: u32) {
    let Some((tracer, table)) = open(name) else { return };
    let started = std::time::Instant::now();
    let found = tracer.irradiance(&table.points, paths, 1, &Silent).expect("irradiance");
    let found = with_error(&found);
    let [rms, own, its] = shares(&found, &table.irradiance);
    let seconds = started.elapsed().as_secs_f64();
    println!("{name}: rms {rms:.3} %, own error {own:.3} %, its {its:.3} %, {seconds:.1} s");
    for (k, ([found, sigma], [wanted, other])) in found.iter().zip(&table.irradiance).enumerate() {
        let off = (*found - *wanted) / (*sigma * *sigma + *other * *other).map(f64::sqrt);
        if off.abs().max_element() > 4.0 {
            println!("  at {}: {found}, {wanted} there, {off:.1} sigma", table.points[k].position);
        }
    }
    assert_consistent(name, &found, &table.irradiance);
}

fn assert_probes(name: &str, paths: u32) {
    let Some((tracer, table)) = open(name) else { return };
    let found = tracer.probes(&table.probes, paths, 1, &Silent).expect("probes");
    assert!(!found.is_empty());
    let found: Vec<[DVec3; 2]> = found
        .iter()
        .flat_map(|probe| (0..9).map(|k| [probe.coefficients[k], probe.standard_error[k]]))
        .collect();
    let wanted: Vec<[DVec3; 2]> = table.coefficients.iter().flatten().copied().collect();
    assert_consistent(&format!("probes of {name}"), &found, &wanted);
}

#[test]
fn the_cornell_box_is_as_another_path_tracer_has_it() {
    assert_irradiance("cornell", 8192);
}

#[test]
fn two_rooms_are_as_another_path_tracer_has_them() {
    assert_irradiance("two_rooms", 8192);
}

#[test]
fn a_room_with_lamps_is_as_another_path_tracer_has_it() {
    assert_irradiance("lamps", 8192);
}

#[test]
fn a_furnace_is_as_another_path_tracer_has_it() {
    assert_irradiance("furnace05", 4096);
}

#[test]
fn light_probes_are_as_another_path_tracer_has_them() {
    for name in ["cornell", "two_rooms", "furnace05"] {
        assert_probes(name, 32_768);
    }
}
