//! Nodes become entities: one each, in the order of the hierarchy.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use glam::{DMat4, DQuat, DVec3, Vec3};
use gltf::accessor::{DataType, Iter};
use gltf::animation::util::Rotations;
use gltf::{Accessor, Document, Mesh, Node, Primitive};
use serde_json::Value;

use super::accessor::{ROTATIONS, VECTORS, bytes_of, read};
use super::mesh::{makes_triangles, mesh_name};
use super::{Gltf, Placement, animation, check, find, lights, material, matrix};
use crate::scene::{
    Density, Entity, EntityId, MaterialId, MeshRenderer, MeshSource, Motion, Reflection, Scene, Transform,
    Warning,
};

/// The file's default scene, or its first, or all nodes, or all meshes: whichever is there.
pub fn scene(project: &Path, gltf: &Gltf) -> Result<(Scene, Vec<Warning>), String> {
    let mut warnings = Vec::new();
    let mut materials = material::materials(project, gltf, &mut warnings)?;
    let mut made = Made::new(gltf, warnings);
    if gltf.placements.is_empty() {
        made.meshes();
    } else {
        made.nodes(roots(&gltf.document))?;
    }
    if made.default_is_used {
        materials.push(material::default_material(default_id(gltf)));
    }
    made.warn_of_what_is_lost();
    let mut lost = Vec::new();
    let sky = lights::sky(&gltf.document, &mut lost);
    lost.into_iter().for_each(|message| made.warn(message));
    Ok((Scene { sky, materials, entities: made.entities }, made.warnings))
}

pub const INSTANCING: &str = "EXT_mesh_gpu_instancing";

/// A few bytes can ask for any number of instances.
const MOST_ENTITIES: usize = 1 << 20;

/// A node that is about to become an entity.
struct Pending<'a> {
    node: Node<'a>,
    parent: Option<EntityId>,
}

struct Made<'a> {
    gltf: &'a Gltf,
    animation_of_node: HashMap<usize, u32>,
    /// Nodes that an animation moves or carries.
    moving: HashSet<usize>,
    entities: Vec<Entity>,
    /// Ids up to the number of nodes are the nodes' own; others follow.
    next_id: u64,
    default_is_used: bool,
    warnings: Vec<Warning>,
}

impl<'a> Made<'a> {
    fn new(gltf: &'a Gltf, warnings: Vec<Warning>) -> Self {
        let animation_of_node = animation::animation_of_node(&gltf.document);
        Self {
            gltf,
            moving: animation::moving_nodes(&gltf.document, animation_of_node.keys().copied()),
            animation_of_node,
            entities: Vec::new(),
            next_id: gltf.placements.len() as u64 + 1,
            default_is_used: false,
            warnings,
        }
    }

    fn warn(&mut self, message: String) {
        self.warnings.push(Warning::new(&self.gltf.file, message));
    }

    fn nodes(&mut self, roots: Vec<Node<'a>>) -> Result<(), String> {
        let mut stack: Vec<Pending> =
            roots.into_iter().rev().map(|node| Pending { node, parent: None }).collect();
        let mut seen = HashSet::new();
        while let Some(next) = stack.pop() {
            let (node, index) = (&next.node, next.node.index());
            if !seen.insert(index) {
                self.warn(format!("node {index} stands in more than one place; the first is taken"));
                continue;
            }
            let id = self.node(&next).map_err(|message| format!("{}: {message}", name(node)))?;
            let children: Vec<Node> = node.children().collect();
            stack.extend(children.into_iter().rev().map(|node| Pending { node, parent: Some(id) }));
        }
        Ok(())
    }

    /// The entity that the node's children belong to.
    fn node(&mut self, pending: &Pending<'a>) -> Result<EntityId, String> {
        let (node, index) = (&pending.node, pending.node.index());
        let (transform, before) = transform(&self.gltf.placements[index])?;
        let mut entity = Entity {
            id: EntityId(index as u64 + 1),
            name: name(node),
            parent: pending.parent,
            transform,
            motion: self.motion(index),
            ..Entity::default()
        };
        if let Some(rotation) = before {
            // The shear's second rotation: what the node carries hangs below it.
            let inner = Transform { rotation, ..Transform::default() };
            let inner = self.child(&entity, format!("{} (sheared)", entity.name), inner);
            self.entities.push(std::mem::replace(&mut entity, inner));
        }
        let mut lost = Vec::new();
        entity.light = lights::light(self.gltf, node, &mut lost);
        entity.camera = lights::camera(self.gltf, node, &mut lost);
        lost.into_iter().for_each(|message| self.warn(message));
        let id = entity.id;
        let mesh = node.mesh().and_then(|mesh| self.renderer(&mesh));
        let is_static = !self.moving.contains(&index) && !self.skin_moves(node);
        match (mesh, node.extension_value(INSTANCING)) {
            (Some(mesh), Some(instancing)) => {
                let instances = self.instances(&entity, instancing, mesh, is_static)?;
                self.entities.push(entity);
                self.entities.extend(instances);
            }
            (mesh, _) => {
                entity.is_static = mesh.is_some() && is_static;
                entity.mesh = mesh;
                self.entities.push(entity);
            }
        }
        Ok(id)
    }

