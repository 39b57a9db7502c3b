//! The one kernel of the bake: the histogram of what a point's rays hit.
//!
//! A ray that leaves hits a sky patch; one that hits a back face, or leaves where there is no sky, is lost.
//! Counts are integers and each row is one task's: the result is the same for any number of threads.

use engine::transport::sky;
use glam::Vec3;
use rayon::prelude::*;

use crate::bvh::{Bvh, Holes, patch_of};
use crate::cache::Cache;
use crate::directions::{Sobol, cosine_direction, frame, hash, unit};
use crate::layout::{Places, RayScene};
use crate::{BakeError, Watcher};

/// What a row's rays hit: columns ascending, with counts. All rows have the same number of rays.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hits {
    pub starts: Vec<usize>,
    pub columns: Vec<u32>,
    pub counts: Vec<u32>,
    /// By row.
    pub lost: Vec<u32>,
}

/// One row of [`Hits`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Row {
    pub hits: Vec<(u32, u32)>,
    pub lost: u32,
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
            let places = Places::of(self.scene, i);
            let key = self.scene.patch_keys[i];
            for ray in 0..rays {
                let [a, b, c, d] = sobol.point(ray, key);
                let (position, normal, _) = places.at(a, b);
                self.count(position, normal, cosine_direction(c, d), hash(key ^ u64::from(ray)), counter);
            }
        })
    }

    /// A row for each receiver: from its point.
    pub fn receiver_rows(&self, rays: u32, cache: &Cache) -> Result<Hits, BakeError> {
        self.watcher.stage("receiver rows", self.scene.receivers.len() as u64);
        self.rows(self.scene.receivers.len(), rays, cache, |i, sobol, counter| {
            let place = &self.scene.receivers[i];
            for ray in 0..rays {
                let [a, b, ..] = sobol.point(ray, place.key);
                let chance = hash(place.key ^ u64::from(ray));
                self.count(place.position.as_vec3(), place.normal, cosine_direction(a, b), chance, counter);
            }
        })
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
                    if let Some(kept) = cache.chunk(chunk) {
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

    /// What a ray hits: a column, or `None` where its light is lost.
    pub fn column(&self, position: Vec3, normal: Vec3, direction: Vec3, chance: f32) -> Option<u32> {
        match self.bvh.closest(position, normal, direction, chance, self.holes) {
            Some(hit) => patch_of(&hit, &self.scene.patches),
            None if self.scene.sky_patches > 0 => {
                Some(self.scene.patch_areas.len() as u32 + sky::patch_of(direction))
            }
            None => None,
        }
    }
}

/// Counts of one row: dense, with a list of what was touched.
struct Counter {
    counts: Vec<u32>,
    touched: Vec<u32>,
    lost: u32,
}

impl Counter {
    fn new(columns: usize) -> Self {
        Self { counts: vec![0; columns], touched: Vec::new(), lost: 0 }
    }

    fn add(&mut self, column: Option<u32>) {
        let Some(column) = column else {
            self.lost += 1;
            return;
        };
        let count = &mut self.counts[column as usize];
        if *count == 0 {
            self.touched.push(column);
        }
        *count += 1;
    }

    fn take(&mut self) -> Row {
        self.touched.sort_unstable();
        let hits = self.touched.drain(..).map(|column| (column, std::mem::take(&mut self.counts[column as usize]))).collect();
        Row { hits, lost: std::mem::take(&mut self.lost) }
    }
}
