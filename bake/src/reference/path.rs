//! Paths: light followed backwards from where it is asked for, for ever.
//!
//! At each surface a path meets, what that surface gives off is added; then every punctual light and one point of an
//! emitter are joined to it by shadow rays, and it goes on in one direction. It ends where nothing is met, on a back
//! face, and else by lot (Russian roulette): it goes on as often as the largest share that it still carries says, and
//! carries the more for it, so that the mean is that of paths that never end.

use std::path::Path;

use engine::scene::Scene;
use engine::scene::assets::Assets;
use engine::transport::sky;
use glam::{DVec3, Vec3};

use super::Surfaces;
use super::finish::{Arrival, Finish};
use super::ggx::SplitSum;
use super::sequence::Numbers;
use super::sources::{Sources, Towards, weight};
use super::world::{Ray, World};
use crate::surface::{Surface, sanitise};
use crate::{BakeError, Opened};

/// A path of a room of white walls ends after a thousand of them or so.
const MOST_SURVIVAL: f64 = 0.999;
/// Without roulette a path ends when it carries no more than this.
const NOTHING: f64 = 1e-9;

/// The slow reference: see [`super`].
pub struct PathTracer {
    pub(super) world: World,
    sources: Sources,
    surfaces: Surfaces,
    split: SplitSum,
    roulette: bool,
}

/// Radiance along a ray [W/m2/sr].
#[derive(Clone, Copy, Debug, Default)]
pub struct Arriving {
    /// From what the ray meets itself, and from the sky behind it.
    pub emitted: DVec3,
    /// What is met reflects.
    pub reflected: DVec3,
}

/// How many decisions a path takes at a surface.
const DECISIONS: u32 = 4;
const DIRECTION: u32 = 0;
const EMITTER: u32 = 1;
const HOLE: u32 = 2;
const SHADOW: u32 = 3;

impl PathTracer {
    /// All static triangles of a scene, and its lights, emitters and sky as they are now.
    pub fn new(scene: &Scene, assets: &Assets, surfaces: Surfaces) -> Result<Self, BakeError> {
        Ok(Self::of(scene, assets, sanitise(scene, assets)?, surfaces))
    }

    /// Of a scene on disk (`None`: the project's default one).
    pub fn open(project: &Path, scene: Option<&str>, surfaces: Surfaces) -> Result<Self, BakeError> {
        let opened = Opened::open(project, scene)?;
        Ok(Self::of(&opened.scene, &opened.assets, opened.surface, surfaces))
    }

    fn of(scene: &Scene, assets: &Assets, surface: Surface, surfaces: Surfaces) -> Self {
        let world = World::new(scene, assets, surface);
        let sources = Sources::new(&world);
        Self { world, sources, surfaces, split: SplitSum::new(), roulette: true }
    }

    /// The same without lots: paths end only when they carry next to nothing. For rooms that are not white.
    pub fn without_roulette(self) -> Self {
        Self { roulette: false, ..self }
    }

    /// Irradiance from one path [W/m2]: straight from emitters, sky and lights, and by way of surfaces.
    pub(super) fn irradiance_of_path(&self, position: Vec3, normal: Vec3, numbers: &Numbers) -> [DVec3; 2] {
        let meter = Finish::meter(normal);
        let lit = self.joined(position, normal, &meter, 0, numbers);
        let Some(drawn) = meter.draw(numbers.four(DIRECTION)) else { return [lit, DVec3::ZERO] };
        let ray = Ray { origin: position, normal, direction: drawn.direction.as_vec3() };
        let arriving = self.arriving(ray, Some(drawn.density), numbers);
        [lit + drawn.weight * arriving.emitted, drawn.weight * arriving.reflected]
    }

