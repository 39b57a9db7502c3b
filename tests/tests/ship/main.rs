//! What the player loads is less than the bake, and gives the same light; whatever becomes of the files.

mod intensity;

use std::path::Path;

use bake::{BakeError, Baked, Settings, Silent, bake, check};
use engine::play::World;
use engine::render::{Eye, View};
use engine::scene::file::{load_project, save_project};
use engine::scene::{Changes, EntityId, Feature, Forced, LightKind, Scene, SkyKind};
use engine::transport::solve::gather;
use engine::transport::solved::{Solved, Source, Spread};
use engine::transport::{Transport, file};
use glam::{DVec3, Vec3};
use tests::enclosure::{self, Wall, room};
use tests::picture::{Studio, gpu};
use tests::project::TestProject;
use tests::room::light;
use tests::solved;

const LAMP: EntityId = EntityId(100);

fn settings() -> Settings {
    Settings { rays: Some(256), patch_length: Some(0.5), ..Settings::default() }
}

fn baked(project: &TestProject) -> Baked {
    bake(project.path(), None, &settings(), &Silent).expect("a bake")
}

/// Left out is whatever the rules find.
fn project_of(walls: &[Wall]) -> TestProject {
    let project = enclosure::project(walls);
    force(&project, &[]);
    project
}

/// A closed room of 2 m with coloured walls and a lamp; nothing in it ever changes.
fn still_room() -> TestProject {
    let project = project_of(&room(Vec3::ZERO, Vec3::splat(2.0)));
    enclosure::change(&project, |scene| {
        scene.materials[0].albedo.color = Vec3::new(0.7, 0.2, 0.1);
        scene.materials[1].albedo.color = Vec3::new(0.1, 0.6, 0.2);
        let at = DVec3::new(0.6, 1.5, 0.8);
        scene.entities.push(light(LAMP.0, LightKind::Point, 3.0, at, DVec3::ZERO));
        all_changes(scene, Changes::Never);
    });
    project
}

fn all_changes(scene: &mut Scene, changes: Changes) {
    for material in &mut scene.materials {
        (material.albedo.changes, material.emission.changes) = (changes, changes);
    }
    scene.entities.iter_mut().filter_map(|entity| entity.light.as_mut()).for_each(|l| l.changes = changes);
    scene.sky.changes = changes;
}

fn lamp(scene: &mut Scene) -> &mut engine::scene::Light {
    let lamp = scene.entities.iter_mut().find(|entity| entity.id == LAMP);
    lamp.and_then(|lamp| lamp.light.as_mut()).expect("a lamp")
}

/// What the author says of features, whatever the rules find.
fn force(project: &TestProject, says: &[(Feature, Forced)]) {
    let mut settings = load_project(project.path()).expect("project.ron");
    settings.features = says.iter().copied().collect();
    save_project(project.path(), &settings).expect("project.ron");
}

fn full_file(project: &TestProject) -> std::path::PathBuf {
    file::full_path(project.path(), "main")
}

fn shipped(project: &TestProject) -> Transport {
    file::load(&project.light_file()).expect("a light file")
}

fn section_names(path: &Path) -> String {
    let sections = file::sections(path).expect("sections");
    sections.into_iter().map(|section| section.0 + " ").collect()
}

fn omitted(transport: &Transport) -> Vec<Feature> {
    transport.omissions.iter().map(|omission| omission.feature).collect()
}

/// Irradiance at receivers, solved anew from the full transport: all but what comes straight from lights.
fn fresh(project: &TestProject, full: &Transport) -> Vec<Vec3> {
    let scene = project.scene();
    let (assets, _) = engine::scene::import::load_assets(project.path(), &scene).expect("assets");
    let light = solved::Solved::with(scene, assets, full.clone());
    gather(&full.receiver_from_patch, &light.radiosity).into_iter().map(|h| h.as_vec3()).collect()
}

fn irradiance(spread: &Spread) -> Vec<Vec3> {
    let [emitted, bounced] = &spread.receivers;
    let at = |values: &[Vec3], i: usize| values.get(i).copied().unwrap_or(Vec3::ZERO);
    (0..emitted.len().max(bounced.len())).map(|i| at(emitted, i) + at(bounced, i)).collect()
}

