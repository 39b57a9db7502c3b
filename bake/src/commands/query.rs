//! `hohlraum-bake query PROJECT --points|--probes IN.csv --out OUT.csv`

use std::path::Path;
use std::process::ExitCode;

use anyhow::{Context, Error, Result, bail};
use bake::{BakeError, Irradiance, Point};
use engine::scene::file::write_atomically;
use glam::{DVec3, Vec3};
use serde_json::json;

use super::columns::{self, Row};
use crate::args::QueryArgs;
use crate::print;

pub fn run(args: &QueryArgs) -> Result<ExitCode> {
    let (answers, rows) = match (&args.points, &args.probes) {
        (Some(points), _) => points_answered(args, points)?,
        (None, Some(probes)) => probes_answered(args, probes)?,
        (None, None) => bail!("neither --points nor --probes"), // the arguments' group rules it out
    };
    write_atomically(&args.out, &answers)?;
    if args.json {
        print::json(&json!({ "rows": rows, "out": args.out }));
    } else {
        print::text(&format!("{}: {rows} rows\n", args.out.display()));
    }
    Ok(ExitCode::SUCCESS)
}

fn points_answered(args: &QueryArgs, file: &Path) -> Result<(Vec<u8>, usize)> {
    let rows = columns::read(file, ["x", "y", "z", "nx", "ny", "nz"])?;
    let points = rows.iter().map(|row| point(file, row));
    let points = points.collect::<Result<Vec<_>>>()?;
    let (scene, settings) = (&args.scene, args.settings());
    let method = args.method.unwrap_or_default();
    let answers = bake::query_points(&scene.project, scene.name(), &settings, &points, method)
        .map_err(|error| about(file, error))?;

    let header = "x,y,z,nx,ny,nz,direct_r,direct_g,direct_b,indirect_r,indirect_g,indirect_b,Er,Eg,Eb";
    let rows =
        rows.iter().zip(&answers).map(|(row, answer)| [&row.numbers[..], &irradiance(answer)].concat());
    Ok((written(&header.split(',').map(str::to_owned).collect::<Vec<_>>(), rows)?, answers.len()))
}

fn probes_answered(args: &QueryArgs, file: &Path) -> Result<(Vec<u8>, usize)> {
    let rows = columns::read(file, ["x", "y", "z"])?;
    let points: Vec<_> = rows.iter().map(|row| DVec3::from_array(row.numbers)).collect();
    let (scene, settings) = (&args.scene, args.settings());
    let answers = bake::query_probes(&scene.project, scene.name(), &settings, &points)
        .map_err(|error| about(file, error))?;
    let rows = rows.iter().zip(&answers).map(|(row, l)| [&row.numbers[..], &coefficients(l)].concat());
    Ok((written(&probe_header(), rows)?, answers.len()))
}

/// Normals of any length above 0 are taken.
fn point(file: &Path, row: &Row<6>) -> Result<Point> {
    let [x, y, z, nx, ny, nz] = row.numbers;
    let no_direction = || format!("{}: line {}: nx,ny,nz is no direction", file.display(), row.line);
    let normal = DVec3::new(nx, ny, nz).try_normalize().with_context(no_direction)?;
    Ok(Point { position: DVec3::new(x, y, z), normal })
}

fn irradiance(light: &Irradiance) -> [f64; 9] {
    let mut columns = [0.0; 9];
    for (place, part) in
        columns.chunks_mut(3).zip([light.direct, light.indirect, light.direct + light.indirect])
    {
        place.copy_from_slice(&part.to_array());
    }
    columns
}

fn coefficients(l: &[Vec3; 9]) -> Vec<f64> {
    l.iter().flat_map(|l| l.to_array()).map(shortest).collect()
}

/// The f64 that is written with the digits of the f32 and no more.
fn shortest(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::from(value))
}

/// x,y,z,L00_r,L00_g,L00_b,L1-1_r .. L22_b
fn probe_header() -> Vec<String> {
    let bands = (0..=2).flat_map(|l: i32| (-l..=l).map(move |m| format!("L{l}{m}")));
    let colors = bands.flat_map(|lm| ["r", "g", "b"].map(|c| format!("{lm}_{c}")));
    ["x", "y", "z"].map(str::to_owned).into_iter().chain(colors).collect()
}

fn written(header: &[String], rows: impl Iterator<Item = Vec<f64>>) -> Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(header)?;
    for row in rows {
        writer.write_record(row.iter().map(f64::to_string))?;
    }
    Ok(writer.into_inner().map_err(|error| error.into_error())?)
}

/// What the library says of a row is said of the file's rows, counted from 1 below the header.
fn about(file: &Path, error: BakeError) -> Error {
    match error {
        BakeError::Other(message) => anyhow::anyhow!("{}: {message}", file.display()),
        error => error.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coefficients_are_named_by_band_and_order() {
        let header = probe_header();
        assert_eq!(header.len(), 3 + 27);
        assert_eq!(header[3..7], ["L00_r", "L00_g", "L00_b", "L1-1_r"]);
        assert_eq!(header[29], "L22_b");
    }

    #[test]
    fn numbers_keep_all_their_digits() {
        let bytes =
            written(&["a".to_owned(), "b".to_owned()], [vec![0.1 + 0.2, shortest(0.1)]].into_iter()).unwrap();
        assert_eq!(String::from_utf8(bytes).unwrap(), "a,b\n0.30000000000000004,0.1\n");
    }
}
