//! The whole pipeline on the CPU: a project in, a bake whose certificate holds, and out comes the light.

use bake::{Settings, Silent, bake};
use engine::gpu::buffer;
use engine::scene::assets::Assets;
use engine::scene::import::load_assets;
use engine::scene::{Material, Scene, world_from_local};
use engine::transport::materials::{PatchMaterials, of_patches};
use engine::transport::solve::{System, exact, gather, limit_gain};
use engine::transport::{Occluders, Transport, direct, file, sky};
use glam::{DVec3, Vec3, Vec4};

use crate::picture::Studio;
use crate::project::TestProject;
use crate::room::{Rectangle, walls};
use crate::surfaces::{Faces, face, turned};

/// Patches of this length [m], so many rays a row.
pub fn settings(length: f64, rays: u32) -> Settings {
    Settings { rays: Some(rays), patch_length: Some(length), ..Settings::default() }
}

/// Read back from its file; its certificate holds.
pub fn baked(project: &TestProject, settings: &Settings) -> Transport {
    let baked = bake(project.path(), None, settings, &Silent).expect("a bake");
    let transport = file::load(&baked.file).expect("a light file");
    let certificate = &transport.certificate;
    assert!(certificate.holds(), "{:#?}", certificate.statements());
    transport
}

/// A scene with its bake and its light. By column (patches, then the sky's) or by patch, W/m2.
pub struct Solved {
    pub scene: Scene,
    pub assets: Assets,
    pub transport: Transport,
    pub materials: PatchMaterials,
    /// Irradiance from punctual lights and the sky.
    pub received: Vec<DVec3>,
    /// E = M + rho times what is received.
    pub exitance: Vec<DVec3>,
    /// By column.
    pub radiosity: Vec<DVec3>,
}

impl Solved {
    pub fn of(project: &TestProject, settings: &Settings) -> Self {
        let transport = baked(project, settings);
        let scene = project.scene();
        let (assets, _) = load_assets(project.path(), &scene).expect("assets");
        Self::with(scene, assets, transport)
    }

    /// Of a bake that is there.
    pub fn with(scene: Scene, assets: Assets, transport: Transport) -> Self {
        let mut materials = of_patches(&transport, &scene, &assets);
        limit_gain(&transport.patch_from_patch, &transport.patches, &mut materials.albedo);
        let n = transport.patches.len();
        let mut radiosity = vec![DVec3::ZERO; transport.columns()];
        if transport.sky_patches > 0 {
            let radiance = sky::radiance_of_patches(&scene.sky, &assets);
            let light = radiance.iter().map(|radiance| radiance.as_dvec3() * std::f64::consts::PI);
            radiosity[n..].iter_mut().zip(light).for_each(|(column, light)| *column = light);
        }
        let from_sky = gather(&transport.patch_from_patch, &radiosity);
        let from_lights = from_lights(&scene, &transport);
        let received: Vec<DVec3> =
            from_sky.iter().zip(&from_lights).map(|(sky, lights)| *sky + lights.as_dvec3()).collect();
        let e = |i: usize| materials.exitance[i].as_dvec3() + materials.albedo[i].as_dvec3() * received[i];
        let exitance: Vec<DVec3> = (0..n).map(e).collect();
        let b = exact(&system(&transport, &materials.albedo), &exitance, 1e-10);
        radiosity[..n].copy_from_slice(&b);
        Self { scene, assets, transport, materials, received, exitance, radiosity }
    }

    pub fn patches(&self) -> usize {
        self.transport.patches.len()
    }