/// Differs nowhere by more than this share of the largest.
fn assert_same(a: &[Vec3], b: &[Vec3], limit: f32) {
    assert_eq!(a.len(), b.len());
    let largest = b.iter().fold(0.0_f32, |most, b| most.max(b.abs().max_element()));
    let apart = a.iter().zip(b).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max);
    assert!(largest > 0.0 && apart <= limit * largest, "{apart} of {largest}");
}

fn combined(solved: &Solved, scene: &Scene) -> Vec<Vec3> {
    irradiance(&solved.combine(&solved.scale(scene)))
}

fn warnings(project: &TestProject) -> (World, Vec<String>) {
    let (world, warnings) = World::load(project.path(), None, false).expect("a world");
    (world, warnings.iter().map(ToString::to_string).collect())
}

#[test]
fn light_that_never_changes_is_solved_at_the_bake_and_no_matrix_is_in_the_file() {
    let project = still_room();
    force(&project, &[(Feature::Matrix, Forced::In)]);
    let whole = baked(&project);
    let whole_bytes = std::fs::metadata(&whole.file).expect("a file").len();
    assert!(!full_file(&project).exists(), "nothing is left out");

    force(&project, &[]);
    let again = baked(&project);
    assert!(again.unchanged, "no ray is traced for it");
    assert_eq!(again.transport.hash(), whole.transport.hash());
    let light = shipped(&project);
    assert_eq!(omitted(&light), [Feature::Matrix]);
    assert_eq!(light.certificate.transport_hash, whole.transport.hash().to_hex().to_string());
    let names = section_names(&project.light_file());
    let rows = ["patch.", "receiver.", "probe.", "samples", "sky"];
    assert!(rows.iter().all(|rows| !names.contains(rows)), "{names}");
    let bytes = std::fs::metadata(project.light_file()).expect("a file").len();
    println!("{bytes} of {whole_bytes} bytes");
    assert!(2 * bytes < whole_bytes, "{bytes} of {whole_bytes} bytes");
    let solved = light.solved.as_ref().expect("light");
    assert_eq!(solved.responses.len(), 1);
    assert_same(&combined(solved, &project.scene()), &fresh(&project, &again.transport), 1e-6);
    assert_eq!(file::load_full(project.path(), "main").expect("a bake").hash(), whole.transport.hash());
    assert!(check(project.path(), None, &settings()).expect("a certificate").holds());
}

#[test]
fn a_lamp_of_intensity_is_one_response_and_follows_every_switch() {
    let project = still_room();
    enclosure::change(&project, |scene| {
        lamp(scene).changes = Changes::Intensity;
        scene.materials[3].emission.color = Vec3::new(0.4, 0.3, 0.2);
        scene.materials[2].emission.color = Vec3::new(0.0, 0.1, 0.5);
        scene.materials[2].emission.changes = Changes::Intensity;
    });
    let full = baked(&project).transport;
    let light = shipped(&project);
    let solved = light.solved.as_ref().expect("light");
    let sources: Vec<Source> = solved.responses.iter().map(|response| response.source).collect();
    let emission = Source::Emission(project.scene().materials[2].id);
    assert_eq!(sources, [Source::Never, Source::Light(LAMP), emission]);
    for (on, intensity, strength) in
        [(true, 3.0, 1.0), (false, 3.0, 1.0), (true, 1.5, 0.0), (true, 40.0, 2.5)]
    {
        enclosure::change(&project, |scene| {
            (lamp(scene).on, lamp(scene).intensity) = (on, intensity);
            scene.materials[2].emission.strength = strength;
        });
        assert_same(&combined(solved, &project.scene()), &fresh(&project, &full), 1e-5);
        let (world, told) = warnings(&project);
        assert!(told.is_empty() && world.transport.solved.is_some(), "{told:?}");
    }
}

#[test]
fn a_sky_of_intensity_is_one_response() {
    let mut walls = room(Vec3::ZERO, Vec3::splat(2.0));
    walls.retain(|wall| wall.name != "ceiling");
    let project = project_of(&walls);
    enclosure::change(&project, |scene| {
        enclosure::under_a_sky(scene, 0.7);
        all_changes(scene, Changes::Never);
        scene.sky.changes = Changes::Intensity;
    });
    let full = baked(&project).transport;
    let light = shipped(&project);
    let solved = light.solved.as_ref().expect("light");
    for radiance in [0.7, 2.0] {
        enclosure::change(&project, |scene| enclosure::under_a_sky(scene, radiance));
        assert_same(&combined(solved, &project.scene()), &fresh(&project, &full), 1e-5);
    }
}

