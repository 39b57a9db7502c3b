//! What is drawn.

use std::f64::consts::PI;

use engine::gpu::{Gpu, buffer};
use engine::render::rows::Summed;
use engine::render::{Eye, Settings, View};
use engine::scene::assets::Assets;
use engine::scene::file::{Project, save_project};
use engine::scene::import::load_assets;
use engine::scene::shape::Shape;
use engine::scene::{Changes, Entity, EntityId, LightProbeGroup, MaterialId, Scene, Transform};
use engine::transport::directional::tilted;
use engine::transport::{Transport, file, sh};
use glam::{DVec3, Vec3, Vec4};
use tests::bumps::{self, BEHIND, FLOOR, as_stored, bumps, paint, room as walls, wear};
use tests::picture::{Studio, gpu};
use tests::project::TestProject;
use tests::room;
use tests::solved::{self as lit, Solved};

const SIZE: u32 = 33;
const MIDDLE: u32 = SIZE / 2;
/// On the wall behind, off its middle; and where it is looked at from.
const POINT: DVec3 = DVec3::new(0.37, 0.46, 0.0);
const EYE: DVec3 = DVec3::new(0.45, 0.5, 0.7);

fn solved(project: &TestProject) -> Solved {
    Solved::of(project, &lit::settings(0.2, 512))
}

fn studio(gpu: Gpu, lit: &Solved, summed: Option<Summed>) -> Studio {
    studio_of(gpu, lit.transport.clone(), &lit.assets, summed)
}

fn studio_of(gpu: Gpu, transport: Transport, assets: &Assets, summed: Option<Summed>) -> Studio {
    let eye = Eye::looking(EYE, POINT);
    let settings = Settings { samples: Some(1), summed, ..Settings::default() };
    let mut studio = Studio::with(gpu, transport, eye, [SIZE; 2], settings);
    studio.assets = assets.clone();
    studio
}

/// Light by column: emitted, and bounced.
fn sources(lit: &Solved) -> [Vec<DVec3>; 2] {
    let emitted: Vec<DVec3> = lit.materials.exitance.iter().map(|m| m.as_dvec3()).collect();
    let bounced = lit.radiosity.iter().zip(&emitted).map(|(b, m)| *b - *m).collect();
    [emitted, bounced]
}

#[test]
fn the_gpu_gathers_directional_terms_as_the_cpu_does() {
    let project = walls();
    wear(&project, BEHIND, paint(project.path(), "assets/bumps.png", 64, bumps));
    let lit = solved(&project);
    for summed in [Summed::ByThread, Summed::ByGroup] {
        let Some(gpu) = gpu() else { return };
        let mut studio = studio(gpu, &lit, Some(summed));
        studio.settle(&lit.scene, View::Composite);
        let on_gpu = studio.renderer.solved().unwrap();
        let values: Vec<DVec3> = on_gpu.radiosity.iter().map(|b| b.as_dvec3()).collect();
        let truth = bumps::irradiance(&lit.transport, &values);
        assert_eq!(on_gpu.directional.len(), 3 * truth.len());
        let largest = truth.iter().map(|(e, _)| e.max_element()).fold(0.0, f64::max);
        let on_gpu = on_gpu.directional.chunks_exact(3);
        let apart = |(terms, (_, v)): (&[Vec3], &(DVec3, [DVec3; 3]))| -> f64 {
            let apart = terms.iter().zip(v).map(|(a, b)| (a.as_dvec3() - *b).abs().max_element());
            apart.fold(0.0, f64::max)
        };
        let worst = on_gpu.zip(&truth).map(apart).fold(0.0, f64::max);
        assert!(worst < 1e-4 * largest, "{summed:?}: {worst} of {largest}");
        assert!(truth.iter().any(|(_, v)| v[0].x.abs() > 0.1 * largest), "no direction at all");
    }
}

/// Where a flat picture of one normal tilts the wall behind.
fn tilted_normal(transport: &Transport, normal: Vec3) -> DVec3 {
    let batch = transport.surface.batches.iter().find(|batch| batch.material as usize == BEHIND).unwrap();
    let vertex = transport.surface.vertices[transport.surface.triangles[batch.first as usize][0] as usize];
    let tangent = Vec4::from(vertex.tangent);
    let bitangent = vertex.normal.cross(tangent.truncate()) * tangent.w;
    (tangent.truncate() * normal.x + bitangent * normal.y + vertex.normal * normal.z).as_dvec3()
}