    fn motion(&self, node: usize) -> Option<Motion> {
        let animation = *self.animation_of_node.get(&node)?;
        Some(Motion::Clip { file: self.gltf.file.clone(), animation, node: node as u32, speed: 1.0 })
    }

    fn child(&mut self, parent: &Entity, name: String, transform: Transform) -> Entity {
        let id = EntityId(self.next_id);
        self.next_id += 1;
        Entity { id, name, parent: Some(parent.id), transform, ..Entity::default() }
    }

    /// A file without nodes: its meshes, at the origin.
    fn meshes(&mut self) {
        for mesh in self.gltf.document.meshes() {
            let Some(renderer) = self.renderer(&mesh) else { continue };
            let name = mesh.name().map_or_else(|| format!("mesh {}", mesh.index()), str::to_owned);
            let id = EntityId(mesh.index() as u64 + 1);
            let mesh = Some(renderer);
            self.entities.push(Entity { id, name, is_static: true, mesh, ..Entity::default() });
        }
    }

    /// `None` for a mesh of points and lines alone.
    fn renderer(&mut self, mesh: &Mesh) -> Option<MeshRenderer> {
        let (drawn, left_out): (Vec<Primitive>, Vec<Primitive>) =
            mesh.primitives().partition(makes_triangles);
        let material = |primitive: &Primitive| match primitive.material().index() {
            Some(index) => MaterialId(index as u32),
            None => default_id(self.gltf),
        };
        let materials: Vec<MaterialId> = drawn.iter().map(material).collect();
        self.default_is_used |= materials.contains(&default_id(self.gltf));
        if !left_out.is_empty() {
            self.warn(format!(
                "{}: {} primitives of points, lines or no positions were left out",
                mesh_name(mesh),
                left_out.len()
            ));
        }
        let source = MeshSource::File { file: self.gltf.file.clone(), mesh: mesh.index() as u32 };
        (!drawn.is_empty()).then(|| renderer(source, materials))
    }

    /// EXT_mesh_gpu_instancing: one child for each instance.
    fn instances(
        &mut self,
        parent: &Entity,
        instancing: &Value,
        mesh: MeshRenderer,
        is_static: bool,
    ) -> Result<Vec<Entity>, String> {
        let transforms = instance_transforms(self.gltf, instancing)?;
        if self.entities.len() + transforms.len() > MOST_ENTITIES {
            return Err(format!("its instances make more than {MOST_ENTITIES} entities"));
        }
        let mut made = Vec::with_capacity(transforms.len());
        for (n, transform) in transforms.into_iter().enumerate() {
            let child = self.child(parent, format!("{} {n}", parent.name), transform);
            made.push(Entity { mesh: Some(mesh.clone()), is_static, ..child });
        }
        Ok(made)
    }

    /// Whether a joint of the node's skin moves: then the skinned mesh is no part of the static scene.
    fn skin_moves(&self, node: &Node) -> bool {
        node.skin().is_some_and(|skin| skin.joints().any(|joint| self.moving.contains(&joint.index())))
    }

    fn warn_of_what_is_lost(&mut self) {
        let document = &self.gltf.document;
        check::lost_extensions(self.gltf).into_iter().for_each(|message| self.warn(message));
        if document.nodes().any(|node| node.skin().is_some() && node.mesh().is_some()) {
            self.warn("has skinned meshes: they are shown as modelled, without their bones".to_owned());
        }
        let mut primitives = document.meshes().flat_map(|mesh| mesh.primitives());
        if animation::morphs(document) || primitives.any(|primitive| primitive.morph_targets().len() > 0) {
            self.warn("has morph targets: meshes are shown without them".to_owned());
        }
    }
}

fn default_id(gltf: &Gltf) -> MaterialId {
    MaterialId(gltf.document.materials().len() as u32)
}

