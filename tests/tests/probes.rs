//! Light probes of whole bakes: the light of one room stays out of the next, and passes through its door without a jump.

use bake::{Settings, Silent, bake};
use engine::scene::import::load_assets;
use engine::scene::{Entity, EntityId, LightProbeGroup};
use engine::transport::probe_field::{Cell, ProbeField, Weights};
use engine::transport::{Transport, file, materials, sh, solve};
use glam::{DVec3, Vec3};
use tests::project::TestProject;
use tests::room::walls;
use tests::surfaces::{self, Faces, face, turned};

/// Of the rooms, and of the wall between them.
const HIGH: Vec3 = Vec3::new(4.0, 2.0, 2.0);
const WALL: [f32; 2] = [1.95, 2.05];

fn probes() -> Vec<Vec3> {
    let mut positions = Vec::new();
    for x in [0.4, 1.0, 1.5, 2.6, 3.2, 3.6] {
        for y in [0.4, 1.0, 1.6] {
            positions.extend([0.4, 1.0, 1.6].map(|z| Vec3::new(x, y, z)));
        }
    }
    positions
}

/// Two rooms, the wall at -x glows; `parts` stand between them.
fn rooms(parts: &[[Vec3; 2]], probes: &[Vec3]) -> TestProject {
    let names = ["glow", "+x", "floor", "ceiling", "-z", "+z"];
    let outer = walls(Vec3::ZERO, HIGH);
    let mut all: Vec<(&str, Faces)> = names.into_iter().zip(outer.iter().map(face)).collect();
    let solid =
        |[low, high]: &[Vec3; 2]| walls(*low, *high).iter().flat_map(|wall| turned(face(wall))).collect();
    all.extend(["wall 1", "wall 2", "wall 3"].into_iter().zip(parts.iter().map(solid)));
    let project = surfaces::project(&all);
    let mut scene = project.scene();
    let glow = scene.materials.iter_mut().find(|material| material.name == "glow");
    glow.expect("a material").emission.color = Vec3::splat(10.0);
    let light_probes = Some(LightProbeGroup { positions: probes.to_vec() });
    scene.entities.push(Entity { id: EntityId(500), light_probes, ..Entity::default() });
    project.save(&scene);
    project
}

fn closed() -> Vec<[Vec3; 2]> {
    vec![[Vec3::new(WALL[0], 0.0, 0.0), Vec3::new(WALL[1], HIGH.y, HIGH.z)]]
}

/// A door in the middle, 0.6 m wide and 1.6 m high.
fn with_door() -> Vec<[Vec3; 2]> {
    let part = |y: [f32; 2], z: [f32; 2]| [Vec3::new(WALL[0], y[0], z[0]), Vec3::new(WALL[1], y[1], z[1])];
    vec![part([0.0, 2.0], [0.0, 0.7]), part([0.0, 2.0], [1.3, 2.0]), part([1.6, 2.0], [0.7, 1.3])]
}

/// The bake, and the mean radiance at each probe.
fn baked(project: &TestProject) -> (Transport, Vec<f32>) {
    let settings = Settings { rays: Some(256), patch_length: Some(0.25), ..Settings::default() };
    let baked = bake(project.path(), None, &settings, &Silent).expect("a bake");
    let transport = file::load(&baked.file).expect("a light file");
    assert_eq!(transport.depths, baked.transport.depths);
    let scene = project.scene();
    let (assets, _) = load_assets(project.path(), &scene).expect("meshes");
    let materials = materials::of_patches(&transport, &scene, &assets);
    let exitance: Vec<DVec3> = materials.exitance.iter().map(|m| m.as_dvec3()).collect();
    let system = solve::System {
        rows: &transport.patch_from_patch,
        patches: &transport.patches,
        albedo: &materials.albedo,
    };
    let mut radiosity = solve::exact(&system, &exitance, 1e-9);
    radiosity.resize(transport.columns(), DVec3::ZERO);
    let light = solve::gather(&transport.probe_from_patch, &radiosity);
    let mean = |probe: &[DVec3]| (probe[0].x * f64::from(sh::basis(Vec3::X)[0])) as f32;
    let light = light.chunks_exact(sh::COEFFICIENTS).map(mean).collect();
    (transport, light)
}

