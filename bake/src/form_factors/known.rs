//! What need not be left to chance: pairs of flat patches with nothing between them have closed forms; of others a
//! share of the closed form is seen, and shadow rays from one to the other find it.
//!
//! ```text
//! A_i F_ij = (A_i F_ij)_free * Sum_k c_k V_k / Sum_k c_k
//! c = cos cos / r^2        between points even on both patches
//! c = cos * solid angle    between patches that are near: even on one, even over the solid angle of the other
//! ```
//! Whether a pair is known is decided by geometry and by rays that are not counted, so that neither what is known
//! nor what is left to chance is biased by it. A patch that is bent or has holes is left to chance.

use glam::Vec3;
use rayon::prelude::*;

use super::facet::{Facet, facets};
use super::pairs::{Pair, Sights, pairs};
use super::solid_angle::Spherical;
use crate::BakeError;
use crate::directions::{Sobol, hash, unit};
use crate::emitter::Emitters;
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

/// Shadow rays for each hit that the pair is worth, and their limits.
const SHADOW_RAYS: f64 = 4.0;
const FEWEST: u32 = 8;
const MOST: u32 = 256;
/// Shadow rays that look whether anything is to be seen at all.
const SCOUTS: u32 = 4;
/// Between patches nearer to each other than this many radii of both, c has no bound: one point is even over the
/// other patch's solid angle instead.
const NEAR: f64 = 1.5;
/// What a closed form is off by, in shares of itself.
const CLOSED: f64 = 1e-4;

/// Rows of known entries by patch, columns ascending; symmetric. Pairs worth fewer hits than `least` are left to
/// chance. `is_whole`: by patch, has it no holes?
pub fn known(
    tracer: &Tracer,
    rays: u32,
    least: f64,
    emitters: &Emitters,
    is_whole: impl Fn(usize) -> bool,
) -> Result<Vec<Vec<Known>>, BakeError> {
    let scene = tracer.scene;
    let n = scene.patch_areas.len();
    tracer.watcher.stage("closed forms", 1);
    let slack = f64::from(tracer.bvh.offset());
    let facets = facets(scene, slack, is_whole);
    let sights = Sights {
        facets: &facets,
        things: (0..n as u32).filter(|&i| !scene.patch_back[i as usize]).collect(),
        slack,
        density: scene.patch_areas.iter().map(|area| f64::from(rays) / area).collect(),
        least,
    };
    let shadows = Shadows::new(tracer, &facets);
    let found = pairs(&sights, tracer.watcher, |pair| {
        let [i, j] = pair.patches.map(|i| i as usize);
        let hits = pair.exchange * (sights.density[i] + sights.density[j]);
        if pair.is_free {
            return Some((pair, (CLOSED * CLOSED * hits) as f32));
        }
        // Emitters are sampled towards already.
        let by_chance = emitters.is_emitter[i] == emitters.is_emitter[j];
        let (share, freedom) = by_chance.then(|| shadows.share(&pair, hits)).flatten()?;
        Some((Pair { exchange: pair.exchange * share, ..pair }, freedom))
    })?;
    let mut known: Vec<Vec<Known>> = vec![Vec::new(); n];
    for (Pair { patches: [i, j], exchange, .. }, freedom) in found {
        let freedom = freedom.clamp(LEAST_FREEDOM, 1.0);
        known[i as usize].push(Known { column: j, exchange, freedom });
        known[j as usize].push(Known { column: i, exchange, freedom });
    }
    known.par_iter_mut().for_each(|row| row.sort_unstable_by_key(|known| known.column));
    tracer.watcher.advance(1, 0);
    Ok(known)
}

