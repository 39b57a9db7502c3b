//! Scenes and files with absurd numbers in them, through the whole program: refused by name, or baked, solved and drawn.

use bake::{
    BakeError, Irradiance, Method, Point, Settings, Silent, bake, check, plan, query_points, query_probes,
};
use engine::render::{Eye, Settings as Drawing, View};
use engine::scene::{
    AutoExposure, Camera, Entity, EntityId, LightKind, LightProbeGroup, Projection, ReflectionProbe, Scene,
    SkyKind,
};
use engine::transport::probe_field::{Cell, ProbeField};
use engine::transport::{Transport, file};
use glam::{DQuat, DVec3, Vec3};
use proptest::prelude::*;
use tests::picture::{Studio, gpu};
use tests::project::TestProject;
use tests::room::light;
use tests::solved::{Solved, WALLS, change, paint, settings, shell};
use tests::surfaces;

use super::hostile::{number, seeded};

/// A room with one of everything.
fn room() -> TestProject {
    let project = surfaces::project(&shell(Vec3::ZERO, Vec3::new(2.0, 1.0, 1.0), WALLS));
    paint(&project, |name, material| {
        material.albedo.color = Vec3::splat(0.5);
        material.emission.color = Vec3::splat(if name == "-x" { 1.0 } else { 0.0 });
        material.roughness = if name == "-y" { 0.2 } else { 1.0 };
    });
    change(&project, |scene| {
        let at = DVec3::new(1.5, 0.75, 0.5);
        scene.entities.push(light(100, LightKind::Spot { inner: 0.3, outer: 0.6 }, 2.0, at, DVec3::ZERO));
        let light_probes =
            Some(LightProbeGroup { positions: vec![Vec3::splat(0.5), Vec3::new(1.5, 0.5, 0.5)] });
        scene.entities.push(Entity {
            id: EntityId(200),
            name: "group".to_owned(),
            light_probes,
            ..Entity::default()
        });
        let reflection_probe = Some(ReflectionProbe { resolution: 16, ..ReflectionProbe::default() });
        let name = "cubemap".to_owned();
        scene.entities.push(Entity { id: EntityId(300), name, reflection_probe, ..Entity::default() });
        scene.entities[8].transform.translation = DVec3::new(1.0, 0.5, 0.5);
        let camera = Some(Camera::default());
        scene.entities.push(Entity {
            id: EntityId(400),
            name: "eye".to_owned(),
            camera,
            ..Entity::default()
        });
        scene.entities[9].transform.translation = DVec3::new(1.0, 0.5, 0.9);
        scene.sky.kind = SkyKind::Constant { radiance: Vec3::ONE };
    });
    project
}

/// Where an absurd number may stand; what names it when it is refused.
const PLACES: [&str; 24] = [
    "`-x`",
    "`-x`",
    "`-x`",
    "`-x`",
    "`light 100`",
    "`light 100`",
    "`light 100`",
    "`light 100`",
    "`light 100`",
    "`group`",
    "`cubemap`",
    "`cubemap`",
    "`cubemap`",
    "`eye`",
    "`eye`",
    "`eye`",
    "`eye`",
    "`eye`",
    "`-x`",
    "`-x`",
    "`-x`",
    "`-x`",
    "sky",
    "sky",
];

