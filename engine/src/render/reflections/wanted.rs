//! Which reflection probes of a scene take part, and whether its sky does.

use glam::DVec3;

use super::super::frame::Now;
use super::super::instances::{Draw, Instances};
use super::super::materials::Materials;
use super::Asked;
use super::uses::Ranked;
use crate::scene::{EntityId, Forced, Material, ReflectionProbe, SkyKind};
use crate::transport::reflection::ROUGH;
use crate::transport::reflection::influence::Influence;

/// Bytes of the array of cubemaps, at most.
const BUDGET: u64 = 512 << 20;
/// Of a cube's face: at least two levels, at most what fits a console's memory.
const SIZES: [u32; 2] = [16, 1024];

/// A probe that takes part.
pub struct Wanted<'a> {
    pub entity: EntityId,
    pub settings: &'a ReflectionProbe,
    pub influence: Influence,
    pub size: u32,
}

/// Probes and whether the sky is read: neither where nothing that is shown is smooth enough to show them, and no probe
/// that nothing smooth reads.
pub fn wanted<'a>(
    now: &Now<'a>,
    instances: &Instances,
    materials: &Materials,
    origin: DVec3,
    asked: &Asked,
) -> (Vec<Wanted<'a>>, bool) {
    let smooth = |draw: &&Draw| draw.shown && is_smooth(materials.material(draw.material));
    let smooth: Vec<&Draw> = instances.draws.iter().filter(smooth).collect();
    if !asked.cubemaps.map_or(!smooth.is_empty(), |forced| forced == Forced::In) {
        return (Vec::new(), false);
    }
    let mut probes = placed(now, instances, origin);
    if asked.cubemaps.is_none() {
        let read = read_by(&smooth, &probes, now, origin);
        let mut read = read.into_iter();
        probes.retain(|_| read.next().unwrap_or(true));
    }
    (probes, asked.sky && now.scene.sky.kind != SkyKind::None)
}

/// Probe by probe: whether one of these surfaces reads it. What may move could come to each of them: making room for a
/// probe means that all are captured again.
fn read_by(draws: &[&Draw], probes: &[Wanted<'_>], now: &Now<'_>, origin: DVec3) -> Vec<bool> {
    if draws.iter().any(|draw| draw.mesh.is_some()) {
        return vec![true; probes.len()];
    }
    let ranked = Ranked::new(probes.iter().map(|probe| (probe.entity, probe.influence)).collect());
    let usable = vec![true; probes.len()];
    let mut read = vec![false; probes.len()];
    for draw in draws {
        let reads = ranked.of(draw, now, origin, &usable);
        reads.all().for_each(|probe| read[probe] = true);
    }
    read
}

/// All of the scene that are not hidden.
fn placed<'a>(now: &Now<'a>, instances: &Instances, origin: DVec3) -> Vec<Wanted<'a>> {
    let placed = now.scene.entities.iter().zip(now.world_from_local);
    let probes =
        placed.filter(|(entity, _)| !instances.is_hidden(entity.id)).filter_map(|(entity, world)| {
            let settings = entity.reflection_probe.as_ref()?;
            let influence = Influence::new(settings, world, origin)?;
            let size = settings.resolution.clamp(SIZES[0], SIZES[1]).next_power_of_two();
            Some(Wanted { entity: entity.id, settings, influence, size })
        });
    probes.collect()
}

/// Keeps the array of cubemaps within its memory: fewer texels for the largest, and no more probes than there are
/// layers. Returns how many probes had to go.
pub fn fit(probes: &mut Vec<Wanted<'_>>, layers: u32) -> usize {
    let most = (layers / 6).saturating_sub(1) as usize;
    let left_out = probes.len().saturating_sub(most);
    probes.truncate(most);
    let count = probes.len() as u64 + 1;
    let bytes = |size: u32| count * 64 * u64::from(size) * u64::from(size);
    while let Some(size) = probes.iter().map(|probe| probe.size).max() {
        if bytes(size) <= BUDGET || size <= SIZES[0] {
            break;
        }
        probes.iter_mut().for_each(|probe| probe.size = probe.size.min(size / 2));
    }
    left_out
}

/// Shows reflections.
pub fn is_smooth(material: &Material) -> bool {
    !material.unlit && (material.roughness < ROUGH || material.metallic_roughness_texture.is_some())
}
