//! What is on disk and what the clock says: threads, damaged bakes, scenes without or with far too much to bake,
//! odd times.

use bake::{Settings, Silent, bake, check, plan};
use engine::play::clock::Clock;
use engine::render::{Eye, View};
use engine::scene::file::Quality;
use engine::scene::motion::moved;
use engine::scene::{Entity, EntityId, LightProbeGroup, Motion, Scene, SkyKind, Transform};
use engine::transport::file::{self, VERSION, arrays};
use glam::{DVec3, Vec3};
use tests::picture::{Studio, gpu};
use tests::project::TestProject;
use tests::solved::{
    Solved, WALLS, baked, block, change, paint, radiosity_on_gpu, rectangle, settings, shell,
};
use tests::surfaces::{self, entities};

/// A room with something of everything that a bake holds.
fn room() -> TestProject {
    let mut surfaces = shell(Vec3::ZERO, Vec3::new(2.0, 1.0, 1.0), WALLS);
    surfaces[3].1.clear(); // under the sky
    surfaces.push(("block", block(Vec3::new(0.5, 0.0, 0.25), Vec3::new(0.75, 0.5, 0.75))));
    let project = surfaces::project(&surfaces);
    paint(&project, |name, material| {
        material.albedo.color = Vec3::new(0.7, 0.5, 0.3);
        material.double_sided = name == "+x";
        material.emission.color = Vec3::splat(if name == "-x" { 1.0 } else { 0.0 });
        material.emission.sampled = name == "-x";
    });
    change(&project, |scene| {
        scene.sky.kind = SkyKind::Constant { radiance: Vec3::ONE };
        let positions = vec![Vec3::new(0.25, 0.5, 0.5), Vec3::new(1.5, 0.5, 0.5), Vec3::new(1.0, 0.25, 0.75)];
        let light_probes = Some(LightProbeGroup { positions });
        scene.entities.push(Entity { id: EntityId(500), light_probes, ..Entity::default() });
    });
    project
}

// ---- case 43

/// All arrays of the file: beside them it holds how long the bake took and on how many threads.
#[test]
fn one_two_or_sixteen_threads_bake_the_same_bytes() {
    let project = room();
    let baked_by = |threads: usize| {
        let settings = Settings { threads: Some(threads), force: true, ..settings(0.25, 256) };
        let baked = bake(project.path(), None, &settings, &Silent).expect("a bake");
        assert_eq!(baked.transport.certificate.threads, threads);
        assert!(baked.transport.certificate.rays_traced > 0 && baked.transport.certificate.holds());
        file::load(&baked.file).expect("a light file")
    };
    let one = baked_by(1);
    for threads in [2, 16] {
        let other = baked_by(threads);
        for ((name, bytes), (_, others)) in arrays(&one).iter().zip(arrays(&other)) {
            assert!(*bytes == others, "{name} on {threads} threads");
        }
        assert_eq!(other.certificate.transport_hash, one.certificate.transport_hash);
    }
}

// ---- case 58

#[test]
fn a_coin_on_a_ground_of_a_hundred_kilometres_is_baked_with_few_patches() {
    let side = 1e5;
    let ground = rectangle(Vec3::new(-0.5, 0.0, -0.5) * side, Vec3::Z * side, Vec3::X * side);
    let rim = |k: usize| {
        let (sin, cos) = (std::f32::consts::TAU * k as f32 / 12.0).sin_cos();
        Vec3::new(0.005 * cos, 0.1, -0.005 * sin)
    };
    let coin = vec![(0..12).map(rim).collect()];
    let project = surfaces::project(&[("ground", ground), ("coin", coin)]);
    paint(&project, |_, material| material.albedo.color = Vec3::splat(0.5));
    change(&project, |scene| scene.sky.kind = SkyKind::Constant { radiance: Vec3::ONE });
    // As the program chooses by itself.
    let chosen = Settings { quality: Some(Quality::Draft), rays: Some(64), ..Settings::default() };
    let planned = plan(project.path(), None, &chosen).expect("a plan");
    let light = Solved::of(&project, &chosen);
    let certificate = &light.transport.certificate;
    println!("{} patches of {:.0} m", certificate.patches, certificate.base_length);
    assert_eq!((planned.patches, planned.patch_length), (certificate.patches, certificate.base_length));
    // 1000 are aimed at; of a scene this large at most eight times as many, up to what rounding adds, and the coin.
    assert!((1000..=8000 + 80).contains(&certificate.patches), "{}", certificate.patches);
    let of = entities(&light.transport);
    let coins: Vec<usize> = (0..of.len()).filter(|&i| of[i] == 2).collect();
    // A regular dodecagon of 5 mm: 3 r^2. None of it is lost beside so large a ground.
    let area: f64 = coins.iter().map(|&i| light.area(i)).sum();
    assert!(coins.len() == 1 && (area / 7.5e-5 - 1.0).abs() < 1e-3, "{coins:?} {area}");
    let mut areas: Vec<f64> = (0..of.len()).filter(|&i| of[i] == 1).map(|i| light.area(i)).collect();
    areas.sort_by(f64::total_cmp);
    let natural = certificate.base_length.powi(2);
    assert!(areas[0] > 0.2 * natural && areas[areas.len() - 1] < 3.0 * natural, "{areas:?}");
    // All of it lies under one sky.
    for (i, b) in light.b().iter().enumerate() {
        let wanted = 0.5 * std::f64::consts::PI;
        assert!((b.x / wanted - 1.0).abs() < 1e-3, "patch {i}: {b}");
    }
}

