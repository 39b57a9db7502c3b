//! Light in rooms, on the CPU and on the GPU: doors, holes, corridors, colours, brightness, albedo that is edited, and
//! scenes that stand far away.

use engine::gpu::buffer;
use engine::render::{Eye, Settings, View};
use engine::scene::{LightKind, Scene};
use engine::transport::Transport;
use engine::transport::solve::{Coarse, TwoLevel, cavity_gain, gather};
use glam::{DVec3, Vec3, Vec4};
use tests::picture::{Studio, gpu};
use tests::project::TestProject;
use tests::room::light;
use tests::solved::{
    Solved, WALLS, apart, block, change, exitance_on_gpu, largest, paint, radiosity_on_gpu, rectangle,
    settings, shell,
};
use tests::surfaces::{self, Faces, entities};

/// Looks into a room from inside it.
fn studio(transport: &Transport, at: DVec3) -> Option<Studio> {
    let eye = Eye::looking(at, at + DVec3::new(-0.3, -0.1, -0.2));
    let settings = Settings { samples: Some(1), ..Settings::default() };
    Some(Studio::with(gpu()?, transport.clone(), eye, [16, 16], settings))
}

// ---- cases 36 and 37

/// Of the wall between the rooms and of the opening in it.
const MIDDLE: f32 = 2.0;
const LOW: Vec3 = Vec3::ZERO;
const HIGH: Vec3 = Vec3::new(4.0, 2.0, 2.0);

/// Two rooms of 2 x 2 x 2 m with a wall without thickness between them, and in it a square opening of this side. The
/// wall at -x glows.
fn two_rooms(opening: f32) -> TestProject {
    let first = ["glow", "a +x", "a floor", "a ceiling", "a -z", "a +z"];
    let second = ["b -x", "b +x", "b floor", "b ceiling", "b -z", "b +z"];
    let mut all = shell(LOW, Vec3::new(MIDDLE, HIGH.y, HIGH.z), first);
    all.extend(shell(Vec3::new(MIDDLE, 0.0, 0.0), HIGH, second));
    let (low, high) = (1.0 - 0.5 * opening, 1.0 + 0.5 * opening);
    let part = |y: [f32; 2], z: [f32; 2], towards_b: bool| -> Faces {
        let corner = Vec3::new(MIDDLE, y[0], z[0]);
        let (up, along) = (Vec3::Y * (y[1] - y[0]), Vec3::Z * (z[1] - z[0]));
        if towards_b { rectangle(corner, up, along) } else { rectangle(corner, along, up) }
    };
    let with_hole = |towards_b: bool| -> Faces {
        let around = [
            ([0.0, low], [0.0, 2.0]),
            ([high, 2.0], [0.0, 2.0]),
            ([low, high], [0.0, low]),
            ([low, high], [high, 2.0]),
        ];
        around.into_iter().flat_map(|(y, z)| part(y, z, towards_b)).collect()
    };
    if opening > 0.0 {
        all[1].1 = with_hole(false);
        all[6].1 = with_hole(true);
    }
    let project = surfaces::project(&all);
    paint(&project, |name, material| {
        material.albedo.color = Vec3::splat(0.7);
        material.emission.color = Vec3::splat(if name == "glow" { 1.0 } else { 0.0 });
    });
    project
}

/// Of the room behind the wall.
fn is_dark(transport: &Transport) -> Vec<bool> {
    entities(transport).iter().map(|&entity| entity > 6).collect()
}

