//! From triangles to spaces: the refined surface, its patches with their sample points, receivers and probes.
//! Everything of a transport but its rows.

use std::collections::HashMap;

use engine::scene::assets::Assets;
use engine::scene::{Scene, SkyKind, Warning, world_from_local};
use engine::transport::{NONE, Patch, Probe, Receiver, Sample, Surface, Transport, Vertex, sky};
use glam::{DVec3, Vec2, Vec3};

use crate::directional;
use crate::directions::{Sobol, hash_of, in_triangle};
use crate::receiver::Place;
use crate::{BakeError, Watcher};
use crate::{chart, cut, patch, receiver, split, surface};

/// Points at which a patch's direct light is sampled.
pub const SAMPLES: u32 = 16;

/// A transport without rows, and the same scene in scaled space, where the rays are.
pub struct Layout {
    pub transport: Transport,
    pub rays: RayScene,
    /// How many receivers, the first ones, get directional rows.
    pub directional: usize,
    pub dropped_triangles: usize,
    pub warnings: Vec<Warning>,
}

/// What rays start from and meet, in scaled space.
#[derive(Default)]
pub struct RayScene {
    pub triangles: Vec<[Vec3; 3]>,
    /// By triangle: the patches of its two sides.
    pub patches: Vec<[u32; 2]>,
    /// By patch.
    pub patch_keys: Vec<u64>,
    pub patch_triangles: Vec<std::ops::Range<usize>>,
    pub patch_back: Vec<bool>,
    /// f64, scaled units squared.
    pub patch_areas: Vec<f64>,
    pub receivers: Vec<Place>,
    pub probes: Vec<Vec3>,
    pub sky_patches: u32,
    /// By patch, or empty where none is: it lies on another that faces the same way, and exchanges no light.
    pub covered: Vec<bool>,
}

impl RayScene {
    pub fn columns(&self) -> usize {
        self.patch_areas.len() + self.sky_patches as usize
    }
}

/// The total area of what is baked, m2.
pub fn area(surface: &surface::Surface) -> f64 {
    let scaled: f64 = surface.triangles.iter().map(|triangle| triangle.cross().length() * 0.5).sum();
    scaled * surface.unit * surface.unit
}

/// `length`: of patches where the density is 1, metres.
pub fn layout(
    scene: &Scene,
    assets: &Assets,
    surface: &surface::Surface,
    length: f64,
    watcher: &dyn Watcher,
) -> Result<Layout, BakeError> {
    let mut layout = divide(scene, surface, length, watcher)?;
    crate::holes::shrink_patches(&mut layout.transport, &mut layout.rays, scene, assets);
    Ok(layout)
}

fn divide(
    scene: &Scene,
    surface: &surface::Surface,
    length: f64,
    watcher: &dyn Watcher,
) -> Result<Layout, BakeError> {
    let go_on = || if watcher.cancelled() { Err(BakeError::Cancelled) } else { Ok(()) };
    let length = length / surface.unit;
    let spacing = length * 0.5;
    let mut charts = chart::charts(surface);
    grade(&mut charts, length);
    let size = |id: u32| {
        let vertex = charts.charts[id as usize].outline.first().map_or(0, |edge| edge[0]);
        spacing / f64::from(charts.densities[vertex as usize]).max(1e-3)
    };
    go_on()?;
    let cuts = cut::cuts(surface, &charts, size);
    go_on()?;
    let fine = split::split(surface, &charts, &cuts, spacing, watcher);
    go_on()?;
    let links = patch::links(&fine, &surface.batches);
    go_on()?;
    let groups = patch::group(&fine, &links, length);
    go_on()?;
    let mut receivers = receiver::receivers(&fine, &links, &surface.batches, spacing);
    let directional = directional::put_first(&mut receivers, scene, &fine, &surface.batches);
    go_on()?;
    Ok(Layout { directional, ..assemble(scene, surface, &fine, &groups, receivers) })
}

