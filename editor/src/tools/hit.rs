//! What lies under the mouse in the world: the first surface that a ray meets, and the vertex that is seen nearest to a
//! place. Boxes about meshes are kept, so that most meshes are passed over.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use eframe::egui::Pos2;
use engine::scene::{Entity, EntityId, Mesh, MeshSource};
use glam::{DAffine3, DVec3, Vec3};

use crate::lens::{Lens, Ray};
use crate::scenery::Scenery;

/// A point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    pub entity: EntityId,
    /// Of its mesh: which material is shown there.
    pub primitive: usize,
    /// Vertices of the triangle, and how near to each.
    pub corners: [u32; 3],
    pub shares: [f64; 3],
    pub at: DVec3,
    /// Unit, on the side that the ray comes from.
    pub normal: DVec3,
    /// Metres along the ray.
    pub distance: f64,
}

/// By mesh: what its box was made of, and the box in its own space.
#[derive(Default)]
pub struct Caster {
    boxes: HashMap<MeshSource, (Arc<Mesh>, [Vec3; 2])>,
}

impl Caster {
    /// The first surface that is met, of those entities that are wanted.
    pub fn cast(
        &mut self,
        scenery: &Scenery<'_>,
        ray: &Ray,
        wanted: impl Fn(&Entity) -> bool,
    ) -> Option<Hit> {
        let mut first: Option<Hit> = None;
        for (entity, world) in scenery.placed().filter(|(entity, _)| wanted(entity)) {
            let Some((mesh, reach)) = self.mesh(scenery, entity) else { continue };
            let local = in_space_of(ray, world);
            let farthest = first.map_or(f64::INFINITY, |hit| hit.distance);
            if !meets_box(&local, reach, farthest) || scenery.scene.is_hidden(entity) {
                continue;
            }
            let sides = sides(scenery, entity, &mesh);
            for (index, corners) in mesh.triangles().enumerate() {
                let places = corners.map(|corner| mesh.positions[corner as usize].as_dvec3());
                let met = meets_triangle(&local, places);
                let farthest = first.map_or(f64::INFINITY, |hit| hit.distance);
                // A back that is not drawn is not in the way.
                let is_seen = |(distance, _, front): &(f64, [f64; 3], bool)| {
                    *distance < farthest && (*front || sides.iter().any(|side| side.contains(&index)))
                };
                if let Some((distance, shares, _)) = met.filter(is_seen) {
                    let [a, b, c] = places.map(|place| world.transform_point3(place));
                    let normal = (b - a).cross(c - a).normalize_or(DVec3::Y);
                    let normal = if normal.dot(ray.direction) > 0.0 { -normal } else { normal };
                    let at = ray.origin + ray.direction * distance;
                    let primitive = primitive_of(&mesh, index);
                    first = Some(Hit { entity: entity.id, primitive, corners, shares, at, normal, distance });
                }
            }
        }
        first
    }

    /// The vertex that is seen nearest to a place of the screen and no farther than `within` points from it; of those that
    /// are as near, the one nearest to the eye.
    pub fn vertex(
        &mut self,
        scenery: &Scenery<'_>,
        lens: &Lens,
        at: Pos2,
        within: f32,
        wanted: impl Fn(&Entity) -> bool,
    ) -> Option<DVec3> {
        /// Points that count as nothing.
        const ALIKE: f32 = 3.0;
        let ray = lens.ray(at);
        let mut near: Vec<(f32, f64, DVec3)> = Vec::new();
        for (entity, world) in scenery.placed().filter(|(entity, _)| wanted(entity)) {
            let Some((mesh, reach)) = self.mesh(scenery, entity) else { continue };
            if !passes(&ray, lens, world, reach, within) || scenery.scene.is_hidden(entity) {
                continue;
            }
            for position in &mesh.positions {
                let place = world.transform_point3(position.as_dvec3());
                let seen = lens.project(place).filter(|(seen, _)| seen.distance(at) <= within);
                near.extend(seen.map(|(seen, depth)| (seen.distance(at), depth, place)));
            }
        }
        let least = near.iter().map(|(apart, ..)| *apart).min_by(f32::total_cmp)?;
        let alike = near.into_iter().filter(|(apart, ..)| *apart <= least + ALIKE);
        alike.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(.., place)| place)
    }

    fn mesh(&mut self, scenery: &Scenery<'_>, entity: &Entity) -> Option<(Arc<Mesh>, [Vec3; 2])> {
        let source = &entity.mesh.as_ref()?.mesh;
        let mesh = scenery.assets.meshes.get(source)?;
        if let Some((_, reach)) = self.boxes.get(source).filter(|(of, _)| Arc::ptr_eq(of, mesh)) {
            return Some((mesh.clone(), *reach));
        }
        let fold = |with: fn(Vec3, Vec3) -> Vec3| mesh.positions.iter().copied().reduce(with);
        let reach = [fold(Vec3::min)?, fold(Vec3::max)?];
        self.boxes.insert(source.clone(), (mesh.clone(), reach));
        Some((mesh.clone(), reach))
    }
}

fn primitive_of(mesh: &Mesh, triangle: usize) -> usize {
    let corner = triangle as u32 * 3;
    mesh.primitives.iter().position(|p| (p.first..p.first + p.count).contains(&corner)).unwrap_or(0)
}