fn renderer(mesh: MeshSource, materials: Vec<MaterialId>) -> MeshRenderer {
    let (density, reflection) = (Density::default(), Reflection::default());
    MeshRenderer { mesh, materials, casts_shadows: true, density, reflection }
}

fn roots(document: &Document) -> Vec<Node<'_>> {
    if let Some(scene) = document.default_scene().or_else(|| document.scenes().next()) {
        return scene.nodes().collect();
    }
    let children: HashSet<usize> =
        document.nodes().flat_map(|node| node.children()).map(|child| child.index()).collect();
    document.nodes().filter(|node| !children.contains(&node.index())).collect()
}

fn name(node: &Node) -> String {
    let name = node.name().filter(|name| !name.is_empty());
    name.map_or_else(|| format!("node {}", node.index()), str::to_owned)
}

fn transform(placement: &Placement) -> Result<(Transform, Option<DQuat>), String> {
    let Some(columns) = &placement.matrix else {
        let rotation = DQuat::from_array(placement.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]));
        let transform = Transform {
            translation: placement.translation.map_or(DVec3::ZERO, DVec3::from),
            rotation: unit(rotation).ok_or("its rotation is no direction")?,
            scale: placement.scale.map_or(DVec3::ONE, DVec3::from),
        };
        return Ok((transform, None));
    };
    let found = matrix::decomposed(DMat4::from_cols_array(columns));
    let usable = found.0.is_finite() && found.1.is_none_or(DQuat::is_finite);
    if usable { Ok(found) } else { Err("its matrix is not finite".to_owned()) }
}

/// Files round rotations to f32; a scene's are of length 1 in f64.
fn unit(rotation: DQuat) -> Option<DQuat> {
    let length = rotation.length();
    let usable = length.is_finite() && length > 1e-6;
    usable.then(|| if length == 1.0 { rotation } else { rotation * (1.0 / length) })
}

/// The extension is unknown to the crate: its attributes are accessors.
fn instance_transforms(gltf: &Gltf, instancing: &Value) -> Result<Vec<Transform>, String> {
    let accessor = |name: &str| {
        let index = instancing["attributes"][name].as_u64();
        index.map(|index| find(gltf.document.accessors(), index as usize, "accessor")).transpose()
    };
    let vectors = |name: &str| accessor(name)?.map(|accessor| vectors(gltf, accessor)).transpose();
    let (places, scales) = (vectors("TRANSLATION")?, vectors("SCALE")?);
    let turns = accessor("ROTATION")?.map(|accessor| rotations(gltf, accessor)).transpose()?;
    let lengths =
        [places.as_ref().map(Vec::len), turns.as_ref().map(Vec::len), scales.as_ref().map(Vec::len)];
    let count = lengths.into_iter().flatten().max().unwrap_or(0);
    if lengths.into_iter().flatten().any(|length| length != count) {
        return Err("its instances have attributes of different lengths".to_owned());
    }
    let mut transforms = vec![Transform::default(); count];
    for (to, place) in transforms.iter_mut().zip(places.into_iter().flatten()) {
        to.translation = Vec3::from(place).as_dvec3();
    }
    for (to, xyzw) in transforms.iter_mut().zip(turns.into_iter().flatten()) {
        to.rotation = unit(DQuat::from_array(xyzw.map(f64::from)))
            .ok_or("the rotation of an instance is no direction")?;
    }
    for (to, scale) in transforms.iter_mut().zip(scales.into_iter().flatten()) {
        to.scale = Vec3::from(scale).as_dvec3();
    }
    Ok(transforms)
}

fn vectors(gltf: &Gltf, accessor: Accessor) -> Result<Vec<[f32; 3]>, String> {
    read(gltf, &accessor, VECTORS, [0.0; 3], || Iter::new(accessor.clone(), bytes_of(gltf)))
}

fn rotations(gltf: &Gltf, accessor: Accessor) -> Result<Vec<[f32; 4]>, String> {
    let (of, bytes) = (accessor.clone(), bytes_of(gltf));
    let rotations = || match accessor.data_type() {
        DataType::I8 => Iter::new(of, bytes).map(Rotations::I8),
        DataType::U8 => Iter::new(of, bytes).map(Rotations::U8),
        DataType::I16 => Iter::new(of, bytes).map(Rotations::I16),
        DataType::U16 => Iter::new(of, bytes).map(Rotations::U16),
        DataType::F32 => Iter::new(of, bytes).map(Rotations::F32),
        DataType::U32 => None,
    };
    read(gltf, &accessor, ROTATIONS, [0.0; 4], || rotations().map(Rotations::into_f32))
}
