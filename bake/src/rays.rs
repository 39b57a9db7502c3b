//! The one kernel of the bake: the histogram of what a point's rays hit.
//!
//! A ray that leaves hits a sky patch; one that hits a back face, or leaves where there is no sky, is lost.
//! Counts are integers and each row is one task's: the result is the same for any number of threads.

use engine::transport::sky;
use glam::Vec3;
use rayon::prelude::*;

use crate::cache::Cache;
use crate::directions::{Sobol, cosine_direction, frame, hash, unit};
use crate::layout::{Places, RayScene};
use crate::{BakeError, Watcher};
use engine::transport::bvh::{Bvh, Holes, patch_of};

/// What a row's rays hit: columns ascending, with counts. All rows have the same number of rays.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hits {
    pub starts: Vec<usize>,
    pub columns: Vec<u32>,
    pub counts: Vec<u32>,
    /// By row: rays that met back faces.
    pub lost: Vec<u32>,
    /// By row: rays that left where there is no sky.
    pub escaped: Vec<u32>,
}

/// One row of [`Hits`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Row {
    pub hits: Vec<(u32, u32)>,
    pub lost: u32,
    pub escaped: u32,
}

/// What a ray met.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seen {
    /// A patch, or a sky patch.
    Column(u32),
    /// A back face.
    Back,
    /// Nothing, where there is no sky.
    Nothing,
}

impl Hits {
    pub fn len(&self) -> usize {
        self.lost.len()
    }

    pub fn row(&self, i: usize) -> impl Iterator<Item = (u32, u32)> + Clone + '_ {
        let range = self.starts[i]..self.starts[i + 1];
        self.columns[range.clone()].iter().copied().zip(self.counts[range].iter().copied())
    }

    fn of(rows: impl IntoIterator<Item = Row>) -> Self {
        let mut hits = Self { starts: vec![0], ..Self::default() };
        for row in rows {
            hits.columns.extend(row.hits.iter().map(|hit| hit.0));
            hits.counts.extend(row.hits.iter().map(|hit| hit.1));
            hits.starts.push(hits.columns.len());
            hits.lost.push(row.lost);
            hits.escaped.push(row.escaped);
        }
        hits
    }
}

/// Rows that are traced, kept and cancelled together.
const CHUNK: usize = 32;

/// What every trace needs.
pub struct Tracer<'a> {
    pub scene: &'a RayScene,
    pub bvh: &'a Bvh,
    pub holes: &'a dyn Holes,
    pub watcher: &'a dyn Watcher,
}

