//! Nodes become entities: one each, in the order of the hierarchy.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use glam::{DMat4, DQuat, DVec3, Vec3};

use super::json::{self, Node, Root, extension, get};
use super::mesh::{makes_triangles, mesh_name};
use super::{Gltf, accessor, animation, lights, lost_extensions, material, matrix};
use crate::scene::{
    Density, Entity, EntityId, MaterialId, MeshRenderer, MeshSource, Motion, Reflection, Scene, Transform,
    Warning,
};

/// The file's default scene, or its first, or all nodes, or all meshes: whichever is there.
pub fn scene(project: &Path, gltf: &Gltf) -> Result<(Scene, Vec<Warning>), String> {
    let mut warnings = Vec::new();
    let mut materials = material::materials(project, gltf, &mut warnings)?;
    let mut made = Made::new(gltf, warnings);
    if gltf.root.nodes.is_empty() {
        made.meshes()?;
    } else {
        made.nodes(roots(&gltf.root)?)?;
    }
    if made.default_is_used {
        materials.push(material::default_material(default_id(gltf)));
    }
    made.warn_of_what_is_lost();
    let mut lost = Vec::new();
    let sky = lights::sky(&gltf.root, &mut lost);
    lost.into_iter().for_each(|message| made.warn(message));
    Ok((Scene { sky, materials, entities: made.entities }, made.warnings))
}

/// A few bytes can ask for any number of instances.
const MOST_ENTITIES: usize = 1 << 20;