fn spoil(scene: &mut Scene, place: usize, x: f32) {
    let wide = f64::from(x);
    let entities = &mut scene.entities;
    match place {
        0 => entities[0].transform.translation.x = wide,
        1 => entities[0].transform.scale.y = wide,
        2 => entities[0].transform.rotation = DQuat::from_xyzw(wide, 0.0, 0.0, 1.0),
        3 => entities[0].mesh.as_mut().expect("a mesh").density.scale = x,
        4 => entities[6].transform.translation.y = wide,
        5 => entities[6].light.as_mut().expect("a light").intensity = x,
        6 => entities[6].light.as_mut().expect("a light").color.x = x,
        7 => entities[6].light.as_mut().expect("a light").range = Some(x),
        8 => entities[6].light.as_mut().expect("a light").kind = LightKind::Spot { inner: 0.0, outer: x },
        9 => entities[7].light_probes.as_mut().expect("probes").positions[0].z = x,
        10 => entities[8].transform.translation.x = wide,
        11 => entities[8].reflection_probe.as_mut().expect("a probe").half_size.x = x,
        12 => entities[8].reflection_probe.as_mut().expect("a probe").blend_distance = x,
        13 => entities[9].transform.translation.z = wide,
        14 => camera(scene).near = x,
        15 => camera(scene).far = Some(x),
        16 => camera(scene).projection = Projection::Perspective { fov_y: x },
        17 => camera(scene).auto_exposure = Some(AutoExposure { compensation: x, ..AutoExposure::default() }),
        18 => scene.materials[0].albedo.color.y = x,
        19 => scene.materials[0].emission.strength = x,
        20 => scene.materials[0].roughness = x,
        21 => scene.materials[0].metallic = x,
        22 => scene.sky.kind = SkyKind::Constant { radiance: Vec3::new(x, 1.0, 1.0) },
        _ => {
            let (zenith, horizon, ground) = (Vec3::ONE, Vec3::ONE, Vec3::splat(x));
            scene.sky.kind = SkyKind::Gradient { zenith, horizon, ground, sun: None, sun_diameter: x };
        }
    }
}

fn camera(scene: &mut Scene) -> &mut Camera {
    scene.entities[9].camera.as_mut().expect("a camera")
}

/// Through the CPU: refused with a name, or solved with numbers.
fn through(project: &TestProject, named: &str) -> Result<Option<Solved>, TestCaseError> {
    let settings = settings(0.5, 16);
    let baked = match bake(project.path(), None, &settings, &Silent) {
        Ok(baked) => baked,
        Err(error) => {
            let error = bake::chain::told(&error);
            prop_assert!(error.contains(named), "`{error}` does not name {named}");
            return Ok(None);
        }
    };
    let certificate = &baked.transport.certificate;
    prop_assert!(certificate.holds(), "{:#?}", certificate.statements());
    let transport = file::load(&baked.file).map_err(|error| TestCaseError::fail(error.to_string()))?;
    let scene = project.scene();
    let (assets, _) = engine::scene::import::load_assets(project.path(), &scene).expect("assets");
    let light = Solved::with(scene, assets, transport);
    prop_assert!(light.radiosity.iter().all(|b| b.is_finite() && b.min_element() >= -1e-6));
    prop_assert!(light.transport.irradiance_of_receivers(&light.radiosity).iter().all(|h| h.is_finite()));
    Ok(Some(light))
}

/// One picture, whose pixels are numbers.
fn drawn(light: &Solved) -> Result<(), TestCaseError> {
    let Some(gpu) = gpu() else { return Ok(()) };
    let world = engine::scene::world_from_local(&light.scene);
    let eye = Eye::of_scene(&light.scene, &world).expect("a camera");
    let drawing = Drawing { samples: Some(1), ..Drawing::default() };
    let mut studio = Studio::with(gpu, light.transport.clone(), eye, [8, 8], drawing);
    studio.assets = light.assets.clone();
    for _ in 0..2 {
        studio.draw(&light.scene, View::Composite);
    }
    // Half floats end at 65504: what is brighter at this exposure is white.
    let radiance = studio.radiance();
    prop_assert!(radiance.iter().all(|radiance| !radiance.is_nan()), "{radiance:?}");
    let b = tests::solved::radiosity_on_gpu(&studio);
    prop_assert!(b.iter().all(|b| b.is_finite()), "{b:?}");
    let exposed = studio.renderer.exposed().expect("an exposure");
    prop_assert!(exposed.exposure.is_finite() && exposed.pre_exposure.is_finite(), "{exposed:?}");
    Ok(())
}

proptest! {
    #![proptest_config(seeded(160))]

    #[test]
    fn an_absurd_scene_is_refused_by_name_or_baked_and_solved(place in 0..PLACES.len(), x in number()) {
        let project = room();
        change(&project, |scene| spoil(scene, place, x));
        through(&project, PLACES[place])?;
    }
}

