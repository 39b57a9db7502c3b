//! THE bake, read from top to bottom: patches, receivers, probes, rays, balanced rows, certificate.

use std::path::Path;

use engine::scene::assets::Assets;
use engine::scene::{Entity, EntityId, MaterialId, Scene, Warning};
use engine::transport::key::BakeWith;
pub use engine::transport::needs::PROBE_RAYS;
use engine::transport::packed::fold;
use engine::transport::sh::COEFFICIENTS;
use engine::transport::{Certificate, Probe, Rows, Transport};
use glam::Vec3;
use rayon::prelude::*;

use crate::balance::{balanced_rows, cap};
use crate::cache::Cache;
use crate::certify::certify_rows;
use crate::depth::depths;
use crate::directions::{Sobol, hash, hash_of, sphere_direction, unit};
use crate::emitter::{Emitters, Towards, patches_towards_emitters, receivers_towards_emitters};
use crate::holes::AlphaHoles;
use crate::layout::{Layout, RayScene, layout};
use crate::overlap::covered;
use crate::probe::{ProbeRow, probe_row};
use crate::rays::{Hits, Seen, Tracer};
use crate::receiver::{mark_receivers, valid};
use crate::surface::Surface;
use crate::{BakeError, Watcher, aggregate, directional};
use engine::transport::bvh::Bvh;

/// A point that meets back faces with more than this share of its rays lies inside something.
pub const INSIDE: f64 = 0.25;

/// Where rows are kept while they are traced.
pub struct Caches {
    pub patch: Cache,
    pub receiver: Cache,
}

impl Caches {
    pub fn none() -> Self {
        Self { patch: Cache::none(), receiver: Cache::none() }
    }

    pub fn open(folder: &Path, key: &str) -> Self {
        let key = &key[..key.len().min(32)];
        Self { patch: Cache::open(folder, "patch", key), receiver: Cache::open(folder, "receiver", key) }
    }

    pub fn delete(&self) {
        self.patch.delete();
        self.receiver.delete();
    }
}

/// A scene's transport with its rows, and the part of its certificate that no material decides.
pub fn make(
    scene: &Scene,
    assets: &Assets,
    surface: &Surface,
    with: &BakeWith,
    caches: &Caches,
    watcher: &dyn Watcher,
) -> Result<(Transport, Vec<Warning>), BakeError> {
    watcher.stage("patches and receivers", 1);
    let Layout { mut transport, mut rays, directional, dropped_triangles, mut warnings } =
        layout(scene, assets, surface, with.length, watcher)?;
    watcher.advance(1, 0);

    let holes = AlphaHoles::new(&transport.surface, scene, assets);
    let bvh = Bvh::new(&rays.triangles, holes.holed());
    rays.covered = covered(&rays, &bvh, &holes.holed());
    warnings.extend(warnings_of_covered(scene, &transport, &rays.covered));
    let emitters = emitters(scene, &transport, &rays);
    let tracer = Tracer { scene: &rays, bvh: &bvh, holes: &holes, watcher };

    let patch_hits = tracer.patch_rows(with.rays, &caches.patch)?;
    let patches_towards = patches_towards_emitters(&tracer, &emitters)?;
    let receiver_hits = tracer.receiver_rows(with.rays, &caches.receiver)?;
    let receivers_towards = receivers_towards_emitters(&tracer, &emitters)?;
    let receiver_from_patch = receiver_rows(&receiver_hits, with.rays, &emitters, &receivers_towards);
    let valid = valid(&receiver_hits, with.rays);
    let directional_from_patch =
        directional::rows(&tracer, &emitters, &receiver_from_patch, &valid[..directional], with.rays)?;
    let probe_rows = probe_rows(&tracer, &emitters)?;
    mark_probes(&mut transport.probes, &probe_rows);
    transport.depths = depths(&tracer, &transport, surface.unit);
    add_probe_rows(&mut transport.probe_from_patch, probe_rows);

    // Closed forms for pairs with nothing between them ([`crate::form_factors`]) would make the matrix several times as
    // right, and no irradiance better: the error of chance is averaged away. They cost a fifth to two fifths of a bake.
    let known = vec![Vec::new(); rays.patch_areas.len()];

    watcher.stage("balance", 1);
    let areas = &rays.patch_areas;
    let (rows, targets, balance) =
        balanced_rows(&patch_hits, with.rays, areas, &emitters, &patches_towards, &known, watcher)?;
    transport.patch_from_patch = rows;
    transport.patches.iter_mut().zip(targets).for_each(|(patch, target)| patch.target = target);
    transport.receiver_from_patch = receiver_from_patch;
    transport.directional_from_patch = directional_from_patch;
    mark_receivers(&mut transport, &valid);
    aggregate::mark(&mut transport.patches, &transport.patch_from_patch, watcher);
    watcher.advance(1, 0);

    let rays_of = |rows: usize| rows as u64 * u64::from(with.rays);
    let kept = caches.patch.kept_rows() + caches.receiver.kept_rows();
    let probe_rays = transport.probes.len() as u64 * u64::from(PROBE_RAYS);
    let rays_in_all = rays_of(patch_hits.len() + receiver_hits.len() + directional) + probe_rays;
    let area: f64 = rays.patch_areas.iter().sum();
    let share = |counts: &dyn Fn(usize) -> u32| -> f64 {
        let weighted = (0..patch_hits.len()).map(|i| rays.patch_areas[i] * f64::from(counts(i)));
        if area > 0.0 { weighted.sum::<f64>() / (area * f64::from(with.rays)) } else { 0.0 }
    };
    transport.certificate = Certificate {
        quality: with.quality.to_string(),
        rays_per_row: with.rays,
        base_length: with.length,
        rays: rays_in_all,
        rays_traced: rays_in_all - rays_of(kept),
        row_sum_defect_raw: balance.defect_raw,
        lost: share(&|i| patch_hits.lost[i]),
        escaped: share(&|i| patch_hits.escaped[i] + sky_hits(&patch_hits, i, rays.patch_areas.len())),
        dropped_triangles,
        ..counts(&transport)
    };
    let mut certificate = std::mem::take(&mut transport.certificate);
    certify_rows(&mut certificate, &transport);
    certificate.transport_hash = transport.hash().to_hex().to_string();
    transport.certificate = certificate;
    Ok((transport, warnings))
}

