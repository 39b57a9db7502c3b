//! What is left out follows the scene: after any edits the needs are those of a fresh look; light probes come with what
//! moves, and go with it; and the author has the last word.

use std::collections::BTreeMap;

use bake::{Settings, Silent, bake, plan, query_probes};
use engine::play::World;
use engine::scene::assets::Assets;
use engine::scene::file::{load_project, load_scene};
use engine::scene::import::load_assets;
use engine::scene::shape::Shape;
use engine::scene::{
    Alpha, Changes, Entity, EntityId, Feature, Forced, ImageSource, Light, LightProbeGroup, Material,
    MaterialId, MeshRenderer, MeshSource, Motion, ReflectionProbe, Refresh, Scene, Sky, SkyKind, Texture,
    Transform,
};
use engine::transport::Transport;
use engine::transport::needs::{Needs, needs_of_scene, needs_of_transport, relied_on};
use glam::{DVec3, Vec3};
use proptest::prelude::*;
use tests::project::TestProject;

fn renderer(shape: Shape, material: u32) -> MeshRenderer {
    MeshRenderer {
        mesh: MeshSource::Shape(shape),
        materials: vec![MaterialId(material)],
        casts_shadows: true,
        density: Default::default(),
        reflection: Default::default(),
    }
}

fn entity(id: u64, name: &str) -> Entity {
    Entity { id: EntityId(id), name: name.to_owned(), ..Entity::default() }
}

fn at(x: f64, y: f64, z: f64) -> Transform {
    Transform { translation: DVec3::new(x, y, z), ..Transform::default() }
}

/// A floor under a lamp, with light probes over it.
fn floor() -> Scene {
    let ground = Entity { is_static: true, mesh: Some(renderer(Shape::Plane, 0)), ..entity(1, "floor") };
    let lamp = Entity { light: Some(Light::default()), transform: at(0.0, 2.0, 0.0), ..entity(2, "lamp") };
    let positions = vec![Vec3::Y * 0.5, Vec3::new(0.5, 0.5, 0.0), Vec3::new(0.0, 0.5, 0.5), Vec3::Y];
    let probes = Entity { light_probes: Some(LightProbeGroup { positions }), ..entity(3, "probes") };
    let grey = Material { id: MaterialId(0), name: "grey".to_owned(), ..Material::default() };
    Scene { materials: vec![grey], entities: vec![ground, lamp, probes], ..Scene::default() }
}

fn ball() -> Entity {
    let transform = at(0.2, 0.5, 0.2);
    Entity { mesh: Some(renderer(Shape::Sphere, 0)), transform, ..entity(4, "ball") }
}

fn with_ball() -> Scene {
    let mut scene = floor();
    scene.entities.push(ball());
    scene
}

fn project(scene: &Scene) -> TestProject {
    TestProject::forcing(scene, BTreeMap::new())
}

fn settings() -> Settings {
    Settings { rays: Some(64), patch_length: Some(0.25), ..Settings::default() }
}

fn baked(project: &TestProject) -> bake::Baked {
    bake(project.path(), None, &settings(), &Silent).expect("a bake")
}

fn has_rows_of(transport: &Transport, other: &Transport) -> bool {
    transport.patch_from_patch == other.patch_from_patch
        && transport.receiver_from_patch == other.receiver_from_patch
        && transport.patches == other.patches
        && transport.surface == other.surface
}

#[test]
fn light_probes_come_with_what_moves_and_go_with_it_and_no_other_ray_is_traced() {
    let project = project(&floor());
    let still = baked(&project).transport;
    assert!(still.probes.is_empty() && still.probe_from_patch.is_empty());
    let said = |transport: &Transport| {
        transport.certificate.left_out.iter().any(|line| line.starts_with("light probes: nothing moves"))
    };
    assert!(said(&still), "{:?}", still.certificate.left_out);

    project.save(&with_ball());
    let moving = baked(&project);
    let told: Vec<String> = moving.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(told.iter().filter(|line| line.contains("light probes")).count(), 1, "{told:?}");
    assert!(told.iter().any(|line| line.contains("`ball`")), "{told:?}");
    let moving = moving.transport;
    assert_eq!((moving.probes.len(), moving.probe_from_patch.len()), (4, 36));
    assert!(has_rows_of(&moving, &still) && !said(&moving));
    assert_eq!(moving.certificate.rays_traced, 4 * 4096, "of probes alone");
    let fresh = bake(project.path(), None, &Settings { force: true, ..settings() }, &Silent).expect("a bake");
    assert_eq!(fresh.transport.hash(), moving.hash(), "as if all had been baked at once");
    assert_eq!(fresh.transport.certificate.rays, moving.certificate.rays);

    project.save(&floor());
    let again = baked(&project).transport;
    assert_eq!((again.hash(), again.certificate.rays_traced), (still.hash(), 0));
    assert!(said(&again));
}

