//! A scene by itself, drawn small by the engine's renderer, in light of its own: two suns from the front, a third from behind,
//! a grey sky.

use std::sync::Arc;

use eframe::{egui::ColorImage, wgpu};
use engine::gpu::{Gpu, texture};
use engine::play::world::placed_at;
use engine::render::{Eye, Now, RenderError, Renderer, Settings, View};
use engine::scene::assets::{Assets, Picture};
use engine::scene::import::load_assets;
use engine::scene::shape::Shape;
use engine::scene::{
    Entity, EntityId, ImageSource, Light, LightKind, Material, MeshRenderer, MeshSource, Projection, Scene,
    Sky, SkyKind, Texture, Transform,
};
use engine::transport::Transport;
use glam::{DAffine3, DQuat, DVec3, Vec3};

use super::SIDE;

pub struct Painter {
    gpu: Arc<Gpu>,
    renderer: Renderer,
    target: wgpu::Texture,
    /// A sphere with tangents.
    sphere: Assets,
}

impl Painter {
    pub fn new(gpu: Arc<Gpu>) -> Result<Self, RenderError> {
        let transport = Arc::new(Transport::default());
        let settings = Settings { wait: true, ..Settings::default() };
        let renderer = Renderer::new(gpu.clone(), transport, &Assets::default(), settings)?;
        let format = wgpu::TextureFormat::Rgba8Unorm;
        let target = texture::target(&gpu, "thumbnail", [SIDE, SIDE], 1, format);
        Ok(Self { gpu, renderer, target, sphere: sphere() })
    }

    /// All of a model.
    pub fn model(&mut self, scene: &Scene, assets: &Assets) -> Result<ColorImage, RenderError> {
        self.scene(scene.clone(), assets, 0.78)
    }

    /// A ball of it.
    pub fn material(
        &mut self,
        material: &Material,
        images: Vec<(ImageSource, Arc<Picture>)>,
    ) -> Result<ColorImage, RenderError> {
        let mut assets = self.sphere.clone();
        assets.images.extend(images);
        self.scene(ball(material.clone()), &assets, 0.56)
    }

    /// `reach`: of the box's half diagonal, that much has to be in the picture.
    fn scene(&mut self, mut scene: Scene, assets: &Assets, reach: f64) -> Result<ColorImage, RenderError> {
        light(&mut scene);
        let world_from_local = placed_at(&scene, assets, 0.0);
        let eye = eye(&scene, &world_from_local, assets, reach);
        let now = Now {
            scene: &scene,
            assets,
            world_from_local: &world_from_local,
            time: 0.0,
            eye,
            view: View::Composite,
        };
        self.renderer.draw(&now, &self.target)?;
        let bytes = texture::read(&self.gpu, &self.target, 4)?;
        self.renderer.forget();
        Ok(ColorImage::from_rgba_unmultiplied([SIDE as usize; 2], &bytes))
    }
}

/// A normal map, though it is of nothing, makes the reader give the sphere tangents.
fn sphere() -> Assets {
    let nowhere = Texture::new(ImageSource { file: String::new(), image: None });
    let bumped = Material { normal_texture: Some(nowhere), ..Material::default() };
    load_assets(std::path::Path::new(""), &ball(bumped)).map(|(assets, _)| assets).unwrap_or_default()
}

fn ball(material: Material) -> Scene {
    let renderer = MeshRenderer {
        mesh: MeshSource::Shape(Shape::Sphere),
        materials: vec![material.id],
        casts_shadows: false,
        density: Default::default(),
        reflection: Default::default(),
    };
    let ball = Entity { id: EntityId(1), mesh: Some(renderer), ..Entity::default() };
    Scene { materials: vec![material], entities: vec![ball], ..Scene::default() }
}

/// Its own lamps may be dim, or none: every thumbnail is lit alike.
fn light(scene: &mut Scene) {
    let sky = SkyKind::Gradient {
        zenith: Vec3::splat(0.32),
        horizon: Vec3::splat(0.16),
        ground: Vec3::splat(0.06),
        sun: None,
        sun_diameter: 0.009,
    };
    scene.sky = Sky { kind: sky, ..Sky::default() };
    scene.entities.iter_mut().for_each(|entity| entity.light = None);
    let id = scene.free_entity_id().0;
    let suns = [([-0.5, -0.9, -0.7], 2.3), ([0.9, -0.2, -0.6], 0.9), ([0.1, -0.3, 1.0], 0.8)];
    for (number, (way, intensity)) in suns.into_iter().enumerate() {
        let rotation = DQuat::from_rotation_arc(DVec3::NEG_Z, DVec3::from(way).normalize());
        let light = Light { kind: LightKind::Sun, intensity, casts_shadows: false, ..Light::default() };
        scene.entities.push(Entity {
            id: EntityId(id + number as u64),
            transform: Transform { rotation, ..Transform::default() },
            light: Some(light),
            ..Entity::default()
        });
    }
}

/// From in front and above, so that all of it is seen.
fn eye(scene: &Scene, world_from_local: &[DAffine3], assets: &Assets, reach: f64) -> Eye {
    const FOV: f32 = 0.5;
    let mut corners = scene.entities.iter().zip(world_from_local).flat_map(|(entity, world)| {
        let mesh = entity.mesh.as_ref().and_then(|renderer| assets.meshes.get(&renderer.mesh));
        mesh.into_iter()
            .flat_map(|mesh| mesh.positions.iter().map(|at| world.transform_point3(at.as_dvec3())))
    });
    let first = corners.next().unwrap_or_default();
    let (low, high) = corners.fold((first, first), |(low, high), at| (low.min(at), high.max(at)));
    let (middle, radius) = ((low + high) * 0.5, ((high - low).length() * 0.5).max(1e-6));
    let away = radius * reach / f64::from(FOV * 0.5).sin() + radius * (1.0 - reach).max(0.0);
    let way = DVec3::new(0.6, 0.5, 1.0).normalize();
    let mut eye = Eye::looking(middle + way * away.max(radius * 1.05), middle);
    eye.projection = Projection::Perspective { fov_y: FOV };
    eye.near = (radius * 0.01) as f32;
    eye
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ball_has_its_materials_color_and_a_model_fills_its_picture() {
        let Ok(gpu) = Gpu::headless() else { return println!("not run: no GPU adapter") };
        let mut painter = Painter::new(Arc::new(gpu)).unwrap();
        let pixel = |image: &ColorImage, x: usize, y: usize| image.pixels[y * SIDE as usize + x].to_array();
        for part in [0, 2] {
            let mut material = Material::default();
            material.albedo.color = Vec3::AXES[part];
            let image = painter.material(&material, Vec::new()).unwrap();
            let middle = pixel(&image, SIDE as usize / 2, SIDE as usize / 2);
            let other = if part == 0 { 2 } else { 0 };
            assert!(middle[part] > 90 && middle[other] < middle[part] / 2, "{middle:?}");
        }
        let mut bright = Material::default();
        (bright.unlit, bright.albedo.color) = (true, Vec3::X);
        let image = painter.material(&bright, Vec::new()).unwrap();
        let red = image.pixels.iter().filter(|pixel| pixel.r() > 200 && pixel.g() < 60).count();
        let share = red as f64 / image.pixels.len() as f64;
        assert!(
            (0.4..0.79).contains(&share),
            "the ball is as large as the picture allows, and all in it: {share}"
        );
        let edge = (0..SIDE as usize).flat_map(|at| [pixel(&image, at, 0), pixel(&image, 0, at)]);
        assert!(edge.into_iter().all(|pixel| pixel[0] < 200), "nothing is cut off");
    }
}
