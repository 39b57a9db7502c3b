//! Form factors in closed form, f64 (Howell's catalogue of configuration factors; general rectangles by Ehlert and
//! Smith 1993). F is the share of the light that leaves the first surface and arrives at the second.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

/// Sum over the corners of a box of ranges, signs alternating: what is left of a fourfold integral.
fn corners(ranges: [[f64; 2]; 4], of: impl Fn([f64; 4]) -> f64) -> f64 {
    (0..16_usize)
        .map(|bits| {
            let corner = std::array::from_fn(|k| ranges[k][bits >> k & 1]);
            if bits.count_ones() % 2 == 0 { of(corner) } else { -of(corner) }
        })
        .sum()
}

fn area(x: [f64; 2], y: [f64; 2]) -> f64 {
    (x[1] - x[0]) * (y[1] - y[0])
}

/// Rectangles a x b that face each other at distance c.
pub fn opposed(a: f64, b: f64, c: f64) -> f64 {
    let (x, y) = (a / c, b / c);
    let (p, q) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
    let log = (p * q / (1.0 + x * x + y * y).sqrt()).ln();
    let arcs = x * q * (x / q).atan() + y * p * (y / p).atan() - x * x.atan() - y * y.atan();
    2.0 / (PI * x * y) * (log + arcs)
}

/// x, y against xi, eta in a plane at distance z.
pub fn parallel(x: [f64; 2], y: [f64; 2], xi: [f64; 2], eta: [f64; 2], z: f64) -> f64 {
    let of = |[x, y, xi, eta]: [f64; 4]| {
        let (a, b) = (x - xi, y - eta);
        let (p, q) = (a.hypot(z), b.hypot(z));
        b * p * (b / p).atan() + a * q * (a / q).atan() - 0.5 * z * z * (a * a + b * b + z * z).ln()
    };
    corners([x, y, xi, eta], of) / (TAU * area(x, y))
}

/// x, y in the plane z = 0 against eta (along y), xi (along z) in the plane x = 0.
pub fn perpendicular(x: [f64; 2], y: [f64; 2], eta: [f64; 2], xi: [f64; 2]) -> f64 {
    let of = |[x, y, eta, xi]: [f64; 4]| {
        let (r, b) = (x.hypot(xi), y - eta);
        let arc = if r > 0.0 { b * r * (b / r).atan() } else { 0.0 };
        let square = r * r + b * b;
        let log = if square > 0.0 { square.ln() } else { 0.0 };
        arc - 0.25 * (r * r - b * b) * log
    };
    corners([x, y, eta, xi], of) / (TAU * area(x, y))
}

/// Coaxial discs of radii r1 and r2 at distance h.
pub fn discs(r1: f64, r2: f64, h: f64) -> f64 {
    let (first, second) = (r1 / h, r2 / h);
    let x = 1.0 + (1.0 + second * second) / (first * first);
    0.5 * (x - (x * x - 4.0 * (second / first).powi(2)).sqrt())
}

/// A point against a rectangle x, y in a plane at distance c that it faces, itself under (0, 0).
pub fn point_parallel(x: [f64; 2], y: [f64; 2], c: f64) -> f64 {
    let corner = |x: f64, y: f64| {
        let (x, y) = (x / c, y / c);
        let (p, q) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
        (x / p * (y / p).atan() + y / q * (x / q).atan()) / TAU
    };
    corner(x[1], y[1]) - corner(x[0], y[1]) - corner(x[1], y[0]) + corner(x[0], y[0])
}

/// A point whose normal is parallel to a rectangle's plane, at distance c from it: the rectangle is a (from 0 or
/// beyond) along the normal, b across.
pub fn point_perpendicular(a: [f64; 2], b: [f64; 2], c: f64) -> f64 {
    let corner = |a: f64, b: f64| {
        let r = a.hypot(c);
        ((b / c).atan() - c / r * (b / r).atan()) / TAU
    };
    corner(a[1], b[1]) - corner(a[0], b[1]) - corner(a[1], b[0]) + corner(a[0], b[0])
}

/// A point against a flat polygon that it sees whole: corners counter-clockwise from the front, all above the point's
/// horizon (Lambert 1760). In a plane with the point there is nothing to see.
pub fn point_polygon(position: DVec3, normal: DVec3, corners: &[DVec3]) -> f64 {
    let facing = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    if facing.dot(position - corners[0]) <= 0.0 {
        return 0.0;
    }
    let edge = |k: usize| {
        // Seen from the front corners run the other way round.
        let (a, b) = (corners[(k + 1) % corners.len()] - position, corners[k] - position);
        let cross = a.cross(b);
        cross.length().atan2(a.dot(b)) * normal.dot(cross.normalize_or_zero())
    };
    (0..corners.len()).map(edge).sum::<f64>() / TAU
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_near(found: f64, wanted: f64) {
        assert!((found / wanted - 1.0).abs() < 4e-6, "{found}, {wanted} wanted");
    }

    const UNIT: [f64; 2] = [0.0, 1.0];

    #[test]
    fn rectangles_have_the_catalogues_values() {
        for (c, wanted) in [(0.1, 0.826_995), (1.0, 0.199_825), (10.0, 0.003_162_06)] {
            assert_near(opposed(1.0, 1.0, c), wanted);
            assert_near(parallel(UNIT, UNIT, UNIT, UNIT, c), wanted);
        }
        assert_near(perpendicular(UNIT, UNIT, UNIT, UNIT), 0.200_044);
    }

    #[test]
    fn rows_of_a_divided_cube_sum_to_one() {
        const N: usize = 8;
        let cell = |i: usize| [i as f64 / N as f64, (i + 1) as f64 / N as f64];
        let cells = || (0..N * N).map(|k| (cell(k % N), cell(k / N)));
        for (x, y) in cells() {
            let opposite: f64 = cells().map(|(xi, eta)| parallel(x, y, xi, eta, 1.0)).sum();
            let turned = |range: [f64; 2]| [1.0 - range[1], 1.0 - range[0]];
            let beside = |x: [f64; 2], y: [f64; 2]| -> f64 {
                cells().map(|(eta, xi)| perpendicular(x, y, eta, xi)).sum()
            };
            let sum = opposite + beside(x, y) + beside(turned(x), y) + beside(y, x) + beside(turned(y), x);
            assert!((sum - 1.0).abs() < 1e-12, "{sum}");
        }
    }

    #[test]
    fn discs_and_points_have_the_catalogues_values() {
        for (radii, wanted) in [
            ([1.0, 1.0, 1.0], 0.381_966),
            ([1.0, 2.0, 1.0], 0.763_932),
            ([1.0, 1.0, 0.1], 0.904_875),
            ([0.5, 1.0, 2.0], 0.192_236),
        ] {
            let [r1, r2, h] = radii;
            assert_near(discs(r1, r2, h), wanted);
        }
        assert_near(point_parallel(UNIT, UNIT, 1.0), 0.138_532);
        assert_near(point_parallel([-0.5, 0.5], [-0.5, 0.5], 1.0), 0.239_456);
        assert_near(point_perpendicular(UNIT, UNIT, 1.0), 0.055_734_2);
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, z]| DVec3::new(x, 1.0, z));
        assert_near(point_polygon(DVec3::ZERO, DVec3::Y, &square), 0.138_532);
        assert_eq!(point_polygon(DVec3::Y * 2.0, DVec3::NEG_Y, &square), 0.0);
    }
}
