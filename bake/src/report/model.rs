//! What a report holds: plain data, from which tables, plots and the page are made.

use engine::transport::Certificate;
use glam::DVec3;
use serde::Serialize;

/// Everything that one run found.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Report {
    pub project: String,
    pub scene: String,
    /// Of the bake that was there or was made first: what the project ships.
    pub quality: String,
    pub machine: Machine,
    /// What was seeded, and with what: the same report again measures the same errors.
    pub seeds: Vec<(String, u64)>,
    pub certificate: Certificate,
    /// As the player draws it, PNG; none where there is no player or nothing to draw with.
    #[serde(skip)]
    pub picture: Option<Vec<u8>>,
    /// Of the player; none where there is none or nothing to draw with.
    pub frame: Option<FrameTime>,
    pub diagrams: Vec<Diagram>,
    pub split: Split,
    pub advice: Vec<Advice>,
    /// What was not measured, and why; what the reader should know.
    pub notes: Vec<String>,
    /// Of the whole report, and what it was allowed.
    pub seconds: f64,
    pub budget: f64,
}

/// What measured.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Machine {
    pub processor: String,
    pub threads: usize,
    /// Bytes.
    pub memory: u64,
    pub system: String,
    /// What the player drew with, and whether its passes were timed by the GPU or by the CPU.
    pub adapter: Option<String>,
    pub timing: Option<String>,
}

/// What a picture of the moving scene takes, 960 x 540 pixels.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FrameTime {
    pub passes: Vec<PassTime>,
    /// From picture to picture by the clock, waiting for the GPU.
    pub whole: Option<PassTime>,
    /// The error of B is at most this share of the largest B, once the scene has been still for a while.
    pub bound: Option<f64>,
}

/// Milliseconds a frame.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PassTime {
    pub name: String,
    pub median: f64,
    pub p99: f64,
}

/// One work-precision diagram.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Diagram {
    /// The stem of its files.
    pub id: String,
    pub title: String,
    /// What it answers, and how it was measured, in a sentence or two.
    pub about: String,
    pub x: Axis,
    pub y: Axis,
    /// Which of an error's numbers is drawn along y.
    pub norm: Norm,
    pub series: Vec<Series>,
    /// Errors that no setting of these goes below, or below which none counts; drawn as horizontal lines. The highest
    /// is the diagram's floor.
    pub floors: Vec<Floor>,
}

#[derive(Clone, Debug, Default, Serialize)]
pub struct Axis {
    pub label: String,
    pub unit: String,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Norm {
    #[default]
    Rms,
    P99,
    Max,
}

/// One method, its points in the order of its setting.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Series {
    pub name: String,
    pub points: Vec<Point>,
    /// Its own, above the diagram's.
    pub floor: Option<Floor>,
    /// Why it goes no further, where that is neither its floor nor the budget.
    pub ends: Option<String>,
}

#[derive(Clone, Debug, Default, Serialize)]
pub struct Point {
    /// "1024 rays", "4 products".
    pub setting: String,
    /// Median of `runs` measurements, the least and the largest of them.
    pub x: f64,
    pub x_range: [f64; 2],
    pub runs: usize,
    pub error: Error,
    /// Standard error of the rms, which stands on few places where errors are large; 0 where it is of all that there is.
    pub spread: f64,
    /// The shipped preset that this is: "draft", "standard", "fine", "runtime".
    pub preset: Option<String>,
}

/// How far a field is from its reference, over all channels. `rms`, `bias`, `p99` and `max` are shares: rms and the
/// signed mean over the reference's mean; 99th percentile and largest of |e| / (reference + 1 % of its mean).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Error {
    pub rms: f64,
    /// Signed: above 0 where energy appears.
    pub bias: f64,
    pub p99: f64,
    pub max: f64,
}

#[derive(Clone, Debug, Default, Serialize)]
pub struct Floor {
    pub name: String,
    pub y: f64,
}

/// Where the error comes from. Each part is a field, what one switch changes; the fields add up.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Split {
    pub about: String,
    pub parts: Vec<Part>,
    /// What the player shows against the reference, measured by itself.
    pub total: Error,
    /// The places that have most of its squares, the worst first.
    pub worst: Vec<WorstPlace>,
    /// rms of (sum of the parts' fields - the total's field) over the rms of the total's field.
    pub unexplained: f64,
    pub seeds: Seeds,
    /// Standard error of the reference, rms over its mean: differences below it say nothing.
    pub reference_error: f64,
}

/// The parts against one path-traced field, the total against another that shares no random number with it: what the
/// fields differ by is noise of both, and their replicates say how much of it there must be. All over the total's rms.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Seeds {
    /// rms of what the parts then miss the total by.
    pub missed: f64,
    /// rms of the noise, by the standard errors of both fields.
    pub noise: f64,
    /// One sigma of noise^2, relative: how far from it the square of what is missed may lie by chance.
    pub spread: f64,
}

