//! What rays meet: the static triangles as they are after sanitising, with the scene's own materials at every point.

use engine::scene::assets::{Assets, Picture};
use engine::scene::{Alpha, Material, MaterialId, Scene, Texture, world_from_local};
use engine::transport::NONE;
use engine::transport::bvh::{Bvh, Hit, Holes};
use engine::transport::direct::{PlacedLight, placed_lights};
use engine::transport::materials::{SurfacePoint, coverage};
use glam::{DVec3, Vec2, Vec3, Vec4};

use crate::directions::{hash_of, unit};
use crate::surface::Surface;

pub struct World {
    pub scene: Scene,
    pub assets: Assets,
    surface: Surface,
    /// Metres from the surface's origin.
    pub triangles: Vec<[Vec3; 3]>,
    /// By batch.
    materials: Vec<Material>,
    pub lights: Vec<PlacedLight>,
    pub bvh: Bvh,
    /// No corner is farther from the origin [m].
    pub extent: f32,
}

/// A ray that starts on a surface, or in space where the normal is 0.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    pub origin: Vec3,
    pub normal: Vec3,
    pub direction: Vec3,
}

impl World {
    pub fn new(scene: &Scene, assets: &Assets, surface: Surface) -> Self {
        let unit = surface.unit as f32;
        let triangles: Vec<[Vec3; 3]> = surface
            .triangles
            .iter()
            .map(|triangle| triangle.positions().map(|corner| corner.as_vec3() * unit))
            .collect();
        let materials: Vec<Material> =
            surface.batches.iter().map(|batch| material(scene, batch.material)).collect();
        let holed: Vec<bool> = surface
            .triangles
            .iter()
            .map(|triangle| materials[triangle.batch as usize].alpha != Alpha::Opaque)
            .collect();
        let holed = if holed.contains(&true) { holed } else { Vec::new() };
        let extent = triangles.iter().flatten().fold(1e-3_f32, |far, corner| far.max(corner.length()));
        let lights = placed_lights(scene, &world_from_local(scene), surface.origin);
        let lights = lights.into_iter().filter(|light| light.light.power() != Vec3::ZERO).collect();
        let bvh = Bvh::new(&triangles, holed);
        Self {
            scene: scene.clone(),
            assets: assets.clone(),
            surface,
            triangles,
            materials,
            lights,
            bvh,
            extent,
        }
    }

    pub fn origin(&self) -> DVec3 {
        self.surface.origin
    }

    pub fn material(&self, triangle: u32) -> &Material {
        &self.materials[self.surface.triangles[triangle as usize].batch as usize]
    }

    pub fn is_double_sided(&self, triangle: u32) -> bool {
        self.surface.batches[self.surface.triangles[triangle as usize].batch as usize].double_sided != 0
    }

    pub fn area(&self, triangle: u32) -> f64 {
        let [a, b, c] = self.triangles[triangle as usize].map(Vec3::as_dvec3);
        0.5 * (b - a).cross(c - a).length()
    }

    /// The face's own unit normal.
    pub fn normal(&self, triangle: u32) -> Vec3 {
        let [a, b, c] = self.triangles[triangle as usize];
        (b - a).cross(c - a).normalize_or(Vec3::Y)
    }

    /// Between the normals of the corners, with the normal map's bumps; on the side that is seen.
    pub fn shading_normal(&self, triangle: u32, [v, w]: [f32; 2], back: bool) -> Vec3 {
        let side = if back { -1.0 } else { 1.0 };
        let corners = &self.surface.triangles[triangle as usize].corners;
        let weights = [1.0 - v - w, v, w];
        let smooth: Vec3 = (0..3).map(|k| corners[k].normal * weights[k]).sum();
        let normal = smooth.normalize_or(self.normal(triangle)) * side;
        let along: Vec4 = (0..3).map(|k| Vec4::from(corners[k].tangent) * weights[k]).sum();
        let material = self.material(triangle);
        let tangent = along.truncate().reject_from_normalized(normal).normalize_or_zero();
        if material.normal_texture.is_none() || tangent == Vec3::ZERO {
            return normal;
        }
        let texel = self.data(&material.normal_texture, &self.point(triangle, [v, w])).truncate();
        let bump = (texel * 2.0 - 1.0) * Vec3::new(material.normal_scale, material.normal_scale, 1.0);
        let bitangent = normal.cross(tangent) * (along.w.signum() * side);
        (tangent * bump.x + bitangent * bump.y + normal * bump.z).normalize_or(normal)
    }

