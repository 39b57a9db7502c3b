use std::sync::Arc;

use engine::scene::assets::Assets;
use engine::scene::file::{BakeSettings, Project, Quality};
use engine::scene::shape::{self, Shape};
use engine::scene::{
    Entity, EntityId, LightProbeGroup, Material, MaterialId, MeshRenderer, MeshSource, Scene, SkyKind,
    Transform,
};
use engine::transport::Certificate;
use engine::transport::direct::PlacedLight;
use engine::transport::key::BakeWith;
use glam::{DQuat, DVec3, Vec3};

use super::*;
use crate::pipeline::{Caches, make};
use crate::report::model::{Diagram, Error};
use crate::report::player::{GpuLight, Played};
use crate::{Silent, surface};

const LENGTH: f64 = 0.5;
const RAYS: u32 = 256;

/// Little, and ended by what is asked for, not by the clock.
const LITTLE: Effort = Effort { points: 24, reference: 0.03, rays: RAYS };

fn square(id: u64, material: u32, at: DVec3, turn: DQuat, size: f64) -> Entity {
    let renderer = MeshRenderer {
        mesh: MeshSource::Shape(Shape::Quad),
        materials: vec![MaterialId(material)],
        casts_shadows: true,
        density: Default::default(),
        reflection: Default::default(),
    };
    let transform = Transform { translation: at, rotation: turn, scale: DVec3::splat(size) };
    Entity { id: EntityId(id), is_static: true, mesh: Some(renderer), transform, ..Entity::default() }
}

/// A floor, two walls and a lamp of 60 cm that looks down; open on all other sides.
fn corner() -> Scene {
    let mut grey = Material { id: MaterialId(1), ..Material::default() };
    grey.albedo.color = Vec3::new(0.8, 0.6, 0.4);
    let mut lamp = Material { id: MaterialId(2), ..Material::default() };
    lamp.albedo.color = Vec3::ZERO;
    (lamp.emission.color, lamp.emission.strength) = (Vec3::ONE, 5.0);
    let quarter = std::f64::consts::FRAC_PI_2;
    let entities = vec![
        square(1, 1, DVec3::ZERO, DQuat::from_rotation_x(-quarter), 2.0),
        square(2, 1, DVec3::new(-1.0, 1.0, 0.0), DQuat::from_rotation_y(quarter), 2.0),
        square(3, 1, DVec3::new(0.0, 1.0, -1.0), DQuat::IDENTITY, 2.0),
        square(4, 2, DVec3::new(0.2, 1.7, 0.1), DQuat::from_rotation_x(quarter), 0.6),
    ];
    Scene { entities, materials: vec![grey, lamp], ..Scene::default() }
}

fn setup(scene: Scene) -> Setup {
    let mut assets = Assets::default();
    assets.meshes.insert(MeshSource::Shape(Shape::Quad), Arc::new(shape::mesh(Shape::Quad)));
    let surface = surface::sanitise(&scene, &assets).unwrap();
    let bake = BakeSettings { rays: Some(RAYS), patch_length: Some(LENGTH), ..BakeSettings::default() };
    let settings = Project { default_scene: "corner".to_owned(), bake, ..Project::default() };
    let with = BakeWith { quality: Quality::Standard, rays: RAYS, length: LENGTH };
    let (transport, _) = make(&scene, &assets, &surface, &with, &Caches::none(), &Silent).unwrap();
    let authored = scene.clone();
    let (name, warnings) = ("corner".to_owned(), Vec::new());
    let opened = Opened { settings, name, scene, authored, assets, surface, warnings };
    Setup { opened, transport, played: None }
}

fn measure(setup: &Setup) -> Measured {
    run(setup, &Budget::new(1e4), &LITTLE, &Silent).unwrap()
}

fn numbers(error: &Error) -> [f64; 4] {
    [error.rms, error.bias, error.p99, error.max]
}