/// Sizes of neighbouring vertices differ by at most 0.4 of their distance: no patch stands beside one many
/// times its size (Dijkstra over the sides of triangles).
fn grade(charts: &mut chart::Charts, length: f64) {
    const SLOPE: f64 = 0.4;
    let mut sizes: Vec<f64> =
        charts.densities.iter().map(|&density| length / f64::from(density).max(1e-3)).collect();
    if sizes.iter().all(|&size| size == sizes[0]) {
        return;
    }
    let mut near: Vec<Vec<u32>> = vec![Vec::new(); sizes.len()];
    for corners in &charts.welded {
        for k in 0..3 {
            near[corners[k] as usize].push(corners[(k + 1) % 3]);
            near[corners[(k + 1) % 3] as usize].push(corners[k]);
        }
    }
    let mut queue: std::collections::BinaryHeap<std::cmp::Reverse<(u64, u32)>> =
        sizes.iter().enumerate().map(|(i, size)| std::cmp::Reverse((size.to_bits(), i as u32))).collect();
    while let Some(std::cmp::Reverse((bits, vertex))) = queue.pop() {
        let size = f64::from_bits(bits);
        if size > sizes[vertex as usize] {
            continue;
        }
        for &other in &near[vertex as usize] {
            let way = charts.positions[vertex as usize].distance(charts.positions[other as usize]);
            let limit = size + SLOPE * way;
            if limit < sizes[other as usize] {
                sizes[other as usize] = limit;
                queue.push(std::cmp::Reverse((limit.to_bits(), other)));
            }
        }
    }
    for (density, size) in charts.densities.iter_mut().zip(sizes) {
        *density = (length / size) as f32;
    }
}

fn assemble(
    scene: &Scene,
    source: &surface::Surface,
    fine: &split::Fine,
    groups: &[Vec<u32>],
    receivers: receiver::Receivers,
) -> Layout {
    let unit = source.unit as f32;
    let mut transport = Transport { origin: source.origin, ..Transport::default() };
    transport.surface.batches.clone_from(&source.batches);
    let mut rays = RayScene::default();
    let mut vertices = Vertices::default();
    let mut in_batch: HashMap<u32, u64> = HashMap::new();
    // A sliver that has no area left in f32 can be neither hit nor sampled.
    let has_area = |&&t: &&u32| {
        let corners = fine.triangles[t as usize].corners;
        let [a, b, c] = corners.map(|corner| fine.corners[corner as usize].position.as_vec3());
        (b - a).cross(c - a).length() > 0.0
    };
    for group in groups {
        let group: Vec<u32> = group.iter().filter(has_area).copied().collect();
        if group.is_empty() {
            continue;
        }
        let first = rays.triangles.len();
        let batch = fine.triangles[group[0] as usize].batch;
        for &t in &group {
            let triangle = &fine.triangles[t as usize];
            let corners: [u32; 3] = std::array::from_fn(|k| {
                let node = receivers.node_of[t as usize][k];
                let corner = &fine.corners[triangle.corners[k] as usize];
                vertices.find(node, corner, unit, &receivers, &mut transport.surface)
            });
            transport.surface.triangles.push(corners);
            rays.triangles
                .push(triangle.corners.map(|corner| fine.corners[corner as usize].position.as_vec3()));
        }
        let range = first..rays.triangles.len();
        let entry = &mut transport.surface.batches[batch as usize];
        entry.first = if entry.count == 0 { first as u32 } else { entry.first };
        entry.count += group.len() as u32;
        let number = in_batch.entry(batch).or_default();
        *number += 1;
        let both = add_patches(&mut transport, &mut rays, range.clone(), batch, *number, source);
        transport.surface.patches.extend(range.clone().map(|_| both));
        rays.patches.extend(range.map(|_| both));
    }
    add_samples(&mut transport, &rays, source.unit);
    transport.receivers = receivers
        .places
        .iter()
        .map(|place| Receiver {
            position: place.position.as_vec3() * unit,
            normal: place.normal,
            valid: 1.0,
            padding: 0,
        })
        .collect();
    rays.receivers = receivers.places;
    let mut warnings = source.warnings.clone();
    warnings.extend(add_probes(scene, source, &mut transport, &mut rays));
    transport.sky_patches = if scene.sky.kind == SkyKind::None { 0 } else { sky::COUNT };
    rays.sky_patches = transport.sky_patches;
    Layout { transport, rays, directional: 0, dropped_triangles: source.dropped, warnings }
}