    pub fn position(&self, triangle: u32, [v, w]: [f32; 2]) -> Vec3 {
        let [a, b, c] = self.triangles[triangle as usize];
        a + (b - a) * v + (c - a) * w
    }

    /// What pictures are asked with.
    pub fn point(&self, triangle: u32, [v, w]: [f32; 2]) -> SurfacePoint {
        let corners = &self.surface.triangles[triangle as usize].corners;
        let weights = [1.0 - v - w, v, w];
        let uv = |set: usize| (0..3).map(|k| corners[k].uv[set] * weights[k]).sum::<Vec2>();
        let color = (0..3).map(|k| Vec4::from(corners[k].color) * weights[k]).sum();
        SurfacePoint { uv: [uv(0), uv(1)], color }
    }

    /// Radiance that a point of a surface gives off by itself [W/m2/sr].
    pub fn emission(&self, triangle: u32, barycentric: [f32; 2]) -> DVec3 {
        let material = self.material(triangle);
        let radiance = material.emission.radiance();
        if material.unlit || radiance == Vec3::ZERO {
            return DVec3::ZERO;
        }
        let at = self.point(triangle, barycentric);
        let emitted = radiance * self.color(&material.emission.texture, &at).truncate();
        if emitted.is_finite() { emitted.max(Vec3::ZERO).as_dvec3() } else { DVec3::ZERO }
    }

    /// The share of a point that is there.
    pub fn coverage(&self, triangle: u32, barycentric: [f32; 2]) -> f32 {
        let material = self.material(triangle);
        match material.alpha {
            Alpha::Opaque => 1.0,
            _ => coverage(material, &self.assets, &self.point(triangle, barycentric)),
        }
    }

    pub fn color(&self, texture: &Option<Texture>, at: &SurfacePoint) -> Vec4 {
        self.look_up(texture, at, Picture::sample_color)
    }

    pub fn data(&self, texture: &Option<Texture>, at: &SurfacePoint) -> Vec4 {
        self.look_up(texture, at, Picture::sample_data)
    }

    fn look_up(
        &self,
        texture: &Option<Texture>,
        at: &SurfacePoint,
        sample: impl Fn(&Picture, &Texture, Vec2) -> Vec4,
    ) -> Vec4 {
        let picture = |texture: &Texture| self.assets.images.get(&texture.image);
        texture
            .as_ref()
            .and_then(|texture| Some((texture, picture(texture)?)))
            .map_or(Vec4::ONE, |(texture, picture)| {
                sample(picture, texture, at.uv[usize::from(texture.uv_set.min(1))])
            })
    }

    pub fn closest(&self, ray: &Ray, chance: f32) -> Option<Hit> {
        self.bvh.closest(ray.origin, ray.normal, ray.direction, chance, self)
    }

    /// Is the way between points, each moved off its surface along that one's normal, free?
    pub fn free_between(&self, from: [Vec3; 2], to: [Vec3; 2], chance: f32) -> bool {
        self.bvh.free_between(from, to, chance, self)
    }

    /// Is the way from a point, moved off its surface, free?
    pub fn visible(&self, from: Vec3, normal: Vec3, to: Vec3, chance: f32) -> bool {
        self.bvh.visible(from, normal, to, chance, self)
    }
}

impl Holes for World {
    /// Each layer draws for itself: two half-open ones let a quarter pass.
    fn passes(&self, triangle: u32, barycentric: [f32; 2], chance: f32) -> bool {
        let own = hash_of([u64::from(chance.to_bits()), u64::from(triangle)]);
        unit(own as u32) >= self.coverage(triangle, barycentric)
    }
}

/// A material that the scene does not have counts as white, and none at all as black: as in the bake.
fn material(scene: &Scene, id: u32) -> Material {
    match id {
        NONE => Material { unlit: true, ..Material::default() },
        id => scene.material(MaterialId(id)).cloned().unwrap_or_default(),
    }
}
