//! The references: the path tracer against closed forms, against another path tracer, and against itself.

use bake::reference::{Measured, PathTracer, Surfaces};
use bake::{Point, Silent};
use glam::DVec3;
use tests::project::TestProject;
use tests::shared;
use tests::table;

/// Mean chi-square a point and channel of differences whose sigmas are given, and the bias in sigmas of it.
fn consistency(pairs: &[[DVec3; 4]]) -> (f64, f64) {
    let (mut chi, mut sum, mut variance, mut count) = (0.0, 0.0, 0.0, 0.0);
    for [found, sigma, wanted, other] in pairs {
        let squared = *sigma * *sigma + *other * *other;
        for channel in 0..3 {
            let difference = found[channel] - wanted[channel];
            chi += difference * difference / squared[channel];
            sum += difference;
            variance += squared[channel];
            count += 1.0;
        }
    }
    (chi / count, sum / variance.sqrt())
}

fn compare(name: &str, paths: u32) {
    let Some(shared) = shared() else { return };
    let folder = shared.join("reference");
    let table = table::read(&folder, name);
    let project = TestProject::from_file(&folder.join(format!("scenes/{name}/{name}.gltf")));
    let tracer = PathTracer::open(project.path(), None, Surfaces::Diffuse).expect("a scene");
    let started = std::time::Instant::now();
    let found = tracer.irradiance(&table.points, paths, 1, &Silent).expect("irradiance");
    let seconds = started.elapsed().as_secs_f64();
    let pairs: Vec<[DVec3; 4]> = found
        .iter()
        .zip(&table.irradiance)
        .map(|(found, [wanted, sigma])| [found.total(), found.standard_error, *wanted, *sigma])
        .collect();
    let mean =
        table.irradiance.iter().map(|[e, _]| e.element_sum()).sum::<f64>() / (3.0 * pairs.len() as f64);
    let rms = |of: &dyn Fn(&[DVec3; 4]) -> DVec3| {
        let squares = pairs.iter().map(|pair| of(pair).length_squared()).sum::<f64>();
        (squares / (3.0 * pairs.len() as f64)).sqrt() / mean * 100.0
    };
    let (chi, bias) = consistency(&pairs);
    println!(
        "{name}: rms {:.3} %, own {:.3} %, its {:.3} %; chi-square {chi:.2}, bias {bias:+.2} sigma, {seconds:.1} s",
        rms(&|pair| pair[0] - pair[2]),
        rms(&|pair| pair[1]),
        rms(&|pair| pair[3]),
    );
    for (k, [found, own, wanted, its]) in pairs.iter().enumerate() {
        let sigma = (*own * *own + *its * *its).map(f64::sqrt);
        let off = ((*found - *wanted) / sigma).abs().max_element();
        if off > 4.0 {
            println!(
                "  {k}: {} {}: {found} not {wanted}, {off:.1} sigma",
                table.points[k].position, table.points[k].normal
            );
        }
    }
}

#[test]
fn try_all() {
    for (name, paths) in [("furnace05", 4096), ("cornell", 16384), ("two_rooms", 16384), ("lamps", 8192)] {
        compare(name, paths);
    }
}