/// Of what is known best; balancing must be able to close every row.
const LEAST_FREEDOM: f32 = 1e-6;

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

    /// The share of the closed form that is seen, and its freedom; `None` where chance is to find it.
    fn share(&self, pair: &Pair, hits: f64) -> Option<(f64, f32)> {
        let [i, j] = pair.patches.map(|i| self.tracer.scene.patch_keys[i as usize]);
        let key = hash(i ^ hash(j));
        let (seen, _) = self.sample(pair, SCOUTS, key ^ 0x5c07);
        if seen == 0.0 {
            return None;
        }
        let rays = ((SHADOW_RAYS * hits) as u32).clamp(FEWEST, MOST).next_power_of_two();
        let (seen, all) = self.sample(pair, rays, key);
        if all <= 0.0 {
            return None;
        }
        let share = seen / all;
        // As if one more had been half seen.
        let likely = (share * f64::from(rays) + 0.5) / (f64::from(rays) + 1.0);
        Some((share, ((1.0 - likely) * hits / f64::from(rays)) as f32))
    }

    /// Sums of what would be carried and is, and of what would be.
    fn sample(&self, pair: &Pair, rays: u32, key: u64) -> (f64, f64) {
        let [a, b] = pair.patches.map(|i| &self.places[i as usize]);
        let is_near = self.is_near(pair);
        let (mut seen, mut all) = (0.0, 0.0);
        for k in 0..rays {
            let [u, v, s, t] = self.sobol.point(k, key);
            let (from, normal, _) = a.at(u, v);
            let Some((to, facing, carried)) = (if is_near {
                self.towards(pair.patches[1], from, normal, [s, t])
            } else {
                even(b, from, normal, [s, t])
            }) else {
                continue;
            };
            all += carried;
            let chance = unit(hash(key ^ u64::from(k)) as u32);
            if self.tracer.bvh.free_between([from, normal], [to, facing], chance, self.tracer.holes) {
                seen += carried;
            }
        }
        (seen, all)
    }

    fn is_near(&self, pair: &Pair) -> bool {
        let [a, b] = pair.patches.map(|i| self.facets[i as usize].flat.as_ref());
        a.zip(b).is_some_and(|(a, b)| a.centre.distance(b.centre) < NEAR * (a.radius + b.radius))
    }

    /// A point of a near patch, even over its solid angle, its normal, and cos * solid angle.
    fn towards(&self, patch: u32, from: Vec3, normal: Vec3, [s, t]: [f32; 2]) -> Option<(Vec3, Vec3, f64)> {
        let scene = self.tracer.scene;
        let flat = self.facets[patch as usize].flat.as_ref()?;
        let (at, up) = (from.as_dvec3(), normal.as_dvec3());
        let height = flat.height(at);
        if height <= 0.0 {
            return None;
        }
        let triangles = scene.triangles[scene.patch_triangles[patch as usize].clone()].iter();
        let seen: Vec<Spherical> =
            triangles.filter_map(|t| Spherical::new(at, &t.map(|corner| corner.as_dvec3()))).collect();
        let whole: f64 = seen.iter().map(|seen| seen.solid_angle).sum();
        let mut target = f64::from(s) * whole;
        for seen in &seen {
            if target < seen.solid_angle {
                let direction = seen.direction(target / seen.solid_angle, f64::from(t));
                let (cos, fall) = (up.dot(direction), -flat.normal.dot(direction));
                let to = || (at + direction * (height / fall)).as_vec3();
                return (cos > 0.0 && fall > 0.0).then(|| (to(), flat.normal.as_vec3(), cos * whole));
            }
            target -= seen.solid_angle;
        }
        None
    }
}