// ---- case 59

#[test]
fn densities_that_are_no_numbers_are_taken_for_some_that_are() {
    for (scale, painted) in [
        (0.0, vec![]),
        (f32::INFINITY, vec![]),
        (f32::NAN, vec![]),
        (1.0, vec![0.0, f32::INFINITY, f32::NAN, -1.0]),
        (f32::MAX, vec![f32::MAX, f32::MIN_POSITIVE, -0.0, 1e-30]),
    ] {
        let floor = rectangle(Vec3::ZERO, Vec3::Z * 2.0, Vec3::X * 2.0);
        let project = surfaces::project(&[("floor", floor)]);
        change(&project, |scene| {
            let mesh = scene.entities[0].mesh.as_mut().expect("a mesh");
            (mesh.density.scale, mesh.density.painted) = (scale, painted.clone());
        });
        let transport = baked(&project, &settings(1.0, 16));
        let area: f64 = transport.patches.iter().map(|patch| f64::from(patch.area)).sum();
        println!("{scale} {painted:?}: {} patches", transport.patches.len());
        assert!((area - 4.0).abs() < 1e-5);
        // Between a sixteenth and sixteen times of the one of 1 m.
        assert!((1..=4 * 256 * 3 / 2).contains(&transport.patches.len()));
        assert!(transport.patches.iter().all(|patch| patch.area > 0.2 / 256.0), "no crumbs");
    }
}

// ---- case 60

#[test]
fn a_scene_with_nothing_that_stays_has_no_patches_and_is_drawn() {
    let moving = room();
    change(&moving, |scene| {
        scene.entities.iter_mut().for_each(|entity| entity.is_static = false);
        scene.sky.kind = SkyKind::Constant { radiance: Vec3::splat(0.5) };
    });
    let empty = TestProject::of(&Scene { sky: moving.scene().sky, ..Scene::default() });
    for project in [empty, moving] {
        let light = Solved::of(&project, &settings(0.25, 64));
        let certificate = &light.transport.certificate;
        assert_eq!((light.patches(), certificate.receivers, certificate.entries[0]), (0, 0, 0));
        assert_eq!((certificate.cavity_gain, certificate.lost, certificate.escaped), (1.0, 0.0, 0.0));
        let Some(gpu) = gpu() else { return };
        let eye = Eye::looking(DVec3::new(0.0, 50.0, 0.0), DVec3::new(0.0, 60.0, -1.0));
        let mut studio = Studio::new(gpu, light.transport.clone(), eye, [8, 8]);
        studio.assets = light.assets.clone();
        // Probes, where there are any, see the sky.
        for view in [View::Composite, View::Probes] {
            studio.settle(&light.scene, view);
            assert!(studio.radiance().iter().all(|radiance| radiance.is_finite()));
        }
        studio.settle(&light.scene, View::Composite);
        assert!(studio.radiance().iter().all(|radiance| (*radiance - 0.5).abs().max_element() < 1e-3));
    }
}

// ---- case 63

