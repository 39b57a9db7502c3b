//! Dropping to the floor: what is chosen falls straight down until it stands on something, or at height 0.

use std::collections::HashSet;

use engine::scene::EntityId;
use glam::DVec3;

use super::transform;
use crate::document::Document;
use crate::edit::Edit;
use crate::scenery::Scenery;

/// Metres that it may stand deep in a floor and still be lifted onto it.
const SUNK: f64 = 0.05;

pub fn edit(document: &Document, scenery: &Scenery<'_>, ids: &[EntityId]) -> Edit {
    let indexed = document.indexed();
    let falling: HashSet<EntityId> = ids.iter().flat_map(|id| indexed.subtree(*id)).collect();
    transform::moved(document, ids, |id| {
        let own: HashSet<EntityId> = indexed.subtree(id).into_iter().collect();
        let (low, high) =
            scenery.extent(|entity| own.contains(&entity.id) && entity.mesh.is_some()).unwrap_or_else(|| {
                let at = document.world_from_local(id).translation;
                (at, at)
            });
        let foot = DVec3::new((low.x + high.x) * 0.5, low.y, (low.z + high.z) * 0.5);
        let floor = floor_below(scenery, foot, &falling).unwrap_or(0.0);
        Some(DVec3::Y * (floor - foot.y))
    })
}

/// The highest surface under a point.
fn floor_below(scenery: &Scenery<'_>, foot: DVec3, without: &HashSet<EntityId>) -> Option<f64> {
    let mut highest: Option<f64> = None;
    for (entity, world) in
        scenery.placed().filter(|(entity, _)| !without.contains(&entity.id) && !entity.hidden)
    {
        let mesh = entity.mesh.as_ref().and_then(|renderer| scenery.assets.meshes.get(&renderer.mesh));
        for triangle in
            mesh.iter().flat_map(|mesh| mesh.triangles().map(|t| t.map(|i| mesh.positions[i as usize])))
        {
            let corners = triangle.map(|corner| world.transform_point3(corner.as_dvec3()));
            let height = height_at(corners, foot).filter(|height| *height <= foot.y + SUNK);
            highest = highest.into_iter().chain(height).reduce(f64::max);
        }
    }
    highest
}

/// Of a triangle over or under a point; `None`: it is beside it, or the triangle stands upright.
fn height_at([a, b, c]: [DVec3; 3], at: DVec3) -> Option<f64> {
    let cross = |u: DVec3, v: DVec3| u.x * v.z - u.z * v.x;
    let area = cross(b - a, c - a);
    let (u, v) = (cross(b - a, at - a) / area, cross(at - a, c - a) / area);
    let inside = area != 0.0 && u >= 0.0 && v >= 0.0 && u + v <= 1.0;
    inside.then_some(a.y + (b.y - a.y) * v + (c.y - a.y) * u)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_triangle_has_a_height_only_where_it_is() {
        let triangle = [DVec3::ZERO, DVec3::new(2.0, 0.0, 0.0), DVec3::new(0.0, 2.0, 2.0)];
        let height = |x, z| height_at(triangle, DVec3::new(x, 9.0, z));
        assert!((height(0.5, 1.0).unwrap() - 1.0).abs() < 1e-12);
        assert_eq!((height(1.5, 1.0), height(-0.1, 0.5)), (None, None));
        assert_eq!(height_at([DVec3::ZERO, DVec3::Y, DVec3::X], DVec3::ZERO), None);
    }
}