#[test]
fn a_pixel_shows_the_irradiance_of_its_own_normal() {
    for local in [Vec3::new(0.5, 0.0, 0.87), Vec3::new(-0.4, 0.4, 0.82), Vec3::new(0.0, -0.7, 0.71)] {
        let project = walls();
        wear(&project, BEHIND, paint(project.path(), "assets/tilt.png", 4, |_, _| local));
        let lit = solved(&project);
        let Some(gpu) = gpu() else { return };
        let mut studio = studio(gpu, &lit, None);
        let m = tilted_normal(&lit.transport, as_stored(local));
        let mut tilts = 0.0_f64;
        for (source, view) in sources(&lit).iter().zip([View::Direct, View::Indirect]) {
            let known = bumps::irradiance(&lit.transport, source);
            let (e, v) = bumps::at(&lit.transport, &known, (BEHIND, false), POINT.as_vec3()).unwrap();
            let truth = 0.5 / PI * tilted(e, v, DVec3::Z, m).x;
            studio.settle(&lit.scene, view);
            let drawn = f64::from(studio.radiance_at(MIDDLE, MIDDLE).x);
            assert!((drawn / truth - 1.0).abs() < 5e-3, "{local} {view:?}: {drawn}, not {truth}");
            tilts = tilts.max((drawn / (0.5 / PI * e.x) - 1.0).abs());
        }
        assert!(tilts > 0.05, "{local}: as if it were flat");
    }
}

#[test]
fn both_sides_of_a_bumped_sheet_show_their_own_light() {
    let project = walls();
    let local = Vec3::new(0.4, 0.3, 0.87);
    let map = paint(project.path(), "assets/tilt.png", 4, |_, _| local);
    let mut scene = wear(&project, BEHIND, map);
    scene.materials[BEHIND].double_sided = true;
    // It parts the room, and the lamp in it.
    scene.entities[BEHIND].transform.translation.z = 0.5;
    project.save(&scene);
    let lit = solved(&project);
    let Some(gpu) = gpu() else { return };
    let mut studio = studio(gpu, &lit, None);
    let known = bumps::irradiance(&lit.transport, &sources(&lit)[1]);
    let at = POINT + DVec3::Z * 0.5;
    let front = tilted_normal(&lit.transport, as_stored(local));
    let told = [(0.9, false, 1.0), (0.1, true, -1.0)].map(|(z, back, side)| {
        studio.eye = Eye::looking(DVec3::new(0.4, 0.5, z), at);
        studio.settle(&lit.scene, View::Indirect);
        let drawn = f64::from(studio.radiance_at(MIDDLE, MIDDLE).x);
        let (e, v) = bumps::at(&lit.transport, &known, (BEHIND, back), at.as_vec3()).unwrap();
        let m = DVec3::new(front.x, front.y, front.z * side);
        let truth = 0.5 / PI * tilted(e, v, DVec3::Z * side, m).x;
        assert!((drawn / truth - 1.0).abs() < 5e-3, "{side}: {drawn}, not {truth}");
        drawn
    });
    assert!((told[0] / told[1] - 1.0).abs() > 0.05, "{told:?}");
}

#[test]
fn a_flat_map_changes_nothing_and_where_it_meets_bare_walls_is_no_seam() {
    let project = walls();
    let bare = solved(&project);
    let flat = paint(project.path(), "assets/flat.png", 4, |_, _| Vec3::Z);
    wear(&project, FLOOR, flat.clone());
    wear(&project, BEHIND, flat);
    let mapped = solved(&project);
    assert!(mapped.transport.directional_receivers() > 0);
    let pictures = [&bare, &mapped].map(|lit| {
        let mut studio = studio(gpu()?, lit, None);
        studio.eye = Eye::looking(EYE, DVec3::new(0.5, 0.1, 0.0));
        studio.settle(&lit.scene, View::Composite);
        Some(studio.radiance())
    });
    let [Some(bare), Some(mapped)] = pictures else { return };
    let worst = bare.iter().zip(&mapped).map(|(a, b)| (a.x - b.x).abs() / a.x.max(1e-3)).fold(0.0, f32::max);
    assert!(worst < 0.012, "{worst}"); // eight bits of flat are a third of a degree off
}

#[test]
fn without_normal_maps_nothing_is_held_or_dispatched_for_them() {
    let project = walls();
    let bare = solved(&project);
    wear(&project, BEHIND, paint(project.path(), "assets/bumps.png", 64, bumps));
    let bumped = solved(&project);
    let of = |lit: &Solved| {
        let mut studio = studio(gpu()?, lit, None);
        let first = studio.draw(&lit.scene, View::Composite).transport_dispatches;
        let bytes = studio.renderer.bytes();
        let bytes = |what| bytes.iter().find(|(kind, _)| *kind == what).map_or(0, |found| found.1);
        let told = studio.renderer.left_out().iter().any(|what| what.starts_with("directional terms"));
        Some((first, [bytes("rows"), bytes("light")], told, studio.renderer.spaces().directional))
    };
    let (Some(without), Some(with)) = (of(&bare), of(&bumped)) else { return };
    assert_eq!((without.2, without.3, with.2), (true, 0, false));
    // One more for emitted light, one for what bounced.
    assert_eq!(with.0, without.0 + 2);
    let terms = bumped.transport.directional_from_patch.len() as u64;
    let begin = u64::from(with.3);
    assert_eq!(with.1[1] - without.1[1], 2 * 16 * (begin + terms - bare.transport.receivers.len() as u64));
    assert!(with.1[0] > without.1[0]);
}