/// A node that is about to become an entity.
struct Pending {
    node: usize,
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
        let animation_of_node = animation::animation_of_node(&gltf.root);
        Self {
            gltf,
            moving: animation::moving_nodes(&gltf.root, animation_of_node.keys().copied()),
            animation_of_node,
            entities: Vec::new(),
            next_id: gltf.root.nodes.len() as u64 + 1,
            default_is_used: false,
            warnings,
        }
    }

    fn warn(&mut self, message: String) {
        self.warnings.push(Warning::new(&self.gltf.file, message));
    }

    fn nodes(&mut self, roots: Vec<usize>) -> Result<(), String> {
        let mut stack: Vec<Pending> =
            roots.into_iter().rev().map(|node| Pending { node, parent: None }).collect();
        let mut seen = HashSet::new();
        while let Some(next) = stack.pop() {
            if !seen.insert(next.node) {
                self.warn(format!("node {} stands in more than one place; the first is taken", next.node));
                continue;
            }
            let node = get(&self.gltf.root.nodes, next.node, "node")?;
            let id = self.node(&next).map_err(|message| format!("{}: {message}", name(node, next.node)))?;
            stack.extend(node.children.iter().rev().map(|&child| Pending { node: child, parent: Some(id) }));
        }
        Ok(())
    }

    /// The entity that the node's children belong to.
    fn node(&mut self, pending: &Pending) -> Result<EntityId, String> {
        let node = &self.gltf.root.nodes[pending.node];
        let (transform, before) = transform(node)?;
        let mut entity = Entity {
            id: EntityId(pending.node as u64 + 1),
            name: name(node, pending.node),
            parent: pending.parent,
            transform,
            motion: self.motion(pending.node),
            ..Entity::default()
        };
        if let Some(rotation) = before {
            // The shear's second rotation: what the node carries hangs below it.
            let inner = Transform { rotation, ..Transform::default() };
            let inner = self.child(&entity, format!("{} (sheared)", entity.name), inner);
            self.entities.push(std::mem::replace(&mut entity, inner));
        }
        let mut lost = Vec::new();
        entity.light = lights::light(self.gltf, node, &mut lost)?;
        entity.camera = lights::camera(self.gltf, node, &mut lost)?;
        lost.into_iter().for_each(|message| self.warn(message));
        let id = entity.id;
        let mesh = node.mesh.map(|mesh| self.renderer(mesh)).transpose()?.flatten();
        let is_static = !self.moving.contains(&pending.node) && !self.skin_moves(node)?;
        let instances: Option<json::Instancing> = extension(&node.extensions, "EXT_mesh_gpu_instancing")?;
        match (mesh, instances) {
            (Some(mesh), Some(instances)) => {
                let instances = self.instances(&entity, &instances, mesh, is_static)?;
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
    fn meshes(&mut self) -> Result<(), String> {
        for n in 0..self.gltf.root.meshes.len() {
            let Some(renderer) = self.renderer(n)? else { continue };
            let name = self.gltf.root.meshes[n].name.clone().unwrap_or_else(|| format!("mesh {n}"));
            let id = EntityId(n as u64 + 1);
            self.entities.push(Entity {
                id,
                name,
                is_static: true,
                mesh: Some(renderer),
                ..Entity::default()
            });
        }
        Ok(())
    }

    /// `None` for a mesh of points and lines alone.
    fn renderer(&mut self, mesh: usize) -> Result<Option<MeshRenderer>, String> {
        let authored = get(&self.gltf.root.meshes, mesh, "mesh")?;
        let drawn: Vec<_> =
            authored.primitives.iter().filter(|primitive| makes_triangles(primitive)).collect();
        let mut materials = Vec::with_capacity(drawn.len());
        for primitive in &drawn {
            let material = primitive.material.unwrap_or(self.gltf.root.materials.len());
            self.default_is_used |= primitive.material.is_none();
            if primitive.material.is_some() {
                get(&self.gltf.root.materials, material, "material")?;
            }
            materials.push(MaterialId(material as u32));
        }
        if drawn.len() < authored.primitives.len() {
            let left_out = authored.primitives.len() - drawn.len();
            self.warn(format!(
                "{}: {left_out} primitives of points, lines or no positions were left out",
                mesh_name(self.gltf, mesh)
            ));
        }
        if drawn.is_empty() {
            return Ok(None);
        }
        let source = MeshSource::File { file: self.gltf.file.clone(), mesh: mesh as u32 };
        Ok(Some(renderer(source, materials)))
    }

    /// EXT_mesh_gpu_instancing: one child for each instance.
    fn instances(
        &mut self,
        parent: &Entity,
        instancing: &json::Instancing,
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
    fn skin_moves(&self, node: &Node) -> Result<bool, String> {
        let Some(skin) = node.skin else { return Ok(false) };
        let skin = get(&self.gltf.root.skins, skin, "skin")?;
        Ok(skin.joints.iter().any(|joint| self.moving.contains(joint)))
    }

    fn warn_of_what_is_lost(&mut self) {
        lost_extensions(self.gltf).into_iter().for_each(|message| self.warn(message));
        if self.gltf.root.nodes.iter().any(|node| node.skin.is_some() && node.mesh.is_some()) {
            self.warn("has skinned meshes: they are shown as modelled, without their bones".to_owned());
        }
        let primitives = self.gltf.root.meshes.iter().flat_map(|mesh| &mesh.primitives);
        if animation::morphs(&self.gltf.root)
            || primitives.into_iter().any(|primitive| !primitive.targets.is_empty())
        {
            self.warn("has morph targets: meshes are shown without them".to_owned());
        }
    }
}

fn default_id(gltf: &Gltf) -> MaterialId {
    MaterialId(gltf.root.materials.len() as u32)
}

fn renderer(mesh: MeshSource, materials: Vec<MaterialId>) -> MeshRenderer {
    let (density, reflection) = (Density::default(), Reflection::default());
    MeshRenderer { mesh, materials, casts_shadows: true, density, reflection }
}

fn roots(root: &Root) -> Result<Vec<usize>, String> {
    if root.scenes.is_empty() {
        let children: HashSet<usize> =
            root.nodes.iter().flat_map(|node| node.children.iter().copied()).collect();
        return Ok((0..root.nodes.len()).filter(|node| !children.contains(node)).collect());
    }
    get(&root.scenes, root.scene.unwrap_or(0), "scene").map(|scene| scene.nodes.clone())
}

fn name(node: &Node, index: usize) -> String {
    node.name.clone().filter(|name| !name.is_empty()).unwrap_or_else(|| format!("node {index}"))
}

fn transform(node: &Node) -> Result<(Transform, Option<DQuat>), String> {
    let Some(columns) = &node.matrix else {
        let rotation = DQuat::from_array(node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]));
        let transform = Transform {
            translation: node.translation.map_or(DVec3::ZERO, DVec3::from),
            rotation: unit(rotation).ok_or("its rotation is no direction")?,
            scale: node.scale.map_or(DVec3::ONE, DVec3::from),
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

fn instance_transforms(gltf: &Gltf, instancing: &json::Instancing) -> Result<Vec<Transform>, String> {
    let read = |name: &str, width: usize| match instancing.attributes.get(name) {
        Some(&index) => accessor::floats(gltf, index, &[width]).map(Some),
        None => Ok(None),
    };
    let places = read("TRANSLATION", 3)?;
    let rotations = read("ROTATION", 4)?;
    let scales = read("SCALE", 3)?;
    let lengths: Vec<usize> =
        [&places, &rotations, &scales].into_iter().flatten().map(accessor::Rows::len).collect();
    let count = lengths.first().copied().unwrap_or(0);
    if lengths.iter().any(|&length| length != count) {
        return Err("its instances have attributes of different lengths".to_owned());
    }
    let mut transforms = vec![Transform::default(); count];
    for (to, place) in transforms.iter_mut().zip(places.iter().flat_map(accessor::Rows::arrays::<3>)) {
        to.translation = Vec3::from(place).as_dvec3();
    }
    for (to, xyzw) in transforms.iter_mut().zip(rotations.iter().flat_map(accessor::Rows::arrays::<4>)) {
        to.rotation = unit(DQuat::from_array(xyzw.map(f64::from)))
            .ok_or("the rotation of an instance is no direction")?;
    }
    for (to, scale) in transforms.iter_mut().zip(scales.iter().flat_map(accessor::Rows::arrays::<3>)) {
        to.scale = Vec3::from(scale).as_dvec3();
    }
    Ok(transforms)
}
