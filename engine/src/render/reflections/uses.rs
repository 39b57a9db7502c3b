//! Which reflection probes each object reads, and how much.

use bytemuck::{Pod, Zeroable};
use glam::{Vec3, Vec4};

use super::super::frame::Now;
use super::super::instances::Draw;
use crate::scene::{EntityId, Reflection};
use crate::transport::reflection::influence::{self, Influence};

/// `Probe` in `scene/reflection.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct GpuReflectionProbe {
    pub rows: [Vec4; 3],
    pub position: Vec3,
    pub fade: f32,
    pub half: Vec3,
    pub unit: f32,
    pub cube: u32,
    pub group: u32,
    pub box_projection: u32,
    pub padding: u32,
}

/// `Use` in `scene/reflection.wgsl`, and the room that a dynamic offset leaves.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ReflectionUse {
    pub probes: [u32; MOST],
    pub weights: [f32; MOST],
    pub count: u32,
    pub per_point: u32,
    pub strength: f32,
    pub last_level: f32,
    pub sky: u32,
    pub baked: u32,
    pub padding: [u32; 42],
}

/// Of a [`ReflectionUse`], what the shader reads.
pub const READ_BYTES: u64 = 96;

/// The most probes that one object reads.
pub const MOST: usize = 8;

/// Probes in the order in which they take.
#[derive(Default)]
pub struct Ranked {
    pub influences: Vec<Influence>,
    entities: Vec<EntityId>,
    /// Index and group.
    ranked: Vec<(usize, u32)>,
}

/// What no object reads: everything is unknown.
pub const NOTHING: ReflectionUse = ReflectionUse {
    probes: [0; MOST],
    weights: [0.0; MOST],
    count: 0,
    per_point: 0,
    strength: 1.0,
    last_level: 0.0,
    sky: 0,
    baked: 0,
    padding: [0; 42],
};

impl ReflectionUse {
    /// The probes that are read.
    pub fn all(&self) -> impl Iterator<Item = usize> + use<> {
        self.probes.into_iter().take(self.count as usize).map(|probe| probe as usize)
    }
}

impl Ranked {
    pub fn new(probes: Vec<(EntityId, Influence)>) -> Self {
        let (entities, influences): (Vec<_>, Vec<_>) = probes.into_iter().unzip();
        let ranked = influence::ranked(&influences);
        Self { influences, entities, ranked }
    }

    /// Of each probe, in the order of [`Self::influences`].
    pub fn groups(&self) -> Vec<u32> {
        let mut groups = vec![0; self.influences.len()];
        self.ranked.iter().for_each(|&(index, group)| groups[index] = group);
        groups
    }

    /// What an object reads whose sphere is that of `draw`. `usable` says which probes hold a cubemap.
    pub fn of(&self, draw: &Draw, now: &Now<'_>, origin: glam::DVec3, usable: &[bool]) -> ReflectionUse {
        let reflection = draw.entity.and_then(|entity| now.scene.entities[entity].mesh.as_ref());
        let Some(reflection) = reflection.map(|renderer| &renderer.reflection) else { return NOTHING };
        let anchor = anchor(reflection, now, origin);
        let (centre, radius) = anchor.map_or((draw.centre, draw.radius), |anchor| (anchor, 0.0));
        let chosen = |&(index, _): &(usize, u32)| {
            let listed = reflection.probes.as_ref().is_none_or(|list| list.contains(&self.entities[index]));
            usable[index] && listed && self.influences[index].touches(centre, radius)
        };
        let chosen: Vec<(usize, u32)> = self.ranked.iter().copied().filter(chosen).take(MOST).collect();
        let mut reads = ReflectionUse { strength: reflection.strength, ..NOTHING };
        reads.count = chosen.len() as u32;
        reads.per_point = u32::from(!self.is_one(&chosen, centre, radius));
        let weights = influence::weights(&self.influences, &chosen, centre);
        for (k, (&(index, _), weight)) in chosen.iter().zip(weights).enumerate() {
            (reads.probes[k], reads.weights[k]) = (index as u32, weight);
        }
        reads
    }

