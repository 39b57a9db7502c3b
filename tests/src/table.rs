//! Tables of the independent path tracer (`reference/` of the shared folder): irradiance at points, and coefficients
//! of light probes, each with its standard error.

use std::path::Path;

use bake::Point;
use glam::DVec3;

#[derive(Default)]
pub struct Table {
    pub points: Vec<Point>,
    /// [W/m2], and one sigma.
    pub irradiance: Vec<[DVec3; 2]>,
    pub probes: Vec<DVec3>,
    /// Nine a probe [W/m2/sr], and one sigma.
    pub coefficients: Vec<[[DVec3; 2]; 9]>,
}

const NAMES: [&str; 9] = ["L00", "L1-1", "L10", "L11", "L2-2", "L2-1", "L20", "L21", "L22"];

/// `NAME.csv`, and `NAME_probes.csv` where there is one.
pub fn read(folder: &Path, name: &str) -> Table {
    let mut table = Table::default();
    let mut reader = csv::Reader::from_path(folder.join(format!("{name}.csv"))).expect("a reference table");
    let headers = reader.headers().expect("headers").clone();
    for row in reader.records().flatten() {
        let vector = |names: [&str; 3]| {
            let at = |name: &str| headers.iter().position(|header| header == name).expect("a column");
            DVec3::from_array(names.map(|name| row[at(name)].parse().expect("a number")))
        };
        table.points.push(Point { position: vector(["x", "y", "z"]), normal: vector(["nx", "ny", "nz"]) });
        table.irradiance.push([vector(["Er", "Eg", "Eb"]), vector(["se_r", "se_g", "se_b"])]);
    }
    if let Ok(mut reader) = csv::Reader::from_path(folder.join(format!("{name}_probes.csv"))) {
        reader.records().flatten().for_each(|row| add_probe(&mut table, &row));
    }
    table
}

/// A row of one coefficient; rows of irradiance on axes are left out.
fn add_probe(table: &mut Table, row: &csv::StringRecord) {
    let vector = |first: usize| -> DVec3 {
        DVec3::from_array([0, 1, 2].map(|k| row[first + k].parse().expect("a number")))
    };
    let position = vector(0);
    if table.probes.last() != Some(&position) {
        table.probes.push(position);
        table.coefficients.push([[DVec3::ZERO; 2]; 9]);
    }
    if let (Some(k), Some(last)) =
        (NAMES.iter().position(|name| *name == &row[3]), table.coefficients.last_mut())
    {
        last[k] = [vector(4), vector(7)];
    }
}
