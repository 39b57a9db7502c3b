//! What need not be left to chance: pairs of flat patches with nothing between them have closed forms; of others that
//! are not too near each other, a share of the closed form is seen, and shadow rays from one to the other find it.
//!
//! ```text
//! A_i F_ij = (A_i F_ij)_free * Sum_k c_k V_k / Sum_k c_k        c = cos cos / r^2 between points even on both
//! ```
//! Whether a pair is known is decided by geometry and by rays that are not counted, so that neither what is known
//! nor what is left to chance is biased by it.

use rayon::prelude::*;

use super::facet::{Facet, Flat, facets};
use super::pairs::{Pair, Sights, pairs};
use crate::BakeError;
use crate::directions::{Sobol, hash, unit};
use crate::layout::Places;
use crate::rays::Tracer;

/// An entry that is known from elsewhere than from what rays hit by chance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Known {
    pub column: u32,
    /// A_i F_ij, scaled units squared.
    pub exchange: f64,
    /// Its variance over that of rays: how freely balancing may change it.
    pub freedom: f32,
}

/// Pairs worth fewer hits than this are left to chance.
const LEAST_HITS: f64 = 0.5;
/// Of those with something between, fewer than this.
const LEAST_HITS_SAMPLED: f64 = 0.5;
/// Shadow rays for each hit that the pair is worth, and their limits.
const SHADOW_RAYS: f64 = 2.0;
const FEWEST: u32 = 8;
const MOST: u32 = 256;
/// Shadow rays that look whether anything is to be seen at all.
const SCOUTS: u32 = 4;
/// Patches nearer to each other than this many radii are left to chance: between points close to each other
/// c has no bound.
const NEAR: f64 = 1.5;
/// What a closed form may be off by.
const CLOSED: f64 = 1e-3;

/// By patch, columns ascending; symmetric.
pub fn known(
    tracer: &Tracer,
    rays: u32,
    is_whole: impl Fn(usize) -> bool,
) -> Result<Vec<Vec<Known>>, BakeError> {
    let scene = tracer.scene;
    let n = scene.patch_areas.len();
    tracer.watcher.stage("closed forms", 1);
    let facets = facets(scene, is_whole);
    let things: Vec<u32> = (0..n as u32).filter(|&i| !scene.patch_back[i as usize]).collect();
    let density: Vec<f64> = scene.patch_areas.iter().map(|area| f64::from(rays) / area).collect();
    let sights =
        Sights { facets: &facets, things, slack: f64::from(tracer.bvh.offset()), density, least: LEAST_HITS };
    let shadows = Shadows::new(tracer, &facets);
    let found = pairs(&sights, tracer.watcher, |pair| {
        let [i, j] = pair.patches.map(|i| i as usize);
        let hits = pair.exchange * (sights.density[i] + sights.density[j]);
        if pair.is_free {
            Some((pair.patches, pair.exchange, (CLOSED * CLOSED * hits) as f32))
        } else {
            let (share, freedom) = shadows.share(&pair, hits)?;
            Some((pair.patches, pair.exchange * share, freedom))
        }
    })?;
    let mut known: Vec<Vec<Known>> = vec![Vec::new(); n];
    for ([i, j], exchange, freedom) in found {
        let freedom = freedom.clamp(1e-6, 1.0);
        known[i as usize].push(Known { column: j, exchange, freedom });
        known[j as usize].push(Known { column: i, exchange, freedom });
    }
    known.par_iter_mut().for_each(|row| row.sort_unstable_by_key(|known| known.column));
    tracer.watcher.advance(1, 0);
    Ok(known)
}

/// Shadow rays from patch to patch.
struct Shadows<'a> {
    tracer: &'a Tracer<'a>,
    facets: &'a [Facet],
    places: Vec<Places<'a>>,
    sobol: Sobol,
}

impl<'a> Shadows<'a> {
    fn new(tracer: &'a Tracer<'a>, facets: &'a [Facet]) -> Self {
        let places = (0..facets.len()).map(|i| Places::of(tracer.scene, i)).collect();
        Self { tracer, facets, places, sobol: Sobol::new(MOST) }
    }

    /// The share of the closed form that is seen and its freedom; `None` where chance is to find it.
    fn share(&self, pair: &Pair, hits: f64) -> Option<(f64, f32)> {
        let flat = |i: u32| self.facets[i as usize].flat.as_ref();
        let [a, b] = [flat(pair.patches[0])?, flat(pair.patches[1])?];
        if hits < LEAST_HITS_SAMPLED || is_near(a, b) {
            return None;
        }
        let [i, j] = pair.patches.map(|i| self.tracer.scene.patch_keys[i as usize]);
        let key = hash(i ^ hash(j));
        let (seen, _) = self.sample(pair, SCOUTS, key ^ 0x5c07);
        if seen == 0.0 {
            return None;
        }
        let rays = ((SHADOW_RAYS * hits) as u32).next_power_of_two().clamp(FEWEST, MOST);
        let (seen, all) = self.sample(pair, rays, key);
        if all <= 0.0 {
            return None;
        }
        let share = seen / all;
        // As if one more had been half seen.
        let likely = (share * f64::from(rays) + 0.5) / (f64::from(rays) + 1.0);
        Some((share, ((1.0 - likely) * hits / f64::from(rays)) as f32))
    }

    /// Sums of c V and c.
    fn sample(&self, pair: &Pair, rays: u32, key: u64) -> (f64, f64) {
        let [a, b] = pair.patches.map(|i| &self.places[i as usize]);
        let (mut seen, mut all) = (0.0, 0.0);
        for k in 0..rays {
            let [u, v, s, t] = self.sobol.point(k, key);
            let ((from, normal, _), (to, facing, _)) = (a.at(u, v), b.at(s, t));
            let way = to - from;
            let r2 = way.length_squared();
            let carried = normal.dot(way).max(0.0) * (-facing.dot(way)).max(0.0) / (r2 * r2);
            if carried > 0.0 && carried.is_finite() {
                all += f64::from(carried);
                let chance = unit(hash(key ^ u64::from(k)) as u32);
                if self.tracer.bvh.visible(from, normal, to, chance, self.tracer.holes) {
                    seen += f64::from(carried);
                }
            }
        }
        (seen, all)
    }
}

fn is_near(a: &Flat, b: &Flat) -> bool {
    a.centre.distance(b.centre) < NEAR * (a.radius + b.radius)
}