/// Distances stay what they are in the world.
fn in_space_of(ray: &Ray, world: &DAffine3) -> Ray {
    let local = world.inverse();
    Ray { origin: local.transform_point3(ray.origin), direction: local.transform_vector3(ray.direction) }
}

fn meets_box(ray: &Ray, [low, high]: [Vec3; 2], farthest: f64) -> bool {
    let (mut from, mut to) = (0.0_f64, farthest);
    for axis in 0..3 {
        let bounds = [low[axis], high[axis]].map(|bound| f64::from(bound) - ray.origin[axis]);
        // A box may be flat, and a ray run along it.
        let margin = 1e-9 * (1.0 + bounds[0].abs().max(bounds[1].abs()));
        if ray.direction[axis] == 0.0 {
            if bounds[0] > margin || bounds[1] < -margin {
                return false;
            }
            continue;
        }
        let [a, b] = [bounds[0] - margin, bounds[1] + margin].map(|bound| bound / ray.direction[axis]);
        (from, to) = (from.max(a.min(b)), to.min(a.max(b)));
    }
    from <= to
}

/// Triangles that are seen from behind, too.
fn sides(scenery: &Scenery<'_>, entity: &Entity, mesh: &Mesh) -> Vec<Range<usize>> {
    let Some(renderer) = &entity.mesh else { return Vec::new() };
    let is_double = |slot: usize| {
        let id = renderer.materials.get(slot).or(renderer.materials.last());
        let material = scenery.scene.materials.iter().find(|material| Some(&material.id) == id);
        material.is_some_and(|material| material.double_sided)
    };
    let double = mesh.primitives.iter().enumerate().filter(|(slot, _)| is_double(*slot));
    double.map(|(_, part)| part.first as usize / 3..(part.first + part.count) as usize / 3).collect()
}

/// How far along the ray, the shares of the corners (Möller and Trumbore 1997), and whether it meets the front.
fn meets_triangle(ray: &Ray, [a, b, c]: [DVec3; 3]) -> Option<(f64, [f64; 3], bool)> {
    let (u_side, v_side) = (b - a, c - a);
    let p = ray.direction.cross(v_side);
    let volume = u_side.dot(p);
    let off = ray.origin - a;
    let q = off.cross(u_side);
    let (u, v) = (off.dot(p) / volume, ray.direction.dot(q) / volume);
    let distance = v_side.dot(q) / volume;
    let is_met = volume != 0.0 && u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 0.0;
    is_met.then_some((distance, [1.0 - u - v, u, v], volume > 0.0))
}

/// Does the ray come as near to the sphere about a box as the mouse reaches?
fn passes(ray: &Ray, lens: &Lens, world: &DAffine3, [low, high]: [Vec3; 2], within: f32) -> bool {
    let middle = world.transform_point3(((low + high) * 0.5).as_dvec3());
    let half = ((high - low) * 0.5).as_dvec3();
    let stretch = (0..3).map(|axis| world.matrix3.col(axis).length()).fold(0.0, f64::max);
    let along = (middle - ray.origin).dot(ray.direction);
    let apart = (ray.origin + ray.direction * along).distance(middle);
    let reach = half.length() * stretch;
    apart <= reach + lens.metres_per_point(middle + lens.forward() * reach) * f64::from(within)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: [DVec3; 3] = [DVec3::ZERO, DVec3::X, DVec3::Y];

    #[test]
    fn a_ray_meets_a_triangle_from_both_sides_and_knows_its_shares() {
        for way in [1.0, -1.0] {
            let ray = Ray { origin: DVec3::new(0.25, 0.5, -2.0 * way), direction: DVec3::Z * way };
            let (distance, shares, front) = meets_triangle(&ray, TRIANGLE).unwrap();
            assert!((distance - 2.0).abs() < 1e-12 && front == (way < 0.0));
            assert!(DVec3::from(shares).abs_diff_eq(DVec3::new(0.25, 0.25, 0.5), 1e-12), "{shares:?}");
        }
        let beside = Ray { origin: DVec3::new(0.8, 0.8, 1.0), direction: DVec3::NEG_Z };
        let away = Ray { origin: DVec3::new(0.2, 0.2, 1.0), direction: DVec3::Z };
        assert_eq!((meets_triangle(&beside, TRIANGLE), meets_triangle(&away, TRIANGLE)), (None, None));
    }

    #[test]
    fn a_flat_box_is_met_where_it_is() {
        let reach = [Vec3::new(-1.0, 0.0, -1.0), Vec3::new(1.0, 0.0, 1.0)];
        let down = |x: f64| Ray { origin: DVec3::new(x, 3.0, 0.0), direction: DVec3::NEG_Y };
        assert!(meets_box(&down(0.5), reach, f64::INFINITY) && !meets_box(&down(1.5), reach, f64::INFINITY));
        assert!(!meets_box(&down(0.5), reach, 2.0), "something else is nearer");
        let along = Ray { origin: DVec3::new(-5.0, 0.0, 0.0), direction: DVec3::X };
        assert!(meets_box(&along, reach, f64::INFINITY));
    }
}
