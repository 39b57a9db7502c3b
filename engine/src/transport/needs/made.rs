//! Small scenes for tests of the rules: entities are called `e` and their number, materials `m` and theirs.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{DVec3, Vec3};

use crate::scene::assets::Assets;
use crate::scene::shape::{Shape, mesh};
use crate::scene::{
    Changes, Emission, Entity, EntityId, Feature, Forced, ImageSource, Light, LightProbeGroup, Material,
    MaterialId, MeshRenderer, MeshSource, Motion, ReflectionProbe, Scene, SkyKind,
};
use crate::transport::{Batch, NONE, Patch, Sample, Transport, Vertex};

pub fn scene(entities: Vec<Entity>) -> Scene {
    Scene { entities, ..Scene::default() }
}

pub fn forced() -> BTreeMap<Feature, Forced> {
    BTreeMap::new()
}

fn entity(id: u64) -> Entity {
    Entity { id: EntityId(id), name: format!("e{id}"), ..Entity::default() }
}

fn sphere() -> MeshRenderer {
    MeshRenderer {
        mesh: MeshSource::Shape(Shape::Sphere),
        materials: vec![MaterialId(0)],
        casts_shadows: true,
        density: Default::default(),
        reflection: Default::default(),
    }
}

pub fn wall(id: u64) -> Entity {
    Entity { is_static: true, mesh: Some(sphere()), ..entity(id) }
}

pub fn ball(id: u64) -> Entity {
    Entity { mesh: Some(sphere()), ..entity(id) }
}

pub fn with(mut entity: Entity, material: u32) -> Entity {
    entity.mesh.iter_mut().for_each(|renderer| renderer.materials = vec![MaterialId(material)]);
    entity
}

pub fn moved(entity: Entity) -> Entity {
    let motion = Motion::Spin { axis: DVec3::Y, radians_per_second: 1.0 };
    Entity { motion: Some(motion), ..entity }
}

pub fn probes(id: u64) -> Entity {
    let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
    Entity { light_probes: Some(LightProbeGroup { positions }), ..entity(id) }
}

pub fn cube_probe(id: u64) -> Entity {
    Entity { reflection_probe: Some(ReflectionProbe::default()), ..entity(id) }
}

pub fn lamp(id: u64, light: Light) -> Entity {
    Entity { light: Some(light), ..entity(id) }
}

/// A lamp that never changes.
pub fn never() -> Light {
    Light { changes: Changes::Never, ..Light::default() }
}

pub fn material(id: u32) -> Material {
    Material { id: MaterialId(id), name: format!("m{id}"), ..Material::default() }
}

pub fn emitter(id: u32, changes: Changes) -> Material {
    Material { emission: Emission { color: Vec3::ONE, changes, ..Emission::default() }, ..material(id) }
}

pub fn constant() -> SkyKind {
    SkyKind::Constant { radiance: Vec3::ONE }
}

pub fn gradient() -> SkyKind {
    let zenith = Vec3::new(0.2, 0.4, 1.0);
    SkyKind::Gradient { zenith, horizon: Vec3::ONE, ground: Vec3::ONE, sun: None, sun_diameter: 0.01 }
}

pub fn picture() -> ImageSource {
    ImageSource { file: "assets/bumps.png".to_owned(), image: None }
}

/// With the meshes of the scene's shapes.
pub fn assets(scene: &Scene) -> Assets {
    let mut assets = Assets::default();
    for renderer in scene.entities.iter().filter_map(|entity| entity.mesh.as_ref()) {
        if let MeshSource::Shape(shape) = &renderer.mesh {
            assets.meshes.insert(renderer.mesh.clone(), Arc::new(mesh(*shape)));
        }
    }
    assets
}

/// Two cubes of side 2 that look inside, about x = -2 (entity 1, material 0) and x = 2 (entity 2, material 1): a patch a
/// side, each of which sees the six of its room.
pub fn two_rooms() -> Transport {
    let mut transport = Transport::default();
    for (room, x) in [-2.0_f32, 2.0].into_iter().enumerate() {
        add_room(&mut transport, room as u32, Vec3::X * x);
    }
    for row in 0..12_u32 {
        let first = row / 6 * 6;
        transport.patch_from_patch.push((first..first + 6).map(|column| (column, 1.0 / 8.0)));
    }
    transport
}

fn add_room(transport: &mut Transport, room: u32, centre: Vec3) {
    let surface = &mut transport.surface;
    let corner = |i: usize| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * 2.0 - 1.0;
    let (first_vertex, first_triangle) = (surface.vertices.len() as u32, surface.triangles.len() as u32);
    surface.vertices.extend((0..8).map(|i| Vertex {
        position: centre + corner(i),
        color: [1.0; 4],
        ..Vertex::default()
    }));
    let quads: [[u32; 4]; 6] =
        [[0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [2, 3, 7, 6], [0, 1, 3, 2], [4, 6, 7, 5]];
    for (side, quad) in quads.into_iter().enumerate() {
        let patch = transport.patches.len() as u32;
        let normal = -(0..4).map(|k| corner(quad[k] as usize)).sum::<Vec3>() / 4.0;
        let [a, b, c, d] = quad.map(|corner| first_vertex + corner);
        surface.triangles.extend([[a, b, c], [a, c, d]]);
        surface.patches.extend([[patch, NONE]; 2]);
        transport.patches.push(Patch {
            centre: centre - normal,
            area: 4.0,
            normal,
            batch: room,
            first_triangle: first_triangle + 2 * side as u32,
            triangle_count: 2,
            first_sample: patch,
            sample_count: 1,
            component: room,
            ..Patch::default()
        });
        transport.samples.push(Sample { position: centre - normal, patch, normal, padding: 0 });
    }
    surface.batches.push(Batch {
        entity: [room + 1, 0],
        material: room,
        double_sided: 0,
        first: first_triangle,
        count: 12,
    });
}
