//! The place on a surface that a point means: the nearest front (or back of what has two sides) whose normal is alike.

use glam::{DVec3, Vec3};

use crate::query::nearest;
use crate::{BakeError, Point};

/// A point may lie this far from its surface, in sizes of the scene, and its normal this far from the face's.
const REACH: f32 = 2e-3;
const COS_TURN: f32 = 0.866_025_4;

/// A point on a surface, in metres from the origin of what was searched.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    pub position: Vec3,
    /// As it was asked for, unit.
    pub normal: Vec3,
}

/// `has_side`: does a triangle's front (false) or back (true) reflect?
pub fn places(
    points: &[Point],
    origin: DVec3,
    triangles: &[[Vec3; 3]],
    has_side: impl Fn(usize, bool) -> bool,
) -> Result<Vec<Place>, BakeError> {
    let extent = triangles.iter().flatten().fold(0.0_f32, |far, corner| far.max(corner.length()));
    let place = |(number, point): (usize, &Point)| {
        place(point, origin, triangles, &has_side, REACH * extent)
            .map_err(|why| BakeError::Other(format!("point {} at {}: {why}", number + 1, point.position)))
    };
    points.iter().enumerate().map(place).collect()
}

fn place(
    point: &Point,
    origin: DVec3,
    triangles: &[[Vec3; 3]],
    has_side: &impl Fn(usize, bool) -> bool,
    reach: f32,
) -> Result<Place, String> {
    let wanted = (point.position - origin).as_vec3();
    let normal = point.normal.normalize_or_zero().as_vec3();
    if normal == Vec3::ZERO || !wanted.is_finite() {
        return Err("it has no normal, or is not finite".to_owned());
    }
    let mut best = (f32::INFINITY, Vec3::ZERO);
    for (t, corners) in triangles.iter().enumerate() {
        let [a, b, c] = *corners;
        let cosine = (b - a).cross(c - a).normalize_or_zero().dot(normal);
        if cosine.abs() < COS_TURN || !has_side(t, cosine < 0.0) {
            continue;
        }
        let [v, w] = nearest(wanted, corners);
        let at = a + (b - a) * v + (c - a) * w;
        if at.distance(wanted) < best.0 {
            best = (at.distance(wanted), at);
        }
    }
    match best.0 {
        f32::INFINITY => Err("no front face looks that way".to_owned()),
        distance if distance <= reach => Ok(Place { position: best.1, normal }),
        distance => Err(format!("the nearest front face with such a normal is {distance:.3e} m away")),
    }
}