/// A point of a patch, even by area, its normal, and cos cos / r^2.
fn even(places: &Places, from: Vec3, normal: Vec3, [s, t]: [f32; 2]) -> Option<(Vec3, Vec3, f64)> {
    let (to, facing, _) = places.at(s, t);
    let way = to - from;
    let r2 = way.length_squared();
    let carried = normal.dot(way).max(0.0) * (-facing.dot(way)).max(0.0) / (r2 * r2);
    (carried > 0.0 && carried.is_finite()).then_some((to, facing, f64::from(carried)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Silent;
    use crate::cache::Cache;
    use crate::layout::RayScene;
    use engine::transport::NONE;
    use engine::transport::bvh::{Bvh, Holes};

    const RAYS: u32 = 1 << 16;

    /// Half of each panel is a hole, and of a veil half the light passes.
    struct Half {
        panels: Vec<bool>,
        veils: Vec<bool>,
    }

    impl Holes for Half {
        fn passes(&self, triangle: u32, [v, w]: [f32; 2], chance: f32) -> bool {
            let is = |of: &[bool]| of[triangle as usize];
            is(&self.panels) && v + w < 0.5_f32.sqrt() || is(&self.veils) && chance < 0.5
        }
    }

    fn add(scene: &mut RayScene, corners: [Vec3; 3], double_sided: bool, share: f64) {
        let t = scene.triangles.len();
        scene.triangles.push(corners);
        let mut both = [NONE; 2];
        for (back, patch) in both.iter_mut().enumerate().take(1 + usize::from(double_sided)) {
            *patch = scene.patch_areas.len() as u32;
            let [a, b, c] = corners.map(|corner| corner.as_dvec3());
            scene.patch_areas.push(0.5 * (b - a).cross(c - a).length() * share);
            scene.patch_keys.push(hash(u64::from(*patch)));
            scene.patch_triangles.push(t..t + 1);
            scene.patch_back.push(back == 1);
        }
        scene.patches.push(both);
    }

    /// A closed cube of 48 triangles, each wall in quarters.
    fn cube(scene: &mut RayScene) {
        for axis in [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z] {
            let (u, v) = axis.any_orthonormal_pair();
            for (x, y) in [(-1.0, -1.0), (0.0, -1.0), (-1.0, 0.0), (0.0, 0.0)] {
                let at = |i: f32, j: f32| -axis + u * (x + i) + v * (y + j);
                add(scene, [at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0)], false, 1.0);
                add(scene, [at(0.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)], false, 1.0);
            }
        }
    }

    /// A leaf, a one-sided fin, a panel and a veil.
    fn furniture(scene: &mut RayScene) {
        let at = |x: f32, y: f32, z: f32| Vec3::new(x, y, z);
        add(scene, [at(0.1, -0.2, 0.1), at(0.7, 0.1, 0.2), at(0.2, 0.4, 0.5)], true, 1.0);
        add(scene, [at(-0.6, -1.0, -0.2), at(0.1, -1.0, -0.4), at(-0.3, -0.1, -0.3)], false, 1.0);
        add(scene, [at(-0.7, 0.5, -0.6), at(0.3, 0.5, -0.7), at(-0.2, 0.6, 0.5)], true, 0.5);
        add(scene, [at(-0.8, -0.5, 0.3), at(-0.2, -0.6, 0.8), at(-0.6, 0.2, 0.6)], true, 0.5);
    }

    #[test]
    fn what_is_known_is_what_rays_find_among_leaves_holes_and_veils() {
        let mut scene = RayScene::default();
        cube(&mut scene);
        let walls = scene.triangles.len();
        furniture(&mut scene);
        let only = |k: usize| (0..scene.triangles.len()).map(|t| t == k).collect::<Vec<bool>>();
        let holes = Half { panels: only(walls + 2), veils: only(walls + 3) };
        let holed: Vec<bool> =
            (0..scene.triangles.len()).map(|t| holes.panels[t] || holes.veils[t]).collect();
        let bvh = Bvh::new(&scene.triangles, holed.clone());
        let tracer = Tracer { scene: &scene, bvh: &bvh, holes: &holes, watcher: &Silent };
        let hits = tracer.patch_rows(RAYS, &Cache::none()).unwrap();
        let n = scene.patch_areas.len();
        let emitters = Emitters::choose(&scene, &vec![false; n]);
        let is_whole = |i: usize| !holed[scene.patch_triangles[i].start];
        let known = known(&tracer, RAYS, 0.0, &emitters, is_whole).unwrap();
        let (mut worst, mut square, mut count) = (0.0_f64, 0.0, 0);
        for (i, row) in known.iter().enumerate() {
            for entry in row {
                let found = hits.row(i).find(|hit| hit.0 == entry.column).map_or(0, |hit| hit.1);
                let found = f64::from(found) / f64::from(RAYS);
                let share = entry.exchange / scene.patch_areas[i];
                // Of rays; shadow rays have a share of it.
                let variance = share * (1.0 - share) / f64::from(RAYS);
                let off = (found - share) / (variance * (1.0 + f64::from(entry.freedom)) + 1e-14).sqrt();
                assert!(off.abs() < 4.0, "{i} to {}: {share}, rays {found}: {off} sigma", entry.column);
                worst = worst.max(off.abs());
                square += off * off;
                count += 1;
            }
        }
        let rms = (square / f64::from(count)).sqrt();
        println!("{count} entries, worst {worst:.1} sigma, rms {rms:.2}");
        assert!(count > 1000 && rms < 1.1);
        // Nothing is known of what has holes.
        assert!((0..n).filter(|&i| !is_whole(i)).all(|i| known[i].is_empty()));
    }
}