/// Every error, with what it is of.
fn errors(measured: &Measured) -> Vec<(String, [f64; 4])> {
    let of_diagram = |diagram: &Diagram| {
        let points = diagram.series.iter().flat_map(|series| &series.points);
        points
            .map(|point| (format!("{} {}", diagram.id, point.setting), numbers(&point.error)))
            .collect::<Vec<_>>()
    };
    let mut all: Vec<_> = measured.diagrams.iter().flat_map(of_diagram).collect();
    all.extend(measured.split.parts.iter().map(|part| (part.name.clone(), numbers(&part.error))));
    let split = &measured.split;
    all.push(("total".to_owned(), numbers(&split.total)));
    all.push(("unexplained".to_owned(), [split.unexplained, split.reference_error, 0.0, 0.0]));
    let seeds = &split.seeds;
    all.push(("seeds".to_owned(), [seeds.missed, seeds.noise, seeds.spread, 0.0]));
    let floors = measured.diagrams.iter().flat_map(|diagram| &diagram.floors);
    all.extend(floors.map(|floor| (floor.name.clone(), [floor.y, 0.0, 0.0, 0.0])));
    all
}

fn assert_finite(measured: &Measured) {
    for (what, numbers) in errors(measured) {
        assert!(numbers.iter().all(|number| number.is_finite()), "{what}: {numbers:?}");
    }
    let points =
        measured.diagrams.iter().flat_map(|diagram| &diagram.series).flat_map(|series| &series.points);
    assert!(points.clone().all(|point| point.x.is_finite() && point.x >= 0.0 && point.runs > 0));
    assert!(measured.advice.iter().all(|advice| advice.cost.is_finite() && advice.error.is_finite()));
    assert!(
        measured.diagrams.iter().flat_map(|diagram| &diagram.series).all(|series| !series.points.is_empty())
    );
}

fn series<'a>(measured: &'a Measured, diagram: &str) -> Vec<&'a crate::report::model::Series> {
    measured.diagrams.iter().filter(|one| one.id == diagram).flat_map(|one| &one.series).collect()
}

#[test]
fn the_same_scene_measures_the_same_errors_bit_for_bit() {
    let setup = setup(corner());
    let (once, again) = (measure(&setup), measure(&setup));
    assert_finite(&once);
    let (once, again) = (errors(&once), errors(&again));
    assert!(once.len() > 80, "{}", once.len());
    for (one, other) in once.iter().zip(&again) {
        assert_eq!(one, other);
    }
}

#[test]
fn a_lamp_in_a_corner_fills_all_diagrams_and_its_errors_fall() {
    let measured = measure(&setup(corner()));
    let ids: Vec<&str> = measured.diagrams.iter().map(|diagram| diagram.id.as_str()).collect();
    for id in ["bake", "bake_rays", "bake_matrix", "frame", "lag_moving", "lag_switching", "bytes"] {
        assert!(ids.contains(&id), "{id} of {ids:?}");
    }
    for method in series(&measured, "frame") {
        let (first, last) = (&method.points[0], &method.points[method.points.len() - 1]);
        assert!(
            last.error.max < 1e-3 && last.error.max <= first.error.max,
            "{}: {:?}",
            method.name,
            last.error
        );
    }
    let matrix = &series(&measured, "bake_matrix")[0].points;
    assert!(matrix.len() >= 2 && matrix[1].error.rms < 0.7 * matrix[0].error.rms, "{matrix:?}");
    let named = |name: &str| measured.split.parts.iter().find(|part| part.name == name).unwrap();
    assert!(named("discretisation").error.rms > 0.0 && named("form factors").left_out.is_none());
    assert!(named("GPU").left_out.is_some() && named("lag").left_out.is_some());
    assert!(measured.split.unexplained < 0.01, "{}", measured.split.unexplained);
    let worst = &measured.split.worst;
    assert!(
        !worst.is_empty() && worst.iter().all(|place| named(&place.part).left_out.is_none()),
        "{worst:?}"
    );
    let seeds = measured.split.seeds;
    assert!(measured.split.adds_up() && seeds.missed > 0.0 && seeds.noise > 0.0, "{seeds:?}");
}

