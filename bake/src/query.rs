//! The light at points, from a bake on disk and the CPU's exact solution.
//!
//! * receivers: what the runtime shows: the receivers of the nearest front face, blended as its vertices blend
//!   them, and punctual lights by a shadow ray.
//! * gather: rays of its own, which read the receivers where they land. One order better than the patches
//!   (Sloan's iterate, twice), and free of their edges.

use engine::scene::world_from_local;
use engine::transport::direct::{PlacedLight, extent, irradiance_of_patches, placed_lights};
use engine::transport::materials::{self, PatchMaterials};
use engine::transport::sh::{COEFFICIENTS, basis};
use engine::transport::solve::{System, exact, gather, limit_gain};
use engine::transport::surface::{Blend, Surface};
use engine::transport::{NONE, Transport, sky};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::directions::{Sobol, cosine_direction, frame, hash, hash_of, sphere_direction, unit};
use crate::emitter::Emitters;
use crate::holes::AlphaHoles;
use crate::layout::RayScene;
use crate::pipeline::sampled;
use crate::rays::Tracer;
use crate::{BakeError, Irradiance, Method, Point, Silent, Solvable};
use engine::transport::bvh::{Bvh, Hit, patch_of};

/// Rays of a final gather, and of a fresh probe row.
const GATHER_RAYS: u32 = 1 << 14;
const PROBE_RAYS: u32 = 1 << 16;
/// Shadow rays towards each patch of an emitter.
const EMITTER_RAYS: u32 = 64;
/// A point may lie this far from its surface, in sizes of the scene, and its normal this far from the face's.
const REACH: f32 = 1e-3;
const COS_TURN: f32 = 0.866_025_4;

/// A solved scene that can be asked.
pub struct Query {
    solvable: Solvable,
    rays: RayScene,
    bvh: Bvh,
    emitters: Emitters,
    materials: PatchMaterials,
    lights: Vec<PlacedLight>,
    /// By receiver [W/m2]: from emitters and sky, and from all that reflects.
    from_emitters: Vec<DVec3>,
    reflected: Vec<DVec3>,
    extent: f32,
}

impl Query {
    pub fn new(solvable: Solvable) -> Self {
        let (scene, assets) = (&solvable.opened.scene, &solvable.opened.assets);
        let transport = &solvable.transport;
        let rays = ray_scene(transport);
        let holes = AlphaHoles::new(&transport.surface, scene, assets);
        let bvh = Bvh::new(&rays.triangles, holes.holed());
        let emitters = Emitters::choose(&rays, &sampled(scene, transport)).with_rays(EMITTER_RAYS);
        let mut materials = materials::of_patches(transport, scene, assets);
        if !solvable.opened.settings.bake.unlimited_gain {
            limit_gain(&transport.patch_from_patch, &transport.patches, &mut materials.albedo);
        }
        let lights = placed_lights(scene, &world_from_local(scene), transport.origin);

        let visible = |from: Vec3, normal: Vec3, to: Vec3| {
            bvh.visible(from, normal, to, unit(hash(u64::from(from.x.to_bits())) as u32), &holes)
        };
        let from_lights = irradiance_of_patches(transport, &lights, &visible);
        let n = transport.patches.len();
        let mut sources = vec![DVec3::ZERO; transport.columns()];
        if transport.sky_patches > 0 {
            let sky = sky::radiance_of_patches(&scene.sky, assets);
            sources[n..]
                .iter_mut()
                .zip(sky)
                .for_each(|(source, sky)| *source = sky.as_dvec3() * std::f64::consts::PI);
        }
        let from_sky = gather(&transport.patch_from_patch, &sources);
        let m = |i: usize| materials.exitance[i].as_dvec3();
        let e: Vec<DVec3> = (0..n)
            .map(|i| m(i) + materials.albedo[i].as_dvec3() * (from_lights[i].as_dvec3() + from_sky[i]))
            .collect();
        let system = System {
            rows: &transport.patch_from_patch,
            patches: &transport.patches,
            albedo: &materials.albedo,
        };
        let b = exact(&system, &e, 1e-10);

        (0..n).for_each(|i| sources[i] = m(i));
        let from_emitters = transport.irradiance_of_receivers(&sources);
        let mut reflecting = vec![DVec3::ZERO; transport.columns()];
        (0..n).for_each(|i| reflecting[i] = b[i] - m(i));
        let reflected = transport.irradiance_of_receivers(&reflecting);
        let extent = extent(transport);
        Self { rays, bvh, emitters, materials, lights, from_emitters, reflected, extent, solvable }
    }

