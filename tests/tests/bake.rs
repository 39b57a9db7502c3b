//! What a bake depends on and what not, what is left when it stops, and that no light comes where none can.

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use bake::{
    BakeError, Baked, Irradiance, Method, Point, Settings, Silent, Watcher, bake, plan, query_points,
};
use engine::scene::{LightKind, MaterialId, Scene, SkyKind};
use engine::transport::{Transport, file, materials, solve};
use glam::{DVec3, Vec3};
use tests::project::TestProject;
use tests::room::{light, walls};
use tests::surfaces::{self, Faces, face, quad, turned};

/// Few patches and rays: nothing here is about noise.
fn settings() -> Settings {
    Settings { rays: Some(256), patch_length: Some(0.25), ..Settings::default() }
}

fn baked(project: &TestProject) -> Baked {
    bake(project.path(), None, &settings(), &Silent).expect("a bake")
}

/// A closed unit cube with a lamp in it, under a sky that it does not see.
fn cube() -> TestProject {
    let names = ["-x", "+x", "-y", "+y", "-z", "+z"];
    let walls = walls(Vec3::ZERO, Vec3::ONE);
    let surfaces: Vec<(&str, Faces)> = names.into_iter().zip(walls.iter().map(face)).collect();
    let project = surfaces::project(&surfaces);
    let mut scene = project.scene();
    scene.sky.kind = SkyKind::Constant { radiance: Vec3::ONE };
    scene.entities.push(light(100, LightKind::Point, 1.0, DVec3::splat(0.5), DVec3::ZERO));
    project.save(&scene);
    project
}

fn change(project: &TestProject, change: impl FnOnce(&mut Scene)) {
    let mut scene = project.scene();
    change(&mut scene);
    project.save(&scene);
}

#[test]
fn threads_and_earlier_bakes_leave_no_trace_in_the_transport() {
    let project = cube();
    let hash = |threads: usize| {
        let settings = Settings { threads: Some(threads), ..settings() };
        let baked = bake(project.path(), None, &settings, &Silent).expect("a bake");
        assert!(!baked.unchanged && baked.transport.certificate.rays_traced > 0);
        let hash = baked.transport.hash();
        assert_eq!(hash.to_hex().as_str(), baked.transport.certificate.transport_hash);
        assert_eq!(file::load(&baked.file).expect("a light file").hash(), hash);
        std::fs::remove_dir_all(project.path().join("baked")).expect("a folder");
        hash
    };
    let one = hash(1);
    assert_eq!(hash(2), one);
    assert_eq!(hash(1), one);
}

#[test]
fn an_unchanged_scene_traces_no_ray() {
    let project = cube();
    let first = baked(&project);
    assert!(!first.unchanged);
    let bytes = std::fs::read(&first.file).expect("a light file");
    let second = baked(&project);
    assert!(second.unchanged);
    assert_eq!(second.transport.certificate.rays_traced, 0);
    assert!(std::fs::read(&first.file).expect("a light file") == bytes, "the file is as it was");
    let forced = bake(project.path(), None, &Settings { force: true, ..settings() }, &Silent);
    let forced = forced.expect("a bake").transport;
    assert!(forced.certificate.rays_traced > 0);
    assert_eq!(forced.hash(), first.transport.hash());
}