/// A transport whose light probes alone are not those of the scene, with those of the scene: no other row is traced. None
/// where it has not the scene's places.
pub fn make_probes(
    (scene, assets): (&Scene, &Assets),
    surface: &Surface,
    with: &BakeWith,
    old: Transport,
    watcher: &dyn Watcher,
) -> Result<Option<(Transport, Vec<Warning>)>, BakeError> {
    watcher.stage("patches and receivers", 1);
    let Layout { transport: places, mut rays, mut warnings, .. } =
        layout(scene, assets, surface, with.length, watcher)?;
    watcher.advance(1, 0);
    if !are_in_one_place(&places, &old) {
        return Ok(None);
    }
    let holes = AlphaHoles::new(&places.surface, scene, assets);
    let bvh = Bvh::new(&rays.triangles, holes.holed());
    rays.covered = covered(&rays, &bvh, &holes.holed());
    warnings.extend(warnings_of_covered(scene, &places, &rays.covered));
    let emitters = emitters(scene, &places, &rays);
    let tracer = Tracer { scene: &rays, bvh: &bvh, holes: &holes, watcher };

    let rays_of = |probes: usize| probes as u64 * u64::from(PROBE_RAYS);
    let rays_of_others = old.certificate.rays - rays_of(old.probes.len()).min(old.certificate.rays);
    let mut transport = Transport { probes: places.probes, probe_from_patch: Rows::default(), ..old };
    let probe_rows = probe_rows(&tracer, &emitters)?;
    mark_probes(&mut transport.probes, &probe_rows);
    transport.depths = depths(&tracer, &transport, surface.unit);
    add_probe_rows(&mut transport.probe_from_patch, probe_rows);
    let rays_traced = rays_of(transport.probes.len());
    let counted = counts(&transport);
    let mut certificate = Certificate {
        probes: counted.probes,
        entries: counted.entries,
        rays: rays_of_others + rays_traced,
        rays_traced,
        ..std::mem::take(&mut transport.certificate)
    };
    certify_rows(&mut certificate, &transport);
    certificate.transport_hash = transport.hash().to_hex().to_string();
    transport.certificate = certificate;
    Ok(Some((transport, warnings)))
}