    /// Whether one set of weights does for a whole sphere: it is no wider than what the probes fade over, or all of
    /// it is well in the box of the first of them.
    fn is_one(&self, chosen: &[(usize, u32)], centre: Vec3, radius: f32) -> bool {
        let probes = chosen.iter().map(|&(index, _)| &self.influences[index]);
        let fade = probes.clone().map(|probe| probe.fade).fold(f32::INFINITY, f32::min);
        let alone = |probe: &Influence| probe.depth(centre) >= radius + 0.25 * probe.fade;
        let first_group = |index: usize| chosen.get(index).is_none_or(|second| second.1 != chosen[0].1);
        2.0 * radius <= fade || (probes.clone().next().is_some_and(alone) && first_group(1))
    }
}

/// Where another entity stands that the object takes its probes from.
fn anchor(reflection: &Reflection, now: &Now<'_>, origin: glam::DVec3) -> Option<Vec3> {
    let anchor = reflection.anchor?;
    let index = now.scene.entities.iter().position(|entity| entity.id == anchor)?;
    Some((now.world_from_local[index].translation - origin).as_vec3())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::instances::Pass;
    use crate::render::{Eye, View};
    use crate::scene::assets::Assets;
    use crate::scene::shape::Shape;
    use crate::scene::{Entity, MeshRenderer, MeshSource, ReflectionProbe, Scene};
    use glam::{DAffine3, DVec3};

    fn influence(x: f64) -> Influence {
        let world = DAffine3::from_translation(DVec3::new(x, 0.0, 0.0));
        Influence::new(&ReflectionProbe::default(), &world, DVec3::ZERO).expect("a box")
    }

    /// Two rooms side by side, probes 1 and 2.
    fn rooms() -> Ranked {
        Ranked::new(vec![(EntityId(1), influence(-2.6)), (EntityId(2), influence(2.6))])
    }

    /// What an object of 20 cm in the first room reads, as its author says; entity 9 stands in the second room.
    fn read(reflection: Reflection) -> ReflectionUse {
        let mesh = MeshRenderer {
            mesh: MeshSource::Shape(Shape::Sphere),
            materials: Vec::new(),
            casts_shadows: true,
            density: Default::default(),
            reflection,
        };
        let entity = |id| Entity { id: EntityId(id), ..Entity::default() };
        let object = Entity { mesh: Some(mesh), ..entity(3) };
        let scene = Scene { entities: vec![object, entity(9)], ..Scene::default() };
        let place = |x| DAffine3::from_translation(DVec3::new(x, 0.0, 0.0));
        let world = [place(-2.0), place(2.0)];
        let eye = Eye::looking(DVec3::Z, DVec3::ZERO);
        let view = View::Composite;
        let assets = Assets::default();
        let now = Now { scene: &scene, assets: &assets, world_from_local: &world, time: 0.0, eye, view };
        let draw = Draw {
            entity: Some(0),
            mesh: Some(0),
            instance: 0,
            indices: 0..3,
            material: 0,
            pass: Pass::Opaque,
            double_sided: false,
            bumped: false,
            mirrored: false,
            shown: true,
            casts: true,
            centre: Vec3::new(-2.0, 0.0, 0.0),
            radius: 0.1,
        };
        rooms().of(&draw, &now, DVec3::ZERO, &[true, true])
    }

    #[test]
    fn an_object_reads_the_probe_of_its_room_unless_its_author_says_otherwise() {
        let plain = read(Reflection::default());
        assert_eq!((plain.count, plain.probes[0], plain.weights[0], plain.per_point), (1, 0, 1.0, 0));
        let anchored = read(Reflection { anchor: Some(EntityId(9)), ..Reflection::default() });
        assert_eq!((anchored.count, anchored.probes[0], anchored.weights[0]), (1, 1, 1.0));
        let listed = |list: &[u64]| Some(list.iter().map(|&id| EntityId(id)).collect());
        assert_eq!(read(Reflection { probes: listed(&[2]), ..Reflection::default() }).count, 0);
        assert_eq!(read(Reflection { probes: listed(&[1]), ..Reflection::default() }).count, 1);
        assert_eq!(read(Reflection { strength: 0.25, ..Reflection::default() }).strength, 0.25);
    }

    #[test]
    fn a_small_object_has_one_set_of_weights_and_a_floor_has_many() {
        let ranked = rooms();
        let all = &ranked.ranked;
        assert!(ranked.is_one(all, Vec3::new(0.05, 0.0, 0.0), 0.1));
        assert!(!ranked.is_one(all, Vec3::new(0.3, 0.0, 0.0), 4.0));
        assert!(ranked.is_one(&all[..1], Vec3::new(-2.6, 0.0, 0.0), 1.0));
        assert_eq!(size_of::<ReflectionUse>(), 256);
    }
}
