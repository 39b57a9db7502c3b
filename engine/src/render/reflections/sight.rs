//! Where a cubemap may be taken: not inside a solid, and with a near plane before the nearest wall.

use std::collections::BTreeSet;

use glam::Vec3;

use crate::transport::{NONE, Occluders, Transport, sky};

/// What a place sees of the static surface, by rays all around.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    /// Metres.
    pub nearest: f32,
    /// Likewise; infinite where it sees out of the scene.
    pub farthest: f32,
    /// Of the rays, what meets the back of a one-sided surface.
    pub backs: f32,
    /// For a place inside a solid: one outside.
    pub better: Option<Vec3>,
}

/// More than this share of backs: the place is inside a solid.
const MOST_BACKS: f32 = 0.25;

impl Sight {
    pub fn is_inside(&self) -> bool {
        self.backs > MOST_BACKS
    }
}

pub fn look_around(transport: &Transport, occluders: &Occluders, at: Vec3) -> Sight {
    let mut sight = around(transport, occluders, at);
    if sight.is_inside() {
        sight.better = outside(transport, occluders, at);
    }
    sight
}

/// Batches of the static surface that are seen from a place, by rays all around.
pub fn seen_batches(transport: &Transport, occluders: &Occluders, at: Vec3) -> Vec<usize> {
    let hit = |patch| occluders.nearest(at, sky::direction_in(patch, 0.5, 0.5));
    let hit: BTreeSet<u32> = (0..sky::COUNT).filter_map(hit).map(|hit| hit.triangle).collect();
    let is_seen = |first: u32, count: u32| hit.range(first..first + count).next().is_some();
    let batches = transport.surface.batches.iter().enumerate();
    batches.filter(|(_, batch)| is_seen(batch.first, batch.count)).map(|(index, _)| index).collect()
}

fn around(transport: &Transport, occluders: &Occluders, at: Vec3) -> Sight {
    let mut sight = Sight { nearest: f32::INFINITY, farthest: 0.0, backs: 0.0, better: None };
    for patch in 0..sky::COUNT {
        let Some(hit) = occluders.nearest(at, sky::direction_in(patch, 0.5, 0.5)) else {
            sight.farthest = f32::INFINITY;
            continue;
        };
        sight.farthest = sight.farthest.max(hit.distance);
        sight.nearest = sight.nearest.min(hit.distance);
        let behind = !hit.front && transport.surface.patches[hit.triangle as usize][1] == NONE;
        sight.backs += f32::from(u8::from(behind)) / sky::COUNT as f32;
    }
    sight
}

/// The nearest place beyond a wall that is not inside anything.
fn outside(transport: &Transport, occluders: &Occluders, at: Vec3) -> Option<Vec3> {
    let way = |patch| {
        let direction = sky::direction_in(patch, 0.5, 0.5);
        let hit = occluders.nearest(at, direction).filter(|hit| !hit.front)?;
        Some((hit.distance, direction))
    };
    let mut ways: Vec<(f32, Vec3)> = (0..sky::COUNT).filter_map(way).collect();
    ways.sort_by(|a, b| a.0.total_cmp(&b.0));
    // A few centimetres off the wall, so that the cubemap is not all wall.
    let places = ways.iter().map(|(distance, direction)| at + *direction * (distance * 1.02 + 0.05));
    places.into_iter().find(|&place| !around(transport, occluders, place).is_inside())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transport::{Surface, Vertex};

    /// A cube of side 2 about the origin that is seen from outside.
    fn cube() -> Transport {
        let corner = |k: usize| Vec3::new(k as f32 % 2.0, (k / 2) as f32 % 2.0, (k / 4) as f32) * 2.0 - 1.0;
        let vertices = (0..8).map(|k| Vertex { position: corner(k), ..Vertex::default() }).collect();
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles: Vec<[u32; 3]> =
            quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
        let patches = vec![[0, NONE]; triangles.len()];
        Transport {
            surface: Surface { vertices, triangles, patches, ..Surface::default() },
            ..Transport::default()
        }
    }

    #[test]
    fn inside_a_solid_there_are_backs_and_a_way_out() {
        let transport = cube();
        let occluders = Occluders::new(&transport);
        let inside = look_around(&transport, &occluders, Vec3::new(0.5, 0.0, 0.0));
        assert!(inside.is_inside() && inside.backs > 0.99, "{inside:?}");
        let better = inside.better.expect("a way out");
        assert!(better.x > 1.0 && better.x < 1.2, "{better}");
        let outside = look_around(&transport, &occluders, Vec3::new(1.001, 0.0, 0.0));
        assert!(!outside.is_inside());
        // The near plane follows from this: half of it leaves no hole.
        assert!(outside.nearest < 1.1e-3 && outside.nearest > 0.9e-3, "{outside:?}");
    }
}