fn are_in_one_place(a: &Transport, b: &Transport) -> bool {
    let patches = |transport: &Transport| -> Vec<_> {
        transport.patches.iter().map(|patch| (patch.centre, patch.area, patch.first_triangle)).collect()
    };
    let receivers = |transport: &Transport| -> Vec<_> {
        transport.receivers.iter().map(|receiver| (receiver.position, receiver.normal)).collect()
    };
    (a.origin, patches(a), receivers(a), &a.samples, &a.surface.triangles)
        == (b.origin, patches(b), receivers(b), &b.samples, &b.surface.triangles)
}

/// What is sampled towards.
fn emitters(scene: &Scene, transport: &Transport, rays: &RayScene) -> Emitters {
    let mut sampled = sampled(scene, transport);
    sampled.iter_mut().zip(&rays.covered).for_each(|(sampled, covered)| *sampled &= !covered);
    Emitters::choose(rays, &sampled)
}

/// One an entity.
fn warnings_of_covered(scene: &Scene, transport: &Transport, covered: &[bool]) -> Vec<Warning> {
    let mut counts = std::collections::BTreeMap::<u64, usize>::new();
    for (patch, _) in transport.patches.iter().zip(covered).filter(|(_, covered)| **covered) {
        *counts.entry(transport.surface.batches[patch.batch as usize].entity().0).or_default() += 1;
    }
    let named = counts.into_iter().filter_map(|(id, count)| Some((scene.entity(EntityId(id))?, count)));
    let warning = |(entity, count): (&Entity, usize)| {
        let message =
            format!("{count} of its patches lie on others that face the same way: they exchange no light");
        Warning::new(format!("entity `{}`", entity.name), message)
    };
    named.map(warning).collect()
}

fn sky_hits(hits: &Hits, i: usize, patches: usize) -> u32 {
    hits.row(i).filter(|&(column, _)| column as usize >= patches).map(|(_, count)| count).sum()
}

fn counts(transport: &Transport) -> Certificate {
    Certificate {
        patches: transport.patches.len(),
        receivers: transport.receivers.len(),
        probes: transport.probes.len(),
        sky_patches: transport.sky_patches as usize,
        triangles: transport.surface.triangles.len(),
        entries: [
            transport.patch_from_patch.entries(),
            transport.receiver_from_patch.entries(),
            transport.probe_from_patch.entries(),
        ],
        directional_receivers: transport.directional_receivers(),
        directional_entries: transport.directional_from_patch.entries(),
        ..Certificate::default()
    }
}

/// By patch: does its material ask to be sampled towards?
pub fn sampled(scene: &Scene, transport: &Transport) -> Vec<bool> {
    let material =
        |batch: u32| scene.material(MaterialId(transport.surface.batches[batch as usize].material));
    transport.patches.iter().map(|patch| material(patch.batch).is_some_and(|m| m.emission.sampled)).collect()
}

/// Rows of receivers as they were counted: what was sampled towards takes its share, the rest is scaled so that
/// the row closes. Weights are such as four bytes hold.
pub fn receiver_rows(hits: &Hits, rays: u32, emitters: &Emitters, towards: &Towards) -> Rows {
    let finished: Vec<Vec<(u32, f32)>> =
        (0..hits.len()).into_par_iter().map(|i| receiver_row(hits, i, rays, emitters, &towards[i])).collect();
    let mut rows = Rows::default();
    finished.into_iter().for_each(|row| rows.push(row));
    rows
}

fn receiver_row(
    hits: &Hits,
    i: usize,
    rays: u32,
    emitters: &Emitters,
    towards: &[(u32, f64)],
) -> Vec<(u32, f32)> {
    let is_emitter = |column: u32| emitters.is_emitter.get(column as usize).copied().unwrap_or(false);
    let by_chance = || hits.row(i).filter(|&(column, _)| !is_emitter(column));
    let target = 1.0 - f64::from(hits.lost[i] + hits.escaped[i]) / f64::from(rays);
    let sampled: f64 = towards.iter().map(|towards| towards.1).sum();
    let counted = f64::from(by_chance().map(|(_, count)| count).sum::<u32>());
    // What was sampled towards may say a little more than all that chance leaves.
    let (sampled_scale, scale) = match target - sampled {
        left if counted == 0.0 => {
            (if sampled > 0.0 { (target / sampled).min(1.0) } else { 0.0 }, left.min(0.0))
        }
        left if left <= 0.0 => (target / sampled, 0.0),
        left => (1.0, left / counted),
    };
    let mut row: Vec<(u32, f32)> = by_chance()
        .map(|(column, count)| (column, (f64::from(count) * scale) as f32))
        .chain(towards.iter().map(|&(column, share)| (column, (share * sampled_scale) as f32)))
        .filter(|entry| entry.1 > 0.0)
        .collect();
    row.sort_unstable_by_key(|entry| entry.0);
    cap(&mut row, target);
    fold(&mut row);
    row
}