#[test]
fn behind_a_closed_door_it_is_dark_on_the_cpu_and_on_the_gpu() {
    let project = two_rooms(0.0);
    let light = Solved::of(&project, &settings(0.5, 512));
    let dark = is_dark(&light.transport);
    let mut components: Vec<[u32; 2]> = light
        .transport
        .patches
        .iter()
        .zip(&dark)
        .map(|(patch, &dark)| [u32::from(dark), patch.component])
        .collect();
    components.sort_unstable();
    components.dedup();
    assert_eq!(components.len(), 2, "one component a room: {components:?}");
    assert_ne!(components[0][1], components[1][1]);
    for (b, dark) in light.b().iter().zip(&dark) {
        assert_eq!(*b == DVec3::ZERO, *dark, "{b}");
    }
    let Some(mut studio) = studio(&light.transport, DVec3::new(3.0, 1.0, 1.0)) else { return };
    studio.settle(&light.scene, View::Composite);
    for (b, dark) in radiosity_on_gpu(&studio).iter().zip(&dark) {
        assert_eq!(*b == DVec3::ZERO, *dark, "{b}");
    }
    assert!(studio.radiance().iter().all(|radiance| *radiance == Vec3::ZERO));
    // Rows are not sorted by rooms: those of the dark one are multiplied with zeros, until the light is solved.
    assert_eq!(studio.draw(&light.scene, View::Composite).transport_dispatches, 0);
}

#[test]
fn through_a_hole_comes_some_light_and_no_more_than_the_hole_lets_in() {
    // From 0.1 % of the wall on; 4096 rays.
    for opening in [0.0625_f32, 0.25, 1.0] {
        let light = Solved::of(&two_rooms(opening), &settings(0.5, 4096));
        let dark = is_dark(&light.transport);
        let h = light.irradiance();
        let absorbed = |i: usize| h[i].x * (1.0 - f64::from(light.materials.albedo[i].x)) * light.area(i);
        let sum: f64 = (0..dark.len()).filter(|&i| dark[i]).map(absorbed).sum();
        let most = f64::from(opening).powi(2) * largest(light.b());
        println!("hole of {opening} m: {sum:.4} W of at most {most:.4} W absorbed behind it");
        assert!(0.0 < sum && sum <= most, "{opening}: {sum} of {most}");
    }
}

// ---- case 38

const STIFF: f32 = 0.99;

/// 20 x 1 x 1 m, white, one bright end.
fn corridor() -> Solved {
    let project = surfaces::project(&shell(Vec3::ZERO, Vec3::new(20.0, 1.0, 1.0), WALLS));
    paint(&project, |name, material| {
        material.albedo.color = Vec3::splat(STIFF);
        material.emission.color = Vec3::splat(if name == "-x" { 1.0 } else { 0.0 });
    });
    Solved::of(&project, &settings(0.5, 512))
}

/// E + rho P B.
fn product(light: &Solved, b: &[DVec3]) -> Vec<DVec3> {
    let gathered = gather(&light.transport.patch_from_patch, b);
    let next = |i: usize| light.exitance[i] + light.materials.albedo[i].as_dvec3() * gathered[i];
    (0..b.len()).map(next).collect()
}

/// Products until the largest error is a millionth of the largest B, from B = E.
fn products(light: &Solved, most: u32, step: &dyn Fn(&[DVec3]) -> Vec<DVec3>) -> u32 {
    let (mut b, scale) = (light.exitance.clone(), largest(light.b()));
    for done in 1..=most {
        b = step(&b);
        if apart(&b, light.b()) <= 1e-6 * scale {
            return done;
        }
    }
    panic!("{most} products do not do: {:e}", apart(&b, light.b()) / scale);
}