#[test]
fn light_that_was_solved_at_the_bake_is_tilted_alike() {
    let project = walls();
    save_project(project.path(), &Project::default()).unwrap(); // where nothing is forced
    let map = paint(project.path(), "assets/bumps.png", 64, bumps);
    let mut scene = wear(&project, BEHIND, map);
    for material in &mut scene.materials {
        (material.albedo.changes, material.emission.changes) = (Changes::Never, Changes::Never);
    }
    scene.sky.changes = Changes::Never;
    project.save(&scene);
    lit::baked(&project, &lit::settings(0.2, 512));
    let shipped = file::load(&project.light_file()).unwrap();
    assert!(shipped.solved.is_some() && shipped.directional_from_patch.is_empty());
    let full = file::load_full(project.path(), "main").unwrap();
    assert_eq!(shipped.directional_receivers(), full.directional_receivers());
    let (assets, _) = load_assets(project.path(), &scene).unwrap();
    let lit = Solved::with(scene, assets, full);
    let pictures = [lit.transport.clone(), shipped].map(|transport| {
        let mut studio = studio_of(gpu()?, transport, &lit.assets, None);
        studio.settle(&lit.scene, View::Indirect);
        Some(studio.radiance())
    });
    let [Some(full), Some(shipped)] = pictures else { return };
    let worst = full.iter().zip(&shipped).map(|(a, b)| (a.x - b.x).abs() / a.x.max(1e-4)).fold(0.0, f32::max);
    assert!(worst < 3e-3, "{worst}");
}

#[test]
fn an_older_bake_is_drawn_without_the_maps_tilt() {
    let project = walls();
    wear(&project, BEHIND, paint(project.path(), "assets/bumps.png", 64, bumps));
    let mut lit = solved(&project);
    let bare = Solved::with(
        Scene { materials: without_maps(&lit.scene), ..lit.scene.clone() },
        lit.assets.clone(),
        lit.transport.clone(),
    );
    lit.transport.directional_from_patch = Default::default();
    let pictures = [&bare, &lit].map(|lit| {
        let mut studio = studio(gpu()?, lit, None);
        studio.settle(&lit.scene, View::Indirect);
        Some(studio.radiance())
    });
    let [Some(bare), Some(old)] = pictures else { return };
    assert_eq!(bare, old);
}

fn without_maps(scene: &Scene) -> Vec<engine::scene::Material> {
    let bare = |material: &engine::scene::Material| engine::scene::Material {
        normal_texture: None,
        ..material.clone()
    };
    scene.materials.iter().map(bare).collect()
}

#[test]
fn what_moves_reads_its_probes_by_its_own_mapped_normals() {
    let project = walls();
    let local = Vec3::new(0.6, 0.0, 0.8);
    let map = paint(project.path(), "assets/tilt.png", 4, |_, _| local);
    let mut scene = project.scene();
    scene.materials.push(engine::scene::Material {
        id: MaterialId(77),
        normal_texture: Some(map),
        ..Default::default()
    });
    let positions = [0.3, 0.7].map(|x| [0.3, 0.7].map(|y| [0.3, 0.7].map(|z| Vec3::new(x, y, z))));
    scene.entities.push(Entity {
        id: EntityId(200),
        light_probes: Some(LightProbeGroup { positions: positions.as_flattened().as_flattened().to_vec() }),
        ..Entity::default()
    });
    scene.entities.push(Entity {
        id: EntityId(201),
        mesh: Some(room::mesh(Shape::Quad, 77)),
        transform: Transform { scale: DVec3::splat(0.3), ..Transform::at(DVec3::splat(0.5)) },
        ..Entity::default()
    });
    project.save(&scene);
    let lit = solved(&project);
    assert_eq!(lit.transport.directional_receivers(), 0, "what moves has no receivers");
    let Some(gpu) = gpu() else { return };
    let mut studio = studio(gpu, &lit, None);
    // Quads face +Z, u runs along +X.
    studio.eye = Eye::looking(DVec3::new(0.52, 0.53, 0.9), DVec3::new(0.51, 0.48, 0.5));
    studio.settle(&lit.scene, View::Indirect);
    let drawn = studio.radiance_at(MIDDLE, MIDDLE).x;
    let values: Vec<Vec4> =
        buffer::read(studio.renderer.gpu(), &studio.renderer.objects().light()[1]).unwrap();
    let coefficients: [Vec3; 9] = std::array::from_fn(|k| values[k].truncate());
    let stored = as_stored(local);
    let albedo = lit.scene.materials.last().unwrap().albedo.color.x / std::f32::consts::PI;
    let [flat, truth] = [Vec3::Z, Vec3::new(stored.x, 0.0, stored.z).normalize()]
        .map(|normal| albedo * sh::irradiance(&coefficients, normal).x);
    assert!((drawn / truth - 1.0).abs() < 5e-3, "{drawn}, not {truth}");
    assert!((flat / truth - 1.0).abs() > 0.02, "{flat} {truth}");
}