    /// Radiance along a ray from one path. `density`: with which its direction was drawn, where emitters are joined
    /// to its start, too.
    pub(super) fn arriving(&self, ray: Ray, density: Option<f64>, numbers: &Numbers) -> Arriving {
        let mut arriving = Arriving::default();
        let (mut ray, mut density, mut carried) = (ray, density, DVec3::ONE);
        for bounce in 1.. {
            let decision = bounce * DECISIONS;
            let (emitted, arrival) = self.meet(&ray, density, numbers.one(decision + HOLE));
            let sum = if bounce == 1 { &mut arriving.emitted } else { &mut arriving.reflected };
            *sum += carried * emitted;
            let Some(arrival) = arrival else { break };
            let finish = Finish::at(&self.world, &arrival, self.surfaces, &self.split);
            if finish.is_black() {
                break;
            }
            let position = self.world.position(arrival.triangle, arrival.barycentric);
            let side = if arrival.back { -1.0 } else { 1.0 };
            let normal = self.world.normal(arrival.triangle) * side;
            arriving.reflected += carried * self.joined(position, normal, &finish, bounce, numbers);
            let four = numbers.four(decision + DIRECTION);
            let Some(drawn) = finish.draw(four) else { break };
            let Some(kept) = self.survive(carried * drawn.weight, four[3]) else { break };
            carried = kept;
            density = Some(drawn.density);
            ray = Ray { origin: position, normal, direction: drawn.direction.as_vec3() };
        }
        arriving
    }

    /// What a ray meets: its own light towards the ray's start, weighed against joining it, and where to go on from.
    fn meet(&self, ray: &Ray, density: Option<f64>, chance: f32) -> (DVec3, Option<Arrival>) {
        let Some(hit) = self.world.closest(ray, chance) else {
            let radiance = sky::radiance(&self.world.scene.sky, &self.world.assets, ray.direction);
            return (radiance.as_dvec3(), None);
        };
        if hit.back && !self.world.is_double_sided(hit.triangle) {
            return (DVec3::ZERO, None);
        }
        let arrival = Arrival {
            triangle: hit.triangle,
            barycentric: hit.barycentric,
            back: hit.back,
            to_viewer: -ray.direction.as_dvec3(),
        };
        let emitted = self.world.emission(hit.triangle, hit.barycentric);
        let share = match density {
            Some(density) if emitted != DVec3::ZERO => {
                let position = self.world.position(hit.triangle, hit.barycentric);
                let distance = f64::from(position.distance(ray.origin));
                let direction = ray.direction.as_dvec3();
                weight(density, self.sources.density(&self.world, hit.triangle, direction, distance))
            }
            _ => 1.0,
        };
        (emitted * share, Some(arrival))
    }

    /// Reflected of what is joined by shadow rays: all punctual lights, and one point of an emitter.
    fn joined(&self, position: Vec3, normal: Vec3, finish: &Finish, bounce: u32, numbers: &Numbers) -> DVec3 {
        let chance = numbers.one(bounce * DECISIONS + SHADOW);
        let mut sum = self.lit(position, normal, finish, chance);
        if let Some(towards) = self.towards(position, normal, bounce, numbers) {
            let share = weight(towards.density, finish.density(towards.direction)) / towards.density;
            sum += finish.reflected(towards.direction) * towards.radiance * share;
        }
        sum
    }

    fn lit(&self, position: Vec3, normal: Vec3, finish: &Finish, chance: f32) -> DVec3 {
        let world = &self.world;
        let reflected = |light: &engine::transport::direct::PlacedLight| {
            let (to_light, _) = light.towards(position);
            let arriving = light.irradiance(position, to_light, 0.0).as_dvec3();
            let reflected = finish.reflected(to_light.as_dvec3()) * arriving;
            let end = || light.end(position, world.extent);
            let free = || !light.light.casts_shadows || world.visible(position, normal, end(), chance);
            if reflected != DVec3::ZERO && free() { reflected } else { DVec3::ZERO }
        };
        world.lights.iter().map(reflected).sum()
    }

    /// A seen point of an emitter.
    pub(super) fn towards(
        &self,
        position: Vec3,
        normal: Vec3,
        bounce: u32,
        numbers: &Numbers,
    ) -> Option<Towards> {
        if self.sources.is_empty() {
            return None;
        }
        let decision = bounce * DECISIONS;
        let towards = self.sources.towards(&self.world, position, numbers.four(decision + EMITTER))?;
        let above = normal == Vec3::ZERO || normal.as_dvec3().dot(towards.direction) > 0.0;
        let chance = numbers.one(decision + SHADOW);
        let end = [towards.position, towards.facing];
        (above && self.world.free_between([position, normal], end, chance)).then_some(towards)
    }

    /// What a path carries on, if it goes on.
    fn survive(&self, carried: DVec3, lot: f32) -> Option<DVec3> {
        let most = carried.max_element();
        if !self.roulette {
            return (most > NOTHING).then_some(carried);
        }
        let survival = most.min(MOST_SURVIVAL);
        (f64::from(lot) < survival).then(|| carried / survival)
    }
}
