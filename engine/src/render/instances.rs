//! What is drawn now: batches of the baked surface, and meshes of everything that moves or is in no bake.

use std::collections::{HashMap, HashSet};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use glam::{DAffine3, DVec3, Vec3};

use super::frame::Now;
use super::materials::Materials;
use super::meshes::Meshes;
use crate::gpu::Gpu;
use crate::gpu::buffer::Held;
use crate::scene::{Alpha, EntityId, MaterialId, Scene};
use crate::transport::{Batch, Transport};

/// The per-instance attributes of `Moving` in `scene/mesh.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Instance {
    /// Of world_from_local, world relative to the transport's origin.
    pub rows: [[f32; 4]; 3],
    /// Its own number, by which it finds its light in [`super::objects`].
    pub object: u32,
    pub mirrored: u32,
}

/// Triangles with one material at one place.
#[derive(Clone, Debug)]
pub struct Draw {
    /// Into the scene's; `None`: no more there.
    pub entity: Option<usize>,
    /// `None`: the baked surface.
    pub mesh: Option<usize>,
    /// Into the instances, for what moves.
    pub instance: u32,
    pub indices: Range<u32>,
    pub material: usize,
    pub pass: Pass,
    pub double_sided: bool,
    /// A normal map tilts what arrives: each pixel asks for the light of its own normal.
    pub bumped: bool,
    pub mirrored: bool,
    /// Seen by the camera, and by lights.
    pub shown: bool,
    pub casts: bool,
    /// Sphere about it, relative to the transport's origin.
    pub centre: Vec3,
    pub radius: f32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pass {
    Opaque,
    Mask,
    Blend,
}

pub struct Instances {
    pub draws: Vec<Draw>,
    /// Entity by entity.
    pub hidden: Vec<bool>,
    pub buffer: Held<Instance>,
    items: Vec<Instance>,
    /// Of each instance: its entity, and the middle of its bounding sphere, relative to the transport's origin.
    pub placed: Vec<(EntityId, Vec3)>,
    index_of: HashMap<EntityId, usize>,
    /// Static entities that the bake lights.
    baked: HashSet<EntityId>,
    /// Those of them that are elsewhere now, or of another shape: drawn as if they were in no bake.
    pub displaced: HashSet<EntityId>,
    /// Sphere about each batch of the baked surface.
    batches: Vec<(Vec3, f32)>,
    /// Likewise: has it directional terms?
    directional: Vec<bool>,
}

impl Instances {
    pub fn new(gpu: &Gpu, transport: &Transport) -> Self {
        let surface = &transport.surface;
        let batches = surface
            .batches
            .iter()
            .map(|batch| {
                let triangles = &surface.triangles[batch.first as usize..][..batch.count as usize];
                sphere(triangles.iter().flatten().map(|&vertex| surface.vertices[vertex as usize].position))
            })
            .collect();
        Self {
            draws: Vec::new(),
            hidden: Vec::new(),
            buffer: Held::new(gpu, "instances", wgpu::BufferUsages::VERTEX),
            items: Vec::new(),
            placed: Vec::new(),
            index_of: HashMap::new(),
            baked: surface.batches.iter().map(Batch::entity).collect(),
            displaced: HashSet::new(),
            batches,
            directional: surface.batches.iter().map(|batch| transport.is_directional(batch)).collect(),
        }
    }

    /// Follows the scene.
    pub fn update(
        &mut self,
        gpu: &Gpu,
        now: &Now<'_>,
        transport: &Transport,
        materials: &Materials,
        meshes: &mut Meshes,
    ) {
        self.index_of.clear();
        self.index_of.extend(now.scene.entities.iter().enumerate().map(|(index, entity)| (entity.id, index)));
        self.hidden = hidden(now.scene, &self.index_of);
        self.draws.clear();
        self.items.clear();
        self.placed.clear();
        self.place_batches(now, transport, materials);
        for index in 0..now.scene.entities.len() {
            self.place_moving(gpu, now, transport, materials, meshes, index);
        }
        self.buffer.write(gpu, &self.items);
    }

    /// By itself or by one of its parents.
    pub fn is_hidden(&self, entity: EntityId) -> bool {
        self.index_of.get(&entity).is_none_or(|&index| self.hidden[index])
    }

    /// A number for all that is drawn: where what moves stands, what is shown, and of which material.
    pub fn signature(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        for draw in &self.draws {
            (draw.mesh, draw.shown, draw.material, &draw.indices).hash(&mut hasher);
        }
        bytemuck::cast_slice::<_, u8>(&self.items).hash(&mut hasher);
        hasher.finish()
    }

    /// A number for something that moves: where it stands, and of which material it is.
    pub fn stamp(&self, draw: &Draw, hasher: &mut DefaultHasher) {
        (draw.mesh, draw.shown, draw.material, &draw.indices).hash(hasher);
        let instance = draw.mesh.and_then(|_| self.items.get(draw.instance as usize));
        bytemuck::cast_slice::<_, u8>(&instance.map_or([[0.0; 4]; 3], |instance| instance.rows)).hash(hasher);
    }

    /// Whether anything is drawn that the bake does not light.
    pub fn any_moving(&self) -> bool {
        !self.items.is_empty()
    }