    fn transport(&self) -> &Transport {
        &self.solvable.transport
    }

    fn holes(&self) -> AlphaHoles<'_> {
        let opened = &self.solvable.opened;
        AlphaHoles::new(&self.transport().surface, &opened.scene, &opened.assets)
    }

    pub fn points(&self, points: &[Point], method: Method) -> Result<Vec<Irradiance>, BakeError> {
        let holes = self.holes();
        let tracer = Tracer { scene: &self.rays, bvh: &self.bvh, holes: &holes, watcher: &Silent };
        let sobol = Sobol::new(if method == Method::Gather { GATHER_RAYS } else { 1 });
        points
            .par_iter()
            .enumerate()
            .map(|(number, point)| {
                let place = self.find(point).map_err(|why| {
                    BakeError::Other(format!("point {} at {}: {why}", number + 1, point.position))
                })?;
                let punctual = self.punctual(&tracer, place.position, place.normal);
                let mut irradiance = match method {
                    Method::Receivers => {
                        let (direct, indirect) = self.blended(place.triangle, place.back, place.barycentric);
                        Irradiance { direct, indirect }
                    }
                    Method::Gather => self.gathered(&tracer, &sobol, &place),
                };
                irradiance.direct += punctual;
                Ok(irradiance)
            })
            .collect()
    }

    /// The front face (or the back of a double-sided one) that a point lies on.
    fn find(&self, point: &Point) -> Result<Place, String> {
        let position = (point.position - self.transport().origin).as_vec3();
        let normal = point.normal.normalize_or_zero().as_vec3();
        if normal == Vec3::ZERO || !position.is_finite() {
            return Err("it has no normal, or is not finite".to_owned());
        }
        let reach = REACH * self.extent * 2.0;
        match nearest_face(&self.rays, position, normal) {
            Some((distance, place)) if distance <= reach => Ok(place),
            Some((distance, _)) => {
                Err(format!("the nearest front face with such a normal is {distance:.3e} m away"))
            }
            None => Err("no front face looks that way".to_owned()),
        }
    }

    /// Irradiance from emitters and sky, and from all that reflects, as the vertices of a triangle blend it.
    fn blended(&self, triangle: u32, back: bool, barycentric: [f32; 2]) -> (DVec3, DVec3) {
        let (mut direct, mut indirect) = (DVec3::ZERO, DVec3::ZERO);
        for (receiver, share) in receivers_at(&self.transport().surface, triangle, back, barycentric) {
            direct += self.from_emitters[receiver] * share;
            indirect += self.reflected[receiver] * share;
        }
        (direct, indirect)
    }

    /// From punctual lights, by shadow rays.
    fn punctual(&self, tracer: &Tracer, position: Vec3, normal: Vec3) -> DVec3 {
        let lit = |light: &PlacedLight| {
            let irradiance = light.irradiance(position, normal, 0.0);
            let free = || {
                let end = light.end(position, self.extent);
                !light.light.casts_shadows || tracer.bvh.visible(position, normal, end, 0.5, tracer.holes)
            };
            if irradiance != Vec3::ZERO && free() { irradiance.as_dvec3() } else { DVec3::ZERO }
        };
        self.lights.iter().map(lit).sum()
    }

    fn gathered(&self, tracer: &Tracer, sobol: &Sobol, place: &Place) -> Irradiance {
        let key = hash_of(place.position.to_array().map(|x| u64::from(x.to_bits())));
        let (x, y) = frame(place.normal);
        let mut sum = Irradiance::default();
        for ray in 0..GATHER_RAYS {
            let [a, b, ..] = sobol.point(ray, key);
            let local = cosine_direction(a, b);
            let direction = x * local.x + y * local.y + place.normal * local.z;
            let chance = unit(hash(key ^ u64::from(ray)) as u32);
            let (direct, indirect) = self.arriving(tracer, place.position, place.normal, direction, chance);
            sum.direct += direct;
            sum.indirect += indirect;
        }
        sum.direct /= f64::from(GATHER_RAYS);
        sum.indirect /= f64::from(GATHER_RAYS);
        for (patch, share) in self.emitters.row(tracer, place.position, place.normal, key) {
            sum.direct += self.materials.exitance[patch as usize].as_dvec3() * share;
        }
        sum
    }

    /// Radiosity along a ray, straight from emitters and sky and reflected. Emitters that are sampled towards
    /// are left out of the first.
    fn arriving(
        &self,
        tracer: &Tracer,
        position: Vec3,
        normal: Vec3,
        direction: Vec3,
        chance: f32,
    ) -> (DVec3, DVec3) {
        let Some(hit) = self.bvh.closest(position, normal, direction, chance, tracer.holes) else {
            let opened = &self.solvable.opened;
            let radiance = sky::radiance(&opened.scene.sky, &opened.assets, direction);
            return (radiance.as_dvec3() * std::f64::consts::PI, DVec3::ZERO);
        };
        let Some(patch) = patch_of(&hit, &self.rays.patches) else { return (DVec3::ZERO, DVec3::ZERO) };
        let emitted = if self.emitters.is_emitter[patch as usize] {
            DVec3::ZERO
        } else {
            self.materials.exitance[patch as usize].as_dvec3()
        };
        (emitted, self.leaving(tracer, position, &hit, patch))
    }

    /// What a hit reflects towards where it was seen from.
    fn leaving(&self, tracer: &Tracer, seen_from: Vec3, hit: &Hit, patch: u32) -> DVec3 {
        let albedo = self.materials.albedo[patch as usize].as_dvec3();
        if albedo == DVec3::ZERO {
            return DVec3::ZERO;
        }
        let [a, b, c] = self.rays.triangles[hit.triangle as usize];
        let [v, w] = hit.barycentric;
        let at = a + (b - a) * v + (c - a) * w;
        // At the foot of a wall without thickness it may be rounded into the wall: back to where it was seen from.
        let way = seen_from - at;
        let at = at + way.normalize_or_zero() * (16.0 * f32::EPSILON * self.extent).min(0.5 * way.length());
        let normal = (b - a).cross(c - a).normalize_or_zero() * if hit.back { -1.0 } else { 1.0 };
        let (direct, indirect) = self.blended(hit.triangle, hit.back, hit.barycentric);
        albedo * (direct + indirect + self.punctual(tracer, at, normal))
    }

    pub fn probes(&self, points: &[DVec3]) -> Result<Vec<[Vec3; COEFFICIENTS]>, BakeError> {
        let holes = self.holes();
        let tracer = Tracer { scene: &self.rays, bvh: &self.bvh, holes: &holes, watcher: &Silent };
        let sobol = Sobol::new(PROBE_RAYS);
        let probe = |(number, point): (usize, &DVec3)| {
            let position = (*point - self.transport().origin).as_vec3();
            if !position.is_finite() {
                return Err(BakeError::Other(format!("probe {} is not at a finite place", number + 1)));
            }
            Ok(self.probe(&tracer, &sobol, position))
        };
        points.par_iter().enumerate().map(probe).collect()
    }

    fn probe(&self, tracer: &Tracer, sobol: &Sobol, position: Vec3) -> [Vec3; COEFFICIENTS] {
        let key = hash_of(position.to_array().map(|x| u64::from(x.to_bits())));
        let mut sums = [DVec3::ZERO; COEFFICIENTS];
        for ray in 0..PROBE_RAYS {
            let [u, v, ..] = sobol.point(ray, key);
            let direction = sphere_direction(u, v);
            let chance = unit(hash(key ^ u64::from(ray)) as u32);
            let (direct, indirect) = self.arriving(tracer, position, Vec3::ZERO, direction, chance);
            // 4 pi / R, and 1/pi from radiosity to radiance.
            let radiance = (direct + indirect) * (4.0 / f64::from(PROBE_RAYS));
            sums.iter_mut().zip(basis(direction)).for_each(|(sum, y)| *sum += radiance * f64::from(y));
        }
        for (patch, weights) in crate::probe::towards_all(tracer, &self.emitters, position, sobol, key, 1024)
        {
            let exitance = self.materials.exitance[patch as usize].as_dvec3();
            sums.iter_mut().zip(weights).for_each(|(sum, weight)| *sum += exitance * weight);
        }
        sums.map(|sum| sum.as_vec3())
    }
}

