//! The path tracer's answer at the evaluation points, twice, with seeds of its own each time.
//!
//! Both halves take the same time; all errors are against their mean. What comes straight from punctual lights is taken
//! off again: a path tracer of the same triangles where nothing reflects, emits or shines from the sky says how much.

use engine::scene::{Scene, SkyKind};
use glam::{DVec3, Vec3};

use super::bakes::Quiet;
use super::lit::field;
use crate::reference::{Measured, PathTracer, Surfaces};
use crate::report::Budget;
use crate::report::model::Floor;
use crate::{BakeError, Opened, Point, Watcher};

pub const SEEDS: [u64; 2] = [0x7a11_0001, 0x7a11_0002];

/// Of what is taken off: what is left of it is nothing.
const ROUNDING: f64 = 1e-9;

/// Irradiance at the evaluation points without what comes straight from punctual lights [W/m2].
pub struct Truth {
    pub field: Vec<f64>,
    /// From either seed alone.
    pub halves: [Vec<f64>; 2],
    /// rms over the mean.
    pub standard_error: f64,
}

impl Truth {
    pub fn floors(&self) -> Vec<Floor> {
        vec![Floor { name: "standard error of the path tracer".to_owned(), y: self.standard_error }]
    }

    pub fn is_dark(&self) -> bool {
        self.field.iter().all(|value| *value == 0.0)
    }
}

/// Traces until the standard error, rms over the mean, is `fine_enough`, or the budget is spent.
pub fn trace(
    opened: &Opened,
    points: &[Point],
    fine_enough: f64,
    budget: &Budget,
    watcher: &dyn Watcher,
) -> Result<Truth, BakeError> {
    watcher.stage("path tracer", 2);
    let tracer = PathTracer::new(&opened.scene, &opened.assets, Surfaces::Diffuse)?;
    let straight = PathTracer::new(&darkened(&opened.scene), &opened.assets, Surfaces::Diffuse)?;
    let straight = straight.irradiance(points, 1, SEEDS[0], &Quiet(watcher))?;
    let mut halves: [Vec<f64>; 2] = Default::default();
    let mut squares = 0.0;
    for (k, seed) in SEEDS.into_iter().enumerate() {
        let seconds = budget.left() / (2 - k) as f64;
        let target = fine_enough * std::f64::consts::SQRT_2;
        let found = tracer.irradiance_until(points, target, seconds, seed, &Quiet(watcher))?;
        let net = |(found, straight): (&Measured, &Measured)| {
            let net = found.total() - straight.direct;
            DVec3::select(net.cmpgt(straight.direct * ROUNDING), net, DVec3::ZERO)
        };
        halves[k] = field(found.iter().zip(&straight).map(net));
        squares += found.iter().map(|point| point.standard_error.length_squared()).sum::<f64>();
        watcher.advance(1, 0);
    }
    let mean: Vec<f64> = halves[0].iter().zip(&halves[1]).map(|(a, b)| 0.5 * (a + b)).collect();
    let scale = mean.iter().sum::<f64>() / mean.len().max(1) as f64;
    // The variance of the mean of two is a quarter of the sum of theirs.
    let rms = (0.25 * squares / mean.len().max(1) as f64).sqrt();
    let standard_error = if scale > 0.0 { rms / scale } else { 0.0 };
    Ok(Truth { field: mean, halves, standard_error })
}

/// The same with nothing but its punctual lights.
fn darkened(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    for material in &mut scene.materials {
        material.albedo.color = Vec3::ZERO;
        material.emission.strength = 0.0;
    }
    scene.sky.kind = SkyKind::None;
    scene
}
