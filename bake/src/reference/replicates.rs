//! Means and their errors: sixteen replicates of every answer, each with scrambles of its own (Owen 1997).
//!
//! ```text
//! mean = 1/R Sum_r x_r          standard error^2 = 1/(R (R - 1)) Sum_r (x_r - mean)^2
//! ```
//! A replicate's own points are even and no sample of each other, so that only replicates tell the error. Every
//! replicate of every point is summed by one task, in f64: threads change nothing.

use std::time::Instant;

use engine::transport::sh::{COEFFICIENTS, basis};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::path::PathTracer;
use super::place::{Place, places};
use super::sequence::{Block, Numbers};
use super::sources::weight;
use super::world::Ray;
use super::{Measured, MeasuredProbe, MeasuredRadiance};
use crate::directions::{Sobol, hash_of, sphere_direction};
use crate::{BakeError, Point, Watcher};

const REPLICATES: u32 = 16;
/// Of a replicate, before an error is believed.
const FEWEST: u32 = 32;
/// Of a replicate: no answer needs more, and Sobol's points are kept in memory.
const MOST: u32 = 1 << 20;

/// Sums over paths, by point and replicate: direct and indirect.
type Sums = Vec<[[DVec3; 2]; REPLICATES as usize]>;

impl PathTracer {
    /// Irradiance at points on surfaces, in their order, from so many paths each (rounded up to whole replicates). A
    /// point too far from any front face is an error that names its place in the list (from 1).
    pub fn irradiance(
        &self,
        points: &[Point],
        paths: u32,
        seed: u64,
        watcher: &dyn Watcher,
    ) -> Result<Vec<Measured>, BakeError> {
        let places = self.places(points)?;
        let block = Block { start: 0, count: paths_of_replicate(paths) };
        watcher.stage("reference", points.len() as u64);
        let sums = self.sums(&places, block, seed, watcher)?;
        Ok(measured(&sums, block.count))
    }

    /// The same with more and more paths, until the standard error (rms over points and channels) is at most this
    /// share of the mean, or the time is up [s].
    pub fn irradiance_until(
        &self,
        points: &[Point],
        relative_error: f64,
        seconds: f64,
        seed: u64,
        watcher: &dyn Watcher,
    ) -> Result<Vec<Measured>, BakeError> {
        let started = Instant::now();
        let places = self.places(points)?;
        watcher.stage("reference", points.len() as u64);
        let mut sums: Sums = vec![Default::default(); places.len()];
        let mut block = Block { start: 0, count: FEWEST / 2 };
        loop {
            let more = self.sums(&places, block, seed, watcher)?;
            add(&mut sums, &more);
            let done = block.start + block.count;
            let found = measured(&sums, done);
            let left = seconds - started.elapsed().as_secs_f64();
            let count = affordable(done, left / (seconds - left));
            let is_good = done >= FEWEST && relative(&found) <= relative_error;
            if is_good || count == 0 || done >= MOST || points.is_empty() {
                return Ok(found);
            }
            block = Block { start: done, count };
        }
    }

    /// Coefficients of incoming radiance at points in space, in their order.
    pub fn probes(
        &self,
        points: &[DVec3],
        paths: u32,
        seed: u64,
        watcher: &dyn Watcher,
    ) -> Result<Vec<MeasuredProbe>, BakeError> {
        watcher.stage("reference of probes", points.len() as u64);
        let block = Block { start: 0, count: paths_of_replicate(paths) };
        let sobol = Sobol::new(block.end());
        let probe = |(number, point): (usize, &DVec3)| {
            if !point.is_finite() {
                return Err(BakeError::Other(format!("probe {} is not at a finite place", number + 1)));
            }
            let position = (*point - self.world.origin()).as_vec3();
            let mut replicates = Vec::new();
            for replicate in 0..REPLICATES {
                if watcher.cancelled() {
                    return Err(BakeError::Cancelled);
                }
                let seed = seed_of(seed, position, Vec3::ZERO, replicate);
                let mut sums = [DVec3::ZERO; COEFFICIENTS];
                block.paths(&sobol, seed).for_each(|numbers| self.add_path(position, &numbers, &mut sums));
                replicates.push(sums.map(|sum| sum / f64::from(block.count)));
            }
            watcher.advance(1, u64::from(block.count * REPLICATES));
            Ok(probe_of(&replicates))
        };
        points.par_iter().enumerate().map(probe).collect()
    }

    /// Adds one path's L Y_lm, over all directions.
    fn add_path(&self, position: Vec3, numbers: &Numbers, sums: &mut [DVec3; COEFFICIENTS]) {
        let mut add = |radiance: DVec3, direction: Vec3| {
            sums.iter_mut().zip(basis(direction)).for_each(|(sum, y)| *sum += radiance * f64::from(y));
        };
        let everywhere = 0.25 * std::f64::consts::FRAC_1_PI;
        let [u, v, ..] = numbers.four(0);
        let direction = sphere_direction(u, v);
        let ray = Ray { origin: position, normal: Vec3::ZERO, direction };
        let arriving = self.arriving(ray, Some(everywhere), numbers);
        add((arriving.emitted + arriving.reflected) / everywhere, direction);
        if let Some(towards) = self.towards(position, Vec3::ZERO, 0, numbers) {
            let share = weight(towards.density, everywhere) / towards.density;
            add(towards.radiance * share, towards.direction.as_vec3());
        }
    }

