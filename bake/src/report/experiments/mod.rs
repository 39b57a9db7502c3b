//! What is measured, one file an experiment.
//!
//! All of them look at the same points under the scene's own light, as it is at the start. Each gets a share of the time
//! that is left when its turn comes; bakes come last and take what there is, cheap points first. Seeds are
//! fixed: errors repeat bit for bit where the same points were reached, times do not.

mod advice;
mod bake_time;
mod bakes;
mod bytes;
mod frame;
mod lag;
mod lit;
mod matrix;
mod points;
mod probes;
mod quantise;
mod raw;
mod runtime;
mod script;
mod split;
mod truth;

#[cfg(test)]
mod tests;

use engine::transport::{Rows, Transport};
use glam::{DVec3, Vec3};

use self::bakes::{Bakes, OfLength, Quiet, Recipe};
use self::bytes::Stored;
use self::frame::Problem;
use self::lit::Lit;
use self::matrix::{Exactly, exactly};
use self::points::Points;
use self::runtime::Runtime;
use self::split::{Chain, MANY_SAMPLES};
use self::truth::Truth;
use super::Budget;
use super::budget::Within;
use super::model::{Advice, Diagram, Error, Split};
use super::player::{GpuLight, Played};
use crate::query::Place;
use crate::{BakeError, Opened, Point, Watcher};

/// The scene, opened, with the bake that the project ships, and what the player said of it.
pub struct Setup {
    pub(crate) opened: Opened,
    pub transport: Transport,
    /// None where there is no player or nothing to draw with.
    pub played: Option<Played>,
}

/// What all experiments found.
#[derive(Clone, Debug, Default)]
pub struct Measured {
    pub diagrams: Vec<Diagram>,
    pub split: Split,
    pub advice: Vec<Advice>,
    pub seeds: Vec<(String, u64)>,
    pub notes: Vec<String>,
}

/// How much is done where time does not matter.
#[derive(Clone, Copy, Debug)]
struct Effort {
    points: usize,
    /// Standard error of the path tracer, rms over the mean, below which it need not go.
    reference: f64,
    /// Bakes of one patch length have at most so many rays.
    rays: u32,
}

const EFFORT: Effort = Effort { points: 1000, reference: 1e-4, rays: 1 << 20 };
/// Seconds below which fewer points must do, and so many then.
const SHORT: f64 = 60.0;
const FEW: usize = 64;

/// Cavity gain beyond which paths are long, and time is better spent on few points.
const STIFF: f64 = 20.0;

/// Of the time, what is not for bakes; they come last and take what there is then.
const FOR_OTHERS: f64 = 0.5;
/// Shares of what is left of that, in the order of their turns.
const FOR_MATRIX: f64 = 0.4;
const FOR_TRUTH: f64 = 0.5;
const FOR_STIFF_TRUTH: f64 = 0.65;
const FOR_LAG: f64 = 0.35;
const FOR_FRAME: f64 = 0.5;
const FOR_BYTES: f64 = 0.5;
const FOR_RAW: f64 = 0.8;
/// Of what is left for bakes: the matrix reference of the longest patches, whose layout a bake with so few rays tells.
const FOR_SWEPT: f64 = 0.2;
const FEWEST_RAYS: u32 = 64;

pub fn all(setup: &Setup, budget: &Budget, watcher: &dyn Watcher) -> Result<Measured, BakeError> {
    let points = if budget.left() < SHORT { FEW } else { EFFORT.points };
    run(setup, budget, &Effort { points, ..EFFORT }, watcher)
}

fn run(
    setup: &Setup,
    budget: &Budget,
    effort: &Effort,
    watcher: &dyn Watcher,
) -> Result<Measured, BakeError> {
    let mut measured = Measured { seeds: seeds(), ..Measured::default() };
    let notes = &mut measured.notes;
    if setup.transport.patches.is_empty() {
        notes.push("the scene has no static surfaces: there is nothing to measure".to_owned());
        return Ok(measured);
    }
    let opened = &setup.opened;
    let others = budget.part(FOR_OTHERS);
    let lit = Lit::new(opened, &setup.transport);
    let stiff = frame::largest_gain(&lit) > STIFF;
    let count = if stiff { effort.points.min(FEW) } else { effort.points };
    let points = points_of(opened, count, notes);
    let seen = Seen::new(&lit, &points);
    let exactly = seen.exactly(opened, &others.part(FOR_MATRIX), watcher, notes)?;
    let for_truth = others.part(if stiff { FOR_STIFF_TRUTH } else { FOR_TRUTH });
    let truth = truth::trace(opened, &points, effort.reference, &for_truth, watcher)?;
    if truth.is_dark() {
        notes.push("no light reaches any surface: only lag was measured, by lamps of its own".to_owned());
        measured.diagrams = lag::diagrams(&lit, &others.part(FOR_LAG), watcher, notes)?;
        return Ok(measured);
    }
    let lag = lag::diagrams(&lit, &others.part(FOR_LAG), watcher, notes)?;
    let frame = seen.frame(setup.played.as_ref(), &others.part(FOR_FRAME), watcher)?;
    let bytes = seen.bytes(exactly.as_ref(), &others.part(FOR_BYTES), watcher)?;
    let ends = Ends { exactly: exactly.as_ref(), truth: &truth, direct_exactly: &seen.direct_exactly };
    measured.split = seen.split(setup, &ends, &others.part(FOR_RAW), watcher)?;
    (measured.diagrams, measured.advice) = bakes(setup, &points, &ends, effort, budget, watcher, notes)?;
    measured.advice.extend(frame.first().map(advice::of_frames).unwrap_or_default());
    measured.diagrams.extend(frame);
    measured.diagrams.extend(lag);
    measured.diagrams.push(bytes);
    measured.diagrams.retain(|diagram| !diagram.series.is_empty());
    Ok(measured)
}