#[test]
fn light_that_the_chain_does_not_know_of_is_unexplained() {
    let mut setup = setup(corner());
    let lit = Lit::new(&setup.opened, &setup.transport);
    let b = lit.columns(&lit.solved());
    let irradiance = setup.transport.irradiance_of_receivers(&b);
    let light = |factor: f64| GpuLight {
        radiosity: b.clone(),
        irradiance: irradiance.iter().map(|h| *h * factor).collect(),
        ..GpuLight::default()
    };
    let lights = [1.0, 1.5].map(light);
    drop(lit);
    let unexplained = lights.map(|light| {
        setup.played = Some(Played { light: Some(light), ..Played::default() });
        measure(&setup).split.unexplained
    });
    assert!(unexplained[0] < 1e-9, "{unexplained:?}");
    assert!(unexplained[1] > 0.3, "{unexplained:?}");
}

#[test]
fn light_that_jumps_stands_still_in_the_frames_that_do_not_count() {
    let setup = setup(corner());
    let lit = Lit::new(&setup.opened, &setup.transport);
    let place = |light: &Option<PlacedLight>| light.as_ref().map(|light| light.position);
    for script in script::scripts(&lit).iter().filter(|script| !script.moves) {
        let (before, counted) = script.frames.split_at(script::WARM);
        let first = place(&before[0]);
        assert!(before.iter().all(|light| place(light) == first), "{}", script.name);
        assert!(counted.iter().any(|light| place(light) != first), "{}", script.name);
    }
}

#[test]
fn a_scene_without_light_says_so_and_has_no_numbers_that_are_none() {
    let mut scene = corner();
    scene.materials[1].emission.strength = 0.0;
    let measured = measure(&setup(scene));
    assert_finite(&measured);
    assert!(measured.notes.iter().any(|note| note.contains("no light reaches")), "{:?}", measured.notes);
    assert!(measured.diagrams.iter().all(|diagram| diagram.id.starts_with("lag")));
    assert_eq!(measured.split.total, Error::default());
}

#[test]
fn a_scene_of_nothing_or_of_moving_things_alone_has_nothing_to_measure() {
    let mut moving = corner();
    moving.entities.iter_mut().for_each(|entity| entity.is_static = false);
    for scene in [Scene::default(), moving] {
        let measured = measure(&setup(scene));
        assert_finite(&measured);
        assert!(measured.diagrams.is_empty() && measured.notes.len() == 1, "{:?}", measured.notes);
    }
}

#[test]
fn an_open_scene_under_a_sky_adds_up() {
    let mut scene = corner();
    scene.materials[1].emission.strength = 0.0;
    scene.sky.kind = SkyKind::Constant { radiance: Vec3::new(0.5, 0.7, 1.0) };
    let measured = measure(&setup(scene));
    assert_finite(&measured);
    assert!(measured.split.total.rms > 0.0 && measured.split.unexplained < 0.01, "{:?}", measured.split);
}

#[test]
fn a_budget_that_is_spent_leaves_out_and_says_so() {
    let setup = setup(corner());
    for seconds in [0.0, 0.2] {
        let measured = all(&setup, &Budget::new(seconds), &Silent).unwrap();
        assert_finite(&measured);
        assert!(!measured.notes.is_empty());
    }
    let measured = all(&setup, &Budget::new(0.0), &Silent).unwrap();
    let left_out = |what: &str| measured.notes.iter().any(|note| note.contains(what));
    assert!(left_out("matrix reference") && left_out("bakes"), "{:?}", measured.notes);
}

#[test]
fn light_probes_near_each_other_say_what_is_between_them() {
    let mut scene = corner();
    let positions = vec![Vec3::new(0.4, 0.5, 0.5), Vec3::new(0.5, 0.5, 0.5)];
    let probes = Some(LightProbeGroup { positions });
    scene.entities.push(Entity { id: EntityId(5), light_probes: probes, ..Entity::default() });
    let setup = setup(scene);
    let lit = Lit::new(&setup.opened, &setup.transport);
    let part = probes::part(&lit, &lit.solved());
    assert!(part.is_apart && part.left_out.is_none(), "{part:?}");
    assert!(part.error.rms > 0.0 && part.error.rms < 0.03 && part.error.max < 0.2, "{part:?}");
}

#[test]
fn the_certificate_says_how_the_shipped_bake_was_made() {
    let setup = setup(corner());
    let Certificate { base_length, rays_per_row, .. } = setup.transport.certificate;
    assert_eq!((base_length, rays_per_row), (LENGTH, RAYS));
    assert_eq!(shipped(&setup.transport), Recipe { length: LENGTH, rays: RAYS });
}