impl Tracer<'_> {
    /// A row for each patch: from points on it, even by area.
    pub fn patch_rows(&self, rays: u32, cache: &Cache) -> Result<Hits, BakeError> {
        self.watcher.stage("patch rows", self.scene.patch_areas.len() as u64);
        self.rows(self.scene.patch_areas.len(), rays, cache, |i, sobol, counter| {
            if self.scene.covered.get(i) == Some(&true) {
                counter.lost = rays;
                return;
            }
            let places = Places::of(self.scene, i);
            let key = self.scene.patch_keys[i];
            for ray in 0..rays {
                let [a, b, c, d] = sobol.point(ray, key);
                let (position, normal, _) = places.at(c, d);
                self.count(position, normal, cosine_direction(a, b), hash(key ^ u64::from(ray)), counter);
            }
        })
    }

    /// A row for each receiver: from its point.
    pub fn receiver_rows(&self, rays: u32, cache: &Cache) -> Result<Hits, BakeError> {
        self.watcher.stage("receiver rows", self.scene.receivers.len() as u64);
        self.rows(self.scene.receivers.len(), rays, cache, |i, sobol, counter| {
            self.receiver(i, rays, sobol, counter)
        })
    }

    fn receiver(&self, i: usize, rays: u32, sobol: &Sobol, counter: &mut Counter) {
        let place = &self.scene.receivers[i];
        for ray in 0..rays {
            let [a, b, ..] = sobol.point(ray, place.key);
            let chance = hash(place.key ^ u64::from(ray));
            self.count(place.position.as_vec3(), place.normal, cosine_direction(a, b), chance, counter);
        }
    }

    /// How many entries some receivers' rows have in all; on this thread, to be timed.
    pub fn sample_receivers(&self, receivers: &[usize], rays: u32) -> usize {
        let sobol = Sobol::new(rays);
        let mut counter = Counter::new(self.scene.columns());
        let entries = |&i: &usize| {
            self.receiver(i, rays, &sobol, &mut counter);
            counter.take().hits.len()
        };
        receivers.iter().map(entries).sum()
    }

    fn rows(
        &self,
        rows: usize,
        rays: u32,
        cache: &Cache,
        row: impl Fn(usize, &Sobol, &mut Counter) + Sync,
    ) -> Result<Hits, BakeError> {
        let sobol = Sobol::new(rays);
        let chunks: Vec<usize> = (0..rows.div_ceil(CHUNK)).collect();
        let traced: Result<Vec<Vec<Row>>, BakeError> = chunks
            .par_iter()
            .map_init(
                || Counter::new(self.scene.columns()),
                |counter, &chunk| {
                    let range = chunk * CHUNK..rows.min((chunk + 1) * CHUNK);
                    if let Some(kept) = cache.chunk(chunk).filter(|kept| kept.len() == range.len()) {
                        self.watcher.advance(range.len() as u64, 0);
                        return Ok(kept);
                    }
                    let mut finished = Vec::with_capacity(CHUNK);
                    for i in range {
                        if self.watcher.cancelled() {
                            return Err(BakeError::Cancelled);
                        }
                        row(i, &sobol, counter);
                        finished.push(counter.take());
                        self.watcher.advance(1, u64::from(rays));
                    }
                    cache.keep(chunk, &finished);
                    Ok(finished)
                },
            )
            .collect();
        Ok(Hits::of(traced?.into_iter().flatten()))
    }

    /// One ray from a surface, its direction given about +Z.
    fn count(&self, position: Vec3, normal: Vec3, local: Vec3, chance: u64, counter: &mut Counter) {
        let (x, y) = frame(normal);
        let direction = x * local.x + y * local.y + normal * local.z;
        counter.add(self.column(position, normal, direction, unit(chance as u32)));
    }

    /// What a ray meets.
    pub fn column(&self, position: Vec3, normal: Vec3, direction: Vec3, chance: f32) -> Seen {
        match self.bvh.closest(position, normal, direction, chance, self.holes) {
            Some(hit) => patch_of(&hit, &self.scene.patches).map_or(Seen::Back, Seen::Column),
            None if self.scene.sky_patches > 0 => {
                Seen::Column(self.scene.patch_areas.len() as u32 + sky::patch_of(direction))
            }
            None => Seen::Nothing,
        }
    }
}

/// Counts of one row: dense, with a list of what was touched.
struct Counter {
    counts: Vec<u32>,
    touched: Vec<u32>,
    lost: u32,
    escaped: u32,
}

impl Counter {
    fn new(columns: usize) -> Self {
        Self { counts: vec![0; columns], touched: Vec::new(), lost: 0, escaped: 0 }
    }

    fn add(&mut self, seen: Seen) {
        let column = match seen {
            Seen::Column(column) => column,
            Seen::Back => {
                self.lost += 1;
                return;
            }
            Seen::Nothing => {
                self.escaped += 1;
                return;
            }
        };
        let count = &mut self.counts[column as usize];
        if *count == 0 {
            self.touched.push(column);
        }
        *count += 1;
    }

    fn take(&mut self) -> Row {
        self.touched.sort_unstable();
        let hits = self
            .touched
            .drain(..)
            .map(|column| (column, std::mem::take(&mut self.counts[column as usize])))
            .collect();
        Row { hits, lost: std::mem::take(&mut self.lost), escaped: std::mem::take(&mut self.escaped) }
    }
}
