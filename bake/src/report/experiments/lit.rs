//! A transport under the scene's own light, and what it shows at the evaluation points.
//!
//! ```text
//! E_i = M_i + rho_i (H_dir,i + Sum_sky P_is pi L_s)        B = E + rho P B          shown = blend of (G B)
//! ```
//! What is shown is the irradiance from emitters, sky and all that reflects [W/m2]; what comes straight from punctual
//! lights is left out: the runtime computes it at every pixel, no bake and no solver has a part in it.

use engine::scene::world_from_local;
use engine::transport::bvh::Bvh;
use engine::transport::direct::{PlacedLight, irradiance_of_patches, placed_lights};
use engine::transport::materials;
use engine::transport::sh::COEFFICIENTS;
use engine::transport::solve::{System, exact, gather, limit_gain};
use engine::transport::{Rows, Sample, Transport, sky};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::directions::{Sobol, cosine_direction, frame, hash, hash_of, unit};
use crate::emitter::Emitters;
use crate::holes::AlphaHoles;
use crate::layout::{Places, RayScene};
use crate::pipeline::{INSIDE, sampled};
use crate::probe::{ProbeRow, probe_row};
use crate::query::{Place, nearest_face, ray_scene, receivers_at};
use crate::rays::{Seen, Tracer};
use crate::{Opened, Point, Silent};

/// Shadow rays towards each patch of an emitter, where rays are many.
const EMITTER_RAYS: u32 = 64;
/// Relative residual to which systems are solved.
pub const EXACT: f64 = 1e-10;

/// Rays of one's own.
pub struct Look {
    sobol: Sobol,
    rays: u32,
    seed: u64,
    emitters: Emitters,
}

/// A transport with what the scene's materials and lights say of it.
pub struct Lit<'a> {
    pub transport: &'a Transport,
    pub lights: Vec<PlacedLight>,
    pub albedo: Vec<Vec3>,
    /// M, emitted, by patch [W/m2].
    pub exitance: Vec<DVec3>,
    /// By column: pi times radiance in those of the sky, 0 in patches.
    pub sky: Vec<DVec3>,
    opened: &'a Opened,
    rays: RayScene,
    bvh: Bvh,
}

impl<'a> Lit<'a> {
    pub fn new(opened: &'a Opened, transport: &'a Transport) -> Self {
        let (scene, assets) = (&opened.scene, &opened.assets);
        let mut materials = materials::of_patches(transport, scene, assets);
        if !opened.settings.bake.unlimited_gain {
            limit_gain(&transport.patch_from_patch, &transport.patches, &mut materials.albedo);
        }
        let mut sky = vec![DVec3::ZERO; transport.columns()];
        if transport.sky_patches > 0 {
            let of_sky = sky::radiance_of_patches(&scene.sky, assets);
            let columns = sky[transport.patches.len()..].iter_mut();
            columns.zip(of_sky).for_each(|(sky, l)| *sky = l.as_dvec3() * std::f64::consts::PI);
        }
        let rays = ray_scene(transport);
        let holes = AlphaHoles::new(&transport.surface, scene, assets);
        let bvh = Bvh::new(&rays.triangles, holes.holed());
        Self {
            transport,
            lights: placed_lights(scene, &world_from_local(scene), transport.origin),
            exitance: materials.exitance.iter().map(|m| m.as_dvec3()).collect(),
            albedo: materials.albedo,
            sky,
            opened,
            rays,
            bvh,
        }
    }

    pub fn system<'b>(&'b self, rows: &'b Rows) -> System<'b> {
        System { rows, patches: &self.transport.patches, albedo: &self.albedo }
    }

    /// H_dir by patch, from the transport's own samples, by shadow rays.
    pub fn direct(&self, lights: &[PlacedLight]) -> Vec<Vec3> {
        self.direct_at(self.transport, lights)
    }

    /// The same from `samples` places on every patch.
    pub fn direct_from(&self, lights: &[PlacedLight], samples: u32) -> Vec<Vec3> {
        self.direct_at(&self.with_samples(samples), lights)
    }

