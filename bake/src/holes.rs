//! Alpha at a ray's hit: masks have holes, and a blended surface lets a ray pass with probability 1 - alpha.

use engine::scene::assets::Assets;
use engine::scene::{Alpha, Material, MaterialId, Scene};
use engine::transport::materials::{SurfacePoint, coverage, points_in_triangles};
use engine::transport::{Surface, Transport};
use glam::{Vec2, Vec4};

use crate::directions::{hash_of, unit};
use crate::layout::RayScene;
use engine::transport::bvh::Holes;

pub struct AlphaHoles<'a> {
    surface: &'a Surface,
    assets: &'a Assets,
    /// By triangle: its material, where that is not opaque.
    materials: Vec<Option<&'a Material>>,
}

impl<'a> AlphaHoles<'a> {
    pub fn new(surface: &'a Surface, scene: &'a Scene, assets: &'a Assets) -> Self {
        let mut materials = vec![None; surface.triangles.len()];
        for batch in &surface.batches {
            let material = scene.material(MaterialId(batch.material));
            let holed = material.filter(|material| material.alpha != Alpha::Opaque);
            materials[batch.first as usize..][..batch.count as usize].fill(holed);
        }
        Self { surface, assets, materials }
    }

    /// By triangle, or empty where nothing has holes.
    pub fn holed(&self) -> Vec<bool> {
        if self.materials.iter().all(Option::is_none) {
            return Vec::new();
        }
        self.materials.iter().map(Option::is_some).collect()
    }

    /// The share of light that a triangle stops at a place.
    fn coverage(&self, triangle: u32, [v, w]: [f32; 2]) -> f32 {
        let Some(material) = self.materials[triangle as usize] else { return 1.0 };
        let corners =
            self.surface.triangles[triangle as usize].map(|vertex| &self.surface.vertices[vertex as usize]);
        let u = 1.0 - v - w;
        let uv = |i: usize| -> Vec2 { corners[0].uv[i] * u + corners[1].uv[i] * v + corners[2].uv[i] * w };
        let color = |k: usize| Vec4::from(corners[k].color);
        let at = SurfacePoint { uv: [uv(0), uv(1)], color: color(0) * u + color(1) * v + color(2) * w };
        coverage(material, self.assets, &at)
    }
}

impl Holes for AlphaHoles<'_> {
    /// Each layer draws for itself: two half-open ones let a quarter pass.
    fn passes(&self, triangle: u32, barycentric: [f32; 2], chance: f32) -> bool {
        let own = hash_of([u64::from(chance.to_bits()), u64::from(triangle)]);
        unit(own as u32) >= self.coverage(triangle, barycentric)
    }
}

/// A patch with holes has the area of what is left of it: what it gives and takes is then per area of matter, and
/// reciprocity holds with the share of rays that meet it.
pub fn shrink_patches(transport: &mut Transport, rays: &mut RayScene, scene: &Scene, assets: &Assets) {
    let surface = std::mem::take(&mut transport.surface);
    let holes = AlphaHoles::new(&surface, scene, assets);
    for (i, patch) in transport.patches.iter_mut().enumerate() {
        let range = patch.first_triangle..patch.first_triangle + patch.triangle_count;
        if range.clone().all(|t| holes.materials[t as usize].is_none()) {
            continue;
        }
        let points = points_in_triangles(range.len());
        let (mut covered, mut all) = (0.0, 0.0);
        for t in range {
            let [a, b, c] = surface.positions(t as usize);
            let area = (b - a).cross(c - a).length();
            for &point in &points {
                covered += area * holes.coverage(t, point);
                all += area;
            }
        }
        let share = (covered / all).clamp(1e-3, 1.0);
        patch.area *= share;
        rays.patch_areas[i] *= f64::from(share);
    }
    transport.surface = surface;
}
