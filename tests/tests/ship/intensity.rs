//! Sources whose brightness alone may change: a response each, at receivers and at light probes; too many of them, and
//! light is solved while the scene plays.

use engine::scene::shape::Shape;
use engine::scene::{Entity, ImageSource, LightProbeGroup, Sky, Transform};
use tests::room;

use super::*;

/// Light probes and a ball that reads them and casts no shadow.
fn with_a_reader(project: &TestProject) {
    enclosure::change(project, |scene| {
        let positions =
            vec![Vec3::splat(0.4), Vec3::new(1.6, 0.4, 0.5), Vec3::new(0.5, 0.4, 1.6), Vec3::splat(1.5)];
        let group = Some(LightProbeGroup { positions });
        let mut ball = Some(room::mesh(Shape::Sphere, 0));
        ball.iter_mut().for_each(|ball| ball.casts_shadows = false);
        let transform =
            Transform { translation: DVec3::ONE, scale: DVec3::splat(0.2), ..Transform::default() };
        scene.entities.extend([
            Entity { id: EntityId(200), name: "probes".into(), light_probes: group, ..Entity::default() },
            Entity { id: EntityId(201), name: "ball".into(), mesh: ball, transform, ..Entity::default() },
        ]);
    });
}

/// At receivers, and the coefficients of probes: of the responses as they are shipped, and solved anew.
fn both_ways(project: &TestProject, light: &Solved, full: &Transport) -> [[Vec<Vec3>; 2]; 2] {
    let scene = project.scene();
    let spread = light.combine(&light.scale(&scene));
    let at = |values: &[Vec3], i: usize| values.get(i).copied().unwrap_or(Vec3::ZERO);
    let [emitted, bounced] = &spread.probes;
    let probes = (0..full.probe_from_patch.len()).map(|i| at(emitted, i) + at(bounced, i)).collect();
    let (assets, _) = engine::scene::import::load_assets(project.path(), &scene).expect("assets");
    let truth = solved::Solved::with(scene, assets, full.clone());
    let gathered = |rows| gather(rows, &truth.radiosity).into_iter().map(|light| light.as_vec3()).collect();
    [[irradiance(&spread), gathered(&full.receiver_from_patch)], [probes, gathered(&full.probe_from_patch)]]
}

fn assert_follows(project: &TestProject, light: &Transport, full: &Transport) {
    let solved = light.solved.as_ref().expect("light that was solved");
    let [receivers, probes] = both_ways(project, solved, full);
    assert_same(&receivers[0], &receivers[1], 1e-5);
    if !probes[1].is_empty() {
        assert_same(&probes[0], &probes[1], 1e-5);
    }
    let (world, told) = warnings(project);
    assert!(told.is_empty() && world.transport.solved.is_some(), "{told:?}");
}

#[test]
fn light_probes_follow_each_source_that_is_dimmed() {
    let project = still_room();
    with_a_reader(&project);
    enclosure::change(&project, |scene| {
        lamp(scene).changes = Changes::Intensity;
        scene.materials[2].emission.color = Vec3::new(0.0, 0.1, 0.5);
        scene.materials[2].emission.changes = Changes::Intensity;
        scene.materials[4].emission.color = Vec3::new(0.3, 0.1, 0.1);
    });
    let full = baked(&project).transport;
    let light = shipped(&project);
    assert_eq!(light.solved.as_ref().map(|solved| solved.responses.len()), Some(3));
    assert_eq!((full.probes.len(), full.probe_from_patch.len()), (4, 36));
    for (on, intensity, strength) in [(true, 3.0, 1.0), (false, 3.0, 0.4), (true, 0.5, 0.0), (true, 9.0, 2.5)]
    {
        enclosure::change(&project, |scene| {
            (lamp(scene).on, lamp(scene).intensity) = (on, intensity);
            scene.materials[2].emission.strength = strength;
        });
        assert_follows(&project, &light, &full);
    }
}

/// A room without a ceiling under a sky whose brightness may change.
fn open_room(sky: SkyKind) -> TestProject {
    let mut walls = room(Vec3::ZERO, Vec3::splat(2.0));
    walls.retain(|wall| wall.name != "ceiling");
    let project = project_of(&walls);
    with_a_reader(&project);
    let picture = image::RgbImage::from_fn(32, 16, |x, y| {
        image::Rgb([(x * 8) as u8, (y * 16) as u8, ((x * 5 + y * 3) % 256) as u8])
    });
    picture.save(project.path().join("sky.png")).expect("a picture");
    enclosure::change(&project, |scene| {
        all_changes(scene, Changes::Never);
        scene.sky = Sky { kind: sky, changes: Changes::Intensity };
    });
    project
}

#[test]
fn a_gradient_that_is_dimmed_as_a_whole_is_one_response() {
    let [zenith, horizon, ground] =
        [Vec3::new(0.2, 0.4, 1.0), Vec3::new(0.9, 0.8, 0.7), Vec3::new(0.1, 0.2, 0.1)];
    let dimmed = |share: f32| SkyKind::Gradient {
        zenith: zenith * share,
        horizon: horizon * share,
        ground: ground * share,
        sun: None,
        sun_diameter: 0.01,
    };
    let project = open_room(dimmed(1.0));
    let full = baked(&project).transport;
    let light = shipped(&project);
    for share in [1.0, 0.25, 4.0] {
        enclosure::change(&project, |scene| scene.sky.kind = dimmed(share));
        assert_follows(&project, &light, &full);
    }
}

#[test]
fn a_picture_that_is_dimmed_is_one_response_even_from_darkness() {
    let image = ImageSource { file: "sky.png".into(), image: None };
    let dimmed = |strength| SkyKind::Picture { image: image.clone(), strength, turn: 0.7 };
    let project = open_room(dimmed(0.0));
    let full = baked(&project).transport;
    let light = shipped(&project);
    for strength in [0.3, 1.0, 20.0] {
        enclosure::change(&project, |scene| scene.sky.kind = dimmed(strength));
        assert_follows(&project, &light, &full);
    }
}

#[test]
fn many_lamps_that_are_dimmed_keep_the_matrix_and_its_file_small() {
    let project = still_room();
    enclosure::change(&project, |scene| {
        lamp(scene).changes = Changes::Intensity;
        let first = scene.entities.iter().find(|entity| entity.id == LAMP).expect("the lamp").clone();
        let more = (1..70).map(|k| {
            let mut lamp = Entity { id: EntityId(LAMP.0 + k), ..first.clone() };
            lamp.transform.translation.x = 0.3 + 0.02 * k as f64;
            lamp
        });
        scene.entities.extend(more);
    });
    let told = baked(&project).transport.certificate.needs.expect("needs");
    assert!(
        told.has(Feature::Matrix) && told.verdict(Feature::Matrix).why.contains("more than 64 responses")
    );
    let kept = shipped(&project);
    assert!(kept.solved.is_none() && !omitted(&kept).contains(&Feature::Matrix));
    let bytes = || std::fs::metadata(project.light_file()).expect("a file").len();
    let with_rows = bytes();
    // Whoever wants them has them.
    force(&project, &[(Feature::Matrix, Forced::Out)]);
    baked(&project);
    assert_eq!(shipped(&project).solved.map(|solved| solved.responses.len()), Some(70));
    println!("{with_rows} bytes with rows, {} with 70 responses", bytes());
}