    fn direct_at(&self, transport: &Transport, lights: &[PlacedLight]) -> Vec<Vec3> {
        let holes = AlphaHoles::new(&self.transport.surface, &self.opened.scene, &self.opened.assets);
        let visible = |from: Vec3, normal: Vec3, to: Vec3| {
            self.bvh.visible(from, normal, to, unit(hash(u64::from(from.x.to_bits())) as u32), &holes)
        };
        irradiance_of_patches(transport, lights, &visible)
    }

    fn with_samples(&self, count: u32) -> Transport {
        let from = self.transport;
        let (mut patches, mut samples) = (from.patches.clone(), Vec::new());
        let sobol = Sobol::new(count);
        for (i, patch) in patches.iter_mut().enumerate() {
            (patch.first_sample, patch.sample_count) = (samples.len() as u32, count);
            let places = Places::of(&self.rays, i);
            samples.extend((0..count).map(|k| {
                let [u, v, ..] = sobol.point(k, self.rays.patch_keys[i] ^ 0xd1);
                let (position, normal, _) = places.at(u, v);
                Sample { position, patch: i as u32, normal, padding: 0 }
            }));
        }
        Transport {
            origin: from.origin,
            surface: from.surface.clone(),
            patches,
            samples,
            ..Transport::default()
        }
    }

    /// E, the sky's first bounce in it.
    pub fn e(&self, rows: &Rows, direct: &[Vec3]) -> Vec<DVec3> {
        self.e_of(&gather(rows, &self.sky), direct)
    }

    /// The same from irradiance by patch, of the sky and of punctual lights.
    pub fn e_of(&self, from_sky: &[DVec3], direct: &[Vec3]) -> Vec<DVec3> {
        let e =
            |i: usize| self.exitance[i] + self.albedo[i].as_dvec3() * (direct[i].as_dvec3() + from_sky[i]);
        (0..direct.len()).map(e).collect()
    }

    /// Irradiance of patches straight from the sky, by the transport's own rows.
    pub fn sky_on_patches(&self) -> Vec<DVec3> {
        gather(&self.transport.patch_from_patch, &self.sky)
    }

    pub fn solve(&self, rows: &Rows, e: &[DVec3]) -> Vec<DVec3> {
        exact(&self.system(rows), e, EXACT)
    }

    /// The scene as it is at the start, solved.
    pub fn solved(&self) -> Vec<DVec3> {
        let rows = &self.transport.patch_from_patch;
        self.solve(rows, &self.e(rows, &self.direct(&self.lights)))
    }

    /// Radiosity in all columns.
    pub fn columns(&self, b: &[DVec3]) -> Vec<DVec3> {
        let mut values = self.sky.clone();
        values[..b.len()].copy_from_slice(b);
        values
    }

    /// Where points lie on this transport's surface.
    pub fn places(&self, points: &[Point]) -> Vec<Option<Place>> {
        let place = |point: &Point| {
            let position = (point.position - self.transport.origin).as_vec3();
            nearest_face(&self.rays, position, point.normal.as_vec3()).map(|(_, place)| place)
        };
        points.par_iter().map(place).collect()
    }

    /// What the radiosity shows at places.
    pub fn shown(&self, b: &[DVec3], places: &[Option<Place>]) -> Vec<f64> {
        self.blended(&self.transport.irradiance_of_receivers(&self.columns(b)), places)
    }

    /// Receivers that places read, each once, ascending.
    pub fn receivers(&self, places: &[Option<Place>]) -> Vec<usize> {
        let surface = &self.transport.surface;
        let of = |place: &Place| receivers_at(surface, place.triangle, place.back, place.barycentric);
        let mut read: Vec<usize> =
            places.iter().flatten().flat_map(of).map(|(receiver, _)| receiver).collect();
        read.sort_unstable();
        read.dedup();
        read
    }

