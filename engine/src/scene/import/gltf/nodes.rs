//! Nodes become entities: one each, in the order of the hierarchy.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use glam::{DMat4, DQuat, DVec3, Vec3};

use super::json::{self, Node, Root, extension, get};
use super::mesh::{makes_triangles, mesh_name};
use super::{Gltf, accessor, animation, lost_extensions, material, matrix};
use crate::scene::{
    Camera, Density, Entity, EntityId, Light, LightKind, MaterialId, MeshRenderer, MeshSource, Motion,
    Projection, Reflection, Scene, Sky, SkyKind, Transform, Warning,
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
    let sky = sky(&gltf.root).map_err(|message| format!("extras.sky_radiance: {message}"))?;
    Ok((Scene { sky, materials, entities: made.entities }, made.warnings))
}

/// A node that is about to become an entity.
struct Pending {
    node: usize,
    parent: Option<EntityId>,
    /// Something above it moves.
    carried: bool,
}

struct Made<'a> {
    gltf: &'a Gltf,
    animation_of_node: HashMap<usize, u32>,
    entities: Vec<Entity>,
    /// Ids up to the number of nodes are the nodes' own; others follow.
    next_id: u64,
    default_is_used: bool,
    warnings: Vec<Warning>,
}

impl<'a> Made<'a> {
    fn new(gltf: &'a Gltf, warnings: Vec<Warning>) -> Self {
        let animation_of_node = animation::animation_of_node(&gltf.root);
        let next_id = gltf.root.nodes.len() as u64 + 1;
        Self { gltf, animation_of_node, entities: Vec::new(), next_id, default_is_used: false, warnings }
    }

    fn warn(&mut self, message: String) {
        self.warnings.push(Warning::new(&self.gltf.file, message));
    }

    fn nodes(&mut self, roots: Vec<usize>) -> Result<(), String> {
        let pending = |node: usize, parent, carried| Pending { node, parent, carried };
        let mut stack: Vec<Pending> =
            roots.into_iter().rev().map(|node| pending(node, None, false)).collect();
        let mut seen = HashSet::new();
        while let Some(next) = stack.pop() {
            if !seen.insert(next.node) {
                self.warn(format!("node {} stands in more than one place; the first is taken", next.node));
                continue;
            }
            let node = get(&self.gltf.root.nodes, next.node, "node")?;
            let (id, moves) =
                self.node(&next).map_err(|message| format!("{}: {message}", name(node, next.node)))?;
            stack.extend(node.children.iter().rev().map(|&child| pending(child, Some(id), moves)));
        }
        Ok(())
    }

    /// The entity that the node's children belong to, and whether they move.
    fn node(&mut self, pending: &Pending) -> Result<(EntityId, bool), String> {
        let node = &self.gltf.root.nodes[pending.node];
        let (transform, before) = transform(node)?;
        let animation = self.animation_of_node.get(&pending.node).copied();
        let moves = pending.carried || animation.is_some();
        let mut entity = Entity {
            id: EntityId(pending.node as u64 + 1),
            name: name(node, pending.node),
            parent: pending.parent,
            transform,
            motion: animation.map(|animation| Motion::Clip {
                file: self.gltf.file.clone(),
                animation,
                node: pending.node as u32,
                speed: 1.0,
            }),
            ..Entity::default()
        };
        if let Some(rotation) = before {
            // The shear's second rotation: what the node carries hangs below it.
            let inner = Transform { rotation, ..Transform::default() };
            let inner = self.child(&entity, format!("{} (sheared)", entity.name), inner);
            self.entities.push(std::mem::replace(&mut entity, inner));
        }
        entity.light = self.light(node)?;
        entity.camera = self.camera(node)?;
        let id = entity.id;
        let mesh = node.mesh.map(|mesh| self.renderer(mesh)).transpose()?.flatten();
        let is_static = !moves && !self.skin_moves(node)?;
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
        Ok((id, moves))
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
        let mut made = Vec::with_capacity(transforms.len());
        for (n, transform) in transforms.into_iter().enumerate() {
            let child = self.child(parent, format!("{} {n}", parent.name), transform);
            made.push(Entity { mesh: Some(mesh.clone()), is_static, ..child });
        }
        Ok(made)
    }

