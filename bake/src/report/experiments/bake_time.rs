//! Bake seconds against error: rays and patch lengths, every point a clean bake of this run.
//!
//! Three diagrams of the same bakes. All of the error: what a bake shows, solved exactly, against the path tracer; one
//! line a patch length, its points rays; the shipped presets are marked. Form factors alone: bakes of the longest
//! patches, for which many rays take least time, against the matrix reference on the same patches. Patches alone: patch
//! lengths at the most rays.

use engine::scene::file::Quality;

use super::bakes::{BESIDE, Bakes, Made, OfLength, Recipe, metres};
use super::lit::weights;
use super::matrix::Exactly;
use super::truth::Truth;
use crate::report::Budget;
use crate::report::model::{Axis, Diagram, Error, Floor, Norm, Point, Series};
use crate::{BakeError, Opened, Settings, Watcher, layout, settings};

/// A quality as it is shipped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Preset {
    pub quality: Quality,
    pub recipe: Recipe,
}

/// Rays of the lines, and what the longest patches have besides; patch lengths are the presets' and those between.
const RAYS: [u32; 4] = [64, 256, 1024, 4096];
const RAYS_OF_LONGEST: u32 = 8192;
/// Lengths that are closer have none between.
const APART: f64 = 1.9;
/// Patch lengths of which there are no fewer.
const LENGTHS: usize = 4;
/// With which every patch length is baked before anything is refined.
const FEW_RAYS: u32 = 256;
/// At most so much of what is left goes into one bake that refines.
const LARGE: f64 = 0.8;
/// Runs of a preset's bake, where there is time.
const RUNS: usize = 3;

/// What the three qualities mean for this scene.
pub fn presets(opened: &Opened) -> Result<Vec<Preset>, BakeError> {
    let area = layout::area(&opened.surface);
    let of = |quality: Quality| {
        let asked = Settings { quality: Some(quality), ..Settings::default() };
        let (with, _) = settings::settle(&opened.settings, &opened.name, &asked, area)?;
        Ok(Preset { quality, recipe: Recipe { length: with.length, rays: with.rays } })
    };
    [Quality::Draft, Quality::Standard, Quality::Fine].into_iter().map(of).collect()
}

/// The longest patches of all presets: what they show against the matrix reference is the diagram of form factors.
pub fn longest(presets: &[Preset]) -> f64 {
    presets.iter().map(|preset| preset.recipe.length).fold(0.0, f64::max)
}

/// Bakes what the budget allows, first what every diagram needs: the presets, the longest patches with all rays, all
/// lengths with few; then, the cheap ones first, what refines the lines, and the presets again for a median of three.
pub fn bake_all(
    bakes: &mut Bakes,
    presets: &[Preset],
    shipped: Recipe,
    most_rays: u32,
    budget: &Budget,
    watcher: &dyn Watcher,
) -> Result<(), BakeError> {
    let Wanted { mut least, mut more } = wanted(presets, shipped);
    [&mut least, &mut more].into_iter().for_each(|recipes| recipes.retain(|recipe| recipe.rays <= most_rays));
    watcher.stage("bakes", (least.len() + more.len()) as u64);
    let mut left_out = Vec::new();
    let turns =
        least.into_iter().map(|recipe| (recipe, 1.0)).chain(more.into_iter().map(|recipe| (recipe, LARGE)));
    for (recipe, share) in turns {
        let known = bakes.of(recipe).is_some();
        if !bakes.make(recipe, &budget.part(share), watcher)? && !known {
            left_out.push(format!("{recipe} ({:.0} s)", bakes.expected(recipe)));
        }
        watcher.advance(1, 0);
    }
    if !left_out.is_empty() {
        left_out.dedup();
        bakes.notes.push(format!("bakes that the budget had no time for: {}", left_out.join(", ")));
    }
    Ok(())
}

/// In the order of their turns.
struct Wanted {
    least: Vec<Recipe>,
    /// Once for each time.
    more: Vec<Recipe>,
}