    /// Irradiance by rays of its own at a place on a surface from the radiosity in all columns: emitters that are
    /// sampled towards by their form factor and shadow rays, all else by chance, and no seed that the bake has.
    pub fn gathered(&self, look: &Look, position: Vec3, normal: Vec3, b: &[DVec3]) -> DVec3 {
        let holes = AlphaHoles::new(&self.transport.surface, &self.opened.scene, &self.opened.assets);
        let tracer = Tracer { scene: &self.rays, bvh: &self.bvh, holes: &holes, watcher: &Silent };
        let key = hash_of(position.to_array().map(|x| u64::from(x.to_bits()))) ^ look.seed;
        let (x, y) = frame(normal);
        let arriving = |ray: u32| {
            let [u, v, ..] = look.sobol.point(ray, key);
            let local = cosine_direction(u, v);
            let direction = x * local.x + y * local.y + normal * local.z;
            match tracer.column(position, normal, direction, unit(hash(key ^ u64::from(ray)) as u32)) {
                Seen::Column(column) if look.emitters.is_emitter.get(column as usize) == Some(&true) => {
                    b[column as usize] - self.exitance[column as usize]
                }
                Seen::Column(column) => b[column as usize],
                _ => DVec3::ZERO,
            }
        };
        let by_chance = (0..look.rays).map(arriving).sum::<DVec3>() / f64::from(look.rays);
        let towards = look.emitters.row(&tracer, position, normal, key).into_iter();
        by_chance + towards.map(|(patch, share)| self.exitance[patch as usize] * share).sum::<DVec3>()
    }

    /// SH coefficients of the light at a place in the air, by rays of its own.
    pub fn probe(&self, look: &Look, position: Vec3, b: &[DVec3]) -> [DVec3; COEFFICIENTS] {
        let row = self.probe_row(look, position);
        std::array::from_fn(|k| row.entries.iter().map(|(column, w)| b[*column as usize] * w[k]).sum())
    }

    /// A place in the air that is none: most of what it sees are back faces.
    pub fn is_inside(&self, look: &Look, position: Vec3) -> bool {
        self.probe_row(look, position).lost > INSIDE
    }

    fn probe_row(&self, look: &Look, position: Vec3) -> ProbeRow {
        let holes = AlphaHoles::new(&self.transport.surface, &self.opened.scene, &self.opened.assets);
        let tracer = Tracer { scene: &self.rays, bvh: &self.bvh, holes: &holes, watcher: &Silent };
        let key = hash_of(position.to_array().map(|x| u64::from(x.to_bits()))) ^ look.seed;
        probe_row(&tracer, &look.emitters, position, &look.sobol, look.rays, key)
    }

    /// By patch: marked to be sampled towards.
    pub fn marked(&self) -> Vec<bool> {
        sampled(&self.opened.scene, self.transport)
    }

    /// What such rays need.
    pub fn look(&self, rays: u32, seed: u64) -> Look {
        let emitters = Emitters::choose(&self.rays, &self.marked()).with_rays(EMITTER_RAYS);
        Look { sobol: Sobol::new(rays), rays, seed, emitters }
    }

    /// Irradiance of receivers as their surface blends it.
    pub fn blended(&self, irradiance: &[DVec3], places: &[Option<Place>]) -> Vec<f64> {
        let surface = &self.transport.surface;
        let at = |place: &Option<Place>| -> DVec3 {
            let Some(place) = place else { return DVec3::ZERO };
            let receivers = receivers_at(surface, place.triangle, place.back, place.barycentric);
            receivers.map(|(receiver, share)| irradiance[receiver] * share).sum()
        };
        field(places.iter().map(at))
    }
}

/// Channel after channel.
pub fn field(values: impl Iterator<Item = DVec3>) -> Vec<f64> {
    let values: Vec<DVec3> = values.collect();
    (0..3).flat_map(|channel| values.iter().map(move |value| value[channel])).collect()
}

/// Every point and every channel counts the same.
pub fn weights(field: &[f64]) -> Vec<f64> {
    vec![1.0; field.len()]
}

pub fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}