#[test]
fn the_player_names_the_probes_that_a_new_mover_misses_and_bears_with_those_of_one_that_is_gone() {
    let project = project(&floor());
    baked(&project);
    let warnings = || {
        let (_, warnings) = World::load(project.path(), None, false).expect("a world");
        warnings.iter().map(ToString::to_string).collect::<Vec<_>>()
    };
    assert_eq!(warnings(), [""; 0]);
    project.save(&with_ball());
    let told = warnings();
    assert!(told.len() == 1 && told[0].contains("the light probes of `probes`"), "{told:?}");
    baked(&project);
    assert_eq!(warnings(), [""; 0]);
    project.save(&floor());
    assert_eq!(warnings(), [""; 0], "a bake that has more than is needed");
}

#[test]
fn probes_are_asked_for_in_a_bake_that_has_none() {
    let project = project(&floor());
    assert!(baked(&project).transport.probes.is_empty());
    let light = query_probes(project.path(), None, &settings(), &[DVec3::new(0.0, 0.5, 0.0)]).expect("light");
    assert!(light[0][0].min_element() > 0.0, "{light:?}");
}

#[test]
fn the_author_forces_features_in_and_out_and_is_told_the_price() {
    let forced = [(Feature::LightProbes, Forced::In), (Feature::Sky, Forced::Out)].into();
    let mut scene = floor();
    scene.sky = Sky { kind: SkyKind::Constant { radiance: Vec3::ONE }, changes: Changes::Anything };
    let project = TestProject::forcing(&scene, forced);
    let transport = baked(&project).transport;
    assert_eq!((transport.probes.len(), transport.sky_patches), (4, 0));
    let plan = plan(project.path(), None, &settings()).expect("a plan");
    assert!(plan.exact);
    let [probes, sky] = [Feature::LightProbes, Feature::Sky].map(|feature| plan.needs.verdict(feature));
    assert_eq!(
        (probes.is_in, probes.forced, sky.is_in, sky.forced),
        (true, Some(Forced::In), false, Some(Forced::Out))
    );
    let stored: u64 = engine::transport::file::arrays(&transport)
        .iter()
        .filter(|(name, _)| name.starts_with("probe.") || *name == "probes")
        .map(|(_, bytes)| bytes.len() as u64)
        .sum();
    assert_eq!(probes.saving.file_bytes + 8, stored, "one start more than rows");
    assert!(probes.saving.seconds > 0.0 && probes.saving.milliseconds > 0.0);
    let told = plan.needs.told();
    let price =
        "forced in: light probes, though nothing moves that would read those of `probes`, at the price of ";
    assert!(told.iter().any(|line| line.starts_with(price)), "{told:#?}");
    assert!(
        told.iter().any(|line| line.starts_with("left out: sky: the project says so, though ")),
        "{told:#?}"
    );
    assert_eq!(transport.certificate.needs.as_ref().map(|needs| needs.has(Feature::Sky)), Some(false));
}

#[test]
fn what_is_forced_out_meets_no_ray() {
    let mut scene = floor();
    scene.materials[0].alpha = Alpha::Blend;
    scene.materials[0].opacity = 0.25;
    let area = |transport: &Transport| transport.patches.iter().map(|patch| patch.area).sum::<f32>();
    let [with, without] = [None, Some((Feature::Holes, Forced::Out))].map(|says| {
        let project = TestProject::forcing(&scene, says.into_iter().collect());
        area(&baked(&project).transport)
    });
    assert!((with / without - 0.25).abs() < 1e-3, "{with} {without}");
}

#[test]
fn a_plan_estimates_what_the_bake_then_counts() {
    let project = project(&with_ball());
    let before = plan(project.path(), None, &settings()).expect("a plan");
    baked(&project);
    let after = plan(project.path(), None, &settings()).expect("a plan");
    assert!(!before.exact && after.exact && after.rays_kept == after.rays);
    for feature in [Feature::LightProbes, Feature::Matrix] {
        let [about, counted] = [&before, &after].map(|plan| plan.needs.verdict(feature).saving.file_bytes);
        let ratio = about as f64 / counted.max(1) as f64;
        assert!((0.2..5.0).contains(&ratio), "{feature:?}: about {about}, counted {counted}");
    }
    let needed = |feature| after.needs.has(feature);
    assert!(needed(Feature::LightProbes) && needed(Feature::Matrix) && !needed(Feature::Sky));
    assert_eq!(after.left_out, after.needs.left_out().collect::<Vec<_>>());
}