    /// Radiance that arrives at a place from a direction of any length but 0: what a picture shows there. On one
    /// thread.
    pub fn radiance(&self, origin: DVec3, direction: DVec3, paths: u32, seed: u64) -> MeasuredRadiance {
        let block = Block { start: 0, count: paths_of_replicate(paths) };
        let sobol = Sobol::new(block.end());
        let origin = (origin - self.world.origin()).as_vec3();
        let direction = direction.normalize_or_zero().as_vec3();
        if direction == Vec3::ZERO || !origin.is_finite() {
            return MeasuredRadiance::default();
        }
        let ray = Ray { origin, normal: Vec3::ZERO, direction };
        let replicate = |replicate: u32| {
            let seed = seed_of(seed, origin, direction, replicate);
            let path = |numbers: Numbers| {
                let arriving = self.arriving(ray, None, &numbers);
                arriving.emitted + arriving.reflected
            };
            block.paths(&sobol, seed).map(path).sum::<DVec3>() / f64::from(block.count)
        };
        let replicates: Vec<DVec3> = (0..REPLICATES).map(replicate).collect();
        let (radiance, standard_error) = mean(&replicates);
        MeasuredRadiance { radiance, standard_error }
    }

    fn places(&self, points: &[Point]) -> Result<Vec<Place>, BakeError> {
        let world = &self.world;
        let has_side = |t: usize, back: bool| !back || world.is_double_sided(t as u32);
        places(points, world.origin(), &world.triangles, has_side)
    }

    fn sums(
        &self,
        places: &[Place],
        block: Block,
        seed: u64,
        watcher: &dyn Watcher,
    ) -> Result<Sums, BakeError> {
        let sobol = Sobol::new(block.end());
        let replicate = |k: usize| {
            if watcher.cancelled() {
                return Err(BakeError::Cancelled);
            }
            let (place, replicate) = (&places[k / REPLICATES as usize], k as u32 % REPLICATES);
            let seed = seed_of(seed, place.position, place.normal, replicate);
            let mut sums = [DVec3::ZERO; 2];
            for numbers in block.paths(&sobol, seed) {
                let path = self.irradiance_of_path(place.position, place.normal, &numbers);
                (0..2).for_each(|part| sums[part] += path[part]);
            }
            watcher.advance(u64::from(replicate == 0), u64::from(block.count));
            Ok(sums)
        };
        let count = places.len() * REPLICATES as usize;
        let sums: Result<Vec<[DVec3; 2]>, BakeError> = (0..count).into_par_iter().map(replicate).collect();
        Ok(sums?.as_chunks().0.to_vec())
    }
}

fn paths_of_replicate(paths: u32) -> u32 {
    paths.div_ceil(REPLICATES).clamp(1, MOST)
}

fn seed_of(seed: u64, position: Vec3, normal: Vec3, replicate: u32) -> u64 {
    let words = position.to_array().into_iter().chain(normal.to_array()).map(|x| u64::from(x.to_bits()));
    hash_of([seed, u64::from(replicate)].into_iter().chain(words))
}

/// How many more paths, as many again or a part of that, fit into `times` the time so far: a power of two that the
/// number so far is a multiple of.
fn affordable(done: u32, times: f64) -> u32 {
    let mut count = 1 << done.trailing_zeros();
    while count > 0 && f64::from(count) > f64::from(done) * times {
        count /= 2;
    }
    count
}

fn add(sums: &mut Sums, more: &Sums) {
    for (sum, more) in sums.iter_mut().flatten().flatten().zip(more.iter().flatten().flatten()) {
        *sum += *more;
    }
}

fn measured(sums: &Sums, paths: u32) -> Vec<Measured> {
    let of = |replicates: &[[DVec3; 2]; REPLICATES as usize]| {
        let part = |part: usize| replicates.map(|sums| sums[part] / f64::from(paths));
        let both = replicates.map(|sums| (sums[0] + sums[1]) / f64::from(paths));
        Measured { direct: mean(&part(0)).0, indirect: mean(&part(1)).0, standard_error: mean(&both).1 }
    };
    sums.iter().map(of).collect()
}

/// rms of the standard error over the mean; 0 where all is dark.
fn relative(found: &[Measured]) -> f64 {
    let squares: f64 = found.iter().map(|point| point.standard_error.length_squared()).sum();
    let sum: f64 = found.iter().map(|point| point.total().element_sum()).sum();
    let count = 3.0 * found.len() as f64;
    if sum > 0.0 { (squares * count).sqrt() / sum } else { 0.0 }
}

/// The mean of replicates and its standard error.
fn mean(replicates: &[DVec3]) -> (DVec3, DVec3) {
    let count = replicates.len() as f64;
    let mean = replicates.iter().sum::<DVec3>() / count;
    let squares: DVec3 = replicates.iter().map(|x| (*x - mean) * (*x - mean)).sum();
    (mean, (squares / (count * (count - 1.0))).map(f64::sqrt))
}

fn probe_of(replicates: &[[DVec3; COEFFICIENTS]]) -> MeasuredProbe {
    let mut probe = MeasuredProbe::default();
    for k in 0..COEFFICIENTS {
        let of_k: Vec<DVec3> = replicates.iter().map(|sums| sums[k]).collect();
        (probe.coefficients[k], probe.standard_error[k]) = mean(&of_k);
    }
    probe
}
