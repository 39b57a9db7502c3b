//! Clean bakes, really made in this run and timed as wholes: the pipeline and the certificate, in memory; no cache, no
//! file, nothing kept from one to the next. What each one shows at the evaluation points is kept, itself not.

use std::time::Instant;

use engine::scene::file::Quality;
use engine::transport::key::BakeWith;
use engine::transport::{Certificate, Transport, materials};
use glam::Vec3;

use super::lit::Lit;
use super::matrix::Exactly;
use crate::pipeline::{Caches, make};
use crate::report::Budget;
use crate::report::budget::Within;
use crate::report::model::Error;
use crate::{BakeError, Opened, Point, Watcher, certify};

/// How one bake is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recipe {
    /// Of patches [m].
    pub length: f64,
    /// A row.
    pub rays: u32,
}

/// What one bake cost and shows.
pub struct Made {
    pub recipe: Recipe,
    pub patches: usize,
    /// Of every run, in order.
    pub seconds: Vec<f64>,
    /// Irradiance at the evaluation points.
    pub shown: Vec<f64>,
    /// Where the matrix reference of these patches is known.
    pub beside_matrix: Option<BesideMatrix>,
}

/// What is compared with the matrix reference.
pub struct BesideMatrix {
    /// Irradiance at the evaluation points under that reference's direct light.
    pub shown: Vec<f64>,
    /// Of the patches' form factors.
    pub factors: Error,
}

/// The matrix reference, the patch length that it is of, and its direct light by patch.
#[derive(Clone, Copy)]
pub struct OfLength<'a> {
    pub length: f64,
    pub exactly: &'a Exactly,
    pub direct: &'a [Vec3],
}

/// What was baked so far.
pub struct Bakes<'a> {
    pub opened: &'a Opened,
    pub points: &'a [Point],
    pub reference: Option<OfLength<'a>>,
    pub made: Vec<Made>,
    pub notes: Vec<String>,
}

/// What a row takes beside its rays, in rays: to be laid out, sampled towards, balanced.
const BESIDE: f64 = 192.0;
/// What a bake may take longer than expected.
const MARGIN: f64 = 1.25;
/// Solving it and looking at it, in times of the bake.
const LOOKING: f64 = 0.3;

impl Recipe {
    /// What it costs, up to a factor that is the scene's: rows times their rays, and what a row takes beside.
    pub fn work(self) -> f64 {
        (f64::from(self.rays) + BESIDE) / (self.length * self.length)
    }
}

impl Bakes<'_> {
    /// Seconds: scaled from the bake that is most like it; nothing is known before the first.
    pub fn expected(&self, recipe: Recipe) -> f64 {
        let times = |made: &Made| recipe.work() / made.recipe.work();
        let unlike = |made: &&Made| times(made).ln().abs();
        let like = self.made.iter().min_by(|a, b| unlike(a).total_cmp(&unlike(b)));
        like.map_or(0.0, |made| made.seconds[0] * times(made))
    }

    pub fn of(&self, recipe: Recipe) -> Option<&Made> {
        self.made.iter().find(|made| made.recipe == recipe)
    }

    /// Bakes where that fits into the budget: once more where it was made before. Says whether it did.
    pub fn make(
        &mut self,
        recipe: Recipe,
        budget: &Budget,
        watcher: &dyn Watcher,
    ) -> Result<bool, BakeError> {
        let known = self.made.iter().position(|made| made.recipe == recipe);
        let expected = known.map_or_else(|| self.expected(recipe), |k| self.made[k].seconds[0]);
        let looking = if known.is_some() { 0.0 } else { LOOKING };
        if expected * (MARGIN + looking) > budget.left() || budget.is_spent() {
            return Ok(false);
        }
        let within = Within { watcher: &Quiet(watcher), budget: *budget };
        let (transport, seconds) = match bake(self.opened, recipe, &within) {
            Err(BakeError::Cancelled) if !watcher.cancelled() => {
                self.notes
                    .push(format!("the bake with {recipe} was begun and not ended: the budget was spent"));
                return Ok(false);
            }
            baked => baked?,
        };
        match known {
            Some(k) => self.made[k].seconds.push(seconds),
            None => self.look(recipe, seconds, &transport),
        }
        Ok(true)
    }

    fn look(&mut self, recipe: Recipe, seconds: f64, transport: &Transport) {
        let lit = Lit::new(self.opened, transport);
        let places = lit.places(self.points);
        let shown = lit.shown(&lit.solved(), &places);
        let reference = self.reference.filter(|reference| reference.length == recipe.length);
        let beside_matrix = reference.and_then(|OfLength { exactly, direct, .. }| {
            let rows = &transport.patch_from_patch;
            let factors = exactly.error_of_factors(rows)?;
            Some(BesideMatrix { shown: lit.shown(&lit.solve(rows, &lit.e(rows, direct)), &places), factors })
        });
        let (patches, seconds) = (transport.patches.len(), vec![seconds]);
        self.made.push(Made { recipe, patches, seconds, shown, beside_matrix });
    }
}

/// One bake and its seconds.
pub fn bake(opened: &Opened, recipe: Recipe, watcher: &dyn Watcher) -> Result<(Transport, f64), BakeError> {
    let started = Instant::now();
    // The quality is a name in the certificate and changes nothing.
    let with = BakeWith { quality: Quality::Standard, rays: recipe.rays, length: recipe.length };
    let caches = Caches::none();
    let (transport, _) = make(&opened.scene, &opened.assets, &opened.surface, &with, &caches, watcher)?;
    let mut certificate: Certificate = transport.certificate.clone();
    let mut materials = materials::of_patches(&transport, &opened.scene, &opened.assets);
    let unlimited = opened.settings.bake.unlimited_gain;
    certify::certify_materials(&mut certificate, &transport, &opened.scene, &mut materials, unlimited);
    Ok((transport, started.elapsed().as_secs_f64()))
}

/// Only asks whether to go on: the stages of a bake are no stages of the report.
pub struct Quiet<'a>(pub &'a dyn Watcher);

impl Watcher for Quiet<'_> {
    fn cancelled(&self) -> bool {
        self.0.cancelled()
    }
}

impl std::fmt::Display for Recipe {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "{} rays, {}", self.rays, metres(self.length))
    }
}

/// Three digits.
pub fn metres(length: f64) -> String {
    let digits = (2 - length.log10().floor() as i32).max(0) as usize;
    format!("{length:.digits$} m")
}