#[test]
fn an_unknown_feature_is_refused_by_file_and_the_known_ones_are_listed() {
    let project = project(&floor());
    let path = project.path().join("project.ron");
    let text = std::fs::read_to_string(&path).expect("project.ron");
    let with = |features: &str| {
        let end = text.rfind(')').expect("a struct");
        std::fs::write(&path, format!("{}    features: {features},\n)\n", &text[..end])).expect("a file");
        load_project(project.path())
    };
    let read = with("{light_probes: in, holes: out}").expect("settings");
    let says = [(Feature::LightProbes, Forced::In), (Feature::Holes, Forced::Out)].into();
    assert_eq!(read.features, says);
    let refused = with("{lite_probes: in}").expect_err("no such feature").to_string();
    assert!(refused.contains("project.ron") && refused.contains("lite_probes"), "{refused}");
    assert!(refused.contains("light_probes") && refused.contains("material_variants"), "{refused}");
    let refused = with("{light_probes: maybe}").expect_err("no such word").to_string();
    assert!(refused.contains("maybe") && refused.contains("out"), "{refused}");
}

// ---- any edits

/// Nothing but the materials that edits paint with.
fn palette() -> Scene {
    let material = |id| Material { id: MaterialId(id), name: format!("m{id}"), ..Material::default() };
    Scene { materials: (0..5).map(material).collect(), ..Scene::default() }
}

/// One edit of a scene, by its number and what it is told.
fn edit(scene: &mut Scene, what: u8, which: usize, changes: Changes) {
    let id = scene.free_entity_id();
    let name = format!("e{}", id.0);
    let place = at(which as f64 - 2.0, 1.0, 0.0);
    let new = Entity { transform: place, ..entity(id.0, &name) };
    let material = scene.materials.len().checked_sub(1).map(|last| which % (last + 1));
    let of_all = |scene: &mut Scene, edit: &mut dyn FnMut(&mut Entity)| {
        let count = scene.entities.len();
        if count > 0 {
            edit(&mut scene.entities[which % count]);
        }
    };
    let texture = || Some(Texture::new(ImageSource { file: "assets/none.png".to_owned(), image: None }));
    match what {
        0 => scene.entities.push(Entity { mesh: Some(renderer(Shape::Sphere, which as u32)), ..new }),
        1 => {
            let mesh = Some(renderer(Shape::Cube, which as u32));
            scene.entities.push(Entity { mesh, is_static: true, ..new });
        }
        2 => {
            let light_probes = Some(LightProbeGroup { positions: vec![Vec3::ZERO, Vec3::X] });
            scene.entities.push(Entity { light_probes, ..new });
        }
        3 => {
            let light = Some(Light { changes, casts_shadows: which.is_multiple_of(2), ..Light::default() });
            scene.entities.push(Entity { light, ..new });
        }
        4 => {
            let refresh = if which.is_multiple_of(2) { Refresh::Baked } else { Refresh::OnChange };
            let reflection_probe = Some(ReflectionProbe { refresh, ..ReflectionProbe::default() });
            scene.entities.push(Entity { reflection_probe, ..new });
        }
        5 => of_all(scene, &mut |entity| entity.hidden = !entity.hidden),
        6 if !scene.entities.is_empty() => {
            let index = which % scene.entities.len();
            scene.entities.remove(index);
        }
        7 => of_all(scene, &mut |entity| {
            let spin = Motion::Spin { axis: DVec3::Y, radians_per_second: 1.0 };
            entity.motion = entity.motion.take().xor(Some(spin)).filter(|_| !entity.is_static);
        }),
        8 => scene.sky.changes = changes,
        9 => scene.sky.kind = SkyKind::None,
        10 => scene.sky.kind = SkyKind::Constant { radiance: Vec3::splat(which as f32) },
        11 => {
            let (horizon, ground) = (Vec3::ONE, Vec3::splat(0.1 * which as f32));
            let zenith = Vec3::new(0.2, 0.3, 1.0);
            scene.sky.kind = SkyKind::Gradient { zenith, horizon, ground, sun: None, sun_diameter: 0.01 };
        }
        12 => {
            let id = MaterialId(scene.materials.len() as u32);
            scene.materials.push(Material { id, name: format!("m{}", id.0), ..Material::default() });
        }
        _ => {
            let Some(material) = material.map(|index| &mut scene.materials[index]) else { return };
            match what {
                13 => material.roughness = 0.25 * which as f32,
                14 => material.normal_texture = material.normal_texture.take().xor(texture()),
                15 => material.alpha = [Alpha::Opaque, Alpha::Blend, Alpha::Mask { cutoff: 0.5 }][which % 3],
                16 => material.albedo.color = [Vec3::ZERO, Vec3::ONE, Vec3::X][which % 3],
                17 => {
                    material.emission.color = [Vec3::ZERO, Vec3::ONE, Vec3::Y][which % 3];
                    material.emission.changes = changes;
                }
                18 => material.unlit = !material.unlit,
                19 => material.metallic = f32::from(u8::from(material.metallic == 0.0)),
                _ => of_all(scene, &mut |entity| {
                    entity.light.iter_mut().for_each(|light| light.changes = changes);
                    entity.mesh.iter_mut().for_each(|mesh| mesh.casts_shadows = !mesh.casts_shadows);
                }),
            }
        }
    }
}