#[test]
fn light_and_colour_change_without_a_ray() {
    let project = cube();
    let first = baked(&project).transport;
    type Change = fn(&mut Scene);
    let changes: [(&str, Change); 8] = [
        ("a light's intensity", |scene| scene.entities[6].light.as_mut().unwrap().intensity = 7.0),
        ("a light's place", |scene| scene.entities[6].transform.translation.y = 0.9),
        ("a light gone", |scene| scene.entities.truncate(6)),
        ("a light more", |scene| {
            scene.entities.push(light(100, LightKind::Sun, 1.0, DVec3::splat(0.5), DVec3::ZERO));
        }),
        ("an albedo", |scene| scene.materials[2].albedo.color = Vec3::new(0.9, 0.0, 0.3)),
        ("an emission from nothing", |scene| scene.materials[3].emission.color = Vec3::ONE),
        ("an emission's colour", |scene| scene.materials[3].emission.color = Vec3::new(3.0, 2.0, 1.0)),
        ("the sky's radiance", |scene| scene.sky.kind = SkyKind::Constant { radiance: Vec3::X * 9.0 }),
    ];
    for (what, apply) in changes {
        change(&project, apply);
        let again = baked(&project);
        assert!(again.unchanged, "{what}");
        assert_eq!(again.transport.certificate.rays_traced, 0, "{what}");
        assert_eq!(again.transport.certificate.key, first.certificate.key, "{what}");
        assert_eq!(again.transport.hash(), first.hash(), "{what}");
    }
}

#[test]
fn another_order_of_the_hierarchy_is_no_other_bake() {
    let project = cube();
    let first = baked(&project).transport;
    change(&project, |scene| scene.entities.reverse());
    let again = baked(&project);
    assert!(again.unchanged && again.transport.hash() == first.hash());
    std::fs::remove_dir_all(project.path().join("baked")).expect("the bake is removed");
    let anew = baked(&project);
    assert!(!anew.unchanged);
    assert_eq!(anew.transport.hash(), first.hash());
}

#[test]
fn a_wall_that_moves_is_baked_anew() {
    let project = cube();
    let first = baked(&project).transport;
    change(&project, |scene| scene.entities[3].transform.translation.y = 0.5);
    let again = baked(&project);
    assert!(!again.unchanged);
    assert!(again.transport.certificate.rays_traced > 0);
    assert_ne!(again.transport.certificate.key, first.certificate.key);
    assert_ne!(again.transport.hash(), first.hash());
    change(&project, |scene| scene.entities[3].transform.translation.y = 0.0);
    assert_eq!(baked(&project).transport.hash(), first.hash(), "back again");
}

/// Cancels after some steps that traced rays.
struct Impatient {
    left: AtomicU64,
}

impl Watcher for Impatient {
    fn advance(&self, _: u64, rays: u64) {
        let some = |left: u64| (rays > 0).then(|| left.saturating_sub(1));
        let _ = self.left.fetch_update(Ordering::SeqCst, Ordering::SeqCst, some);
    }

    fn cancelled(&self) -> bool {
        self.left.load(Ordering::SeqCst) == 0
    }
}

#[test]
fn a_bake_that_is_cancelled_goes_on_where_it_stopped() {
    let whole = cube();
    let wanted = baked(&whole).transport;
    let patches = wanted.patches.len() as u64;
    assert!(patches >= 64, "{patches}");
    // Among the patches' rows, and among the receivers': two threads have finished 32 rows in one piece by then.
    let settings = Settings { threads: Some(2), ..settings() };
    for steps in [patches * 3 / 4, patches + 64] {
        let project = cube();
        let watcher = Impatient { left: AtomicU64::new(steps) };
        let stopped = bake(project.path(), None, &settings, &watcher);
        assert!(matches!(stopped, Err(BakeError::Cancelled)), "after {steps}");
        assert!(!project.light_file().exists());
        let planned = plan(project.path(), None, &settings).expect("a plan");
        assert!(planned.rays_kept <= planned.rays);
        let resumed = baked(&project).transport;
        let certificate = &resumed.certificate;
        println!("after {steps} rows: {} of {} rays traced", certificate.rays_traced, certificate.rays);
        assert!(0 < certificate.rays_traced && certificate.rays_traced < certificate.rays);
        assert_eq!(resumed.hash(), wanted.hash());
    }
}

