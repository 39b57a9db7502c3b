//! The matrix reference under the scene's light: the shipped patches with rays that are many more and others.
//!
//! Two matrices of half the rays each, from two seeds; what they show is averaged, and half of what they differ by is
//! its error. Receivers and points gather from them by rays of their own.

use engine::transport::Rows;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::bakes::Quiet;
use super::lit::{Lit, difference, field, weights};
use crate::query::Place;
use crate::reference::MatrixReference;
use crate::report::Budget;
use crate::report::budget::Within;
use crate::report::model::Error;
use crate::{BakeError, Opened, Watcher};

pub const SEEDS: [u64; 2] = [0x3a7c_0001, 0x3a7c_0002];
/// Of both matrices together, a row: at most, and least.
pub const MOST: u32 = 1 << 14;
const LEAST: u32 = 1 << 11;

/// What the shipped patches would show if their form factors were exact.
pub struct Exactly {
    /// Of both matrices together, a row.
    pub rays: u32,
    /// Irradiance at the evaluation points, through the receivers, and by rays of the points themselves.
    pub at_receivers: Vec<f64>,
    pub at_points: Vec<f64>,
    /// Of `at_receivers`: rms over the mean.
    pub standard_error: f64,
    matrices: Vec<MatrixReference>,
}

/// None where it does not fit into the budget or into memory; `notes` says so. `direct`: from punctual lights, by patch.
pub fn exactly(
    opened: &Opened,
    lit: &Lit,
    direct: &[Vec3],
    places: &[Option<Place>],
    budget: &Budget,
    watcher: &dyn Watcher,
    notes: &mut Vec<String>,
) -> Result<Option<Exactly>, BakeError> {
    let transport = lit.transport;
    let receivers = lit.receivers(places);
    let per_ray = seconds_of_a_ray(lit, places);
    let rows = (transport.patches.len() + receivers.len() + places.len()) as f64;
    let affordable = budget.left() / (1.5 * rows * per_ray).max(1e-12);
    let rays = [MOST, MOST / 2, MOST / 4, LEAST].into_iter().find(|&rays| f64::from(rays) <= affordable);
    let Some(rays) = rays else {
        notes.push("the matrix reference was left out: the budget has no time for it".to_owned());
        return Ok(None);
    };
    watcher.stage("matrix reference", 2);
    let mut matrices = Vec::new();
    let (mut at_receivers, mut at_points) = (Vec::new(), Vec::new());
    for seed in SEEDS {
        let within = Within { watcher: &Quiet(watcher), budget: *budget };
        let made = MatrixReference::new(&opened.scene, &opened.assets, transport, rays / 2, seed, &within);
        let matrix = match made {
            Ok(matrix) => matrix,
            Err(BakeError::Cancelled) if watcher.cancelled() => return Err(BakeError::Cancelled),
            Err(why) => {
                notes.push(format!("the matrix reference was left out: {why}"));
                return Ok(None);
            }
        };
        let from_sky = matrix.gather(&lit.sky);
        let albedo: Vec<DVec3> = lit.albedo.iter().map(|albedo| albedo.as_dvec3()).collect();
        let b = lit.columns(&matrix.solve_with(&albedo, &lit.e_of(&from_sky, direct)));
        let (receiving, own) = seen(lit, rays / 2, seed, &b, &receivers, places);
        at_receivers.push(lit.blended(&receiving, places));
        at_points.push(own);
        matrices.push(matrix);
        watcher.advance(1, 0);
    }
    let mean = |halves: &[Vec<f64>]| -> Vec<f64> {
        halves[0].iter().zip(&halves[1]).map(|(a, b)| 0.5 * (a + b)).collect()
    };
    let reference = mean(&at_receivers);
    let apart = difference(&at_receivers[0], &at_receivers[1]);
    let standard_error = 0.5 * Error::of_field(&apart, &reference, &weights(&reference)).rms;
    let at_points = mean(&at_points);
    Ok(Some(Exactly { rays, at_points, at_receivers: reference, standard_error, matrices }))
}

/// Irradiance of all receivers that are read (others 0), and at the places themselves.
fn seen(
    lit: &Lit,
    rays: u32,
    seed: u64,
    b: &[DVec3],
    receivers: &[usize],
    places: &[Option<Place>],
) -> (Vec<DVec3>, Vec<f64>) {
    let look = lit.look(rays, seed);
    let at = |&receiver: &usize| {
        let place = &lit.transport.receivers[receiver];
        (receiver, lit.gathered(&look, place.position, place.normal, b))
    };
    let found: Vec<(usize, DVec3)> = receivers.par_iter().map(at).collect();
    let mut irradiance = vec![DVec3::ZERO; lit.transport.receivers.len()];
    found.into_iter().for_each(|(receiver, value)| irradiance[receiver] = value);
    let own = |place: &Option<Place>| {
        place.as_ref().map_or(DVec3::ZERO, |place| lit.gathered(&look, place.position, place.normal, b))
    };
    let own: Vec<DVec3> = places.par_iter().map(own).collect();
    (irradiance, field(own.into_iter()))
}

/// From a few places, on all threads.
fn seconds_of_a_ray(lit: &Lit, places: &[Option<Place>]) -> f64 {
    const RAYS: u32 = 8192;
    let look = lit.look(RAYS, 0);
    let black = vec![DVec3::ZERO; lit.transport.columns()];
    let some: Vec<&Place> = places.iter().flatten().take(8).collect();
    let started = std::time::Instant::now();
    some.par_iter().for_each(|place| {
        lit.gathered(&look, place.position, place.normal, &black);
    });
    started.elapsed().as_secs_f64() / (some.len().max(1) as f64 * f64::from(RAYS))
}

impl Exactly {
    /// |P - P_exact| / |P_exact|, both as one vector (Frobenius), signed by the sum of all entries.
    /// None of rows that are not these patches'.
    pub fn error_of_factors(&self, rows: &Rows) -> Option<Error> {
        let columns = self.matrices[0].columns();
        if rows.len() * columns != self.matrices[0].matrix().len() {
            return None;
        }
        let [a, b] = [self.matrices[0].matrix(), self.matrices[1].matrix()];
        let (mut far, mut size, mut excess, mut sum, mut largest) = (0.0, 0.0, 0.0, 0.0, 0.0_f64);
        let mut dense = vec![0.0; columns];
        for i in 0..rows.len() {
            rows.row(i).for_each(|(column, weight)| dense[column as usize] = f64::from(weight));
            for (j, found) in dense.iter_mut().enumerate() {
                let wanted = 0.5 * (a[i * columns + j] + b[i * columns + j]);
                let e = std::mem::take(found) - wanted;
                far += e * e;
                size += wanted * wanted;
                excess += e;
                sum += wanted;
                largest = largest.max(e.abs());
            }
        }
        if size <= 0.0 {
            return None;
        }
        Some(Error { rms: (far / size).sqrt(), bias: excess / sum, p99: 0.0, max: largest })
    }

    /// Of the reference's own factors, by the same measure.
    pub fn floor_of_factors(&self) -> f64 {
        let [a, b] = [self.matrices[0].matrix(), self.matrices[1].matrix()];
        let (far, size) = a.iter().zip(b).fold((0.0, 0.0), |(far, size), (a, b)| {
            (far + 0.25 * (a - b) * (a - b), size + 0.25 * (a + b) * (a + b))
        });
        if size > 0.0 { (far / size).sqrt() } else { 0.0 }
    }
}