/// Render vertices: one for each node and set of attributes.
#[derive(Default)]
struct Vertices {
    known: HashMap<(u32, [u32; 16]), u32>,
}

impl Vertices {
    fn find(
        &mut self,
        node: u32,
        corner: &surface::Corner,
        unit: f32,
        receivers: &receiver::Receivers,
        surface: &mut Surface,
    ) -> u32 {
        let mut attributes = [0; 16];
        let words = corner.normal.to_array().into_iter().chain(corner.tangent).chain(corner.color);
        let words = words.chain(corner.uv.iter().flat_map(|uv: &Vec2| uv.to_array()));
        // Rounded, so that two charts that agree on a vertex but for the last bit share it.
        for (slot, word) in attributes.iter_mut().zip(words) {
            *slot = ((word * 65536.0).round() as i32) as u32;
        }
        *self.known.entry((node, attributes)).or_insert_with(|| {
            surface.vertices.push(Vertex {
                position: corner.position.as_vec3() * unit,
                normal: corner.normal,
                tangent: corner.tangent,
                uv: corner.uv,
                color: corner.color,
            });
            surface.blends.push(receivers.blends[node as usize]);
            if let Some(back) = receivers.back_blends.get(node as usize) {
                surface.back_blends.push(*back);
            }
            surface.vertices.len() as u32 - 1
        })
    }
}

/// The patch of a group of triangles, and the one of its back where it has one.
fn add_patches(
    transport: &mut Transport,
    rays: &mut RayScene,
    range: std::ops::Range<usize>,
    batch: u32,
    number: u64,
    source: &surface::Surface,
) -> [u32; 2] {
    let (mut area, mut centre, mut normal) = (0.0, DVec3::ZERO, DVec3::ZERO);
    for corners in &rays.triangles[range.clone()] {
        let [a, b, c] = corners.map(|corner| corner.as_dvec3());
        let cross = (b - a).cross(c - a) * 0.5;
        area += cross.length();
        centre += (a + b + c) / 3.0 * cross.length();
        normal += cross;
    }
    let entry = &source.batches[batch as usize];
    let slot = source.batches[..batch as usize].iter().filter(|other| other.entity == entry.entity).count();
    let mut add = |back: bool| {
        let normal = normal.normalize_or(DVec3::Y).as_vec3() * if back { -1.0 } else { 1.0 };
        transport.patches.push(Patch {
            centre: (centre / area).as_vec3() * source.unit as f32,
            area: (area * source.unit * source.unit) as f32,
            normal,
            batch,
            first_triangle: range.start as u32,
            triangle_count: range.len() as u32,
            back: u32::from(back),
            aggregate: NONE,
            ..Patch::default()
        });
        rays.patch_keys.push(hash_of([entry.entity().0, slot as u64, number, u64::from(back)]));
        rays.patch_triangles.push(range.clone());
        rays.patch_back.push(back);
        rays.patch_areas.push(area);
        transport.patches.len() as u32 - 1
    };
    let front = add(false);
    [front, if entry.double_sided != 0 { add(true) } else { NONE }]
}

/// Points of a patch, even by area.
pub struct Places<'a> {
    triangles: &'a [[Vec3; 3]],
    /// Running area.
    sums: Vec<f32>,
    back: bool,
}

impl<'a> Places<'a> {
    pub fn of(rays: &'a RayScene, patch: usize) -> Self {
        let triangles = &rays.triangles[rays.patch_triangles[patch].clone()];
        let mut sum = 0.0;
        let sums = triangles
            .iter()
            .map(|[a, b, c]| {
                sum += (*b - *a).cross(*c - *a).length();
                sum
            })
            .collect();
        Self { triangles, sums, back: rays.patch_back[patch] }
    }