proptest! {
    #![proptest_config(seeded(8))]

    #[test]
    fn an_absurd_scene_that_is_not_refused_is_drawn(places in prop::collection::vec((0..PLACES.len(), number()), 1..4)) {
        let project = room();
        change(&project, |scene| places.iter().for_each(|&(place, x)| spoil(scene, place, x)));
        if let Some(light) = through(&project, "")? {
            drawn(&light)?;
        }
    }
}

#[test]
fn the_largest_and_the_smallest_that_a_scene_may_hold_is_drawn() {
    for (place, x) in [
        (4, 1e30),
        (5, 1e26),
        (10, -1e30),
        (13, 1e30),
        (14, 1e30),
        (17, 1e30),
        (19, 1e26),
        (22, 1e26),
        (19, 1e-40),
        (9, f32::MAX),
    ] {
        let project = room();
        change(&project, |scene| spoil(scene, place, x));
        let light = through(&project, "nothing").expect("numbers").expect("a bake");
        drawn(&light).unwrap_or_else(|error| panic!("{place} {x}: {error}"));
    }
}

#[test]
fn whatever_a_bake_is_told_is_done_or_refused() {
    let project = room();
    let numbers = [0.0, -1.0, 1e-300, 1e-9, 1e-3, 1e30, f64::MAX, f64::NAN, f64::INFINITY];
    for length in numbers {
        let told = Settings { patch_length: Some(length), rays: Some(8), ..Settings::default() };
        match plan(project.path(), None, &told) {
            Ok(plan) => assert!(plan.seconds.is_finite() && plan.patches < 3_000_000, "{length}: {plan:?}"),
            Err(error) => assert!(error.to_string().contains("patch length"), "{length}: {error}"),
        }
    }
    for (rays, threads) in [(0, None), (1, Some(0)), (3, Some(1)), (u32::MAX, None)] {
        let told = Settings { rays: Some(rays), threads, patch_length: Some(1.0), ..Settings::default() };
        let planned = plan(project.path(), None, &told);
        assert_eq!(planned.is_err(), rays == 0, "{rays}");
        if rays < 1000 {
            let baked = bake(project.path(), None, &told, &Silent);
            assert_eq!(baked.is_err(), rays == 0, "{rays}");
        }
        assert!(planned.is_err() || planned.is_ok_and(|plan| plan.rays > 0), "{rays}");
    }
}

#[test]
fn points_that_are_asked_for_are_answered_with_numbers_or_refused_by_their_place_in_the_list() {
    let project = room();
    let settings = settings(0.5, 64);
    bake(project.path(), None, &settings, &Silent).expect("a bake");
    let certificate = check(project.path(), None, &settings).expect("a certificate");
    assert!(certificate.holds());
    let numbers = [0.0, 0.5, 1e-40, -1e30, 1e300, f64::NAN, f64::INFINITY];
    let refused = |error: BakeError, what: &str| assert!(error.to_string().contains(what), "{error}");
    for x in numbers {
        for n in numbers {
            let point = Point { position: DVec3::new(0.5, x, 0.5), normal: DVec3::new(0.0, 1.0, n) };
            for method in [Method::Receivers, Method::Gather] {
                match query_points(project.path(), None, &settings, &[point], method) {
                    Ok(found) => {
                        let is_finite =
                            |light: &Irradiance| light.direct.is_finite() && light.indirect.is_finite();
                        assert!(found.iter().all(is_finite), "{point:?}: {found:?}");
                    }
                    Err(error) => refused(error, "point 1"),
                }
            }
        }
    }
    for x in numbers {
        let at = DVec3::new(0.5, x, 0.25);
        match query_probes(project.path(), None, &settings, &[at]) {
            Ok(found) => assert!(found.iter().flatten().all(|l| l.is_finite()), "{at}: {found:?}"),
            Err(error) => refused(error, "probe 1"),
        }
    }
}