fn probe_rows(tracer: &Tracer, emitters: &Emitters) -> Result<Vec<ProbeRow>, BakeError> {
    tracer.watcher.stage("light probes", tracer.scene.probes.len() as u64);
    let sobol = Sobol::new(PROBE_RAYS);
    tracer
        .scene
        .probes
        .par_iter()
        .map(|&position| {
            if tracer.watcher.cancelled() {
                return Err(BakeError::Cancelled);
            }
            let key = hash_of(position.to_array().map(|x| u64::from(x.to_bits())));
            let row = probe_row(tracer, emitters, position, &sobol, PROBE_RAYS, key);
            tracer.watcher.advance(1, u64::from(PROBE_RAYS));
            Ok(row)
        })
        .collect()
}

/// Probes inside a solid are not used.
fn mark_probes(probes: &mut [Probe], rows: &[ProbeRow]) {
    for (probe, row) in probes.iter_mut().zip(rows) {
        probe.valid = f32::from(u8::from(row.lost <= INSIDE));
    }
}

fn add_probe_rows(probe_from_patch: &mut Rows, rows: Vec<ProbeRow>) {
    for row in rows {
        for k in 0..COEFFICIENTS {
            let mut entries: Vec<(u32, f32)> =
                row.entries.iter().map(|(column, weights)| (*column, weights[k] as f32)).collect();
            fold(&mut entries);
            probe_from_patch.push(entries);
        }
    }
}

/// What a bake will come to, by a few rows of the scene itself.
pub struct Measured {
    /// Seconds, on one thread.
    pub per_ray: f64,
    /// Entries of a receiver's row, which patches' are like.
    pub per_row: f64,
    /// Of each of a probe's nine.
    pub per_probe_row: f64,
}

pub fn measure(layout: &Layout, scene: &Scene, assets: &Assets, rays: u32) -> Measured {
    const ROWS: usize = 32;
    let holes = AlphaHoles::new(&layout.transport.surface, scene, assets);
    let bvh = Bvh::new(&layout.rays.triangles, holes.holed());
    let tracer = Tracer { scene: &layout.rays, bvh: &bvh, holes: &holes, watcher: &crate::Silent };
    let rows = layout.rays.receivers.len();
    let some: Vec<usize> = (0..ROWS.min(rows)).map(|k| k * rows / ROWS.min(rows)).collect();
    let started = std::time::Instant::now();
    let entries = tracer.sample_receivers(&some, rays);
    let traced = some.len() as f64 * f64::from(rays);
    let per_ray = started.elapsed().as_secs_f64() / traced.max(1.0);
    let per_row = entries as f64 / some.len().max(1) as f64;
    let probes = &layout.rays.probes[..layout.rays.probes.len().min(4)];
    let met: usize = probes.iter().map(|&probe| columns_of_probe(&tracer, probe)).sum();
    Measured { per_ray, per_row, per_probe_row: met as f64 / probes.len().max(1) as f64 }
}

/// How many a probe sees.
fn columns_of_probe(tracer: &Tracer, position: Vec3) -> usize {
    let sobol = Sobol::new(PROBE_RAYS);
    let column = |ray: u32| {
        let [u, v, ..] = sobol.point(ray, 0);
        match tracer.column(position, Vec3::ZERO, sphere_direction(u, v), unit(hash(u64::from(ray)) as u32)) {
            Seen::Column(column) => Some(column),
            Seen::Back | Seen::Nothing => None,
        }
    };
    (0..PROBE_RAYS).filter_map(column).collect::<std::collections::BTreeSet<u32>>().len()
}