#[test]
fn a_white_corridor_is_solved_in_few_products_down_to_the_floor_of_rounding() {
    let light = corridor();
    let coarse = Coarse::new(&light.system());
    let gain = largest(&cavity_gain(&light.system()));
    println!("{} patches, {} aggregates, cavity gain {gain:.1}", light.patches(), coarse.m);
    assert!(coarse.m >= 8 && (gain / 100.0 - 1.0).abs() < 1e-3, "{gain}");

    let jacobi = products(&light, 5000, &|b| product(&light, b));
    let two_level = products(&light, 100, &|b| {
        let next = product(&light, b);
        // The correction is of the change: single precision does for it in each step.
        let change: Vec<DVec3> = next.iter().zip(b).map(|(next, b)| *next - *b).collect();
        let unit = largest(&change).max(f64::MIN_POSITIVE);
        let lifts = coarse.correction(&change.iter().map(|c| (*c / unit).as_vec3()).collect::<Vec<_>>());
        let lift = |i: usize| lifts.get(light.transport.patches[i].aggregate as usize).copied();
        let lifted = |i: usize| next[i] + lift(i).unwrap_or_default().as_dvec3() * unit;
        (0..b.len()).map(|i| lifted(i).max(light.exitance[i])).collect()
    });
    println!("to 1e-6 in {jacobi} products of Jacobi, {two_level} of two levels");
    assert!(jacobi > 1000 && two_level <= 45, "{jacobi} {two_level}");

    // Single precision, as the runtime has it: 4 eps w.
    let floor = 4.0 * f64::from(f32::EPSILON) * gain;
    let e: Vec<Vec3> = light.exitance.iter().map(|e| e.as_vec3()).collect();
    let (mut b, system) = (e.clone(), light.system());
    let twin = TwoLevel { system: &system, coarse: &coarse };
    for _ in 0..100 {
        twin.step(&e, &mut b);
    }
    let b: Vec<DVec3> = b.iter().map(|b| b.as_dvec3()).collect();
    let error = apart(&b, light.b()) / largest(light.b());
    println!("in single precision {error:.1e}, the floor is {floor:.1e}");
    assert!(error <= floor, "{error}");

    let Some(mut studio) = studio(&light.transport, DVec3::new(1.0, 0.5, 0.5)) else { return };
    let mut scene = light.scene.clone();
    scene.materials.iter_mut().for_each(|material| material.emission.strength = 1.0);
    let bright = scene.materials.iter().position(|material| material.name == "-x").expect("a material");
    // A light that changes in its last bit is solved on, beyond what is seen.
    for frame in 0..60 {
        scene.materials[bright].emission.strength = if frame % 2 == 0 { 1.0_f32.next_up() } else { 1.0 };
        studio.draw(&scene, View::Composite);
    }
    let error = apart(&radiosity_on_gpu(&studio), light.b()) / largest(light.b());
    println!("on the GPU {error:.1e}");
    assert!(error <= floor, "{error}");
}

// ---- case 41

#[test]
fn red_light_stays_red_on_coloured_walls() {
    let project = surfaces::project(&shell(Vec3::ZERO, Vec3::ONE, WALLS));
    let colors =
        [Vec3::X, Vec3::Y, Vec3::ONE, Vec3::new(0.1, 0.8, 0.3), Vec3::new(0.9, 0.5, 0.0), Vec3::splat(0.5)];
    paint(&project, |name, material| {
        let wall = WALLS.iter().position(|wall| *wall == name).expect("a wall");
        material.albedo.color = colors[wall];
        material.emission.color = if name == "+y" { Vec3::new(2.0, 0.0, 0.0) } else { Vec3::ZERO };
    });
    change(&project, |scene| {
        let mut lamp = light(100, LightKind::Point, 3.0, DVec3::splat(0.4), DVec3::ZERO);
        lamp.light.as_mut().expect("a light").color = Vec3::X;
        scene.entities.push(lamp);
    });
    let light = Solved::of(&project, &settings(0.25, 256));
    let only_red = |light: &[DVec3]| light.iter().all(|b| b.y == 0.0 && b.z == 0.0) && largest(light) > 1.0;
    assert!(only_red(light.b()) && only_red(&light.transport.irradiance_of_receivers(&light.radiosity)));
    let Some(mut studio) = studio(&light.transport, DVec3::splat(0.6)) else { return };
    studio.settle(&light.scene, View::Composite);
    assert!(only_red(&radiosity_on_gpu(&studio)));
    assert!(studio.radiance().iter().all(|radiance| radiance.y == 0.0 && radiance.z == 0.0));
}

