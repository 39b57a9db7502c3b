//! Albedo and emission of patches, from the scene's materials and pictures. No ray depends on them: they may
//! change at any time.

use std::f32::consts::PI;

use glam::{DVec3, Vec2, Vec3, Vec4};
use rayon::prelude::*;

use super::{NONE, Patch, Surface, Transport};
use crate::scene::assets::Assets;
use crate::scene::{Alpha, Material, MaterialId, Scene, Texture, Warning};

/// By patch.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PatchMaterials {
    /// Diffuse, 0..1.
    pub albedo: Vec<Vec3>,
    /// M, emitted [W/m2].
    pub exitance: Vec<Vec3>,
}

/// Means over each patch. A material that the scene does not have counts as white.
pub fn of_patches(transport: &Transport, scene: &Scene, assets: &Assets) -> PatchMaterials {
    let white = Material::default();
    let both: Vec<(Vec3, Vec3)> = transport
        .patches
        .par_iter()
        .map(|patch| {
            let id = transport.surface.batches[patch.batch as usize].material;
            if id == NONE {
                return (Vec3::ZERO, Vec3::ZERO); // of what is gone
            }
            let id = MaterialId(id);
            let material = scene.material(id).unwrap_or(&white);
            of_patch(&transport.surface, patch, material, assets)
        })
        .collect();
    let (albedo, exitance) = both.into_iter().unzip();
    PatchMaterials { albedo, exitance }
}

/// Names what no surface can be: albedo outside 0..1 is clamped, NaN becomes 0.5.
pub fn warnings(scene: &Scene) -> Vec<Warning> {
    let bad = |material: &&Material| {
        let color = material.albedo.color;
        color.is_nan() || color.min_element() < 0.0 || color.max_element() > 1.0
    };
    let say = |material: &Material| {
        Warning::new(format!("material `{}`", material.name), "its albedo is clamped to 0..1 (NaN to 0.5)")
    };
    scene.materials.iter().filter(bad).map(say).collect()
}

fn of_patch(surface: &Surface, patch: &Patch, material: &Material, assets: &Assets) -> (Vec3, Vec3) {
    if material.unlit {
        return (Vec3::ZERO, Vec3::ZERO);
    }
    let range = patch.first_triangle as usize..(patch.first_triangle + patch.triangle_count) as usize;
    let points = points_in_triangles(range.len());
    // In f64: the mean of one colour is that colour to the last bit. An albedo of 0.999999 that comes out a few digits
    // higher makes a closed room three times as bright.
    let (mut weight, mut albedo, mut emission) = (0.0_f64, DVec3::ZERO, DVec3::ZERO);
    for t in range {
        let corners = surface.triangles[t].map(|v| &surface.vertices[v as usize]);
        let [a, b, c] = corners.map(|vertex| vertex.position);
        let area = (b - a).cross(c - a).length();
        for &[v, w] in &points {
            let mix2 = |i: usize| -> Vec2 {
                corners[0].uv[i] * (1.0 - v - w) + corners[1].uv[i] * v + corners[2].uv[i] * w
            };
            let color = |k: usize| Vec4::from(corners[k].color);
            let color = color(0) + (color(1) - color(0)) * v + (color(2) - color(0)) * w;
            let at = SurfacePoint { uv: [mix2(0), mix2(1)], color };
            // What is a hole in the surface does not count.
            let area = f64::from(area * coverage(material, assets, &at).max(1e-4));
            albedo += diffuse(material, assets, &at).as_dvec3() * area;
            emission += look_up(&material.emission.texture, assets, &at, true).truncate().as_dvec3() * area;
            weight += area;
        }
    }
    let weight = weight.max(f64::MIN_POSITIVE);
    let (albedo, emission) = ((albedo / weight).as_vec3(), (emission / weight).as_vec3());
    let clamped = |x: f32| if x.is_nan() { 0.5 } else { x.clamp(0.0, 1.0) };
    let exitance = material.emission.radiance() * emission * PI;
    let exitance = if exitance.is_finite() { exitance.max(Vec3::ZERO) } else { Vec3::ZERO };
    (albedo.map(clamped), exitance)
}

/// What a material's pictures are asked with.
pub struct SurfacePoint {
    pub uv: [Vec2; 2],
    pub color: Vec4,
}

/// base colour * (1 - metallic): what metal reflects is not diffuse.
fn diffuse(material: &Material, assets: &Assets, at: &SurfacePoint) -> Vec3 {
    let base = material.albedo.color
        * look_up(&material.albedo.texture, assets, at, true).truncate()
        * at.color.truncate();
    let metallic = material.metallic * look_up(&material.metallic_roughness_texture, assets, at, false).z;
    base * (1.0 - metallic.clamp(0.0, 1.0))
}

/// The share of light that the surface stops here: its alpha, or 0 and 1 about the cutoff.
pub fn coverage(material: &Material, assets: &Assets, at: &SurfacePoint) -> f32 {
    let alpha = || material.opacity * look_up(&material.albedo.texture, assets, at, false).w * at.color.w;
    match material.alpha {
        Alpha::Opaque => 1.0,
        Alpha::Mask { cutoff } => f32::from(u8::from(alpha() >= cutoff)),
        Alpha::Blend => alpha().clamp(0.0, 1.0),
    }
}

fn look_up(texture: &Option<Texture>, assets: &Assets, at: &SurfacePoint, color: bool) -> Vec4 {
    let Some(texture) = texture else { return Vec4::ONE };
    let Some(picture) = assets.images.get(&texture.image) else { return Vec4::ONE };
    let uv = at.uv[usize::from(texture.uv_set.min(1))];
    if color { picture.sample_color(texture, uv) } else { picture.sample_data(texture, uv) }
}

/// About 64 points for a patch: barycentric weights of the second and third corner, the same in each of its
/// triangles (Roberts' R2 sequence, folded into the triangle).
pub fn points_in_triangles(triangles: usize) -> Vec<[f32; 2]> {
    let n = (64 / triangles.max(1)).max(1);
    if n == 1 {
        return vec![[1.0 / 3.0; 2]];
    }
    (0..n)
        .map(|i| {
            let at = |step: f64| (0.5 + step * (i + 1) as f64).fract() as f32;
            let (u, v) = (at(0.754_877_666_246_692_8), at(0.569_840_290_998_053_2));
            if u + v > 1.0 { [1.0 - u, 1.0 - v] } else { [u, v] }
        })
        .collect()
}