fn light_of(weights: &Weights, light: &[f32]) -> f32 {
    weights.probes.iter().zip(weights.weights).map(|(&probe, weight)| light[probe as usize] * weight).sum()
}

/// From x = `from` to `to`, close to all other walls too.
fn points(from: f32, to: f32) -> Vec<Vec3> {
    let along = |low: f32, high: f32| (0..=24).map(move |k| low + (high - low) * k as f32 / 24.0);
    along(from, to)
        .flat_map(|x| along(0.02, 1.98).flat_map(move |y| along(0.02, 1.98).map(move |z| Vec3::new(x, y, z))))
        .collect()
}

#[test]
fn the_light_of_one_room_stays_out_of_the_next() {
    let project = rooms(&closed(), &probes());
    let (transport, light) = baked(&project);
    assert!(!transport.depths.probes.is_empty());
    let field = ProbeField::new(&transport);
    let at = |point: Vec3| point - transport.origin.as_vec3();
    let mut cell = Cell::default();
    let mut light_at = |point: Vec3| light_of(&field.weights(at(point), &mut cell), &light);
    let lit = points(0.02, WALL[0] - 0.2).into_iter().map(&mut light_at).fold(f32::INFINITY, f32::min);
    let dark = points(WALL[1] + 0.2, 3.98).into_iter().map(&mut light_at).fold(0.0, f32::max);
    println!("lit room at least {lit}, dark room at most {dark}");
    assert!(lit > 1.0 && dark < 0.01 * lit, "lit room at least {lit}, dark room at most {dark}");
}

#[test]
fn light_through_a_door_does_not_jump() {
    let (transport, light) = baked(&rooms(&with_door(), &probes()));
    assert!(!transport.depths.probes.is_empty());
    let field = ProbeField::new(&transport);
    let brightest = light.iter().copied().fold(0.0, f32::max);
    for (from, to) in [
        (Vec3::new(0.5, 1.0, 1.0), Vec3::new(3.5, 1.0, 1.0)),
        (Vec3::new(0.3, 0.5, 0.4), Vec3::new(3.7, 1.2, 1.6)),
        (Vec3::new(2.3, 1.0, 0.1), Vec3::new(2.3, 1.0, 1.9)),
    ] {
        let largest = |steps: u32| {
            let mut cell = Cell::default();
            let mut light_at = |k: u32| {
                let point = from.lerp(to, k as f32 / steps as f32) - transport.origin.as_vec3();
                light_of(&field.weights(point, &mut cell), &light)
            };
            let mut last = light_at(0);
            let mut largest = 0.0_f32;
            for k in 1..=steps {
                let now = light_at(k);
                largest = largest.max((now - last).abs() / brightest);
                last = now;
            }
            largest
        };
        let [coarse, fine] = [3000, 12000].map(largest);
        println!("steps of a millimetre change {coarse}, quarters of one {fine}");
        assert!(coarse < 0.02 && fine < 0.3 * coarse, "{from} {to}: {coarse} {fine}");
    }
}

#[test]
fn a_probe_inside_a_wall_is_marked_and_changes_nothing() {
    let mut with_one = probes();
    with_one.push(Vec3::new(2.0, 1.0, 1.0));
    let (without, _) = baked(&rooms(&closed(), &probes()));
    let (with, _) = baked(&rooms(&closed(), &with_one));
    let valid: Vec<f32> = with.probes.iter().map(|probe| probe.valid).collect();
    assert_eq!(valid, [vec![1.0; with_one.len() - 1], vec![0.0]].concat());
    assert!(with.certificate.left_out.iter().any(|line| line == "1 light probes: they are inside solids"));
    let (a, b) = (ProbeField::new(&without), ProbeField::new(&with));
    for point in points(0.1, 3.9).into_iter().step_by(7) {
        let at = point - with.origin.as_vec3();
        assert_eq!(a.weights(at, &mut Cell::default()), b.weights(at, &mut Cell::default()), "{point}");
    }
}

#[test]
fn probes_that_see_each_other_keep_no_depths() {
    let (transport, _) = baked(&rooms(&[], &probes()));
    assert!(transport.depths.probes.is_empty());
    let told = transport.certificate.left_out.iter().any(|line| line.starts_with("depths of light probes"));
    assert!(told, "{:?}", transport.certificate.left_out);
}