/// What fields are compared with.
struct Ends<'a> {
    exactly: Option<&'a Exactly>,
    truth: &'a Truth,
    /// From punctual lights, by patch, from many samples.
    direct_exactly: &'a [Vec3],
}

fn points_of(opened: &Opened, count: usize, notes: &mut Vec<String>) -> Vec<Point> {
    let Points { points, inside } = points::choose(opened, count);
    if inside > 0 {
        notes.push(format!("{inside} evaluation points of {count} were left out: they lie inside solids"));
    }
    points
}

/// Everything that takes bakes of its own.
fn bakes(
    setup: &Setup,
    points: &[Point],
    ends: &Ends,
    effort: &Effort,
    budget: &Budget,
    watcher: &dyn Watcher,
    notes: &mut Vec<String>,
) -> Result<(Vec<Diagram>, Vec<Advice>), BakeError> {
    let shipped = shipped(&setup.transport);
    let presets = bake_time::presets(&setup.opened)?;
    let longest = bake_time::longest(&presets);
    let of_shipped = ends.exactly.map(|exactly| (shipped.length, exactly));
    let own = match of_shipped {
        Some((length, _)) if length != longest => {
            swept(setup, longest, points, &budget.part(FOR_SWEPT), watcher, notes)?
        }
        _ => None,
    };
    let reference = match (&own, of_shipped) {
        (Some((exactly, direct)), _) => Some(OfLength { length: longest, exactly, direct }),
        (None, Some((length, exactly))) if length == longest => {
            Some(OfLength { length, exactly, direct: ends.direct_exactly })
        }
        _ => None,
    };
    let mut bakes = Bakes { opened: &setup.opened, points, reference, made: Vec::new(), notes: Vec::new() };
    bake_time::bake_all(&mut bakes, &presets, shipped, effort.rays, budget, watcher)?;
    notes.append(&mut bakes.notes);
    let exactly: Vec<(f64, &Exactly)> =
        of_shipped.into_iter().chain(own.iter().map(|(exactly, _)| (longest, exactly))).collect();
    let diagrams = bake_time::diagrams(&bakes, &presets, &exactly, ends.truth);
    Ok((diagrams, advice::of_bakes(&bakes, &presets, shipped, ends.truth)))
}

/// The matrix reference of patches of another length than the shipped ones, and their direct light.
fn swept(
    setup: &Setup,
    length: f64,
    points: &[Point],
    budget: &Budget,
    watcher: &dyn Watcher,
    notes: &mut Vec<String>,
) -> Result<Option<(Exactly, Vec<Vec3>)>, BakeError> {
    let opened = &setup.opened;
    let within = Within { watcher: &Quiet(watcher), budget: *budget };
    let transport = match bakes::bake(opened, Recipe { length, rays: FEWEST_RAYS }, &within) {
        Err(BakeError::Cancelled) if !watcher.cancelled() => return Ok(None),
        baked => baked?.0,
    };
    let lit = Lit::new(opened, &transport);
    let direct = lit.direct_from(&lit.lights, MANY_SAMPLES);
    let found = exactly(opened, &lit, &direct, &lit.places(points), budget, watcher, notes)?;
    Ok(found.map(|exactly| (exactly, direct)))
}

fn seeds() -> Vec<(String, u64)> {
    let of = |name: &str, seeds: &[u64]| -> Vec<(String, u64)> {
        (1..).zip(seeds).map(|(k, &seed)| (format!("{name} {k}"), seed)).collect()
    };
    let mut all =
        vec![("evaluation points".to_owned(), points::SEED), ("fresh probe rows".to_owned(), probes::SEED)];
    all.extend(of("path tracer", &truth::SEEDS));
    all.extend(of("matrix reference", &matrix::SEEDS));
    all
}