/// What a program that writes wrong files could leave: the checksum fits.
#[test]
fn a_bake_with_any_wrong_number_is_refused_or_solved() {
    let project = room();
    let light = Solved::of(&project, &settings(0.5, 16));
    let path = project.light_file();
    let odd = [f32::NAN, f32::INFINITY, f32::MAX, -1.0, 0.0, 1e-40, 1e30];
    let counts = [u32::MAX, u32::MAX - 1, 1 << 20, 7];
    type Damage = Box<dyn Fn(&mut Transport)>;
    let mut damages: Vec<(String, Damage)> = Vec::new();
    for x in odd {
        let mut add = |what: &str, damage: Damage| damages.push((format!("{what} {x}"), damage));
        add("area", Box::new(move |t| t.patches[1].area = x));
        add("centre", Box::new(move |t| t.patches[1].centre.x = x));
        add("normal", Box::new(move |t| t.patches[1].normal.x = x));
        add("target", Box::new(move |t| t.patches[1].target = x));
        add("sample", Box::new(move |t| t.samples[3].position.y = x));
        add("sample's normal", Box::new(move |t| t.samples[3].normal.y = x));
        add("receiver", Box::new(move |t| t.receivers[3].position.y = x));
        add("receiver's normal", Box::new(move |t| t.receivers[3].normal = Vec3::splat(x)));
        add("probe", Box::new(move |t| t.probes[0].position.y = x));
        add("vertex", Box::new(move |t| t.surface.vertices[3].position.y = x));
        add("vertex's normal", Box::new(move |t| t.surface.vertices[3].normal.y = x));
        add("texture coordinate", Box::new(move |t| t.surface.vertices[3].uv[0].y = x));
        add("colour", Box::new(move |t| t.surface.vertices[3].color[0] = x));
        add("blend", Box::new(move |t| t.surface.blends[3].weights[0] = x));
        add("share", Box::new(move |t| t.patch_from_patch.weights[5] = x));
        add("receiver's share", Box::new(move |t| t.receiver_from_patch.weights[5] = x));
        add("probe's weight", Box::new(move |t| t.probe_from_patch.weights[5] = x));
        add("origin", Box::new(move |t| t.origin.z = f64::from(x)));
    }
    for n in counts {
        let mut add = |what: &str, damage: Damage| damages.push((format!("{what} {n}"), damage));
        add("component", Box::new(move |t| t.patches[1].component = n));
        add("aggregate", Box::new(move |t| t.patches[1].aggregate = n));
        add("batch", Box::new(move |t| t.patches[1].batch = n));
        add("first triangle", Box::new(move |t| t.patches[1].first_triangle = n));
        add("triangles", Box::new(move |t| t.patches[1].triangle_count = n));
        add("first sample", Box::new(move |t| t.patches[1].first_sample = n));
        add("samples", Box::new(move |t| t.patches[1].sample_count = n));
        add("sample's patch", Box::new(move |t| t.samples[1].patch = n));
        add("sky", Box::new(move |t| t.sky_patches = n));
        add("column", Box::new(move |t| t.patch_from_patch.columns[3] = n));
        add("start", Box::new(move |t| t.patch_from_patch.starts[3] = u64::from(n)));
        add("triangle's corner", Box::new(move |t| t.surface.triangles[2][1] = n));
        add("triangle's patch", Box::new(move |t| t.surface.patches[2][0] = n));
        add("batch's first", Box::new(move |t| t.surface.batches[1].first = n));
        add("batch's material", Box::new(move |t| t.surface.batches[1].material = n));
        add("blend's receiver", Box::new(move |t| t.surface.blends[3].receivers[0] = n));
    }
    let mut refused = 0;
    for (what, damage) in &damages {
        let mut transport = light.transport.clone();
        damage(&mut transport);
        file::save(&path, &transport).expect("a file");
        let Ok(transport) = file::load(&path) else {
            refused += 1;
            continue;
        };
        let solved = Solved::with(light.scene.clone(), light.assets.clone(), transport);
        assert!(solved.radiosity.iter().all(|b| b.is_finite()), "{what}");
        assert!(solved.irradiance().iter().all(|h| h.is_finite()), "{what}");
        let weights = ProbeField::new(&solved.transport).weights(Vec3::ZERO, &mut Cell::default());
        assert!(weights.weights.iter().all(|weight| weight.is_finite()), "{what}");
    }
    println!("{refused} of {} wrong files refused, the others solved", damages.len());
    assert!(refused > damages.len() / 2);
}