/// The cheapest of the lines to begin with, for nothing is known of time before.
fn wanted(presets: &[Preset], shipped: Recipe) -> Wanted {
    let longest = longest(presets);
    let mut lengths: Vec<f64> = presets.iter().map(|preset| preset.recipe.length).collect();
    lengths.sort_by(|a, b| b.total_cmp(a));
    lengths.dedup();
    let between = |pair: &[f64]| (pair[0] > APART * pair[1]).then(|| (pair[0] * pair[1]).sqrt());
    let between: Vec<f64> = lengths.windows(2).filter_map(between).collect();
    lengths.extend(between);
    if !lengths.contains(&shipped.length) {
        lengths.push(shipped.length);
    }
    // What patches bring is seen beyond the finest preset too.
    let shortest = lengths.iter().copied().fold(f64::INFINITY, f64::min);
    let (few, ratio) =
        (lengths.len() < LENGTHS, (longest / shortest).powf(1.0 / (lengths.len() - 1).max(1) as f64));
    let beyond = (few && ratio > 1.0).then_some(Recipe { length: shortest / ratio, rays: FEW_RAYS });
    let mut lines: Vec<Recipe> = lengths
        .iter()
        .flat_map(|&length| RAYS.into_iter().map(move |rays| Recipe { length, rays }))
        .chain([Recipe { length: longest, rays: RAYS_OF_LONGEST }])
        .chain(beyond)
        .collect();
    lines.sort_by(|a, b| a.work(BESIDE).total_cmp(&b.work(BESIDE)));
    let first = lines.first().copied();
    let mut presets: Vec<Recipe> = presets.iter().map(|preset| preset.recipe).collect();
    presets.dedup();
    let is_least = |recipe: &Recipe| recipe.length == longest || recipe.rays == FEW_RAYS;
    let (of_all, finer): (Vec<Recipe>, Vec<Recipe>) = lines.into_iter().partition(is_least);
    let mut least: Vec<Recipe> = Vec::new();
    for recipe in first.into_iter().chain(presets.iter().copied()).chain([shipped]).chain(of_all) {
        if !least.contains(&recipe) {
            least.push(recipe);
        }
    }
    let finer = finer.into_iter().filter(|recipe| !least.contains(recipe));
    let again = presets.into_iter().flat_map(|preset| [preset; RUNS - 1]);
    let mut more: Vec<Recipe> = finer.chain(again).collect();
    more.sort_by(|a, b| a.work(BESIDE).total_cmp(&b.work(BESIDE)));
    Wanted { least, more }
}

/// What the bakes say: all of it, form factors, patches. `exactly`: the matrix references of patch lengths.
pub fn diagrams(
    bakes: &Bakes,
    presets: &[Preset],
    exactly: &[(f64, &Exactly)],
    truth: &Truth,
) -> Vec<Diagram> {
    let mut diagrams = vec![total(bakes, presets, exactly, truth), patches(bakes, presets, truth)];
    if let Some(OfLength { length, exactly, .. }) = bakes.reference {
        diagrams.push(form_factors(bakes, presets, length, exactly));
        diagrams.push(matrices(bakes, presets, length, exactly));
    }
    diagrams.iter_mut().for_each(|diagram| diagram.series.retain(|series| !series.points.is_empty()));
    diagrams
}

/// All of the error, against the path tracer.
fn total(bakes: &Bakes, presets: &[Preset], exactly: &[(f64, &Exactly)], truth: &Truth) -> Diagram {
    let mut lengths: Vec<f64> = bakes.made.iter().map(|made| made.recipe.length).collect();
    lengths.sort_by(|a, b| b.total_cmp(a));
    lengths.dedup();
    let line = |&length: &f64| {
        let of_length =
            sorted(bakes, |made| made.recipe.length == length, |made| f64::from(made.recipe.rays));
        let patches = of_length.first().map_or(0, |made| made.patches);
        let exactly = exactly.iter().find(|(of, _)| *of == length).map(|(_, exactly)| *exactly);
        let floor = floor_of_patches(&of_length, exactly, truth);
        let shown = |made: &Made| point(made, presets, &made.shown, &truth.field);
        let points = of_length.into_iter().map(shown).collect();
        Series { floor, ..Series::new(format!("{patches} patches of {}", metres(length)), points) }
    };
    Diagram {
        id: "bake".to_owned(),
        title: "Bake time and all of the error".to_owned(),
        about: "What does a longer bake bring? Each point is a clean bake of this run, solved exactly, against the path \
                tracer at the evaluation points, without what comes straight from punctual lights; along a line the \
                rays of a row grow."
            .to_owned(),
        x: seconds(),
        y: irradiance(),
        norm: Norm::Rms,
        series: lengths.iter().map(line).collect(),
        floors: truth.floors(),
    }
}

