//! What stands in the way at run time: the static surface of a transport, asked by rays. Where a reflection probe
//! may stand, how near its walls are, and whether a light reaches a patch.
//!
//! It is the bake's tree over the triangles that the bake drew ([`super::bvh`]), so that both meet the same walls.
//! Every triangle blocks, from both sides: of alpha and of what is hidden or moves the caller knows.

use glam::Vec3;

use super::Transport;
use super::bvh::{Bvh, Holes};

/// The static surface, in the transport's space [m].
pub struct Occluders {
    bvh: Bvh,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Metres.
    pub distance: f32,
    /// On the side from which its corners run counter-clockwise.
    pub front: bool,
    /// Into `surface.triangles`.
    pub triangle: u32,
}

/// No triangle has holes.
struct Solid;

impl Holes for Solid {
    fn passes(&self, _: u32, _: [f32; 2], _: f32) -> bool {
        false
    }
}

impl Occluders {
    pub fn new(transport: &Transport) -> Self {
        let surface = &transport.surface;
        let corners: Vec<[Vec3; 3]> =
            (0..surface.triangles.len()).map(|triangle| surface.positions(triangle)).collect();
        Self { bvh: Bvh::new(&corners, Vec::new()) }
    }

    /// The nearest surface in a direction of any length but 0. A ray that starts on a surface meets that surface
    /// or not, as rounding has it: start off it.
    pub fn nearest(&self, origin: Vec3, direction: Vec3) -> Option<Hit> {
        let direction = direction.try_normalize()?;
        let hit = self.bvh.closest(origin, Vec3::ZERO, direction, 0.0, &Solid)?;
        Some(Hit { distance: self.bvh.distance(&hit), front: !hit.back, triangle: hit.triangle })
    }

    /// Does nothing stand between two points? What `to` lies on does not count; move `from` off its surface.
    pub fn free(&self, from: Vec3, to: Vec3) -> bool {
        self.bvh.visible(from, Vec3::ZERO, to, 0.0, &Solid)
    }

    /// The same from a point on a surface, which is moved off it along the unit normal by as much as rounding
    /// needs.
    pub fn free_from_surface(&self, from: Vec3, normal: Vec3, to: Vec3) -> bool {
        self.bvh.visible(from, normal, to, 0.0, &Solid)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transport::{Surface, Vertex};

    /// A cube of side 2 whose fronts face inwards, scaled and moved.
    fn cube(scale: f32, at: Vec3) -> Transport {
        let corner = |i: usize| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * 2.0 - 1.0;
        let vertices =
            (0..8).map(|i| Vertex { position: corner(i) * scale + at, ..Vertex::default() }).collect();
        let quads: [[u32; 4]; 6] =
            [[0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [2, 3, 7, 6], [0, 1, 3, 2], [4, 6, 7, 5]];
        let triangles = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
        Transport { surface: Surface { vertices, triangles, ..Surface::default() }, ..Transport::default() }
    }

    fn directions() -> impl Iterator<Item = Vec3> {
        // A spiral over the sphere, and the axes.
        let spiral = (0..2000).map(|i| {
            let z = 1.0 - (2.0 * i as f32 + 1.0) / 2000.0;
            let turn = i as f32 * 2.399_963;
            let r = (1.0 - z * z).sqrt();
            Vec3::new(r * turn.cos(), r * turn.sin(), z)
        });
        spiral.chain([Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z])
    }

    #[test]
    fn from_inside_a_box_every_ray_meets_a_front_at_the_right_distance_at_any_scale() {
        for scale in [1e-4, 1.0, 1e5] {
            let occluders = Occluders::new(&cube(scale, Vec3::ZERO));
            let origin = Vec3::new(0.3, -0.2, 0.1) * scale;
            for direction in directions() {
                let hit = occluders.nearest(origin, direction * 7.0).unwrap();
                let ways = (0..3).map(|axis| {
                    let wall = scale.copysign(direction[axis]);
                    (wall - origin[axis]) / direction[axis]
                });
                let truth = ways.filter(|way| way.is_finite()).fold(f32::INFINITY, f32::min);
                assert!(
                    hit.front && (hit.distance / truth - 1.0).abs() < 1e-5,
                    "{scale} {direction}: {hit:?}, {truth}"
                );
            }
        }
    }

    #[test]
    fn from_outside_it_is_seen_from_behind_and_blocks_all_the_same() {
        let occluders = Occluders::new(&cube(1.0, Vec3::new(100.0, 0.0, 0.0)));
        let hit = occluders.nearest(Vec3::new(0.0, 0.3, 0.2), Vec3::X).unwrap();
        assert!(!hit.front && (hit.distance - 99.0).abs() < 1e-3, "{hit:?}");
        assert_eq!(occluders.nearest(Vec3::new(0.0, 3.0, 0.2), Vec3::X), None);
        let far = Vec3::new(200.0, 0.3, 0.2);
        assert!(!occluders.free(Vec3::new(0.0, 0.3, 0.2), far));
        assert!(occluders.free(Vec3::new(0.0, 3.0, 0.2), far + Vec3::Y * 2.7));
    }

    #[test]
    fn what_the_end_lies_on_does_not_block_and_what_is_no_direction_meets_nothing() {
        let occluders = Occluders::new(&cube(1.0, Vec3::ZERO));
        assert!(occluders.free(Vec3::ZERO, Vec3::new(1.0, 0.2, 0.3)));
        assert!(!occluders.free(Vec3::ZERO, Vec3::new(1.1, 0.2, 0.3)));
        assert!(occluders.free_from_surface(Vec3::new(-1.0, 0.1, 0.1), Vec3::X, Vec3::new(1.0, 0.2, 0.3)));
        assert_eq!(occluders.nearest(Vec3::ZERO, Vec3::ZERO), None);
        assert_eq!(occluders.nearest(Vec3::ZERO, Vec3::NAN), None);
        let nothing = Occluders::new(&Transport::default());
        assert_eq!(nothing.nearest(Vec3::ZERO, Vec3::X), None);
        assert!(nothing.free(Vec3::ZERO, Vec3::X));
    }
}