/// As the certificate says.
fn shipped(transport: &Transport) -> Recipe {
    Recipe { length: transport.certificate.base_length, rays: transport.certificate.rays_per_row }
}

/// The shipped bake under the scene's light, and where it is looked at.
struct Seen<'a> {
    lit: &'a Lit<'a>,
    points: &'a [Point],
    places: Vec<Option<Place>>,
    /// From punctual lights, by patch: as shipped, and from many samples.
    direct: Vec<Vec3>,
    direct_exactly: Vec<Vec3>,
    e: Vec<DVec3>,
    exact: Vec<DVec3>,
}

impl<'a> Seen<'a> {
    fn new(lit: &'a Lit<'a>, points: &'a [Point]) -> Self {
        let places = lit.places(points);
        let rows = &lit.transport.patch_from_patch;
        let direct = lit.direct(&lit.lights);
        let direct_exactly = lit.direct_from(&lit.lights, MANY_SAMPLES);
        let e = lit.e(rows, &direct);
        let exact = lit.solve(rows, &e);
        Self { lit, points, places, direct, direct_exactly, e, exact }
    }

    fn exactly(
        &self,
        opened: &Opened,
        budget: &Budget,
        watcher: &dyn Watcher,
        notes: &mut Vec<String>,
    ) -> Result<Option<Exactly>, BakeError> {
        if self.exact.iter().all(|b| *b == DVec3::ZERO) {
            return Ok(None);
        }
        exactly(opened, self.lit, &self.direct_exactly, &self.places, budget, watcher, notes)
    }

    fn frame(
        &self,
        played: Option<&Played>,
        budget: &Budget,
        watcher: &dyn Watcher,
    ) -> Result<Vec<Diagram>, BakeError> {
        let problem = Problem { lit: self.lit, e: &self.e, exact: &self.exact };
        frame::diagrams(&problem, played, budget, watcher)
    }

    /// What the runtime's iteration ends with.
    fn settled(&self) -> Vec<DVec3> {
        let system = self.lit.system(&self.lit.transport.patch_from_patch);
        Runtime::new(&system, frame::largest_gain(self.lit)).settled(&self.e)
    }

    fn bytes(
        &self,
        exactly: Option<&Exactly>,
        budget: &Budget,
        watcher: &dyn Watcher,
    ) -> Result<Diagram, BakeError> {
        let (lit, places) = (self.lit, &self.places);
        let counted = exactly.map(|exactly| self.error_of_counting(exactly));
        let stored = Stored { lit, direct: &self.direct, exact: &self.exact, places, counted };
        bytes::diagram(&stored, budget, watcher)
    }

    /// What the shipped rows show against exact ones, both solved exactly under the same direct light: rms.
    fn error_of_counting(&self, exactly: &Exactly) -> f64 {
        let rows = &self.lit.transport.patch_from_patch;
        let e = self.lit.e(rows, &self.direct_exactly);
        let shown = self.lit.shown(&self.lit.solve(rows, &e), &self.places);
        Error::of(&shown, &exactly.at_receivers, &lit::weights(&shown)).rms
    }

    fn split(
        &self,
        setup: &Setup,
        ends: &Ends,
        budget: &Budget,
        watcher: &dyn Watcher,
    ) -> Result<Split, BakeError> {
        watcher.stage("split", 2);
        let raw = raw(setup, &Within { watcher: &Quiet(watcher), budget: *budget })?;
        watcher.advance(1, 0);
        let fits = |light: &&GpuLight| {
            light.radiosity.len() >= setup.transport.patches.len()
                && light.irradiance.len() == setup.transport.receivers.len()
        };
        let chain = Chain {
            lit: self.lit,
            points: self.points,
            places: &self.places,
            direct_exactly: &self.direct_exactly,
            exact: &self.exact,
            iterated: &self.settled(),
            gpu: setup.played.as_ref().and_then(|played| played.light.as_ref()).filter(fits),
            raw,
            exactly: ends.exactly,
            truth: ends.truth,
        };
        let mut split = chain.split();
        split.parts.push(probes::part(self.lit, &self.exact));
        watcher.advance(1, 0);
        Ok(split)
    }
}

/// Rows as their rays counted them, or why there are none.
fn raw(setup: &Setup, within: &Within) -> Result<Result<Rows, String>, BakeError> {
    let because = |why: &str| Ok(Err(format!("{why}: its share lies in form factors")));
    match raw::rows(&setup.opened, shipped(&setup.transport), within) {
        Err(BakeError::Cancelled) if within.watcher.cancelled() => Err(BakeError::Cancelled),
        Err(_) => because("the budget had no time to trace its rays again"),
        Ok(rows) if rows.len() == setup.transport.patches.len() => Ok(Ok(rows)),
        Ok(_) => because("the layout is not the bake's"),
    }
}