    /// The place, its triangle's normal on the patch's side, and the triangle's number in the patch.
    pub fn at(&self, u: f32, v: f32) -> (Vec3, Vec3, usize) {
        let total = *self.sums.last().unwrap_or(&0.0);
        let target = u * total;
        let k = self.sums.partition_point(|&sum| sum <= target).min(self.sums.len() - 1);
        let before = if k == 0 { 0.0 } else { self.sums[k - 1] };
        let inside = ((target - before) / (self.sums[k] - before)).clamp(0.0, 1.0 - f32::EPSILON);
        let [a, b, c] = self.triangles[k];
        let (p, q) = in_triangle(inside, v);
        let normal = (b - a).cross(c - a).normalize_or(Vec3::Y);
        (a + (b - a) * p + (c - a) * q, if self.back { -normal } else { normal }, k)
    }
}

fn add_samples(transport: &mut Transport, rays: &RayScene, unit: f64) {
    let sobol = Sobol::new(SAMPLES);
    for (i, patch) in transport.patches.iter_mut().enumerate() {
        patch.first_sample = transport.samples.len() as u32;
        patch.sample_count = SAMPLES;
        let places = Places::of(rays, i);
        for k in 0..SAMPLES {
            let [u, v, ..] = sobol.point(k, rays.patch_keys[i] ^ 0x5a);
            let (position, normal, _) = places.at(u, v);
            transport.samples.push(Sample {
                position: position * unit as f32,
                patch: i as u32,
                normal,
                padding: 0,
            });
        }
    }
}

/// Says which are out of reach.
fn add_probes(
    scene: &Scene,
    source: &surface::Surface,
    transport: &mut Transport,
    rays: &mut RayScene,
) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let world = world_from_local(scene);
    for (entity, world_from_local) in scene.entities.iter().zip(&world) {
        let Some(group) = entity.light_probes.as_ref().filter(|_| !entity.hidden) else { continue };
        for (index, &position) in group.positions.iter().enumerate() {
            let local = world_from_local.transform_point3(position.as_dvec3()) - source.origin;
            if !(local.is_finite() && local.abs().max_element() <= surface::FARTHEST) {
                let message = format!(
                    "its light probe {index} lies farther than {:e} m away; it is left out",
                    surface::FARTHEST
                );
                warnings.push(Warning::new(&entity.name, message));
                continue;
            }
            rays.probes.push((local / source.unit).as_vec3());
            transport.probes.push(Probe {
                position: local.as_vec3(),
                valid: 1.0,
                entity: [entity.id.0 as u32, (entity.id.0 >> 32) as u32],
                index: index as u32,
                padding: 0,
            });
        }
    }
    warnings
}

#[cfg(test)]
mod tests {
    use super::*;
    use engine::scene::{Entity, EntityId, MeshRenderer, MeshSource, Transform, shape::Shape};

    #[test]
    fn patches_tile_their_surfaces_at_every_length() {
        let mesh = MeshSource::Shape(Shape::Plane);
        let renderer = MeshRenderer {
            mesh: mesh.clone(),
            materials: Vec::new(),
            casts_shadows: true,
            density: Default::default(),
            reflection: Default::default(),
        };
        let transform = Transform {
            scale: DVec3::new(0.5592, 1.0, 0.5488),
            rotation: glam::DQuat::from_rotation_x(0.7),
            ..Transform::default()
        };
        let plane =
            Entity { id: EntityId(1), is_static: true, mesh: Some(renderer), transform, ..Entity::default() };
        let scene = Scene { entities: vec![plane], ..Scene::default() };
        let mut assets = Assets::default();
        assets.meshes.insert(mesh, std::sync::Arc::new(engine::scene::shape::mesh(Shape::Plane)));
        let surface = surface::sanitise(&scene, &assets).unwrap();
        for step in 0..60 {
            let length = 0.02 + 0.0013 * f64::from(step);
            let layout = layout(&scene, &assets, &surface, length, &crate::Silent).unwrap();
            let covered: f64 = layout.transport.patches.iter().map(|patch| f64::from(patch.area)).sum();
            assert!(
                (covered / area(&surface) - 1.0).abs() < 1e-5,
                "{length}: {covered} of {}",
                area(&surface)
            );
        }
    }
}