fn edits() -> impl Strategy<Value = Vec<(u8, usize, Changes)>> {
    let changes = prop_oneof![Just(Changes::Never), Just(Changes::Intensity), Just(Changes::Anything)];
    prop::collection::vec((0_u8..21, 0_usize..5, changes), 1..24)
}

fn none() -> BTreeMap<Feature, Forced> {
    BTreeMap::new()
}

/// What a look at nothing but the files finds.
fn fresh_look(scene: &Scene) -> Needs {
    let project = TestProject::of(scene);
    let scene = load_scene(project.path(), "main").expect("the scene");
    let (assets, _) = load_assets(project.path(), &scene).expect("assets");
    needs_of_scene(&scene, &assets, &none())
}

fn assets_of(scene: &Scene) -> Assets {
    let mut assets = Assets::default();
    for renderer in scene.entities.iter().filter_map(|entity| entity.mesh.as_ref()) {
        if let MeshSource::Shape(shape) = &renderer.mesh {
            let mesh = engine::scene::shape::mesh(*shape);
            assets.meshes.insert(renderer.mesh.clone(), std::sync::Arc::new(mesh));
        }
    }
    assets
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 192, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn after_any_edits_the_needs_are_those_of_a_fresh_look_and_no_omission_is_stale(edits in edits()) {
        let mut scene = palette();
        for (what, which, changes) in edits {
            let was = scene.clone();
            edit(&mut scene, what, which, changes);
            let (assets, before) = (assets_of(&scene), assets_of(&was));
            let (needs, old) = (needs_of_scene(&scene, &assets, &none()), needs_of_scene(&was, &before, &none()));
            for feature in Feature::ALL {
                let relies = [relied_on(feature, &was, &before), relied_on(feature, &scene, &assets)];
                if old.has(feature) != needs.has(feature) {
                    prop_assert_ne!(&relies[0], &relies[1], "{:?} by edit {}", feature, what);
                }
            }
            prop_assert_eq!(needs.verdicts.iter().map(|verdict| verdict.feature).collect::<Vec<_>>(), Feature::ALL);
        }
        let fresh = fresh_look(&scene);
        prop_assert_eq!(needs_of_scene(&scene, &assets_of(&scene), &none()), fresh);
    }

    #[test]
    fn what_is_forced_is_so_whatever_the_scene_and_nothing_else_is(edits in edits(), which in 0_usize..16, way in 0_u8..2) {
        let mut scene = palette();
        edits.into_iter().for_each(|(what, which, changes)| edit(&mut scene, what, which, changes));
        let assets = assets_of(&scene);
        let (feature, says) = (Feature::ALL[which], [Forced::In, Forced::Out][usize::from(way)]);
        let plain = needs_of_scene(&scene, &assets, &none());
        let forced = needs_of_scene(&scene, &assets, &[(feature, says)].into());
        prop_assert_eq!(forced.has(feature), says == Forced::In);
        prop_assert_eq!(forced.verdict(feature).forced.is_some(), plain.has(feature) != (says == Forced::In));
        // Those that stand on the sky, on cubemaps or on the matrix follow it.
        let follows = |other: Feature| match feature {
            Feature::Sky => true,
            Feature::Reflections => matches!(other, Feature::Recaptures | Feature::UnseenCaptures),
            Feature::Matrix => matches!(other, Feature::CoarseCorrection | Feature::Columns),
            _ => false,
        };
        for other in Feature::ALL.into_iter().filter(|&other| other != feature && !follows(other)) {
            prop_assert_eq!(forced.verdict(other), plain.verdict(other));
        }
    }
}

#[test]
fn the_same_bake_with_the_same_scene_needs_the_same() {
    let project = project(&with_ball());
    let transport = baked(&project).transport;
    let (scene, (assets, _)) =
        (project.scene(), load_assets(project.path(), &project.scene()).expect("assets"));
    let needs = needs_of_transport(&scene, &assets, &transport, &none());
    assert_eq!(Some(&needs), transport.certificate.needs.as_ref());
    let is_out = |feature| !needs.has(feature);
    assert!(
        [Feature::Sky, Feature::Holes, Feature::Directional, Feature::Reflections].into_iter().all(is_out)
    );
    assert!([Feature::Matrix, Feature::ShadowMaps, Feature::LightProbes].into_iter().all(|f| needs.has(f)));
}