#[test]
fn black_patches_have_neither_row_nor_column_and_the_light_is_the_same() {
    let project = still_room();
    enclosure::change(&project, |scene| {
        all_changes(scene, Changes::Anything);
        for material in [1, 4] {
            scene.materials[material].albedo.color = Vec3::ZERO;
            scene.materials[material].albedo.changes = Changes::Never;
            scene.materials[material].emission.changes = Changes::Never;
        }
    });
    let full = baked(&project).transport;
    let light = shipped(&project);
    assert_eq!(omitted(&light), [Feature::BlackPatches]);
    let (before, after) = (full.patch_from_patch.entries(), light.patch_from_patch.entries());
    // Of six walls two are black: of 30 pairs of walls 12 are left.
    assert!(after * 30 < before * 13, "{after} of {before}");
    assert!(light.receiver_from_patch.entries() < full.receiver_from_patch.entries());
    assert_same(&fresh(&project, &light), &fresh(&project, &full), 1e-6);
}

#[test]
fn rooms_that_no_light_comes_to_have_no_rows() {
    let mut walls = room(Vec3::ZERO, Vec3::splat(2.0));
    walls.extend(room(Vec3::X * 3.0, Vec3::new(5.0, 2.0, 2.0)));
    let project = project_of(&walls);
    enclosure::change(&project, |scene| {
        scene.entities.push(light(LAMP.0, LightKind::Point, 3.0, DVec3::ONE, DVec3::ZERO));
    });
    let full = baked(&project).transport;
    let light = shipped(&project);
    assert_eq!(omitted(&light), [Feature::UnlitPatches]);
    let share = light.patch_from_patch.entries() as f64 / full.patch_from_patch.entries() as f64;
    assert!((share - 0.5).abs() < 0.02, "{share}");
    assert_same(&fresh(&project, &light), &fresh(&project, &full), 1e-6);
}

#[test]
fn a_sky_that_is_the_same_everywhere_is_one_column_or_two() {
    let mut walls = room(Vec3::ZERO, Vec3::splat(2.0));
    walls.retain(|wall| wall.name != "ceiling");
    let project = project_of(&walls);
    force(&project, &[(Feature::Matrix, Forced::In)]);
    enclosure::change(&project, |scene| {
        enclosure::under_a_sky(scene, 0.7);
        scene.sky.changes = Changes::Intensity;
    });
    let full = baked(&project).transport;
    let light = shipped(&project);
    assert_eq!(omitted(&light), [Feature::SkyPatches]);
    assert!((1..=2).contains(&light.sky_patches) && full.sky_patches > 256);
    light.validate().expect("a sound transport");
    for row in 0..light.patch_from_patch.len() {
        let (sum, whole) = (light.patch_from_patch.sum(row), full.patch_from_patch.sum(row));
        assert!(sum <= whole && whole - sum < 3e-7, "{sum} {whole}");
    }
    assert_same(&fresh(&project, &light), &fresh(&project, &full), 1e-6);
}

#[test]
fn a_second_bake_does_nothing_and_an_edit_of_lights_rewrites_the_light_file_alone() {
    let project = still_room();
    baked(&project);
    let read =
        || [project.light_file(), full_file(&project)].map(|path| std::fs::read(path).expect("a file"));
    let written = || {
        [project.light_file(), full_file(&project)]
            .map(|path| std::fs::metadata(path).and_then(|about| about.modified()).expect("a file"))
    };
    let (first, times) = (read(), written());
    assert!(baked(&project).unchanged);
    assert_eq!(written(), times, "nothing is written");
    enclosure::change(&project, |scene| lamp(scene).color = Vec3::new(1.0, 0.5, 0.1));
    let again = baked(&project);
    assert!(again.unchanged && again.transport.certificate.rays_traced == 0);
    let second = read();
    assert!(second[0] != first[0] && second[1] == first[1]);
    assert_eq!(written()[1], times[1]);
    let solved = shipped(&project).solved.expect("light");
    assert_same(&combined(&solved, &project.scene()), &fresh(&project, &again.transport), 1e-6);
}