/// What patches of one length are off by with any number of rays, and no less than the reference: by the matrix
/// reference, or else what the errors of these bakes tend to.
fn floor_of_patches(made: &[&Made], exactly: Option<&Exactly>, truth: &Truth) -> Option<Floor> {
    let (name, y) = match exactly {
        Some(exactly) => {
            let y = error(&exactly.at_receivers, &truth.field).rms;
            ("patches of this length, by the matrix reference", y)
        }
        None => {
            let points =
                made.iter().map(|made| [f64::from(made.recipe.rays), error(&made.shown, &truth.field).rms]);
            ("what more rays tend to, fitted", tends_to(&points.collect::<Vec<_>>())?)
        }
    };
    Some(Floor { name: name.to_owned(), y: y.max(truth.standard_error) })
}

/// e^2 ~ f^2 + c / R: noise of R rays on top of what they do not change. Least squares of the relative misfit over points
/// [R, e]; returns f, None of fewer than two points.
fn tends_to(points: &[[f64; 2]]) -> Option<f64> {
    let known: Vec<[f64; 2]> = points
        .iter()
        .filter(|[_, e]| *e > 0.0)
        .map(|[rays, e]| [1.0 / (e * e), 1.0 / (rays * e * e)])
        .collect();
    let sum = |of: &dyn Fn(&[f64; 2]) -> f64| known.iter().map(of).sum::<f64>();
    let (aa, ab, bb) = (sum(&|x| x[0] * x[0]), sum(&|x| x[0] * x[1]), sum(&|x| x[1] * x[1]));
    let (a, b) = (sum(&|x| x[0]), sum(&|x| x[1]));
    let determinant = aa * bb - ab * ab;
    let is_determined = known.len() > 1 && determinant > 1e-12 * aa * bb;
    is_determined.then(|| ((a * bb - b * ab) / determinant).max(0.0).sqrt())
}

/// Bakes of one length against the same patches with many more rays.
fn form_factors(bakes: &Bakes, presets: &[Preset], length: f64, exactly: &Exactly) -> Diagram {
    let of_length = sorted(bakes, |made| made.recipe.length == length, |made| f64::from(made.recipe.rays));
    let points = of_length.into_iter().filter_map(|made| {
        let shown = &made.beside_matrix.as_ref()?.shown;
        Some(point(made, presets, shown, &exactly.at_receivers))
    });
    Diagram {
        id: "bake_rays".to_owned(),
        title: "Bake time and the error of form factors".to_owned(),
        about: format!(
            "What do more rays bring? Clean bakes with patches of {}, against the matrix reference on the same patches \
             with {} rays a row, all of them others; both under the same direct light, solved exactly and seen at the same receivers. Where the cavity gain is large, most of it \
             is one number, how bright the room is as a whole, and a single bake may be lucky.",
            metres(length),
            exactly.rays
        ),
        x: seconds(),
        y: irradiance(),
        norm: Norm::Rms,
        series: vec![Series::new("rays of a row", points.collect())],
        floors: vec![Floor { name: "error of the matrix reference".to_owned(), y: exactly.standard_error }],
    }
}

