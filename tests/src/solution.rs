//! A scene through the whole pipeline: baked, its certificate checked, its file read again, solved on the CPU.

use std::f64::consts::PI;
use std::sync::Arc;

use bake::{Baked, Settings, Silent, bake};
use engine::scene::assets::Assets;
use engine::scene::file::load_project;
use engine::scene::import::load_assets;
use engine::scene::{Scene, Warning, world_from_local};
use engine::transport::direct::{irradiance_of_patches, placed_lights};
use engine::transport::solve::{self, System};
use engine::transport::{Occluders, Transport, file, materials, sky};
use glam::{DVec3, Vec3};

use crate::project::TestProject;

/// The light of a scene, by patch [W/m2].
pub struct Solved {
    pub transport: Arc<Transport>,
    pub scene: Scene,
    pub assets: Assets,
    pub warnings: Vec<Warning>,
    pub unlimited_gain: bool,
    /// As far as closed rooms can bear it.
    pub albedo: Vec<Vec3>,
    /// Emitted.
    pub m: Vec<DVec3>,
    /// Arrives from punctual lights, and from the sky.
    pub direct: Vec<DVec3>,
    pub from_sky: Vec<DVec3>,
    /// E = M + rho (H_dir + H_sky), B = E + rho P B.
    pub e: Vec<DVec3>,
    pub b: Vec<DVec3>,
}

/// Bakes what the project holds. The certificate holds.
pub fn baked(project: &TestProject, patch_length: f64, rays: u32) -> Baked {
    let settings = Settings { rays: Some(rays), patch_length: Some(patch_length), ..Settings::default() };
    let baked = bake(project.path(), None, &settings, &Silent).expect("a bake");
    let certificate = &baked.transport.certificate;
    assert!(certificate.holds(), "{:#?}", certificate.statements());
    baked
}

pub fn solved(project: &TestProject, patch_length: f64, rays: u32) -> Solved {
    let baked = baked(project, patch_length, rays);
    let transport = Arc::new(file::load(&baked.file).expect("a light file"));
    let scene = project.scene();
    let (assets, _) = load_assets(project.path(), &scene).expect("meshes");
    let unlimited = load_project(project.path()).expect("project.ron").bake.unlimited_gain;
    solve(transport, scene, assets, baked.warnings, unlimited)
}

fn solve(
    transport: Arc<Transport>,
    scene: Scene,
    assets: Assets,
    warnings: Vec<Warning>,
    unlimited_gain: bool,
) -> Solved {
    let mut materials = materials::of_patches(&transport, &scene, &assets);
    if !unlimited_gain {
        solve::limit_gain(&transport.patch_from_patch, &transport.patches, &mut materials.albedo);
    }
    let (albedo, m) = (materials.albedo, wide(&materials.exitance));
    let direct = from_lights(&transport, &scene);
    let from_sky = solve::gather(&transport.patch_from_patch, &columns(&transport, &scene, &assets, None));
    let e: Vec<DVec3> =
        (0..m.len()).map(|i| m[i] + albedo[i].as_dvec3() * (direct[i] + from_sky[i])).collect();
    let system = System { rows: &transport.patch_from_patch, patches: &transport.patches, albedo: &albedo };
    let b = solve::exact(&system, &e, 1e-12);
    Solved { albedo, m, direct, from_sky, e, b, transport, scene, assets, warnings, unlimited_gain }
}

/// Irradiance from punctual lights, with shadows.
pub fn from_lights(transport: &Transport, scene: &Scene) -> Vec<DVec3> {
    let occluders = Occluders::new(transport);
    let lights = placed_lights(scene, &world_from_local(scene), transport.origin);
    let visible = |from: Vec3, normal: Vec3, to: Vec3| occluders.free_from_surface(from, normal, to);
    wide(&irradiance_of_patches(transport, &lights, &visible))
}

/// Of patches (none: 0), then of the sky.
fn columns(
    transport: &Transport,
    scene: &Scene,
    assets: &Assets,
    of_patches: Option<&[DVec3]>,
) -> Vec<DVec3> {
    let mut values = vec![DVec3::ZERO; transport.columns()];
    if let Some(of_patches) = of_patches {
        values[..of_patches.len()].copy_from_slice(of_patches);
    }
    if transport.sky_patches > 0 {
        let sky = sky::radiance_of_patches(&scene.sky, assets);
        let behind = &mut values[transport.patches.len()..];
        behind.iter_mut().zip(sky).for_each(|(value, sky)| *value = sky.as_dvec3() * PI);
    }
    values
}

impl Solved {
    /// In other light and other colours: the same rows.
    pub fn again(&self, change: impl FnOnce(&mut Scene)) -> Self {
        let mut scene = self.scene.clone();
        change(&mut scene);
        let warnings = self.warnings.clone();
        solve(self.transport.clone(), scene, self.assets.clone(), warnings, self.unlimited_gain)
    }

    pub fn system(&self) -> System<'_> {
        let Transport { patch_from_patch: rows, patches, .. } = &*self.transport;
        System { rows, patches, albedo: &self.albedo }
    }

    /// All that arrives at patches: what they send each other by their rows, and from sky and lights.
    pub fn h(&self) -> Vec<DVec3> {
        let values = columns(&self.transport, &self.scene, &self.assets, Some(&self.b));
        let gathered = solve::gather(&self.transport.patch_from_patch, &values);
        gathered.iter().zip(&self.direct).map(|(gathered, direct)| *gathered + *direct).collect()
    }

    /// The same at receivers, without punctual lights.
    pub fn h_of_receivers(&self) -> Vec<DVec3> {
        self.transport.irradiance_of_receivers(&columns(
            &self.transport,
            &self.scene,
            &self.assets,
            Some(&self.b),
        ))
    }

    pub fn area(&self, patch: usize) -> f64 {
        f64::from(self.transport.patches[patch].area)
    }

    /// Int over all patches of a value in green.
    pub fn flux(&self, values: impl Fn(usize) -> f64) -> f64 {
        (0..self.b.len()).map(|i| self.area(i) * values(i)).sum()
    }

    /// Patches of the entity with this id.
    pub fn of_entity(&self, id: u64) -> Vec<usize> {
        let batches = &self.transport.surface.batches;
        let of = |i: &usize| batches[self.transport.patches[*i].batch as usize].entity().0 == id;
        (0..self.b.len()).filter(of).collect()
    }

    /// The area mean of a value over some patches.
    pub fn mean(&self, patches: &[usize], value: impl Fn(usize) -> f64) -> f64 {
        let area: f64 = patches.iter().map(|&i| self.area(i)).sum();
        patches.iter().map(|&i| self.area(i) * value(i)).sum::<f64>() / area
    }

    /// Largest cavity gain.
    pub fn gain(&self) -> f64 {
        largest(&solve::cavity_gain(&self.system()))
    }
}

pub fn wide(values: &[Vec3]) -> Vec<DVec3> {
    values.iter().map(|value| value.as_dvec3()).collect()
}

pub fn narrow(values: &[DVec3]) -> Vec<Vec3> {
    values.iter().map(|value| value.as_vec3()).collect()
}

/// NaN where one is.
pub fn largest(values: &[DVec3]) -> f64 {
    let most = |most: f64, value: f64| if value.is_nan() || value > most { value } else { most };
    values.iter().flat_map(|value| value.to_array()).map(f64::abs).fold(0.0, most)
}

/// The largest difference.
pub fn apart(a: &[DVec3], b: &[DVec3]) -> f64 {
    assert_eq!(a.len(), b.len());
    largest(&a.iter().zip(b).map(|(a, b)| *a - *b).collect::<Vec<_>>())
}