/// 4 x 2 x 2 m, closed, floor, ceiling and long walls in one piece each; the wall at -x glows, and a lamp hangs in
/// the half below x = 2.
fn two_rooms(parts: Vec<(&'static str, Faces)>) -> TestProject {
    let names = ["glow", "+x", "floor", "ceiling", "-z", "+z"];
    let outer = walls(Vec3::ZERO, Vec3::new(4.0, 2.0, 2.0));
    let mut all: Vec<(&str, Faces)> = names.into_iter().zip(outer.iter().map(face)).collect();
    all.extend(parts);
    let project = surfaces::project(&all);
    change(&project, |scene| {
        let glow = scene.materials.iter_mut().find(|material| material.name == "glow");
        glow.expect("a material").emission.color = Vec3::splat(10.0);
        scene.entities.push(light(
            100,
            LightKind::Point,
            10.0,
            DVec3::new(1.0, 1.5, 1.0),
            DVec3::new(1.0, 0.0, 1.0),
        ));
    });
    project
}

/// Points on every surface of the rooms between these x, as close to the ends as a millimetre.
fn points(low: f64, high: f64) -> Vec<Point> {
    let along =
        |low: f64, high: f64| [0.001, 0.02, 0.3, 0.5, 0.7, 0.98, 0.999].map(|t| low + (high - low) * t);
    let mut points = Vec::new();
    for x in along(low, high) {
        for s in along(0.0, 2.0) {
            points.push((DVec3::new(x, 0.0, s), DVec3::Y));
            points.push((DVec3::new(x, 2.0, s), DVec3::NEG_Y));
            points.push((DVec3::new(x, s, 0.0), DVec3::Z));
            points.push((DVec3::new(x, s, 2.0), DVec3::NEG_Z));
        }
    }
    for y in along(0.0, 2.0) {
        for z in along(0.0, 2.0) {
            points.push((DVec3::new(low, y, z), DVec3::X));
            points.push((DVec3::new(high, y, z), DVec3::NEG_X));
        }
    }
    points.into_iter().map(|(position, normal)| Point { position, normal }).collect()
}

fn asked(project: &Path, points: &[Point], method: Method) -> Vec<Irradiance> {
    query_points(project, None, &settings(), points, method).expect("a query")
}

/// The room from x = `high` on gets nothing, exactly; the one up to `low` does.
fn assert_dark_beyond(project: &TestProject, low: f64, high: f64) {
    let transport = baked(project).transport;
    assert!(transport.certificate.holds(), "{:#?}", transport.certificate.statements());
    let origin = transport.origin;
    let is_beyond = |position: Vec3, normal: Vec3| {
        let x = position.x as f64 + origin.x;
        // Receivers lie on their surfaces; those of the dividing wall look along +x there.
        x > high + 1e-4 || (x > high - 1e-4 && normal.x > 0.5)
    };
    let light = irradiance_of_glow(project, &transport);
    let receivers: Vec<(usize, &engine::transport::Receiver)> =
        transport.receivers.iter().enumerate().filter(|(_, r)| is_beyond(r.position, r.normal)).collect();
    assert!(receivers.len() > 100, "{}", receivers.len());
    for (i, receiver) in receivers {
        assert_eq!(light[i], DVec3::ZERO, "at {}", receiver.position.as_dvec3() + origin);
    }
    for method in [Method::Receivers, Method::Gather] {
        let bright = points(0.0, low);
        for (point, found) in bright.iter().zip(asked(project.path(), &bright, method)) {
            let sum = found.direct + found.indirect;
            assert!(sum.min_element() > 0.0, "{method:?} {}: {sum}", point.position);
        }
        let dark = points(high, 4.0);
        for (point, found) in dark.iter().zip(asked(project.path(), &dark, method)) {
            assert_eq!(
                (found.direct, found.indirect),
                (DVec3::ZERO, DVec3::ZERO),
                "{method:?} {} facing {}",
                point.position,
                point.normal
            );
        }
    }
}

/// By receiver, from all that glows, with all that is reflected.
fn irradiance_of_glow(project: &TestProject, transport: &Transport) -> Vec<DVec3> {
    let scene = project.scene();
    let (assets, _) = engine::scene::import::load_assets(project.path(), &scene).expect("meshes");
    let materials = materials::of_patches(transport, &scene, &assets);
    let exitance: Vec<DVec3> = materials.exitance.iter().map(|m| m.as_dvec3()).collect();
    assert!(exitance.iter().any(|m| *m != DVec3::ZERO));
    let system = solve::System {
        rows: &transport.patch_from_patch,
        patches: &transport.patches,
        albedo: &materials.albedo,
    };
    solve::gather(&transport.receiver_from_patch, &solve::exact(&system, &exitance, 1e-10))
}

#[test]
fn no_light_passes_under_a_wall_that_stands_on_the_floor() {
    let (low, high) = (Vec3::new(1.95, 0.0, 0.0), Vec3::new(2.05, 2.0, 2.0));
    let wall: Faces = walls(low, high).iter().flat_map(|wall| turned(face(wall))).collect();
    assert_dark_beyond(&two_rooms(vec![("wall", wall)]), 1.95, 2.05);
}

#[test]
fn no_light_passes_a_wall_without_thickness() {
    let towards_b = quad(Vec3::X * 2.0, Vec3::Y * 2.0, Vec3::Z * 2.0);
    let walls = vec![("towards a", turned(towards_b.clone())), ("towards b", towards_b)];
    assert_dark_beyond(&two_rooms(walls), 2.0, 2.0);
}

/// Every wrong byte is found: the error names the file.
#[test]
fn damaged_light_files_are_refused_by_name() {
    let project = cube();
    let file = baked(&project).file;
    let whole = std::fs::read(&file).expect("a light file");
    let refused = |bytes: &[u8], what: &str| {
        std::fs::write(&file, bytes).expect("a file");
        let error = file::load(&file).map(|_| ()).expect_err(what).to_string();
        assert!(error.contains("light.hohlraum"), "{what}: {error}");
        let asked = query_points(project.path(), None, &settings(), &[], Method::Receivers);
        let error = asked.map(|_| ()).expect_err(what).to_string();
        assert!(error.contains("light.hohlraum"), "{what}: {error}");
        let _ = file::load_certificate(&file); // it reads no more than it needs, and never panics
    };
    for length in [0, 1, 7, 8, 12, 15, 16, 17, 40, 63, 64, 100, 1000, whole.len() / 2, whole.len() - 33] {
        refused(&whole[..length], &format!("cut off after {length}"));
    }
    refused(&whole[..whole.len() - 1], "one byte short");
    refused(&[whole.as_slice(), &[0]].concat(), "one byte long");
    for n in 0..48 {
        let at = if n < 24 { n } else { n * 7919 % whole.len() };
        let mut bytes = whole.clone();
        bytes[at] ^= 1 << (n % 8);
        refused(&bytes, &format!("bit {} of byte {at}", n % 8));
    }
    let again = baked(&project);
    assert!(!again.unchanged, "a damaged file is baked anew");
    assert_eq!(std::fs::read(&file).expect("a light file").len(), whole.len());
}

/// No patch is half under the panel: what is covered is dark, the rest is not darkened by it.
#[test]
fn a_panel_just_under_the_ceiling_cuts_it_along_its_outline() {
    let mut surfaces: Vec<(&str, Faces)> = ["-x", "+x", "-y", "ceiling", "-z", "+z"]
        .into_iter()
        .zip(walls(Vec3::ZERO, Vec3::ONE).iter().map(face))
        .collect();
    let corner = Vec3::new(0.3, 0.99, 0.35);
    surfaces.push(("panel", quad(corner, Vec3::X * 0.37, Vec3::Z * 0.33)));
    let project = surfaces::project(&surfaces);
    let transport = bake(project.path(), None, &settings(), &Silent).expect("a bake").transport;
    let entities = surfaces::entities(&transport);
    let (mut covered, mut ceiling) = (0.0, 0.0);
    for (i, patch) in transport.patches.iter().enumerate().filter(|&(i, _)| entities[i] == 4) {
        let triangles = patch.first_triangle..patch.first_triangle + patch.triangle_count;
        let under = |p: Vec3| {
            let p = p + transport.origin.as_vec3() - corner;
            p.x > 0.0 && p.x < 0.37 && p.z > 0.0 && p.z < 0.33
        };
        let middle = |t: u32| transport.surface.positions(t as usize).iter().sum::<Vec3>() / 3.0;
        let (inside, all) = (triangles.clone().filter(|&t| under(middle(t))).count(), triangles.len());
        assert!(inside == 0 || inside == all, "patch {i} is half under the panel");
        ceiling += f64::from(patch.area);
        covered += if inside == all { f64::from(patch.area) } else { 0.0 };
    }
    assert!((ceiling - 1.0).abs() < 1e-6 && (covered - 0.37 * 0.33).abs() < 1e-6, "{covered} of {ceiling}");
}

#[test]
fn a_bake_whose_certificate_does_not_hold_is_asked_by_force_alone() {
    let project = cube();
    let file = baked(&project).file;
    let mut broken = file::load(&file).expect("a light file");
    broken.certificate.row_sum_excess = 0.035;
    file::save(&file, &broken).expect("a light file");
    let ask = |force| {
        let settings = Settings { force, ..settings() };
        query_points(project.path(), None, &settings, &[], Method::Receivers).map(|_| ())
    };
    let refused = ask(false).expect_err("a refusal").to_string();
    assert!(refused.contains("row sums exceed their targets by 3.5e-2 (limit 0.0e0)"), "{refused}");
    ask(true).expect("an answer");
    // Its arrays are sound: what `check` finds in them is what holds.
    assert!(bake::check(project.path(), None, &settings()).expect("a certificate").holds());
}

#[test]
fn a_position_that_is_no_number_is_left_out_by_name() {
    let obj = "o floor\nv 0 0 0\nv 0 0 1\nv 1 0 1\nv 1 0 0\nf 1 2 3 4\n\
        o broken\nv nan 1 0\nv 0 1 1\nv 1 1 1\nf 5 6 7\nv 0 1 0\nf 8 7 6\n";
    let project = surfaces::from_obj(obj);
    let baked = baked(&project);
    let told = baked.warnings.iter().any(|warning| warning.to_string().contains("surfaces.obj"));
    assert!(told, "{:?}", baked.warnings);
    baked.transport.validate().expect("a sound transport");
    assert!(baked.transport.certificate.holds());

    // Nor may a place be none.
    let mut scene = project.scene();
    scene.entities[0].transform.translation.y = f64::NAN;
    let refused = scene.validate().map_err(|error| error.to_string()).expect_err("a refusal");
    assert!(refused.contains("floor"), "{refused}");
}

#[test]
fn a_scene_without_static_surfaces_has_no_patches() {
    let moving = cube();
    change(&moving, |scene| scene.entities.iter_mut().for_each(|entity| entity.is_static = false));
    for project in [TestProject::of(&Scene::default()), moving] {
        let baked = baked(&project);
        assert_eq!(baked.transport.patches.len(), 0);
        assert_eq!(baked.transport.certificate.rays, 0);
        assert!(baked.transport.certificate.holds(), "{:#?}", baked.transport.certificate.statements());
        file::load(&baked.file).expect("a light file");
        assert!(self::baked(&project).unchanged);
    }
}

#[test]
fn a_material_that_asks_to_be_sampled_is_part_of_the_bake() {
    let project = cube();
    let key = baked(&project).transport.certificate.key;
    change(&project, |scene| {
        let material = scene.materials.iter_mut().find(|material| material.id == MaterialId(3));
        material.expect("a material").emission.sampled = true;
    });
    let again = baked(&project);
    assert!(!again.unchanged);
    assert_ne!(again.transport.certificate.key, key);
}
