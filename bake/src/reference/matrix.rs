//! The radiosity model as such, for the patches of a bake: nothing sparse, nothing in f32, nothing left early.
//!
//! ```text
//! S_ij = (h_ij + h_ji) / (R / A_i + R / A_j)        h_ij: of R rays from patch i, cosine-distributed, hits on patch j
//! P_ij = d_i S_ij d_j / A_i                         closed to rounding (closing.rs)
//! B = E + rho P B                                   solved to rounding (solve.rs)
//! E(x) = Sum_j F_xj B_j                             by rays of its own from point x
//! ```
//! Small lamps are found by chance like all else: use many rays.

use engine::scene::Scene;
use engine::scene::assets::Assets;
use engine::transport::bvh::{Bvh, patch_of};
use engine::transport::materials::of_patches;
use engine::transport::{NONE, Surface, Transport, sky};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::closing::{Pooled, close, row_of};
use super::place::places;
use super::solve::solve;
use crate::directions::{Sobol, cosine_direction, frame, hash, hash_of, in_triangle, unit};
use crate::holes::AlphaHoles;
use crate::{BakeError, Point, Watcher};

/// Bytes that the matrix and its counts may take.
const MOST_BYTES: f64 = 2e9;

/// Dense form factors of a bake's patches: see the head of this file.
pub struct MatrixReference {
    /// n x columns, row-major.
    matrix: Vec<f64>,
    columns: usize,
    areas: Vec<f64>,
    albedo: Vec<DVec3>,
    defect: f64,
    rays: Rays,
}

/// What rays start from and meet [m].
struct Rays {
    scene: Scene,
    assets: Assets,
    surface: Surface,
    triangles: Vec<[Vec3; 3]>,
    bvh: Bvh,
    patches: usize,
    sky_patches: u32,
    origin: DVec3,
}

impl MatrixReference {
    /// From so many rays a patch. An error where the matrix does not fit into 2 GB.
    pub fn new(
        scene: &Scene,
        assets: &Assets,
        transport: &Transport,
        rays: u32,
        seed: u64,
        watcher: &dyn Watcher,
    ) -> Result<Self, BakeError> {
        let (n, columns) = (transport.patches.len(), transport.columns());
        let bytes = (n * columns) as f64 * 12.0;
        if bytes > MOST_BYTES {
            let message = format!(
                "a dense matrix of {n} patches needs {:.1} GB, more than {:.1} GB: bake with longer patches",
                bytes * 1e-9,
                MOST_BYTES * 1e-9
            );
            return Err(BakeError::Other(message));
        }
        let traced = Rays::new(scene, assets, transport);
        let areas: Vec<f64> = transport.patches.iter().map(|patch| f64::from(patch.area)).collect();
        watcher.stage("matrix reference", n as u64);
        let hits = traced.hits(transport, rays, seed, watcher)?;
        let (mut matrix, slack) = pool(&hits, columns, rays, &areas);
        drop(hits);
        let (d, defect) = close(&Pooled { matrix: &matrix, columns, slack: &slack, areas: &areas });
        scale(&mut matrix, columns, &d, &areas);
        let albedo = of_patches(transport, scene, assets).albedo;
        let albedo = albedo.into_iter().map(Vec3::as_dvec3).collect();
        Ok(Self { matrix, columns, areas, albedo, defect, rays: traced })
    }

    /// Row i, patch i's shares of the light that arrives there: `columns` of them, patches then sky patches.
    pub fn matrix(&self) -> &[f64] {
        &self.matrix
    }

    pub fn columns(&self) -> usize {
        self.columns
    }

    /// How far the worst row with what it loses is from 1, relative: rounding, but where hits leave no way to close.
    pub fn defect(&self) -> f64 {
        self.defect
    }

    /// B by patch from E (emission, and what punctual lights and sky send at once, reflected) [W/m2], with the scene's
    /// albedo.
    pub fn solve(&self, e: &[DVec3]) -> Vec<DVec3> {
        self.solve_with(&self.albedo, e)
    }