/// A point on a surface.
pub struct Place {
    pub triangle: u32,
    pub back: bool,
    pub barycentric: [f32; 2],
    pub position: Vec3,
    /// As it was asked for, within 30 degrees of the face's.
    pub normal: Vec3,
}

/// The front face (or the back of a double-sided one) that is nearest to a point, and how far it is, among those
/// within 30 degrees of a normal.
pub fn nearest_face(rays: &RayScene, position: Vec3, normal: Vec3) -> Option<(f32, Place)> {
    let mut best: Option<(f32, Place)> = None;
    for (t, corners) in rays.triangles.iter().enumerate() {
        let cross = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
        let back = cross.dot(normal) < 0.0;
        if cross.dot(normal).abs() < COS_TURN || rays.patches[t][usize::from(back)] == NONE {
            continue;
        }
        let barycentric = nearest(position, corners);
        let [v, w] = barycentric;
        let at = corners[0] + (corners[1] - corners[0]) * v + (corners[2] - corners[0]) * w;
        let distance = at.distance(position);
        if best.as_ref().is_none_or(|(least, _)| distance < *least) {
            let normal = if back { -cross } else { cross };
            best = Some((distance, Place { triangle: t as u32, back, barycentric, position: at, normal }));
        }
    }
    best
}

/// What a point of a triangle reads: receivers, and how much of each.
pub fn receivers_at(
    surface: &Surface,
    triangle: u32,
    back: bool,
    [v, w]: [f32; 2],
) -> impl Iterator<Item = (usize, f64)> + '_ {
    let blends = if back { &surface.back_blends } else { &surface.blends };
    let corners = surface.triangles[triangle as usize].into_iter().zip([1.0 - v - w, v, w]);
    corners.flat_map(|(vertex, weight)| {
        let Blend { receivers, weights } = blends[vertex as usize];
        let shares = receivers.into_iter().zip(weights).filter(|(_, share)| *share > 0.0);
        shares.map(move |(receiver, share)| (receiver as usize, f64::from(weight) * f64::from(share)))
    })
}

