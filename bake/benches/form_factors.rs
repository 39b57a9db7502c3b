//! The form-factor matrix of the Cornell box, 500 faces as patches: error against time of the bake's own way and of
//! its plain twin, in turn on the same machine.
//!
//! `cargo bench -p bake --bench form_factors`, `-- RUNS` for other than 3 runs each; reads
//! `reference/cornell_500_form_factors.npy` (2.1 M rays a patch, noise 0.4 % rms) and its faces from the shared folder.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow};
use bake::form_factors::precision::{Point, compare};
use glam::Vec3;

const PRODUCT_RAYS: [u32; 6] = [32, 64, 128, 256, 1024, 4096];
const PLAIN_RAYS: [u32; 6] = [64, 256, 1024, 4096, 16384, 65536];

fn main() -> Result<()> {
    let runs = std::env::args().skip(1).find_map(|argument| argument.parse().ok()).unwrap_or(3);
    let Some(shared) = shared() else {
        println!("not run: no ../shared");
        return Ok(());
    };
    let faces = faces(&shared.join("reference/scenes/cornell/patches_500.obj"))?;
    let reference = matrix(&shared.join("reference/cornell_500_form_factors.npy"))?;
    let compared = compare(&faces, &reference, &PRODUCT_RAYS, &PLAIN_RAYS, runs)?;
    println!("{} faces, {} threads, medians of {runs} runs", faces.len(), rayon::current_num_threads());
    table("this bake", &compared.product);
    table("plain rays", &compared.plain);
    println!("{:>7} {:>10} {:>22} {:>22}", "rays", "seconds", "error, equal time", "time, equal error");
    let ratios = compared.errors_at_equal_time().into_iter().zip(compared.times_at_equal_error());
    for (point, (error, time)) in compared.product.iter().zip(ratios) {
        println!("{:>7} {:>10.4} {error:>21.3}x {time:>21.5}x", point.rays, point.seconds);
    }
    Ok(())
}

fn table(name: &str, points: &[Point]) {
    println!(
        "\n{name:<12}{:>7} {:>10} {:>10} {:>10} {:>12} {:>10}",
        "rays", "seconds", "rms", "row L1", "reciprocity", "row sum"
    );
    for Point { rays, seconds, error } in points {
        let [rms, row_l1] = [error.rms, error.row_l1].map(|error| error * 100.0);
        println!(
            "{:<12}{rays:>7} {seconds:>10.4} {rms:>8.3} % {row_l1:>8.3} % {:>12.1e} {:>10.1e}",
            "", error.reciprocity, error.row_sum
        );
    }
    println!();
}

fn shared() -> Option<PathBuf> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared");
    Some(std::env::var_os("HOHLRAUM_SHARED").map_or_else(beside, PathBuf::from))
        .filter(|folder| folder.is_dir())
}

/// Triangles of an OBJ file.
fn faces(file: &Path) -> Result<Vec<[Vec3; 3]>> {
    let text = std::fs::read_to_string(file).with_context(|| file.display().to_string())?;
    let (mut corners, mut faces) = (Vec::new(), Vec::new());
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let numbers = words.map(str::parse).collect::<Result<Vec<f32>, _>>()?;
                corners.push(Vec3::from_slice(numbers.get(..3).context("three numbers")?));
            }
            Some("f") => {
                let of = |word: &str| corners.get(word.parse::<usize>().ok()?.checked_sub(1)?).copied();
                let found: Option<Vec<Vec3>> = words.map(of).collect();
                let found = found.with_context(|| format!("a face's corners: {line}"))?;
                faces.push(found.try_into().map_err(|_| anyhow!("not three corners: {line}"))?);
            }
            _ => {}
        }
    }
    Ok(faces)
}

fn matrix(file: &Path) -> Result<Vec<f32>> {
    let bytes = std::fs::read(file).with_context(|| file.display().to_string())?;
    Ok(npyz::NpyFile::new(&bytes[..])?.into_vec()?)
}