/// The same of the matrices themselves.
fn matrices(bakes: &Bakes, presets: &[Preset], length: f64, exactly: &Exactly) -> Diagram {
    let of_length = sorted(bakes, |made| made.recipe.length == length, |made| f64::from(made.recipe.rays));
    let points = of_length.into_iter().filter_map(|made| {
        let error = made.beside_matrix.as_ref()?.factors;
        // Of all form factors.
        Some(Point { error, spread: 0.0, ..point(made, presets, &made.shown, &exactly.at_receivers) })
    });
    Diagram {
        id: "bake_matrix".to_owned(),
        title: "Bake time and the error of the matrix".to_owned(),
        about: format!(
            "The form factors of patches of {} one by one, before light averages over them: norm of the difference from the \
             matrix reference over its norm (Frobenius).",
            metres(length)
        ),
        x: seconds(),
        y: Axis { label: "error of the matrix, relative".to_owned(), unit: String::new() },
        norm: Norm::Rms,
        series: vec![Series::new("rays of a row", points.collect())],
        floors: vec![Floor {
            name: "error of the matrix reference".to_owned(),
            y: exactly.floor_of_factors(),
        }],
    }
}

/// Patch lengths at the most rays that four lengths, or else as many as there are, were baked with.
fn patches(bakes: &Bakes, presets: &[Preset], truth: &Truth) -> Diagram {
    let with = |rays: u32| sorted(bakes, |made| made.recipe.rays == rays, |made| -made.recipe.length);
    let most = |lengths: usize| RAYS.into_iter().rev().find(|&rays| with(rays).len() >= lengths);
    let rays = most(4).or(most(3)).or(most(2)).unwrap_or(RAYS[0]);
    let points = with(rays).into_iter().map(|made| Point {
        setting: format!("{} patches", made.patches),
        ..point(made, presets, &made.shown, &truth.field)
    });
    let mut floors = truth.floors();
    let made = |length: f64| bakes.of(Recipe { length, rays })?.beside_matrix.as_ref();
    if let Some((made, reference)) = bakes.reference.and_then(|of| Some((made(of.length)?, of.exactly))) {
        let y = error(&made.shown, &reference.at_receivers).rms;
        floors.push(Floor { name: format!("form factors from {rays} rays"), y });
    }
    Diagram {
        id: "bake_patches".to_owned(),
        title: "Bake time and the error of patches".to_owned(),
        about: format!(
            "What do smaller patches bring? Clean bakes with {rays} rays a row against the path tracer, from long patches \
             to short ones. Receivers lie twice as close as patches."
        ),
        x: seconds(),
        y: irradiance(),
        norm: Norm::Rms,
        series: vec![Series::new(format!("patch length at {rays} rays"), points.collect())],
        floors,
    }
}

fn sorted<'a>(bakes: &'a Bakes, which: impl Fn(&Made) -> bool, by: impl Fn(&Made) -> f64) -> Vec<&'a Made> {
    let mut made: Vec<&Made> = bakes.made.iter().filter(|made| which(made)).collect();
    made.sort_by(|a, b| by(a).total_cmp(&by(b)));
    made
}

fn error(found: &[f64], reference: &[f64]) -> Error {
    Error::of(found, reference, &weights(reference))
}

fn point(made: &Made, presets: &[Preset], shown: &[f64], reference: &[f64]) -> Point {
    let preset = presets.iter().find(|preset| preset.recipe == made.recipe);
    let error = error(shown, reference);
    Point {
        setting: format!("{} rays", made.recipe.rays),
        error,
        spread: error.rms * spread(shown, reference),
        preset: preset.map(|preset| preset.quality.to_string()),
        ..timed(&made.seconds)
    }
}

/// Standard error of the rms over the rms, as squares scatter over n places, s^2 being one place's (all its channels):
/// sd(s^2) / (2 sqrt(n) mean s^2), to first order. Where one place has all of it, this is 1/2.
fn spread(shown: &[f64], reference: &[f64]) -> f64 {
    let n = reference.len() / 3;
    let of_place = |k: usize| (0..3).map(|c| (shown[c * n + k] - reference[c * n + k]).powi(2)).sum::<f64>();
    let squares: Vec<f64> = (0..n).map(of_place).collect();
    let mean = squares.iter().sum::<f64>() / n.max(1) as f64;
    let variance = squares.iter().map(|square| (square - mean).powi(2)).sum::<f64>() / n.max(1) as f64;
    if mean > 0.0 { 0.5 * (variance / n as f64).sqrt() / mean } else { 0.0 }
}

