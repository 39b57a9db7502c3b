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

/// What a row takes beside its rays, in rays, where nothing is known yet: to be laid out, sampled towards, balanced.
pub const BESIDE: f64 = 192.0;
/// It is no more than this, whatever few times say.
const MOST_BESIDE: f64 = 4096.0;
/// What a bake may take longer than expected.
const MARGIN: f64 = 1.25;
/// Solving it and looking at it, in times of the bake.
const LOOKING: f64 = 0.3;

impl Recipe {
    /// What it costs, up to a factor that is the scene's: rows times their rays, and what a row takes beside, in rays.
    pub fn work(self, beside: f64) -> f64 {
        (f64::from(self.rays) + beside) / (self.length * self.length)
    }
}

impl Bakes<'_> {
    /// Seconds: scaled from the bake that is most like it; nothing is known before the first.
    pub fn expected(&self, recipe: Recipe) -> f64 {
        let times: Vec<(Recipe, f64)> = self.made.iter().map(|made| (made.recipe, made.seconds[0])).collect();
        expected(&times, recipe)
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

/// Seconds of a bake, scaled from the one of these that is most like it.
fn expected(times: &[(Recipe, f64)], recipe: Recipe) -> f64 {
    let beside = beside(times);
    let factor = |like: Recipe| recipe.work(beside) / like.work(beside);
    let unlike = |&&(like, _): &&(Recipe, f64)| factor(like).ln().abs();
    let like = times.iter().min_by(|a, b| unlike(a).total_cmp(&unlike(b)));
    like.map_or(0.0, |&(like, seconds)| seconds * factor(like))
}

/// Rays that take as long as what a row takes beside them, which a scene's number of receivers and its gaps decide:
/// seconds ~ (a + b rays) / length^2 by least squares of the relative misfit, and of that a / b.
fn beside(times: &[(Recipe, f64)]) -> f64 {
    let columns = times.iter().map(|&(recipe, seconds)| {
        let row = 1.0 / (recipe.length * recipe.length * seconds);
        [row, row * f64::from(recipe.rays)]
    });
    let columns: Vec<[f64; 2]> = columns.filter(|column| column[1].is_finite()).collect();
    let sum = |of: &dyn Fn(&[f64; 2]) -> f64| columns.iter().map(of).sum::<f64>();
    let (aa, ab, bb) = (sum(&|x| x[0] * x[0]), sum(&|x| x[0] * x[1]), sum(&|x| x[1] * x[1]));
    let (a, b) = (sum(&|x| x[0]), sum(&|x| x[1]));
    let (of_row, of_ray) = (a * bb - b * ab, b * aa - a * ab);
    let is_determined = columns.len() > 1 && aa * bb - ab * ab > 1e-6 * aa * bb && of_ray > 0.0;
    if is_determined { (of_row / of_ray).clamp(0.0, MOST_BESIDE) } else { BESIDE }
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

#[cfg(test)]
mod tests {
    use super::*;

    fn times(of: impl Fn(f64, f64) -> f64, recipes: &[(f64, u32)]) -> Vec<(Recipe, f64)> {
        let one = |&(length, rays): &(f64, u32)| {
            let rows = 1.0 / (length * length);
            (Recipe { length, rays }, of(rows, f64::from(rays)))
        };
        recipes.iter().map(one).collect()
    }

    /// In the Cornell box a row takes 600 rays beside its own, in the corridor 50.
    #[test]
    fn a_bake_is_expected_to_take_what_others_of_the_scene_say() {
        for beside in [50.0, 600.0] {
            let seconds = |rows: f64, rays: f64| 1e-6 * rows * (beside + rays);
            let known = times(seconds, &[(0.04, 64), (0.04, 512), (0.04, 8192), (0.02, 1024), (0.016, 64)]);
            let recipe = Recipe { length: 0.03, rays: 1024 };
            let right = seconds(1.0 / (0.03 * 0.03), 1024.0);
            assert!((expected(&known, recipe) - right).abs() < 1e-6 * right, "{beside}");
        }
    }

    #[test]
    fn what_few_or_strange_times_say_is_finite() {
        let recipe = Recipe { length: 0.03, rays: 1024 };
        assert_eq!(expected(&[], recipe), 0.0);
        let strange: [fn(f64, f64) -> f64; 4] =
            [|_, _| 0.0, |_, _| 1.0, |_, rays| 1.0 / rays, |rows, _| rows];
        for seconds in strange {
            for recipes in
                [&[(0.04, 64)][..], &[(0.04, 64), (0.04, 64)], &[(0.04, 64), (0.04, 512), (0.02, 512)]]
            {
                let expected = expected(&times(seconds, recipes), recipe);
                assert!(expected.is_finite() && expected >= 0.0, "{recipes:?}");
            }
        }
    }
}