#[test]
fn damaged_bakes_are_refused_by_name_whatever_is_wrong_with_them() {
    let project = room();
    baked(&project, &settings(0.5, 64));
    let path = project.light_file();
    let whole = std::fs::read(&path).expect("a light file");
    let mut refused = 0;
    let mut refuse = |bytes: &[u8], what: &str, message: &str| {
        std::fs::write(&path, bytes).expect("a file");
        let error = file::load(&path).map(|_| ()).expect_err(what).to_string();
        assert!(error.contains("light.hohlraum") && error.contains(message), "{what}: {error}");
        let _ = file::load_certificate(&path); // it reads no more than it needs, and never panics
        refused += 1;
    };
    for n in 0..60 {
        let length = if n < 20 { n } else { (n - 19) * whole.len() / 42 };
        refuse(&whole[..length], &format!("cut off after {length}"), "");
    }
    for version in [0, VERSION + 1, u32::MAX] {
        let mut bytes = whole.clone();
        bytes[8..12].copy_from_slice(&version.to_le_bytes());
        refuse(&bytes, "another version", "version");
    }
    for n in 0..400 {
        let at = if n < 128 { n / 8 } else { (n * 104_729) % whole.len() };
        let mut bytes = whole.clone();
        bytes[at] ^= 1 << (n % 8);
        refuse(&bytes, &format!("bit {} of byte {at}", n % 8), "");
    }
    println!("{refused} damaged files of {} bytes refused", whole.len());
    let error = check(project.path(), None, &settings(0.5, 64)).map(|_| ()).expect_err("a refusal");
    assert!(error.to_string().contains("light.hohlraum"), "{error}");
    // And baked anew by the next who asks.
    let again = bake(project.path(), None, &settings(0.5, 64), &Silent).expect("a bake");
    assert!(!again.unchanged);
    file::load(&path).expect("a light file");
}

// ---- case 64

const ODD: [f64; 9] =
    [0.0, -1.0, 10.0, 1e9, -1e300, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MIN_POSITIVE];

#[test]
fn the_clock_neither_jumps_nor_goes_back_whatever_passes() {
    let mut clock = Clock::new(None);
    clock.advance(0.0);
    let mut last = clock.time();
    for passed in ODD.into_iter().chain([0.01; 3]).chain(ODD) {
        let counted = clock.advance(passed);
        let gone = clock.time() - last;
        assert!(
            (0.0..=0.25).contains(&counted) && (0.0..=0.25 + 1e-9).contains(&gone),
            "{passed}: {counted} {gone}"
        );
        last = clock.time();
    }
    let spin = Motion::Spin { axis: DVec3::Y, radians_per_second: 1e3 };
    let path = Motion::PingPong { points: vec![DVec3::ZERO, DVec3::X], seconds: 0.0, look: true };
    for seconds in ODD {
        for motion in [&spin, &path] {
            let at = moved(motion, &Transform::default(), None, seconds);
            assert!(
                at.is_finite() && at.translation.length() <= 1.0 + 1e-9,
                "{motion:?} after {seconds}: {at:?}"
            );
        }
    }
}

#[test]
fn light_that_stands_does_not_depend_on_the_time_between_pictures() {
    let light = Solved::of(&room(), &settings(0.5, 64));
    let drawn_at = |times: &[f64]| -> Option<(Vec<DVec3>, Vec<Vec3>)> {
        let eye = Eye::looking(DVec3::new(1.5, 0.5, 0.9), DVec3::new(0.0, 0.4, 0.0));
        let mut studio = Studio::new(gpu()?, light.transport.clone(), eye, [8, 8]);
        // The eye gets used to the light: what is left of a change is e^(-speed t), between 0 and 1.
        studio.eye.auto_exposure = Some(Default::default());
        for &time in times {
            studio.draw_at(&light.scene, View::Composite, time);
            let exposed = studio.renderer.exposed().expect("an exposure");
            assert!(exposed.exposure.is_finite() && exposed.exposure > 0.0, "at {time}: {exposed:?}");
        }
        Some((radiosity_on_gpu(&studio), studio.radiance()))
    };
    let Some((b, radiance)) = drawn_at(&[0.0, 0.1, 0.2, 0.3, 0.4, 0.5]) else { return };
    for times in [[0.0; 6], [5.0, 4.0, 3.0, 2.0, 1.0, 0.0], [0.0, 10.0, f64::NAN, f64::INFINITY, -1e9, 0.0]] {
        let (other, seen) = drawn_at(&times).expect("a GPU");
        assert_eq!(b, other, "{times:?}");
        // The picture itself is stored over a power of two that follows the exposure.
        let off = radiance.iter().zip(&seen).map(|(a, b)| (*a / *b - 1.0).abs().max_element());
        assert!(off.fold(0.0, f32::max) < 2e-3, "{times:?}");
    }
}