/// The parts add up to the total where they miss it by no more of its rms.
pub const ADDS_UP: f64 = 0.05;

impl Split {
    /// Against one reference, and against two but for their noise.
    pub fn adds_up(&self) -> bool {
        self.unexplained <= ADDS_UP && self.seeds.is_noise()
    }
}

impl Seeds {
    /// Noise, at three sigma, and [`ADDS_UP`] explain what is missed.
    pub fn is_noise(&self) -> bool {
        let explained = self.noise.powi(2) * (1.0 + 3.0 * self.spread) + ADDS_UP.powi(2);
        self.missed.powi(2) <= explained
    }

    /// Of what is missed, what the noise does not explain.
    pub fn beyond_noise(&self) -> f64 {
        (self.missed.powi(2) - self.noise.powi(2)).max(0.0).sqrt()
    }
}

#[derive(Clone, Debug, Default, Serialize)]
pub struct Part {
    /// "discretisation", "form factors", ..
    pub name: String,
    /// Which two computations differ in this one thing.
    pub compared: String,
    pub error: Error,
    /// Why it was not measured; its error is then 0 and its share lies in another part that is named here.
    pub left_out: Option<String>,
    /// A field of its own, at other places: it stands beside the sum.
    pub is_apart: bool,
}

/// An evaluation point where much of the error is.
#[derive(Clone, Debug, Default, Serialize)]
pub struct WorstPlace {
    /// World space [m].
    pub position: DVec3,
    pub normal: DVec3,
    /// Irradiance, mean of the channels [W/m2].
    pub shown: f64,
    pub reference: f64,
    /// Of the squares of all points.
    pub share: f64,
    /// Which part of the split is largest here.
    pub part: String,
}

/// What to change, and what that brings, from measured points.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Advice {
    /// "half the error", "half the bake time", ..
    pub goal: String,
    /// A command line or a setting.
    pub change: String,
    /// Factors against the shipped setting, of time (or bytes) and of error.
    pub cost: f64,
    pub error: f64,
}

impl Series {
    /// Without a floor of its own.
    pub fn new(name: impl Into<String>, points: Vec<Point>) -> Self {
        Self { name: name.into(), points, ..Self::default() }
    }
}

impl Error {
    /// `found` against `reference`, weighted (areas, or 1); all of one length, channel after channel.
    pub fn of(found: &[f64], reference: &[f64], weights: &[f64]) -> Self {
        let differences: Vec<f64> =
            found.iter().zip(reference).map(|(found, wanted)| found - wanted).collect();
        Self::of_field(&differences, reference, weights)
    }

    /// The same of a field of differences.
    pub fn of_field(differences: &[f64], reference: &[f64], weights: &[f64]) -> Self {
        let weight: f64 = weights.iter().sum();
        let mean = |value: &dyn Fn(usize) -> f64| -> f64 {
            (0..differences.len()).map(|i| weights[i] * value(i)).sum::<f64>() / weight
        };
        let scale = mean(&|i| reference[i]);
        if differences.is_empty() || scale <= 0.0 {
            return Self::default();
        }
        let mut relative: Vec<f64> =
            differences.iter().zip(reference).map(|(e, wanted)| e.abs() / (wanted + 0.01 * scale)).collect();
        relative.sort_by(f64::total_cmp);
        let at = |share: f64| relative[((share * relative.len() as f64) as usize).min(relative.len() - 1)];
        Self {
            rms: mean(&|i| differences[i] * differences[i]).sqrt() / scale,
            bias: mean(&|i| differences[i]) / scale,
            p99: at(0.99),
            max: at(1.0),
        }
    }

    pub fn by(&self, norm: Norm) -> f64 {
        match norm {
            Norm::Rms => self.rms,
            Norm::P99 => self.p99,
            Norm::Max => self.max,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn split(unexplained: f64, missed: f64) -> Split {
        let seeds = Seeds { missed, noise: 0.5, spread: 0.2 };
        Split { unexplained, seeds, ..Split::default() }
    }

    #[test]
    fn parts_add_up_where_the_sum_is_near_and_noise_explains_what_two_seeds_miss() {
        assert!(split(0.04, 0.6).adds_up());
        assert!(!split(0.06, 0.6).adds_up());
        assert!(!split(0.04, 0.7).adds_up());
        assert!((split(0.0, 0.7).seeds.beyond_noise() - 0.24_f64.sqrt()).abs() < 1e-12);
        assert_eq!(split(0.0, 0.3).seeds.beyond_noise(), 0.0);
    }
}
