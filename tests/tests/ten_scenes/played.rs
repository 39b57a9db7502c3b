//! A scene, baked and played as a user would: what lies in its file, on the GPU and in its frames.

use std::collections::BTreeMap;
use std::sync::Arc;

use bake::{Settings, Silent, bake};
use engine::gpu::{Gpu, texture};
use engine::play::World;
use engine::render::{self, Drawn, Now, Renderer, View};
use engine::scene::file::{load_project, save_project};
use engine::scene::{Feature, Forced, Scene};
use engine::transport::file;
use engine::transport::needs::Needs;
use glam::Vec3;
use tests::picture::radiance_of;
use tests::project::TestProject;
use tests::ten;

/// Of pictures.
const SIZE: [u32; 2] = [48, 32];
/// Seconds from frame to frame while things move.
const STEP: f64 = 0.05;
const MOVING: usize = 24;

pub struct Played {
    pub needs: Needs,
    /// Bytes by section of the file that the player loads.
    pub sections: BTreeMap<String, u64>,
    /// Bytes on the GPU by kind.
    pub bytes: BTreeMap<&'static str, u64>,
    /// By name; nobody asked for another view or pressed a key.
    pub pipelines: Vec<String>,
    /// The last of the frames in which time goes on.
    pub moving: Drawn,
    /// When time stands still and the light is solved.
    pub steady: Drawn,
    /// Faces captured once nothing changes any more, in ten frames.
    pub captures: u32,
    pub sky_patches: u32,
    pub picture: Vec<Vec3>,
}

impl Played {
    /// Of sections whose names begin so.
    pub fn section(&self, start: &str) -> u64 {
        self.sections.iter().filter(|(name, _)| name.starts_with(start)).map(|(_, bytes)| bytes).sum()
    }

    /// For whoever looks for what went wrong.
    pub fn told(&self) -> String {
        let Self { sections, bytes, pipelines, moving, steady, captures, sky_patches, .. } = self;
        format!(
            "{sections:?}\n{bytes:?}\n{pipelines:?}\n{moving:?}\n{steady:?}\n{captures} captures, {sky_patches} sky \
             patches"
        )
    }

    pub fn compiled(&self, word: &str) -> bool {
        self.pipelines.iter().any(|name| name.contains(word))
    }
}

pub fn project(scene: &Scene) -> TestProject {
    let project = TestProject::of(scene);
    let bumps = project.path().join(ten::BUMPS);
    std::fs::create_dir_all(bumps.parent().expect("a folder")).expect("a folder");
    ten::bumps().save(bumps).expect("a picture");
    project
}

/// Bakes what is stale, and plays. `forced`: what the author says.
pub fn play(gpu: &Arc<Gpu>, project: &TestProject, forced: &[(Feature, Forced)]) -> Played {
    let mut settings = load_project(project.path()).expect("a project");
    settings.features = forced.iter().copied().collect();
    save_project(project.path(), &settings).expect("a project");
    let with = Settings { rays: Some(256), patch_length: Some(0.5), ..Settings::default() };
    bake(project.path(), None, &with, &Silent).expect("a bake");
    let (mut world, warnings) = World::load(project.path(), None, false).expect("a world");
    assert!(warnings.is_empty(), "{warnings:?}");
    let with = render::Settings { samples: Some(1), wait: true, ..render::Settings::default() };
    let features = world.features.clone();
    let mut renderer = Renderer::asked(gpu.clone(), world.transport.clone(), &world.assets, with, features)
        .expect("pipelines");
    let display = texture::target(gpu, "display", SIZE, 1, wgpu::TextureFormat::Rgba8UnormSrgb);
    let mut draw = |world: &mut World, time: f64| {
        world.follow(time);
        let world_from_local = &world.placed_at(time);
        let eye = world.eye(world_from_local);
        let (scene, assets) = (&world.scene, &world.assets);
        renderer
            .draw(&Now { scene, assets, world_from_local, time, eye, view: View::Composite }, &display)
            .expect("a frame")
    };
    let moving = (0..MOVING).map(|frame| draw(&mut world, frame as f64 * STEP)).last().expect("frames");
    let time = MOVING as f64 * STEP;
    (0..200).find(|_| draw(&mut world, time).transport_dispatches == 0).expect("the light settles");
    // Sliced captures and what follows them.
    (0..12).for_each(|_| {
        draw(&mut world, time);
    });
    let still: Vec<Drawn> = (0..10).map(|_| draw(&mut world, time)).collect();
    Played {
        sections: file::sections(&file::path(project.path(), "main"))
            .expect("sections")
            .into_iter()
            .collect(),
        captures: still.iter().map(|drawn| drawn.captures).sum(),
        steady: still.last().expect("frames").clone(),
        moving,
        bytes: renderer.bytes().into_iter().collect(),
        pipelines: renderer.gpu().pipelines(),
        sky_patches: world.transport.sky_patches,
        picture: radiance_of(&renderer),
        needs: world.needs,
    }
}