    /// The same with another albedo.
    pub fn solve_with(&self, albedo: &[DVec3], e: &[DVec3]) -> Vec<DVec3> {
        let mut b = vec![DVec3::ZERO; e.len()];
        for channel in 0..3 {
            let rho: Vec<f64> = albedo.iter().map(|albedo| albedo[channel]).collect();
            let e: Vec<f64> = e.iter().map(|e| e[channel]).collect();
            let found = solve(&self.matrix, self.columns, &self.areas, &rho, &e);
            b.iter_mut().zip(found).for_each(|(b, found)| b[channel] = found);
        }
        b
    }

    /// Irradiance of patches from radiosity in all columns (of sky patches pi * radiance) [W/m2].
    pub fn gather(&self, values: &[DVec3]) -> Vec<DVec3> {
        let row =
            |i: usize| row_of(&self.matrix, self.columns, i).iter().zip(values).map(|(f, b)| *b * *f).sum();
        (0..self.areas.len()).into_par_iter().map(row).collect()
    }

    /// Irradiance at points from radiosity in all columns, by so many rays a point [W/m2].
    pub fn irradiance(
        &self,
        points: &[Point],
        values: &[DVec3],
        rays: u32,
        seed: u64,
        watcher: &dyn Watcher,
    ) -> Result<Vec<DVec3>, BakeError> {
        let has_side = |t: usize, back: bool| self.rays.surface.patches[t][usize::from(back)] != NONE;
        let places = places(points, self.rays.origin, &self.rays.triangles, has_side)?;
        let sobol = Sobol::new(rays);
        let holes = self.rays.holes();
        watcher.stage("matrix reference at points", points.len() as u64);
        let gathered = |place: &super::place::Place| {
            if watcher.cancelled() {
                return Err(BakeError::Cancelled);
            }
            let seed = hash_of(place.position.to_array().map(|x| u64::from(x.to_bits()))) ^ hash(seed);
            let arriving = |ray: u32| {
                let [a, b, ..] = sobol.point(ray, seed);
                let column = self.rays.column(place.position, place.normal, [a, b], (seed, ray), &holes);
                column.map_or(DVec3::ZERO, |column| values[column])
            };
            let sum: DVec3 = (0..rays).map(arriving).sum();
            watcher.advance(1, u64::from(rays));
            Ok(sum / f64::from(rays))
        };
        places.par_iter().map(gathered).collect()
    }
}

impl Rays {
    fn new(scene: &Scene, assets: &Assets, transport: &Transport) -> Self {
        let surface = transport.surface.clone();
        let triangles: Vec<[Vec3; 3]> = (0..surface.triangles.len()).map(|t| surface.positions(t)).collect();
        let holed = AlphaHoles::new(&surface, scene, assets).holed();
        Self {
            scene: scene.clone(),
            assets: assets.clone(),
            bvh: Bvh::new(&triangles, holed),
            triangles,
            surface,
            patches: transport.patches.len(),
            sky_patches: transport.sky_patches,
            origin: transport.origin,
        }
    }

