//! The scene as it is shown now: the authored one, or the copy that plays.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use engine::play::world::placed_at;
use engine::render::{Eye, Now, View};
use engine::scene::assets::Assets;
use engine::scene::{Entity, EntityId, Mesh, Scene};
use engine::transport::{Batch, Transport};
use glam::{DAffine3, DVec3, Vec3};

use crate::document::Document;
use crate::play::Play;

/// Where everything authored stands; kept from picture to picture until the document changes.
#[derive(Default)]
pub struct Placed {
    revision: Option<u64>,
    pub world_from_local: Vec<DAffine3>,
    /// Of what is in the bake, but elsewhere or in another shape there.
    pub displaced: HashSet<EntityId>,
}

/// Where the bake has what it holds.
#[derive(Default)]
pub struct AsBaked {
    /// And the mesh as it was read then.
    placed: HashMap<EntityId, (DAffine3, Option<Arc<Mesh>>)>,
}

impl AsBaked {
    /// Of a scene that the transport was baked from, as far as it holds it.
    pub fn of(scene: &Scene, assets: &Assets, transport: &Transport) -> Self {
        let world_from_local = placed_at(scene, assets, 0.0);
        let baked: HashSet<EntityId> = transport.surface.batches.iter().map(Batch::entity).collect();
        let placed = scene.entities.iter().zip(world_from_local).filter_map(|(entity, world)| {
            let mesh = entity.mesh.as_ref().filter(|_| baked.contains(&entity.id))?;
            Some((entity.id, (world, assets.meshes.get(&mesh.mesh).cloned())))
        });
        Self { placed: placed.collect() }
    }

    /// A file that was renamed holds the same mesh; one that changed does not.
    fn holds(&self, entity: &Entity, world: &DAffine3, assets: &Assets) -> bool {
        let Some((baked, mesh)) = self.placed.get(&entity.id) else { return true };
        let now = entity.mesh.as_ref().map(|renderer| assets.meshes.get(&renderer.mesh));
        baked == world && now.is_some_and(|now| now.map(Arc::as_ptr) == mesh.as_ref().map(Arc::as_ptr))
    }
}

impl Placed {
    pub fn follow(&mut self, document: &Document, assets: &Assets, baked: &AsBaked) {
        if self.revision == Some(document.revision()) {
            return;
        }
        self.revision = Some(document.revision());
        let scene = document.scene();
        self.world_from_local = placed_at(scene, assets, 0.0);
        let elsewhere = scene
            .entities
            .iter()
            .zip(&self.world_from_local)
            .filter(|(entity, world)| !baked.holds(entity, world, assets));
        self.displaced = elsewhere.map(|(entity, _)| entity.id).collect();
    }

    /// The next time everything is placed anew.
    pub fn forget(&mut self) {
        self.revision = None;
    }
}

#[derive(Clone, Copy)]
pub struct Scenery<'a> {
    pub scene: &'a Scene,
    pub assets: &'a Assets,
    pub world_from_local: &'a [DAffine3],
    pub time: f64,
    pub revision: u64,
    pub is_playing: bool,
    pub displaced: &'a HashSet<EntityId>,
}

impl<'a> Scenery<'a> {
    pub fn of(
        document: &'a Document,
        assets: &'a Assets,
        placed: &'a Placed,
        play: Option<&'a Play>,
    ) -> Self {
        let displaced = &placed.displaced;
        match play {
            Some(play) => Self {
                scene: &play.scene,
                assets,
                world_from_local: &play.world_from_local,
                time: play.time(),
                revision: u64::MAX,
                is_playing: true,
                displaced,
            },
            None => Self {
                scene: document.scene(),
                assets,
                world_from_local: &placed.world_from_local,
                time: 0.0,
                revision: document.revision(),
                is_playing: false,
                displaced,
            },
        }
    }

    pub fn now(&self, eye: Eye, view: View) -> Now<'a> {
        Now {
            scene: self.scene,
            assets: self.assets,
            world_from_local: self.world_from_local,
            time: self.time,
            eye,
            view,
        }
    }

    pub fn placed(&self) -> impl Iterator<Item = (&'a Entity, &'a DAffine3)> + use<'a> {
        self.scene.entities.iter().zip(self.world_from_local)
    }

    /// Of the scene's camera; `None`: it has none.
    pub fn camera(&self) -> Option<Eye> {
        Eye::of_scene(self.scene, self.world_from_local)
    }

    /// The box about all that is chosen, in the world: about surfaces, light probes and boxes of reflection probes; half a
    /// metre about what has none of them.
    pub fn extent(&self, chosen: impl Fn(&Entity) -> bool) -> Option<(DVec3, DVec3)> {
        let mut both: Option<(DVec3, DVec3)> = None;
        for (entity, world) in self.placed().filter(|(entity, _)| chosen(entity)) {
            for point in self.points(entity, world) {
                let (low, high) = both.unwrap_or((point, point));
                both = Some((low.min(point), high.max(point)));
            }
        }
        both
    }

    fn points(&self, entity: &Entity, world: &DAffine3) -> Vec<DVec3> {
        let place = |at: &Vec3| world.transform_point3(at.as_dvec3());
        let mesh = entity.mesh.as_ref().and_then(|renderer| self.assets.meshes.get(&renderer.mesh));
        if let Some(mesh) = mesh {
            return mesh.positions.iter().map(place).collect();
        }
        if let Some(group) = entity.light_probes.as_ref().filter(|group| !group.positions.is_empty()) {
            return group.positions.iter().map(place).collect();
        }
        if let Some(probe) = &entity.reflection_probe {
            let corner =
                |n: u32| Vec3::from([0, 1, 2].map(|axis| if n >> axis & 1 == 0 { -1.0 } else { 1.0 }));
            return (0..8).map(|n| place(&(probe.offset + probe.half_size * corner(n)))).collect();
        }
        [-0.5, 0.5].map(|off| world.translation + DVec3::splat(off)).to_vec()
    }
}
