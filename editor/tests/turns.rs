//! Pictures that are drawn in turn by one renderer: a scene view and a game view beside each other.

use std::sync::Arc;

use engine::gpu::{Gpu, texture};
use engine::play::world::placed_at;
use engine::render::{Eye, Now, Renderer, Settings, View};
use engine::scene::assets::Assets;
use engine::scene::{AutoExposure, Scene, Sky, SkyKind};
use engine::transport::Transport;
use glam::{DVec3, Vec3};

fn sky(radiance: f32) -> Scene {
    let kind = SkyKind::Gradient {
        zenith: Vec3::splat(radiance),
        horizon: Vec3::splat(radiance),
        ground: Vec3::splat(radiance / 64.0),
        sun: None,
        sun_diameter: 0.01,
    };
    Scene { sky: Sky { kind, ..Sky::default() }, ..Scene::default() }
}

struct Shown {
    number: u32,
    display: wgpu::Texture,
    eye: Eye,
}

const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// Metered as it is drawn.
fn view(gpu: &Gpu, number: u32, size: [u32; 2], at: DVec3) -> Shown {
    let auto_exposure = Some(AutoExposure::default());
    let eye = Eye { auto_exposure, ..Eye::looking(DVec3::ZERO, at) };
    Shown { number, display: texture::target(gpu, "picture", size, 1, FORMAT), eye }
}

fn drawn(renderer: &mut Renderer, scene: &Scene, view: &Shown, time: f64) -> Vec<u8> {
    let assets = Assets::default();
    let world_from_local = placed_at(scene, &assets, 0.0);
    let (eye, world_from_local) = (view.eye, world_from_local.as_slice());
    let now = Now { scene, assets: &assets, world_from_local, time, eye, view: View::Composite };
    renderer.turn_to(view.number);
    renderer.draw(&now, &view.display).unwrap();
    texture::read(renderer.gpu(), &view.display, 4).unwrap()
}

#[test]
fn pictures_drawn_in_turn_are_those_that_are_drawn_alone_and_keep_their_targets() {
    let Ok(gpu) = Gpu::headless().map(Arc::new) else {
        println!("not run: no GPU adapter");
        return;
    };
    let scene = sky(40.0);
    let make = || {
        let settings = Settings { wait: true, ..Settings::default() };
        let transport = Arc::new(Transport::default());
        Renderer::new(gpu.clone(), transport, &Assets::default(), settings).unwrap()
    };
    // One looks at the bright sky, one at the dark ground: an eye that both shared would show neither right.
    let views = [
        view(&gpu, 0, [64, 48], DVec3::new(0.0, 0.8, -1.0)),
        view(&gpu, 1, [40, 32], DVec3::new(0.0, -0.8, -1.0)),
    ];
    let times = [0.0, 0.1, 0.2, 0.3];
    let alone: Vec<Vec<Vec<u8>>> = views
        .iter()
        .map(|view| {
            let mut renderer = make();
            times.iter().map(|time| drawn(&mut renderer, &scene, view, *time)).collect()
        })
        .collect();

    let mut renderer = make();
    let mut targets = [None, None];
    for (at, time) in times.iter().enumerate() {
        for (index, view) in views.iter().enumerate() {
            let picture = drawn(&mut renderer, &scene, view, *time);
            assert!(picture == alone[index][at], "picture {index} at {time} s");
            let target = renderer.targets().unwrap().radiance.clone();
            let kept = targets[index].get_or_insert(target.clone());
            assert!(*kept == target, "made anew for picture {index} at {time} s");
        }
    }
    assert!(
        alone.iter().flatten().all(|picture| picture.chunks(4).any(|texel| texel[0] > 40)),
        "something is seen"
    );
}
