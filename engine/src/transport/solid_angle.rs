//! What a light sends into a triangle, exactly: for a light that is near to a patch, where a few points say nothing of
//! the whole. The plain twin of `transport/solid_angle.wgsl`.
//!
//! ```text
//! point  flux = I * Omega                        Omega: solid angle (Van Oosterom and Strackee 1983)
//! spot   flux = I * Int w(mu) phi(mu) dmu        mu = cos(angle to the axis), w = saturate(scale mu + offset)^2
//! ```
//! phi(mu) is how much of the circle at that angle lies in the triangle. Along an edge the azimuth only grows or
//! only falls, and the circle leaves the triangle where an edge enters it, so that
//! ```text
//! phi = 2 pi [axis in the triangle] - sum over edges of the azimuth swept inside the circle
//! ```
//! For triangles that cover the sphere these sum to 2 pi on every circle, whatever rounding does: all of the light
//! is given, none twice.

use std::f32::consts::TAU;

use glam::Vec3;

/// Circles over the full part of a cone, and over the part that fades.
const FULL: u32 = 32;
const FADING: u32 = 24;

/// Signed solid angle of a triangle seen from the origin; negative when its corners run counter-clockwise as seen
/// from there.
pub fn solid_angle(corners: [Vec3; 3]) -> f32 {
    let Some([a, b, c]) = scaled(corners) else { return 0.0 };
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    // a . (b x c), without losing digits where the origin is close to the triangle.
    let numerator = a.dot((b - a).cross(c - a));
    let denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    2.0 * numerator.atan2(denominator)
}

/// Of a size at which products of three lengths are floats; directions do not change. `None`: a corner is nowhere, or
/// all are at the origin.
fn scaled(corners: [Vec3; 3]) -> Option<[Vec3; 3]> {
    let size = corners.iter().map(|corner| corner.abs().max_element()).fold(0.0, f32::max);
    if !corners.iter().all(|corner| corner.is_finite()) || size <= 0.0 {
        return None;
    }
    let is_usual = (1e-9..=1e9).contains(&size);
    Some(if is_usual { corners } else { corners.map(|corner| corner / size) })
}

/// Int over a triangle's directions of saturate(scale * cos + offset)^2, cos to the unit `axis`, seen from the origin
/// [sr]. The corners run clockwise as seen from there; the cone is narrower than a half space.
pub fn cone_in_triangle(corners: [Vec3; 3], axis: Vec3, [scale, offset]: [f32; 2]) -> f32 {
    let Some(corners) = scaled(corners) else { return 0.0 };
    // Beside the axis by what nobody sees: no edge and no corner lies on it, as they do in scenes on a grid.
    let (x, y) = axis.any_orthonormal_pair();
    let z = (axis + x * 1.1e-5 + y * 0.7e-5).normalize();
    let x = (x - z * z.dot(x)).normalize();
    let y = z.cross(x);
    let [a, b, c] = corners.map(|corner| Vec3::new(corner.dot(x), corner.dot(y), corner.dot(z)));
    let edges = [Edge::new(a, b), Edge::new(b, c), Edge::new(c, a)];
    let full = if edges.iter().all(|edge| edge.turn > 0.0) { TAU } else { 0.0 };
    let phi = |mu: f32| full - edges.iter().map(|edge| edge.swept_within(mu)).sum::<f32>();
    let outer = (-offset / scale).clamp(0.0, 1.0);
    let inner = ((1.0 - offset) / scale).clamp(outer, 1.0);
    let mut flux = 0.0;
    for k in 0..FULL {
        let mu = inner + (1.0 - inner) * (k as f32 + 0.5) / FULL as f32;
        flux += phi(mu) * (1.0 - inner) / FULL as f32;
    }
    for k in 0..FADING {
        let (low, high) = (k as f32 / FADING as f32, (k + 1) as f32 / FADING as f32);
        // Int of the share's square over the ring.
        let squares = (high * high * high - low * low * low) / 3.0;
        flux += phi(outer + (inner - outer) * 0.5 * (low + high)) * squares * (inner - outer);
    }
    flux.max(0.0)
}

/// A side of a triangle on the sphere, in a frame whose z is the cone's axis: from * cos t + beside * sin t.
struct Edge {
    from: Vec3,
    beside: Vec3,
    /// Radians from its start to its end.
    length: f32,
    /// Which way the azimuth goes along it: 1 or -1.
    turn: f32,
}

impl Edge {
    fn new(a: Vec3, b: Vec3) -> Self {
        let from = a.normalize_or_zero();
        let normal = from.cross(b);
        let beside = normal.cross(from).normalize_or_zero();
        let length = normal.length().atan2(from.dot(b));
        Self { from, beside, length, turn: if normal.z >= 0.0 { 1.0 } else { -1.0 } }
    }