// ---- cases 45 and 47

/// A room with a block in it, one wall glows; probes and something that moves.
fn furnished(glow: f32) -> TestProject {
    let mut surfaces = shell(Vec3::ZERO, Vec3::new(2.0, 1.5, 1.5), WALLS);
    surfaces.push(("block", block(Vec3::new(0.5, 0.0, 0.5), Vec3::new(1.0, 0.75, 1.0))));
    let project = surfaces::project(&surfaces);
    paint(&project, |name, material| {
        material.albedo.color = Vec3::new(0.7, 0.6, 0.5);
        material.emission.color = Vec3::splat(if name == "-x" { glow } else { 0.0 });
    });
    project
}

#[test]
fn light_that_half_floats_could_not_hold_is_drawn_as_it_is() {
    const GLOW: f32 = 1e7;
    let project = furnished(GLOW);
    change(&project, |scene| {
        let positions = vec![Vec3::new(0.25, 0.5, 0.25), Vec3::new(1.5, 1.0, 1.0)];
        let light_probes = Some(engine::scene::LightProbeGroup { positions });
        scene.entities.push(engine::scene::Entity {
            id: engine::scene::EntityId(500),
            light_probes,
            ..Default::default()
        });
    });
    let light = Solved::of(&project, &settings(0.5, 512));
    let Some(mut studio) = studio(&light.transport, DVec3::new(1.5, 1.0, 1.0)) else { return };
    studio.eye.exposure = -25.0;
    studio.settle(&light.scene, View::Probes);
    let error = apart(&radiosity_on_gpu(&studio), light.b()) / largest(light.b());
    println!("unit {}, error {error:.1e}", studio.renderer.light_unit());
    assert!(error <= 1e-3, "{error}");
    // Sums of nine bands, direct and bounced, of the same B.
    let wanted = gather(&light.transport.probe_from_patch, &radiosity_on_gpu(&studio));
    let spaces = studio.renderer.spaces();
    let sh = |source: usize| -> Vec<Vec4> {
        buffer::read(studio.renderer.gpu(), &spaces.probes[source]).expect("a buffer")
    };
    let (direct, bounced) = (sh(0), sh(1));
    assert!(direct.iter().chain(&bounced).all(|l| l.is_finite()));
    for probe in 0..2 {
        let found = (direct[probe * 9] + bounced[probe * 9]).truncate().as_dvec3();
        let wanted = wanted[probe * 9];
        assert!((found / wanted - 1.0).abs().max_element() <= 1e-3, "{found} {wanted}");
    }
    // The picture is stored in half floats, over a power of two.
    studio.draw(&light.scene, View::Composite);
    let radiance = studio.radiance();
    assert!(radiance.iter().all(|radiance| radiance.is_finite() && radiance.min_element() > 0.0));
    let brightest = radiance.iter().map(|radiance| f64::from(radiance.max_element())).fold(0.0, f64::max);
    assert!(brightest > 1e6, "{brightest}");
    assert!(studio.pixels().iter().any(|&byte| byte > 20));
}