#[test]
fn where_nothing_is_left_out_there_is_one_file_and_no_left_over() {
    let project = still_room();
    baked(&project);
    assert!(full_file(&project).is_file());
    enclosure::change(&project, |scene| all_changes(scene, Changes::Anything));
    let again = baked(&project);
    assert!(again.unchanged && !full_file(&project).exists());
    let light = shipped(&project);
    assert!(light.omissions.is_empty() && light.solved.is_none());
    assert_eq!(light.hash(), again.transport.hash());
}

#[test]
fn a_lamp_that_may_change_by_now_brings_the_full_transport_back_with_one_message() {
    let project = still_room();
    let full = baked(&project).transport;
    let (world, told) = warnings(&project);
    assert!(told.is_empty() && world.transport.solved.is_some(), "{told:?}");

    enclosure::change(&project, |scene| lamp(scene).changes = Changes::Anything);
    let (world, told) = warnings(&project);
    assert_eq!(told.len(), 1, "{told:?}");
    let says = ["matrix at run time", "transport.hohlraum", "light 100", "run `hohlraum-bake"];
    assert!(says.iter().all(|part| told[0].contains(part)), "{told:?}");
    assert_eq!(world.transport.hash(), full.hash());
    assert!(world.transport.solved.is_none() && world.left_out.is_empty());
    let stale = check(project.path(), None, &settings()).map(|_| ()).expect_err("a stale light file");
    assert!(matches!(stale, BakeError::Stale { .. }), "{stale}");

    std::fs::remove_file(full_file(&project)).expect("a file");
    let (world, told) = warnings(&project);
    assert_eq!(told.len(), 1, "{told:?}");
    assert!(told[0].contains("missing") && told[0].contains("run `hohlraum-bake"), "{told:?}");
    assert!(world.transport.patches.is_empty(), "no light is better than wrong light");
    assert_eq!(world.left_out.len(), 1);
}

#[test]
fn a_feature_that_the_project_forces_in_is_played_before_the_next_bake() {
    let project = still_room();
    let full = baked(&project).transport;
    force(&project, &[(Feature::Matrix, Forced::In)]);
    let (world, told) = warnings(&project);
    assert_eq!(told.len(), 1, "{told:?}");
    assert!(told[0].contains("the project asks for it"), "{told:?}");
    assert_eq!(world.transport.hash(), full.hash());
}

#[test]
fn two_files_of_different_bakes_are_noticed_by_all_and_mended_by_the_next_bake() {
    let project = still_room();
    baked(&project);
    let old = std::fs::read(project.light_file()).expect("a file");
    enclosure::change(&project, |scene| scene.entities[0].transform.translation.x = -0.5);
    let full = baked(&project).transport;
    let whole = std::fs::read(project.light_file()).expect("a file");

    // Cut off between the two: the full transport is new, the light file is not.
    std::fs::write(project.light_file(), &old).expect("a file");
    let error = check(project.path(), None, &settings()).map(|_| ()).expect_err("a refusal").to_string();
    assert!(error.contains("different bakes"), "{error}");
    let (_, told) = warnings(&project);
    assert!(told.len() == 1 && told[0].contains("stale"), "{told:?}");
    let mended = baked(&project);
    assert!(mended.unchanged, "the full transport is there: no ray is traced");
    assert_eq!(std::fs::read(project.light_file()).expect("a file"), whole);

    // The very first bake, cut off.
    std::fs::remove_file(project.light_file()).expect("a file");
    assert!(baked(&project).unchanged);
    assert_eq!(shipped(&project).certificate.transport_hash, full.hash().to_hex().to_string());

    // Somebody deletes what is beside it.
    std::fs::remove_file(full_file(&project)).expect("a file");
    let error = check(project.path(), None, &settings()).map(|_| ()).expect_err("a refusal").to_string();
    assert!(error.contains("transport.hohlraum") && error.contains("missing"), "{error}");
    assert!(!baked(&project).unchanged);
    assert_eq!(file::load_full(project.path(), "main").expect("a bake").hash(), full.hash());
}

