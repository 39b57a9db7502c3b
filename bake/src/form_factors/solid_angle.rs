//! Directions even over the solid angle of a triangle.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

/// A triangle as seen from a point.
pub struct Spherical {
    corners: [DVec3; 3],
    /// The angle at the first corner.
    angle: f64,
    /// Of the side from the first corner to the second.
    cos_side: f64,
    pub solid_angle: f64,
}

impl Spherical {
    /// `None` where nothing is left of it.
    pub fn new(at: DVec3, triangle: &[DVec3; 3]) -> Option<Self> {
        let [a, b, c] = triangle.map(|corner| (corner - at).normalize_or_zero());
        let [ab, bc, ca] =
            [a.cross(b).try_normalize()?, b.cross(c).try_normalize()?, c.cross(a).try_normalize()?];
        let angle_between = |p: DVec3, q: DVec3| (-p.dot(q)).clamp(-1.0, 1.0).acos();
        let [alpha, beta, gamma] = [angle_between(ab, ca), angle_between(bc, ab), angle_between(ca, bc)];
        let solid_angle = alpha + beta + gamma - PI;
        (solid_angle > 1e-12 && solid_angle < TAU).then_some(Self {
            corners: [a, b, c],
            angle: alpha,
            cos_side: a.dot(b),
            solid_angle,
        })
    }

    /// u, v in 0..1 (Arvo 1995).
    pub fn direction(&self, u: f64, v: f64) -> DVec3 {
        let [a, b, c] = self.corners;
        let (sin, cos) = (u * self.solid_angle - self.angle).sin_cos();
        let (sin_angle, cos_angle) = self.angle.sin_cos();
        let (p, q) = (cos - cos_angle, sin + sin_angle * self.cos_side);
        let along = ((q * cos - p * sin) * cos_angle - q) / ((q * sin + p * cos) * sin_angle);
        let along = if along.is_finite() { along.clamp(-1.0, 1.0) } else { 1.0 };
        let beside = |from: DVec3, to: DVec3| (to - from * to.dot(from)).normalize_or_zero();
        let third = a * along + beside(a, c) * (1.0 - along * along).sqrt();
        let z = 1.0 - v * (1.0 - third.dot(b));
        b * z + beside(b, third) * (1.0 - z * z).max(0.0).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_even_over_an_octant() {
        let octant = Spherical::new(DVec3::ZERO, &[DVec3::X, DVec3::Y * 2.0, DVec3::Z * 3.0]).unwrap();
        assert!((octant.solid_angle - 0.5 * PI).abs() < 1e-12);
        const N: u32 = 200;
        let at = |k: u32| (f64::from(k) + 0.5) / f64::from(N);
        let all = (0..N).flat_map(|i| (0..N).map(move |j| (at(i), at(j))));
        let (mut mean, mut squares) = (DVec3::ZERO, DVec3::ZERO);
        for (u, v) in all {
            let direction = octant.direction(u, v);
            assert!((direction.length() - 1.0).abs() < 1e-9 && direction.min_element() > -1e-9);
            mean += direction / f64::from(N * N);
            squares += direction * direction / f64::from(N * N);
        }
        assert!((mean - 0.5).abs().max_element() < 1e-3, "{mean}");
        assert!((squares - 1.0 / 3.0).abs().max_element() < 1e-3, "{squares}");
    }
}