/// What rays meet, in metres from the transport's origin.
pub fn ray_scene(transport: &Transport) -> RayScene {
    let surface = &transport.surface;
    RayScene {
        triangles: (0..surface.triangles.len()).map(|t| surface.positions(t)).collect(),
        patches: surface.patches.clone(),
        patch_keys: (0..transport.patches.len() as u64).map(hash).collect(),
        patch_triangles: transport
            .patches
            .iter()
            .map(|patch| {
                patch.first_triangle as usize..(patch.first_triangle + patch.triangle_count) as usize
            })
            .collect(),
        patch_back: transport.patches.iter().map(|patch| patch.back == 1).collect(),
        patch_areas: transport.patches.iter().map(|patch| f64::from(patch.area)).collect(),
        sky_patches: transport.sky_patches,
        ..RayScene::default()
    }
}

/// Weights of the second and third corner at the point of a triangle that is nearest (by the regions of its plane
/// about corners, sides and inside; Ericson 2005, 5.1.5).
pub fn nearest(p: Vec3, &[a, b, c]: &[Vec3; 3]) -> [f32; 2] {
    let (ab, ac) = (b - a, c - a);
    let (d1, d2) = (ab.dot(p - a), ac.dot(p - a));
    let (d3, d4) = (ab.dot(p - b), ac.dot(p - b));
    let (d5, d6) = (ab.dot(p - c), ac.dot(p - c));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [0.0, 0.0];
    }
    if d3 >= 0.0 && d4 <= d3 {
        return [1.0, 0.0];
    }
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 1.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return [d1 / (d1 - d3), 0.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return [0.0, d2 / (d2 - d6)];
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return [1.0 - w, w];
    }
    let sum = va + vb + vc;
    [vb / sum, vc / sum]
}