    fn place_batches(&mut self, now: &Now<'_>, transport: &Transport, materials: &Materials) {
        let batches = transport.surface.batches.iter().zip(&self.batches).zip(&self.directional);
        for ((batch, &(centre, radius)), &directional) in batches {
            let entity = self.index_of.get(&batch.entity()).copied();
            let stays = !self.displaced.contains(&batch.entity());
            let placed = entity
                .filter(|&entity| stays && now.scene.entities[entity].is_static && !self.hidden[entity]);
            let renderer = placed.and_then(|entity| now.scene.entities[entity].mesh.as_ref());
            let shown = renderer.is_some();
            let material = materials.index(MaterialId(batch.material));
            self.draws.push(Draw {
                entity,
                mesh: None,
                instance: 0,
                indices: batch.first * 3..(batch.first + batch.count) * 3,
                material,
                pass: pass_of(materials, material),
                double_sided: batch.double_sided == 1,
                bumped: directional && materials.material(material).normal_texture.is_some(),
                mirrored: false,
                shown,
                casts: renderer.is_some_and(|renderer| renderer.casts_shadows),
                centre,
                radius,
            });
        }
    }

    fn place_moving(
        &mut self,
        gpu: &Gpu,
        now: &Now<'_>,
        transport: &Transport,
        materials: &Materials,
        meshes: &mut Meshes,
        index: usize,
    ) {
        let entity = &now.scene.entities[index];
        // What is static, but not in the bake, is drawn as if it moved.
        let is_baked =
            entity.is_static && self.baked.contains(&entity.id) && !self.displaced.contains(&entity.id);
        let Some(renderer) = entity.mesh.as_ref().filter(|_| !is_baked && !self.hidden[index]) else {
            return;
        };
        let Some(mesh_index) = meshes.find(gpu, now.assets, &renderer.mesh) else { return };
        let mesh = &meshes.all[mesh_index];
        let world = &now.world_from_local[index];
        let (centre, radius) = moved_sphere(world, mesh.low, mesh.high, transport.origin);
        let instance = self.items.len() as u32;
        let mirrored = world.matrix3.determinant() < 0.0;
        self.items.push(Instance {
            rows: rows(world, transport.origin),
            object: instance,
            mirrored: u32::from(mirrored),
        });
        self.placed.push((entity.id, centre));
        for (at, primitive) in mesh.primitives.iter().enumerate() {
            let id = renderer.materials.get(at).or(renderer.materials.last()).copied();
            let material = id.map_or(0, |id| materials.index(id));
            self.draws.push(Draw {
                entity: Some(index),
                mesh: Some(mesh_index),
                instance,
                indices: primitive.first..primitive.first + primitive.count,
                material,
                pass: pass_of(materials, material),
                double_sided: materials.material(material).double_sided,
                bumped: materials.material(material).normal_texture.is_some(),
                mirrored,
                shown: true,
                casts: renderer.casts_shadows,
                centre,
                radius,
            });
        }
    }
}

/// Entities that are hidden themselves or stand under one that is.
fn hidden(scene: &Scene, index_of: &HashMap<EntityId, usize>) -> Vec<bool> {
    let up = |mut index: usize| {
        // No chain is longer than there are entities: a circle ends too.
        for _ in 0..scene.entities.len() {
            let entity = &scene.entities[index];
            if entity.hidden {
                return true;
            }
            match entity.parent.and_then(|parent| index_of.get(&parent)) {
                Some(&parent) => index = parent,
                None => return false,
            }
        }
        false
    };
    (0..scene.entities.len()).map(up).collect()
}

fn pass_of(materials: &Materials, material: usize) -> Pass {
    match materials.material(material).alpha {
        Alpha::Opaque => Pass::Opaque,
        Alpha::Mask { .. } => Pass::Mask,
        Alpha::Blend => Pass::Blend,
    }
}

pub(super) fn rows(world: &DAffine3, origin: DVec3) -> [[f32; 4]; 3] {
    let (m, t) = (world.matrix3, world.translation - origin);
    [0, 1, 2].map(|i| [m.x_axis[i] as f32, m.y_axis[i] as f32, m.z_axis[i] as f32, t[i] as f32])
}

/// A sphere about a box after its transform, relative to `origin`.
fn moved_sphere(world: &DAffine3, low: Vec3, high: Vec3, origin: DVec3) -> (Vec3, f32) {
    let corner = |i: usize| {
        let pick = |axis: usize| if i >> axis & 1 == 1 { high[axis] } else { low[axis] };
        let at = DVec3::new(pick(0).into(), pick(1).into(), pick(2).into());
        (world.transform_point3(at) - origin).as_vec3()
    };
    sphere((0..8).map(corner))
}

/// About the middle of the points' box.
fn sphere(points: impl Iterator<Item = Vec3> + Clone) -> (Vec3, f32) {
    let Some(first) = points.clone().next() else { return (Vec3::ZERO, 0.0) };
    let (low, high) =
        points.clone().fold((first, first), |(low, high), point| (low.min(point), high.max(point)));
    let centre = (low + high) * 0.5;
    (centre, points.map(|point| point.distance(centre)).fold(0.0, f32::max))
}