#[test]
fn albedo_that_is_edited_to_nothing_and_to_everything_while_it_runs_is_followed() {
    let project = furnished(1.0);
    let light = Solved::of(&project, &settings(0.5, 512));
    let Some(mut studio) = studio(&light.transport, DVec3::new(1.5, 1.0, 1.0)) else { return };
    let mut scene = light.scene.clone();
    studio.settle(&scene, View::Composite);
    for albedo in [0.0, 1.0, 0.0, 0.3] {
        scene.materials.iter_mut().for_each(|material| material.albedo.color = Vec3::splat(albedo));
        let wanted = Solved::with(scene.clone(), light.assets.clone(), light.transport.clone());
        let scale = largest(wanted.b());
        for frame in 0..4 {
            let drawn = studio.draw(&scene, View::Composite);
            let (b, e) = (radiosity_on_gpu(&studio), exitance_on_gpu(&studio));
            assert!(b.iter().zip(&e).all(|(b, e)| b.is_finite() && b.cmpge(*e).all()), "albedo {albedo}");
            let error = apart(&b, wanted.b()) / largest(&b);
            // The gain that the bound is made of belongs to the new albedo from the first frame on.
            let bound = f64::from(drawn.bound.expect("a bound"));
            assert!(error <= bound * 1.001 + 1e-5, "albedo {albedo}, frame {frame}: {error} is over {bound}");
            assert!(albedo > 0.0 || b == e, "nothing reflects: B = E");
        }
        studio.settle(&scene, View::Composite);
        let error = apart(&radiosity_on_gpu(&studio), wanted.b()) / scale;
        // What the runtime stops at: a thousandth, or where single precision ends.
        let gain = largest(&cavity_gain(&wanted.system()));
        let bound = 1e-3_f64.max(4.0 * f64::from(f32::EPSILON) * gain);
        println!("albedo {albedo}: gain {gain:.1}, largest B {scale:.4}, error {error:.1e} of {bound:.1e}");
        assert!(error <= 1.001 * bound, "albedo {albedo}: {error}");
        assert!(studio.radiance().iter().all(|radiance| radiance.is_finite()));
    }
}

// ---- case 65

fn moved(project: &TestProject, offset: DVec3) -> TestProject {
    let copy = TestProject::copy_of(project.path());
    change(&copy, |scene| {
        scene.entities.iter_mut().for_each(|entity| entity.transform.translation += offset);
    });
    copy
}

/// B on the GPU after some frames, its bits.
fn after_frames(transport: &Transport, scene: &Scene, at: DVec3) -> Option<Vec<[u64; 3]>> {
    let mut studio = studio(transport, at)?;
    for _ in 0..6 {
        studio.draw(scene, View::Composite);
    }
    Some(radiosity_on_gpu(&studio).iter().map(|b| b.to_array().map(f64::to_bits)).collect())
}

/// The program does not move its origin while it runs: a bake keeps its own, to which all is relative. What has to hold
/// is that only differences from it count.
#[test]
fn a_scene_that_is_moved_with_its_lights_has_the_same_light_to_the_last_bit() {
    let project = furnished(1.0);
    change(&project, |scene| {
        scene.entities.push(light(100, LightKind::Point, 2.0, DVec3::new(1.5, 1.25, 0.75), DVec3::ZERO));
    });
    let settings = settings(0.5, 256);
    let here = Solved::of(&project, &settings);
    let at = DVec3::new(1.5, 1.0, 1.0);
    let on_gpu = after_frames(&here.transport, &here.scene, at);
    // Whole steps of the grid on which bakes put their origin.
    for offset in [DVec3::X * 4096.0, DVec3::new(-65536.0, 256.0, 2_097_152.0)] {
        let there = moved(&project, offset);
        let far = Solved::of(&there, &settings);
        assert_eq!(far.transport.origin - here.transport.origin, offset);
        assert_eq!(far.transport.patch_from_patch, here.transport.patch_from_patch, "{offset}");
        assert_eq!(far.transport.surface.vertices, here.transport.surface.vertices, "{offset}");
        assert_eq!(far.radiosity, here.radiosity, "{offset}");
        let Some(on_gpu) = &on_gpu else { continue };
        let there = after_frames(&far.transport, &far.scene, at + offset).expect("a GPU");
        assert!(there == *on_gpu, "{offset}");
    }
    // The same rows under another origin: nothing is baked anew.
    let mut transport = here.transport.clone();
    let offset = DVec3::new(512.0, 0.0, -1024.0);
    transport.origin += offset;
    let scene = moved(&project, offset).scene();
    let rebased = Solved::with(scene, here.assets.clone(), transport);
    assert_eq!(rebased.radiosity, here.radiosity);
}
