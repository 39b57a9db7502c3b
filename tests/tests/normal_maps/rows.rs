//! What the rows say.

use std::f64::consts::PI;

use bake::{Settings, plan};
use engine::scene::file::{Project, load_scene, save_project};
use engine::transport::bvh::{Bvh, Holes, patch_of};
use engine::transport::directional::{any_directional, tilted};
use engine::transport::{Occluders, Receiver, Transport, file};
use glam::{DVec3, Vec3};
use tests::bumps::{self, BEHIND, FLOOR, WALLS, bumps, paint, room, wear};
use tests::project::TestProject;
use tests::solved::{self as lit, Solved, baked};

fn settings() -> Settings {
    lit::settings(0.25, 256)
}

/// Every wall of the room wears bumps.
fn all_bumped() -> TestProject {
    let project = room();
    let map = paint(project.path(), "assets/bumps.png", 64, bumps);
    (0..WALLS.len()).for_each(|wall| drop(wear(&project, wall, map.clone())));
    project
}

/// Normals about another, up to 45 degrees from it and even by solid angle.
fn tilts(normal: Vec3, count: u32) -> impl Iterator<Item = DVec3> {
    let normal = normal.as_dvec3().normalize();
    let x = normal.any_orthonormal_vector();
    let y = normal.cross(x);
    (0..count).map(move |k| {
        let cosine = 1.0 - (f64::from(k) + 0.5) / f64::from(count) * (1.0 - (PI / 4.0).cos());
        let (sin, cos) = (f64::from(k) * 2.399_963).sin_cos();
        (x * cos + y * sin) * (1.0 - cosine * cosine).sqrt() + normal * cosine
    })
}

struct Solid;

impl Holes for Solid {
    fn passes(&self, _: u32, _: [f32; 2], _: f32) -> bool {
        false
    }
}

/// Irradiance for a tilted normal, by rays of its own: what lies under the surface's horizon is as bright as the mean
/// of what arrives, `own`; emitters are sampled point by point.
fn gathered(lit: &Solved, bvh: &Bvh, at: &Receiver, m: DVec3, own: DVec3) -> DVec3 {
    const RAYS: u32 = 4096;
    let surface = &lit.transport.surface;
    let b = |patch: u32| lit.radiosity[patch as usize];
    let emits = |patch: u32| lit.materials.exitance[patch as usize] != Vec3::ZERO;
    let x = m.any_orthonormal_vector();
    let y = m.cross(x);
    let mut sum = DVec3::ZERO;
    for ray in 0..RAYS {
        let fraction = |step: f64| (0.5 + f64::from(ray) * step).fract();
        let (u, v) = (fraction(0.754_877_666_246_7), fraction(0.569_840_290_998_1));
        let (sin, cos) = (2.0 * PI * v).sin_cos();
        let w = (x * cos + y * sin) * u.sqrt() + m * (1.0 - u).sqrt();
        if w.dot(at.normal.as_dvec3()) <= 0.0 {
            sum += own / f64::from(RAYS);
            continue;
        }
        let hit = bvh.closest(at.position, at.normal, w.as_vec3(), 0.5, &Solid);
        let patch = hit.and_then(|hit| patch_of(&hit, &surface.patches)).filter(|&patch| !emits(patch));
        sum += patch.map_or(DVec3::ZERO, b) / f64::from(RAYS);
    }
    for (triangle, &[patch, _]) in surface.patches.iter().enumerate().filter(|(_, of)| emits(of[0])) {
        sum += b(patch) * share_of(surface.positions(triangle), bvh, at, m);
    }
    sum
}

/// Of a triangle that emits, as a tilted normal sees it.
fn share_of([a, b, c]: [Vec3; 3], bvh: &Bvh, at: &Receiver, m: DVec3) -> f64 {
    const STEPS: u32 = 6;
    let cross = (b - a).cross(c - a);
    let points = (0..STEPS).flat_map(|i| (0..STEPS - i).flat_map(move |j| [(i, j, 1.0), (i, j, 2.0)]));
    let points = points.filter(|&(i, j, third)| third < 2.0 || i + j + 1 < STEPS);
    let share = |(i, j, third): (u32, u32, f32)| {
        let step = |k: u32| (k as f32 + third / 3.0) / STEPS as f32;
        let point = a + (b - a) * step(i) + (c - a) * step(j);
        let way = point - at.position;
        let (distance, facing) = (way.length(), -cross.normalize().dot(way));
        let seen = facing > 0.0 && at.normal.dot(way) > 0.0;
        if !seen || !bvh.visible(at.position, at.normal, point, 0.5, &Solid) {
            return 0.0;
        }
        f64::from(facing) * m.dot(way.as_dvec3()).max(0.0) / (PI * f64::from(distance).powi(4))
    };
    points.map(share).sum::<f64>() * 0.5 * f64::from(cross.length()) / f64::from(STEPS * STEPS)
}