#[test]
fn a_left_over_beside_a_light_file_that_is_whole_is_not_read() {
    let project = still_room();
    baked(&project);
    let left_over = std::fs::read(full_file(&project)).expect("a file");
    enclosure::change(&project, |scene| {
        all_changes(scene, Changes::Anything);
        scene.entities[0].transform.translation.x = -0.5;
    });
    let full = baked(&project).transport;
    std::fs::write(full_file(&project), left_over).expect("a file");
    assert_eq!(file::load_full(project.path(), "main").expect("a bake").hash(), full.hash());
    assert!(baked(&project).unchanged && !full_file(&project).exists());
}

#[test]
fn a_sky_that_turns_into_another_is_not_played_from_one_column() {
    let project = project_of(&room(Vec3::ZERO, Vec3::splat(2.0))[..3]);
    force(&project, &[(Feature::Matrix, Forced::In)]);
    enclosure::change(&project, |scene| {
        enclosure::under_a_sky(scene, 0.7);
        scene.sky.changes = Changes::Intensity;
    });
    baked(&project);
    let gradient = |zenith| SkyKind::Gradient {
        zenith,
        horizon: Vec3::ONE,
        ground: Vec3::ZERO,
        sun: None,
        sun_diameter: 0.01,
    };
    enclosure::change(&project, |scene| scene.sky.kind = gradient(Vec3::X));
    let (world, told) = warnings(&project);
    assert_eq!(told.len(), 1, "{told:?}");
    assert!(world.transport.sky_patches > 256);
}

/// Radiance of a few views, lamp on, dimmed and off; and how many transport dispatches that took.
fn pictures(project: &TestProject, transport: Transport) -> Option<(Vec<Vec3>, u32)> {
    let mut scene = project.scene();
    let eye = Eye::looking(DVec3::new(1.9, 1.7, 1.9), DVec3::new(0.5, 0.6, 0.4));
    let mut studio = Studio::new(gpu()?, transport, eye, [64, 48]);
    (studio.assets, _) = engine::scene::import::load_assets(project.path(), &scene).expect("assets");
    let (mut all, mut dispatches) = (Vec::new(), 0);
    for (on, intensity) in [(true, 3.0), (true, 1.2), (false, 3.0)] {
        (lamp(&mut scene).on, lamp(&mut scene).intensity) = (on, intensity);
        for view in [View::Composite, View::Direct, View::Indirect] {
            dispatches += studio.draw(&scene, view).transport_dispatches;
            studio.settle(&scene, view);
            all.extend(studio.radiance());
        }
    }
    Some((all, dispatches))
}

#[test]
fn the_picture_from_the_light_file_is_that_of_the_full_transport_and_takes_no_dispatch() {
    let project = still_room();
    enclosure::change(&project, |scene| {
        lamp(scene).changes = Changes::Intensity;
        scene.materials[3].emission.color = Vec3::new(0.4, 0.3, 0.2);
    });
    let full = baked(&project).transport;
    let Some((whole, solved_for)) = pictures(&project, full) else { return };
    let Some((less, dispatches)) = pictures(&project, shipped(&project)) else { return };
    assert!(solved_for > 0 && dispatches == 0, "{solved_for} {dispatches}");
    // A light that is solved for frame by frame is within 1e-3 of its solution.
    assert_same(&less, &whole, 1e-3);
}

#[test]
fn the_picture_without_black_and_unlit_patches_and_with_one_column_of_sky_is_the_same() {
    let mut walls = room(Vec3::ZERO, Vec3::splat(2.0));
    walls.retain(|wall| wall.name != "ceiling");
    walls.extend(room(Vec3::X * 3.0, Vec3::new(5.0, 2.0, 2.0)));
    let project = project_of(&walls);
    force(&project, &[(Feature::Matrix, Forced::In)]);
    enclosure::change(&project, |scene| {
        enclosure::under_a_sky(scene, 0.3);
        scene.sky.changes = Changes::Intensity;
        scene.materials[1].albedo.color = Vec3::ZERO;
        scene.entities.push(light(LAMP.0, LightKind::Point, 3.0, DVec3::ONE, DVec3::ZERO));
    });
    let full = baked(&project).transport;
    let light = shipped(&project);
    assert_eq!(omitted(&light), [Feature::SkyPatches, Feature::BlackPatches, Feature::UnlitPatches]);
    assert!(2 * light.patch_from_patch.entries() < full.patch_from_patch.entries());
    let Some((whole, _)) = pictures(&project, full) else { return };
    let Some((less, _)) = pictures(&project, light) else { return };
    assert_same(&less, &whole, 1e-3);
}