    pub fn system(&self) -> System<'_> {
        system(&self.transport, &self.materials.albedo)
    }

    /// B of patches alone.
    pub fn b(&self) -> &[DVec3] {
        &self.radiosity[..self.patches()]
    }

    pub fn area(&self, patch: usize) -> f64 {
        f64::from(self.transport.patches[patch].area)
    }

    /// H = what is received and what arrives from other patches.
    pub fn irradiance(&self) -> Vec<DVec3> {
        let mut only_patches = self.radiosity.clone();
        only_patches[self.patches()..].fill(DVec3::ZERO);
        let gathered = gather(&self.transport.patch_from_patch, &only_patches);
        gathered.iter().zip(&self.received).map(|(gathered, received)| *gathered + *received).collect()
    }

    /// Area mean of B over the patches of an entity.
    pub fn mean_of(&self, entity: u64) -> DVec3 {
        let of = crate::surfaces::entities(&self.transport);
        let (mut flux, mut area) = (DVec3::ZERO, 0.0);
        for i in (0..self.patches()).filter(|&i| of[i] == entity) {
            flux += self.b()[i] * self.area(i);
            area += self.area(i);
        }
        flux / area
    }

    /// By channel: what is absorbed, lost or leaves, and what is given, in watts.
    pub fn balance(&self) -> [DVec3; 2] {
        let n = self.patches();
        let h = self.irradiance();
        let (mut gone, mut given) = (DVec3::ZERO, DVec3::ZERO);
        for (i, h) in h.iter().enumerate() {
            let row = self.transport.patch_from_patch.row(i);
            let kept: f64 = row.filter(|&(j, _)| (j as usize) < n).map(|(_, share)| f64::from(share)).sum();
            let absorbed = (1.0 - self.materials.albedo[i].as_dvec3()) * *h;
            gone += (absorbed + self.b()[i] * (1.0 - kept)) * self.area(i);
            given += (self.materials.exitance[i].as_dvec3() + self.received[i]) * self.area(i);
        }
        [gone, given]
    }
}

fn from_lights(scene: &Scene, transport: &Transport) -> Vec<Vec3> {
    let lights = direct::placed_lights(scene, &world_from_local(scene), transport.origin);
    let occluders = Occluders::new(transport);
    let free = |from, normal, to| occluders.free_from_surface(from, normal, to);
    direct::irradiance_of_patches(transport, &lights, &free)
}

pub fn system<'a>(transport: &'a Transport, albedo: &'a [Vec3]) -> System<'a> {
    System { rows: &transport.patch_from_patch, patches: &transport.patches, albedo }
}

pub fn largest(values: &[DVec3]) -> f64 {
    values.iter().map(|value| value.abs().max_element()).fold(0.0, f64::max)
}

pub fn apart(a: &[DVec3], b: &[DVec3]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f64::max)
}

// ---- rooms

/// Six walls that face the inside, by these names: -x +x -y +y -z +z.
pub fn shell(low: Vec3, high: Vec3, names: [&str; 6]) -> Vec<(&str, Faces)> {
    names.into_iter().zip(walls(low, high).iter().map(face)).collect()
}

pub const WALLS: [&str; 6] = ["-x", "+x", "-y", "+y", "-z", "+z"];

/// A solid that faces the outside.
pub fn block(low: Vec3, high: Vec3) -> Faces {
    walls(low, high).iter().flat_map(|wall| turned(face(wall))).collect()
}

pub fn rectangle(corner: Vec3, first: Vec3, second: Vec3) -> Faces {
    face(&Rectangle { corner, edges: [first, second] })
}

/// Changes the scene on disk.
pub fn change(project: &TestProject, change: impl FnOnce(&mut Scene)) {
    let mut scene = project.scene();
    change(&mut scene);
    project.save(&scene);
}

/// Changes the material of every surface, by its name.
pub fn paint(project: &TestProject, mut paint: impl FnMut(&str, &mut Material)) {
    change(project, |scene| {
        for material in &mut scene.materials {
            let name = material.name.clone();
            paint(&name, material);
        }
    });
}

// ---- the same light on the GPU

/// B by patch [W/m2].
pub fn radiosity_on_gpu(studio: &Studio) -> Vec<DVec3> {
    read(studio, &studio.renderer.spaces().radiosity)
}

/// E by patch [W/m2].
pub fn exitance_on_gpu(studio: &Studio) -> Vec<DVec3> {
    read(studio, &studio.renderer.spaces().exitance)
}

fn read(studio: &Studio, buffer: &wgpu::Buffer) -> Vec<DVec3> {
    let all: Vec<Vec4> = buffer::read(studio.renderer.gpu(), buffer).expect("a buffer");
    let patches = studio.renderer.transport().patches.len();
    all[..patches].iter().map(|value| (value.truncate() * studio.renderer.light_unit()).as_dvec3()).collect()
}