/// Errors over the mean: root mean square and signed mean with directional terms, and root mean square without.
fn errors(lit: &Solved, step: usize) -> [f64; 3] {
    let occluders = Occluders::new(&lit.transport);
    let emitted: Vec<DVec3> = lit.materials.exitance.iter().map(|m| m.as_dvec3()).collect();
    let bounced: Vec<DVec3> = lit.radiosity.iter().zip(&emitted).map(|(b, m)| *b - *m).collect();
    let known = [emitted, bounced].map(|values| bumps::irradiance(&lit.transport, &values));
    let known: Vec<_> = known[0].iter().zip(&known[1]).collect();
    let (mut squares, mut biased, mut plain, mut mean, mut count) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (receiver, (emitted, bounced)) in lit.transport.receivers.iter().zip(known).step_by(step) {
        let (e, normal) = (emitted.0 + bounced.0, receiver.normal.as_dvec3());
        for m in tilts(receiver.normal, 6).filter(|_| receiver.valid > 0.5) {
            let truth = gathered(lit, occluders.bvh(), receiver, m, e).y;
            let told = [emitted, bounced].map(|&(e, v)| tilted(e, v, normal, m).y);
            let told = told[0] + told[1];
            squares += (told - truth).powi(2);
            biased += told - truth;
            plain += (e.y - truth).powi(2);
            mean += truth;
            count += 1.0;
        }
    }
    assert!(count > 300.0, "{count}");
    let mean = mean / count;
    [(squares / count).sqrt() / mean, biased / count / mean, (plain / count).sqrt() / mean]
}

fn holds(what: &str, [rms, bias, plain]: [f64; 3], limit: f64) {
    println!("{what}: rms {:.2} %, bias {:.2} %; without {:.2} %", 1e2 * rms, 1e2 * bias, 1e2 * plain);
    assert!(rms < limit, "{what}: rms {rms}");
    assert!(bias.abs() < 0.01, "{what}: bias {bias}");
    assert!(plain > 2.5 * rms, "{what}: without directional terms {plain}, with them {rms}");
}

#[test]
fn tilted_normals_in_the_cornell_box_get_what_gathers_of_their_own_find() {
    let cornell = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../projects/cornell");
    let project = TestProject::copy_of(&cornell);
    let mut scene = load_scene(project.path(), "cornell").unwrap();
    let map = paint(project.path(), "assets/bumps.png", 16, bumps);
    scene.materials.iter_mut().for_each(|material| material.normal_texture = Some(map.clone()));
    save_project(project.path(), &Project::default()).unwrap();
    project.save(&scene);
    let lit = Solved::of(&project, &lit::settings(0.06, 1024));
    holds("Cornell box, tilts up to 45 degrees", errors(&lit, 17), 0.02);
}

#[test]
fn tilted_normals_beside_a_lamp_get_what_gathers_of_their_own_find() {
    let lit = Solved::of(&all_bumped(), &lit::settings(0.125, 1024));
    holds("a lamp at the side, tilts up to 45 degrees", errors(&lit, 7), 0.06);
}

#[test]
fn in_a_furnace_every_tilt_gets_the_same() {
    let transport = baked(&all_bumped(), &settings());
    let known = bumps::irradiance(&transport, &vec![DVec3::ONE; transport.columns()]);
    let mut closed = 0;
    for (receiver, (e, v)) in transport.receivers.iter().zip(&known).filter(|(r, _)| r.valid > 0.5) {
        assert!(e.x <= 1.0);
        if e.x < 1.0 - 1e-6 {
            continue; // some of its rays were lost
        }
        closed += 1;
        for m in tilts(receiver.normal, 8) {
            let told = tilted(*e, *v, receiver.normal.as_dvec3(), m).x;
            assert!((told - 1.0).abs() < 1e-4, "{told}"); // weights have eleven bits
        }
    }
    assert!(closed > 200, "{closed} of {}", known.len());
}

#[test]
fn the_surfaces_own_normal_keeps_its_irradiance_to_the_last_digit() {
    let lit = Solved::of(&all_bumped(), &settings());
    let known = bumps::irradiance(&lit.transport, &lit.radiosity);
    for (receiver, (e, v)) in lit.transport.receivers.iter().zip(&known) {
        let normal = receiver.normal.as_dvec3().normalize();
        assert!((tilted(*e, *v, normal, normal) - *e).abs().max_element() <= 1e-9 * e.max_element());
    }
}

