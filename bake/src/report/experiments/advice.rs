//! What to change for half the error or half the time: read off the points that were measured, never beyond them.

use super::bake_time::{Preset, timed};
use super::bakes::{Bakes, Made, Recipe};
use super::lit::weights;
use super::truth::Truth;
use crate::report::model::{Advice, Diagram, Error, Point};

/// What has more than this many times the error saves nothing.
const NO_SAVING: f64 = 4.0;

/// A bake that was measured: how it is asked for, seconds, error.
struct Measured {
    change: String,
    seconds: f64,
    error: f64,
}

/// Against the shipped bake.
pub fn of_bakes(bakes: &Bakes, presets: &[Preset], shipped: Recipe, truth: &Truth) -> Vec<Advice> {
    let Some(now) = bakes.of(shipped).map(|made| measured(made, presets, truth)) else { return Vec::new() };
    let others: Vec<Measured> = bakes
        .made
        .iter()
        .filter(|made| made.recipe != shipped)
        .map(|made| measured(made, presets, truth))
        .collect();
    let cheapest = others
        .iter()
        .filter(|one| one.error <= 0.5 * now.error)
        .min_by(|a, b| a.seconds.total_cmp(&b.seconds));
    let nearest =
        others.iter().filter(|one| one.error < now.error).min_by(|a, b| a.error.total_cmp(&b.error));
    let quick = others
        .iter()
        .filter(|one| one.seconds <= 0.5 * now.seconds && one.error <= NO_SAVING * now.error)
        .min_by(|a, b| a.error.total_cmp(&b.error));
    let free = others
        .iter()
        .filter(|one| one.seconds <= now.seconds && one.error < now.error)
        .min_by(|a, b| a.error.total_cmp(&b.error));
    let goals = [
        ("half the error", cheapest),
        ("less error, half of it was not reached", nearest.filter(|_| cheapest.is_none())),
        ("half the bake time", quick),
        ("less error in no more time", free),
    ];
    let advice = |(goal, one): (&str, Option<&Measured>)| {
        let one = one?;
        let (cost, error) = (one.seconds / now.seconds, one.error / now.error);
        Some(Advice { goal: goal.to_owned(), change: one.change.clone(), cost, error })
    };
    goals.into_iter().filter_map(advice).collect()
}

fn measured(made: &Made, presets: &[Preset], truth: &Truth) -> Measured {
    let preset = presets.iter().find(|preset| preset.recipe == made.recipe);
    let change = match preset {
        Some(preset) => format!("--quality {}", preset.quality),
        None => format!("--patch-length {:.4} --rays {}", made.recipe.length, made.recipe.rays),
    };
    let error = Error::of(&made.shown, &truth.field, &weights(&truth.field)).rms;
    Measured { change, seconds: timed(&made.seconds).x, error }
}

/// Products a frame, against the runtime's own point of a diagram: what half the time or half the error would take.
pub fn of_frames(diagram: &Diagram) -> Vec<Advice> {
    let with_preset =
        diagram.series.iter().find(|series| series.points.iter().any(|point| point.preset.is_some()));
    let Some(series) = with_preset else { return Vec::new() };
    let Some(now) = series.points.iter().find(|point| point.preset.is_some()) else { return Vec::new() };
    let (time, error) = (|point: &Point| point.x / now.x, |point: &Point| point.error.max / now.error.max);
    if !(now.x > 0.0 && now.error.max > 0.0) {
        return Vec::new();
    }
    let better = series.points.iter().filter(|point| error(point) <= 0.5).min_by(|a, b| a.x.total_cmp(&b.x));
    let quicker = series
        .points
        .iter()
        .filter(|point| time(point) <= 0.5 && error(point) <= NO_SAVING)
        .min_by(|a, b| a.error.max.total_cmp(&b.error.max));
    let goals = [("half the error of a frame", better), ("half the time of a frame", quicker)];
    let advice = |(goal, point): (&str, Option<&Point>)| {
        let point = point?;
        let change = format!("{}: {}", series.name, point.setting);
        Some(Advice { goal: goal.to_owned(), change, cost: time(point), error: error(point) })
    };
    goals.into_iter().filter_map(advice).collect()
}