    fn light(&mut self, node: &Node) -> Result<Option<Light>, String> {
        const NAME: &str = "KHR_lights_punctual";
        let Some(json::LightOfNode { light }) = extension(&node.extensions, NAME)? else { return Ok(None) };
        let lights: json::Lights = extension(&self.gltf.root.extensions, NAME)?.unwrap_or_default();
        let authored = get(&lights.lights, light, "light")?;
        let made = light_of(authored);
        if made.is_none() {
            self.warn(format!("light {light} is of the unknown kind `{}` and was left out", authored.r#type));
        }
        Ok(made)
    }

    fn camera(&mut self, node: &Node) -> Result<Option<Camera>, String> {
        let Some(camera) = node.camera else { return Ok(None) };
        let made = camera_of(get(&self.gltf.root.cameras, camera, "camera")?);
        if made.is_none() {
            self.warn(format!(
                "camera {camera} sees nothing (its field of view or planes are not usable) and was left out"
            ));
        }
        Ok(made)
    }

    /// Whether a joint of the node's skin moves: then the skinned mesh is no part of the static scene.
    fn skin_moves(&self, node: &Node) -> Result<bool, String> {
        let Some(skin) = node.skin else { return Ok(false) };
        let skin = get(&self.gltf.root.skins, skin, "skin")?;
        Ok(skin.joints.iter().any(|joint| self.animation_of_node.contains_key(joint)))
    }

    fn warn_of_what_is_lost(&mut self) {
        for name in lost_extensions(self.gltf) {
            self.warn(format!("uses {name}, which is not read"));
        }
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

fn light_of(authored: &json::Light) -> Option<Light> {
    let kind = match authored.r#type.as_str() {
        "directional" => LightKind::Sun,
        "point" => LightKind::Point,
        "spot" => {
            let outer = authored.spot.outer_cone_angle.unwrap_or(std::f32::consts::FRAC_PI_4);
            let outer = outer.clamp(0.0, std::f32::consts::FRAC_PI_2);
            LightKind::Spot { inner: authored.spot.inner_cone_angle.unwrap_or(0.0).clamp(0.0, outer), outer }
        }
        _ => return None,
    };
    Some(Light {
        kind,
        color: authored.color.map_or(Vec3::ONE, Vec3::from),
        intensity: authored.intensity.unwrap_or(1.0),
        range: authored.range.filter(|&range| range > 0.0),
        ..Light::default()
    })
}

fn camera_of(authored: &json::Camera) -> Option<Camera> {
    let (projection, near, far) = match (&authored.perspective, &authored.orthographic) {
        (Some(p), _) => (Projection::Perspective { fov_y: p.yfov }, p.znear, p.zfar),
        (None, Some(o)) => (Projection::Orthographic { half_height: o.ymag.abs() }, o.znear, Some(o.zfar)),
        (None, None) => return None,
    };
    let camera = Camera { projection, near, far, exposure: 0.0 };
    camera.validate().is_ok().then_some(camera)
}

/// Our reference scenes say in the glTF scene's extras what radiance [W/m2/sr] surrounds them.
fn sky(root: &Root) -> Result<Sky, String> {
    let value = root.scenes.get(root.scene.unwrap_or(0)).and_then(|scene| scene.extras.get("sky_radiance"));
    let Some(value) = value else { return Ok(Sky::default()) };
    let radiance: [f32; 3] =
        serde::Deserialize::deserialize(value).map_err(|error: serde_json::Error| error.to_string())?;
    let radiance = Vec3::from(radiance);
    if !radiance.is_finite() || radiance.min_element() < 0.0 {
        return Err("three finite numbers, none negative, belong here".to_owned());
    }
    let kind = if radiance == Vec3::ZERO { SkyKind::None } else { SkyKind::Constant { radiance } };
    Ok(Sky { kind, ..Sky::default() })
}
