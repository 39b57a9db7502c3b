use engine::render::{Eye, View};
use engine::scene::LightKind;
use glam::{DVec3, Vec3};
use tests::picture::{Studio, gpu};
use tests::room;

#[test]
fn look() {
    let Some(gpu) = gpu() else { return };
    println!("{}", gpu.name());
    let t0 = std::time::Instant::now();
    let transport = room::closed_box(Vec3::new(-1.0, 0.0, -1.0), Vec3::new(1.0, 2.0, 1.0), 8);
    println!("box {:?}", t0.elapsed());
    let mut scene = room::scene_of(&transport, |i| match i {
        0 => Vec3::new(0.8, 0.1, 0.1),
        1 => Vec3::new(0.1, 0.8, 0.1),
        _ => Vec3::splat(0.75),
    });
    scene.entities.push(room::light(100, LightKind::Point, 1.5, DVec3::new(0.2, 1.6, 0.1), DVec3::ZERO));
    let mut cube =
        engine::scene::Entity { id: engine::scene::EntityId(200), name: "cube".into(), ..Default::default() };
    cube.mesh = Some(room::mesh(engine::scene::shape::Shape::Cube, 4));
    cube.transform.translation = DVec3::new(-0.3, 0.3, -0.2);
    cube.transform.scale = DVec3::splat(0.5);
    cube.transform.rotation = glam::DQuat::from_rotation_y(0.5);
    scene.entities.push(cube);
    let eye = Eye::looking(DVec3::new(0.0, 1.0, 3.4), DVec3::new(0.0, 1.0, 0.0));
    let mut studio = Studio::with(
        gpu,
        transport,
        eye,
        [640, 480],
        engine::render::Settings {
            samples: std::env::var("S").ok().map(|s| s.parse().unwrap()),
            ..Default::default()
        },
    );
    for shape in [engine::scene::shape::Shape::Cube] {
        studio.assets.meshes.insert(
            engine::scene::MeshSource::Shape(shape),
            std::sync::Arc::new(engine::scene::shape::mesh(shape)),
        );
    }
    println!("made {:?}", t0.elapsed());
    for view in View::ALL {
        let t = std::time::Instant::now();
        let drawn = studio.draw(&scene, view);
        println!("{} {:?} {:?}", view.name(), drawn, t.elapsed());
        studio.save(std::path::Path::new(&format!("/tmp/look_{}.png", view.name())));
    }
    println!("{:?}", studio.renderer.timer.summary());
}