    /// Of the azimuth, where the edge is nearer to the axis than acos(mu).
    fn swept_within(&self, mu: f32) -> f32 {
        let highest = self.from.z.hypot(self.beside.z);
        if mu >= highest {
            return 0.0;
        }
        let half = (highest * highest - mu * mu).max(0.0).sqrt().atan2(mu);
        let middle = self.beside.z.atan2(self.from.z);
        let middle = middle - TAU * ((middle - 0.5 * self.length) / TAU).round();
        let (first, last) = ((middle - half).max(0.0), (middle + half).min(self.length));
        if first >= last {
            return 0.0;
        }
        let at = |t: f32| (self.from * t.cos() + self.beside * t.sin()).truncate();
        let (p, q) = (at(first), at(last));
        self.turn * p.perp_dot(q).abs().atan2(p.dot(q))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_facing_triangle_has_a_negative_solid_angle_of_the_right_size() {
        // An octant of directions.
        let omega = solid_angle([Vec3::X, Vec3::Y, Vec3::Z]);
        assert!((omega.abs() - std::f32::consts::FRAC_PI_2).abs() < 1e-6, "{omega}");
        // Seen from the origin, x, y, z run counter-clockwise when looked at from outside, so the face looks
        // away from the origin: a front face towards the origin is the other way round.
        let [a, b, c] = [Vec3::X, Vec3::Y, Vec3::Z];
        let looks_at_origin = (b - a).cross(c - a).dot(-a) > 0.0;
        assert_eq!(looks_at_origin, omega < 0.0);
    }

    /// A triangle cut into `n` x `n` parts, the cone taken at the middle of each.
    fn by_parts([a, b, c]: [Vec3; 3], axis: Vec3, [scale, offset]: [f32; 2], n: usize) -> f64 {
        let at = |i: usize, j: usize| a + ((b - a) * i as f32 + (c - a) * j as f32) / n as f32;
        let part = |corners: [Vec3; 3]| {
            let middle = (corners[0] + corners[1] + corners[2]).normalize();
            let cone = (scale * middle.dot(axis) + offset).clamp(0.0, 1.0);
            f64::from(solid_angle(corners) * cone * cone)
        };
        let mut sum = 0.0;
        for i in 0..n {
            for j in 0..n - i {
                sum += part([at(i, j), at(i + 1, j), at(i, j + 1)]);
                if i + j + 1 < n {
                    sum += part([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
                }
            }
        }
        sum
    }

    fn cone(inner: f32, outer: f32) -> [f32; 2] {
        let scale = 1.0 / (inner.cos() - outer.cos());
        [scale, -outer.cos() * scale]
    }

    /// Int over all directions.
    fn whole(inner: f32, outer: f32) -> f32 {
        TAU * (1.0 - inner.cos() + (inner.cos() - outer.cos()) / 3.0)
    }

    #[test]
    fn a_cone_in_a_triangle_is_the_sum_over_its_parts() {
        let triangle = [Vec3::new(-1.0, -1.0, 0.7), Vec3::new(1.5, -0.5, 0.7), Vec3::new(0.0, 1.0, 0.7)];
        for (axis, inner, outer) in [
            (Vec3::Z, 0.3, 0.6),
            (Vec3::Z, 1.0, 1.3),
            (Vec3::X, 0.9, 1.2),
            (Vec3::new(0.8, 0.0, 0.6), 0.2, 0.21),
            (Vec3::new(0.0, -0.6, 0.8), 0.5, 1.2),
            (Vec3::NEG_Z, 0.5, 1.0),
        ] {
            let closed = cone_in_triangle(triangle, axis, cone(inner, outer));
            let sum = by_parts(triangle, axis, cone(inner, outer), 300);
            let tolerance = 5e-3 * f64::from(whole(inner, outer));
            assert!((f64::from(closed) - sum).abs() < tolerance, "{axis} {inner} {outer}: {closed}, {sum}");
        }
    }

    #[test]
    fn triangles_about_the_light_share_all_of_a_cone() {
        // An octahedron; axes through faces, edges and corners.
        let (x, y, z) = (Vec3::X, Vec3::Y, Vec3::Z);
        let faces = [
            [x, y, z],
            [y, -x, z],
            [-x, -y, z],
            [-y, x, z],
            [y, x, -z],
            [-x, y, -z],
            [-y, -x, -z],
            [x, -y, -z],
        ];
        for axis in
            [x, -z, (x + y).normalize(), (x - y + z).normalize(), Vec3::new(0.1, 0.7, -0.3).normalize()]
        {
            for (inner, outer) in [(0.02, 0.03), (0.4, 0.9), (1.2, 1.5)] {
                let sum: f32 =
                    faces.iter().map(|&face| cone_in_triangle(face, axis, cone(inner, outer))).sum();
                assert!((sum / whole(inner, outer) - 1.0).abs() < 1e-4, "{axis} {inner}: {sum}");
            }
        }
    }
}