/// Where a receiver is, in bits, and its row.
type Placed = ([u32; 6], Vec<(u32, f32)>);

/// Receivers by place, with their rows of irradiance.
fn by_place(transport: &Transport) -> Vec<Placed> {
    let bits = |v: Vec3| v.to_array().map(f32::to_bits);
    let place = |r: &Receiver| {
        let ([a, b, c], [d, e, f]) = (bits(r.position), bits(r.normal));
        [a, b, c, d, e, f]
    };
    let rows = (0..transport.receivers.len()).map(|i| transport.receiver_from_patch.row(i).collect());
    let mut all: Vec<_> = transport.receivers.iter().map(place).zip(rows).collect();
    all.sort_by_key(|receiver| receiver.0);
    all
}

fn has_section(project: &TestProject) -> bool {
    let bytes = std::fs::read(project.light_file()).unwrap();
    bytes.windows(12).any(|word| word == b"directional.")
}

#[test]
fn a_scene_without_normal_maps_has_nothing_of_directional_terms() {
    let project = room();
    let plain = baked(&project, &settings());
    assert!(!any_directional(&project.scene()));
    assert!(plain.directional_from_patch.is_empty() && !has_section(&project));
    let told = |transport: &Transport| {
        transport.certificate.left_out.iter().any(|what| what.starts_with("directional rows"))
    };
    assert!(told(&plain));
    assert!(!plain.certificate.statements().iter().any(|statement| statement.what.contains("directional")));

    // The same room, one wall of it bumped.
    let map = paint(project.path(), "assets/bumps.png", 64, bumps);
    wear(&project, BEHIND, map);
    let before = plan(project.path(), None, &settings()).unwrap();
    let bumped = baked(&project, &settings());
    assert!(any_directional(&project.scene()) && has_section(&project) && !told(&bumped));
    assert!(bumped.certificate.statements().iter().any(|statement| statement.what.contains("directional")));
    let directional = bumped.directional_receivers();
    assert!(directional > 10 && directional < bumped.receivers.len() / 4, "{directional}");
    for batch in &bumped.surface.batches {
        assert_eq!(bumped.is_directional(batch), batch.material as usize == BEHIND);
    }
    let more = (directional as u64) * 256;
    assert_eq!((bumped.certificate.rays, before.rays), (plain.certificate.rays + more, before.rays));
    assert_eq!(before.rays, bumped.certificate.rays, "the plan knows of them");

    // All else is as it was.
    assert_eq!(by_place(&plain), by_place(&bumped));
    assert_eq!(plain.patch_from_patch, bumped.patch_from_patch);
}

#[test]
fn a_normal_map_makes_the_bake_stale_and_so_does_taking_it_off() {
    let project = room();
    let settings = settings();
    let first = baked(&project, &settings).certificate.key;
    let map = paint(project.path(), "assets/bumps.png", 64, bumps);
    wear(&project, FLOOR, map);
    let second = baked(&project, &settings);
    assert_ne!(first, second.certificate.key);
    assert!(second.directional_receivers() > 0);
    let mut scene = project.scene();
    scene.materials[FLOOR].normal_texture = None;
    project.save(&scene);
    let third = baked(&project, &settings);
    assert_eq!((third.directional_receivers(), third.certificate.key), (0, first));
}

#[test]
fn a_file_of_before_directional_terms_loads() {
    let project = all_bumped();
    let mut transport = baked(&project, &settings());
    // As such a file was: no section, and a certificate that says nothing of it.
    transport.directional_from_patch = Default::default();
    transport.certificate.directional_receivers = 0;
    transport.certificate.directional_entries = 0;
    file::save(&project.light_file(), &transport).unwrap();
    assert!(!has_section(&project));
    let loaded = file::load(&project.light_file()).unwrap();
    assert_eq!((loaded.directional_receivers(), loaded.hash()), (0, transport.hash()));
    assert!(loaded.surface.batches.iter().all(|batch| !loaded.is_directional(batch)));
}

#[test]
fn terms_that_no_light_can_make_are_refused() {
    let project = all_bumped();
    let transport = baked(&project, &settings());
    let refused = |change: fn(&mut Transport)| {
        let mut broken = transport.clone();
        change(&mut broken);
        broken.validate().unwrap_err()
    };
    assert!(refused(|t| t.directional_from_patch.weights[5] = 3.0).contains("directional term"));
    assert!(refused(|t| t.directional_from_patch.weights[5] = f32::NAN).contains("directional"));
    assert!(refused(|t| t.directional_from_patch.columns[5] = 1 << 20).contains("directional rows"));
    assert!(refused(|t| t.receivers.truncate(1)).contains("exist"));
}