    fn holes(&self) -> AlphaHoles<'_> {
        AlphaHoles::new(&self.surface, &self.scene, &self.assets)
    }

    /// The patch or sky patch that a ray meets; none where it is lost.
    fn column(
        &self,
        position: Vec3,
        normal: Vec3,
        [a, b]: [f32; 2],
        (seed, ray): (u64, u32),
        holes: &AlphaHoles,
    ) -> Option<usize> {
        let (x, y) = frame(normal);
        let local = cosine_direction(a, b);
        let direction = x * local.x + y * local.y + normal * local.z;
        let chance = unit(hash(seed ^ u64::from(ray)) as u32);
        match self.bvh.closest(position, normal, direction, chance, holes) {
            Some(hit) => patch_of(&hit, &self.surface.patches).map(|patch| patch as usize),
            None if self.sky_patches > 0 => Some(self.patches + sky::patch_of(direction) as usize),
            None => None,
        }
    }

    /// Counts, n x columns.
    fn hits(
        &self,
        transport: &Transport,
        rays: u32,
        seed: u64,
        watcher: &dyn Watcher,
    ) -> Result<Vec<u32>, BakeError> {
        let sobol = Sobol::new(rays);
        let holes = self.holes();
        let mut hits = vec![0_u32; transport.patches.len() * transport.columns()];
        let rows = hits.par_chunks_mut(transport.columns().max(1)).zip(&transport.patches).enumerate();
        rows.try_for_each(|(i, (row, patch))| {
            if watcher.cancelled() {
                return Err(BakeError::Cancelled);
            }
            let seed = hash_of([seed, i as u64]);
            let range = patch.first_triangle as usize..(patch.first_triangle + patch.triangle_count) as usize;
            let starts = Starts::new(&self.triangles[range], patch.back == 1);
            for ray in 0..rays {
                let [a, b, c, d] = sobol.point(ray, seed);
                let (position, normal) = starts.at(c, d);
                if let Some(column) = self.column(position, normal, [a, b], (seed, ray), &holes) {
                    row[column] += 1;
                }
            }
            watcher.advance(1, u64::from(rays));
            Ok(())
        })?;
        Ok(hits)
    }
}

/// Points of a patch, even by area.
struct Starts<'a> {
    triangles: &'a [[Vec3; 3]],
    /// Running area, twice.
    sums: Vec<f64>,
    side: f32,
}

impl<'a> Starts<'a> {
    fn new(triangles: &'a [[Vec3; 3]], back: bool) -> Self {
        let area = |sum: &mut f64, [a, b, c]: &[Vec3; 3]| {
            *sum += f64::from((*b - *a).cross(*c - *a).length());
            Some(*sum)
        };
        let sums = triangles.iter().scan(0.0, area).collect();
        Self { triangles, sums, side: if back { -1.0 } else { 1.0 } }
    }

    /// A place and its triangle's normal.
    fn at(&self, u: f32, v: f32) -> (Vec3, Vec3) {
        let target = f64::from(u) * self.sums.last().copied().unwrap_or(0.0);
        let k = self.sums.partition_point(|&sum| sum <= target).min(self.sums.len() - 1);
        let before = if k == 0 { 0.0 } else { self.sums[k - 1] };
        let within = ((target - before) / (self.sums[k] - before)) as f32;
        let [a, b, c] = self.triangles[k];
        let (p, q) = in_triangle(within.clamp(0.0, 1.0), v);
        let normal = (b - a).cross(c - a).normalize_or(Vec3::Y) * self.side;
        (a + (b - a) * p + (c - a) * q, normal)
    }
}

/// S and what leaves it, from counts: columns of sky patches hold what goes there, slack all that goes to no patch;
/// both in area.
fn pool(hits: &[u32], columns: usize, rays: u32, areas: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let n = areas.len();
    let rays = f64::from(rays);
    let mut matrix = vec![0.0; n * columns];
    matrix.par_chunks_mut(columns.max(1)).enumerate().for_each(|(i, row)| {
        for (j, value) in row.iter_mut().enumerate() {
            let there = f64::from(hits[i * columns + j]);
            *value = match areas.get(j) {
                Some(area) => (there + f64::from(hits[j * columns + i])) / (rays / areas[i] + rays / area),
                None => there * areas[i] / rays,
            };
        }
    });
    let on_patches =
        |i: usize| row_of(hits, columns, i)[..n].iter().map(|&count| f64::from(count)).sum::<f64>();
    let slack = (0..n).map(|i| (rays - on_patches(i)) / rays * areas[i]).collect();
    (matrix, slack)
}

/// Shares from S and d.
fn scale(matrix: &mut [f64], columns: usize, d: &[f64], areas: &[f64]) {
    matrix.par_chunks_mut(columns.max(1)).enumerate().for_each(|(i, row)| {
        for (j, value) in row.iter_mut().enumerate() {
            *value *= d[i] * d.get(j).copied().unwrap_or(d[i]) / areas[i];
        }
    });
}
