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
    /// Variance of what the halves differ by, as their replicates say.
    pub apart: Vec<f64>,
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
    let target = fine_enough * std::f64::consts::SQRT_2;
    let follow = |seed: u64, seconds: f64| -> Result<Traced, BakeError> {
        let found = tracer.irradiance_until(points, target, seconds, seed, &Quiet(watcher))?;
        watcher.advance(1, 0);
        Ok(Traced::new(&found, &straight))
    };
    let one = follow(SEEDS[0], 0.5 * budget.left())?;
    Ok(Truth::of(one, follow(SEEDS[1], budget.left())?))
}

/// What one seed found, channel after channel: net of what comes straight from lights, and its variance.
struct Traced {
    field: Vec<f64>,
    variance: Vec<f64>,
}

impl Traced {
    fn new(found: &[Measured], straight: &[Measured]) -> Self {
        let net = |(found, straight): (&Measured, &Measured)| {
            let net = found.total() - straight.direct;
            DVec3::select(net.cmpgt(straight.direct * ROUNDING), net, DVec3::ZERO)
        };
        Self {
            field: field(found.iter().zip(straight).map(net)),
            variance: field(found.iter().map(|point| point.standard_error * point.standard_error)),
        }
    }
}

impl Truth {
    fn of(one: Traced, other: Traced) -> Self {
        let both = |a: &[f64], b: &[f64], share: f64| -> Vec<f64> {
            a.iter().zip(b).map(|(a, b)| share * (a + b)).collect()
        };
        let field = both(&one.field, &other.field, 0.5);
        let apart = both(&one.variance, &other.variance, 1.0);
        let scale = mean(&field);
        // The variance of the mean of two is a quarter of the sum of theirs.
        let rms = (0.25 * mean(&apart)).sqrt();
        let standard_error = if scale > 0.0 { rms / scale } else { 0.0 };
        Self { field, halves: [one.field, other.field], apart, standard_error }
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
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