/// A point at the median of what was measured.
pub fn timed(x: &[f64]) -> Point {
    let mut sorted = x.to_vec();
    sorted.sort_by(f64::total_cmp);
    let (Some(&least), Some(&most)) = (sorted.first(), sorted.last()) else { return Point::default() };
    let middle = sorted.len() / 2;
    let median = if sorted.len().is_multiple_of(2) {
        0.5 * (sorted[middle - 1] + sorted[middle])
    } else {
        sorted[middle]
    };
    Point { x: median, x_range: [least, most], runs: sorted.len(), ..Point::default() }
}

fn seconds() -> Axis {
    Axis { label: "bake".to_owned(), unit: "s".to_owned() }
}

pub fn irradiance() -> Axis {
    Axis { label: "error of irradiance, rms over mean".to_owned(), unit: String::new() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_more_rays_tend_to_is_found_below_the_noise() {
        let e = |rays: f64| (0.01_f64.powi(2) + 0.04 / rays).sqrt();
        let points = |rays: &[f64]| rays.iter().map(|&rays| [rays, e(rays)]).collect::<Vec<_>>();
        for rays in [&[64.0, 256.0][..], &[64.0, 256.0, 1024.0], &[16.0, 4096.0, 64.0]] {
            assert!((tends_to(&points(rays)).unwrap() - 0.01).abs() < 1e-9, "{rays:?}");
        }
        assert_eq!(tends_to(&points(&[64.0])), None);
        // Errors that fall faster than noise does tend to nothing.
        assert_eq!(tends_to(&[[64.0, 1.0], [256.0, 0.3]]), Some(0.0));
    }

    #[test]
    fn an_rms_is_as_sure_as_its_squares_are_many() {
        let channels = |of: &dyn Fn(usize) -> f64, n: usize| -> Vec<f64> {
            (0..3).flat_map(|_| (0..n).map(of).collect::<Vec<_>>()).collect()
        };
        let zero = vec![0.0; 3 * 400];
        assert_eq!(spread(&zero, &zero), 0.0);
        assert!(spread(&channels(&|_| 0.1, 400), &zero) < 1e-12);
        let one = spread(&channels(&|k| if k == 7 { 1.0 } else { 0.0 }, 400), &zero);
        assert!((one - 0.5).abs() < 0.01, "{one}");
        // Squares that are 0 or 2 as often: sd = mean.
        let coin = spread(&channels(&|k| if k % 2 == 0 { 2.0_f64.sqrt() } else { 0.0 }, 400), &zero);
        assert!((coin - 0.5 / 20.0).abs() < 1e-9, "{coin}");
    }

    #[test]
    fn what_every_diagram_needs_is_baked_before_what_refines_it() {
        let preset = |quality, length, rays| Preset { quality, recipe: Recipe { length, rays } };
        let presets = [preset(Quality::Draft, 1.0, 512), preset(Quality::Standard, 0.5, 1024)];
        let Wanted { least, more } = wanted(&presets, presets[1].recipe);
        assert_eq!(least[0], Recipe { length: 1.0, rays: 64 });
        assert_eq!(least[1..3], presets.map(|preset| preset.recipe));
        assert!(
            [64, 256, 1024, 4096, 8192]
                .map(|rays| Recipe { length: 1.0, rays })
                .iter()
                .all(|of| least.contains(of))
        );
        let again = |recipe: Recipe| more.iter().filter(|of| **of == recipe).count();
        assert!(presets.iter().all(|preset| again(preset.recipe) == RUNS - 1));
        let finer = more.iter().filter(|recipe| presets.iter().all(|preset| preset.recipe != **recipe));
        assert!(finer.clone().all(|recipe| !least.contains(recipe)) && finer.count() > 0);
    }
}
