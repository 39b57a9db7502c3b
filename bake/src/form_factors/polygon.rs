//! The form factor of two flat polygons that see all of each other, in closed form (f64).
//!
//! ```text
//! A_i F_ij = 1/(2 pi) Sum_e Sum_f (u_e . u_f) Int_e Int_f ln r dt ds       over edges e of i, f of j
//! ```
//! Stokes' theorem turns both areas into their outlines (Sparrow 1963); edges run counter-clockwise as seen from the
//! front, u are their unit directions. The inner integral is elementary; the outer one is Gauss's, on pieces that
//! shrink towards the ends of the other edge, where two polygons may touch and ln r has no derivative.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

pub type Edge = [DVec3; 2];

/// A_i F_ij in the square of the callers' unit.
pub fn exchange(of: &[Edge], with: &[Edge]) -> f64 {
    let pairs = of.iter().flat_map(|&outer| with.iter().map(move |&inner| edges(outer, inner)));
    (pairs.sum::<f64>() / TAU).max(0.0)
}

/// The same from points that stand for areas, for polygons that are far from each other.
pub fn exchange_by_points(of: &[(DVec3, f64)], with: &[(DVec3, f64)], normals: [DVec3; 2]) -> f64 {
    let mut sum = 0.0;
    for (from, area) in of {
        let mut arriving = 0.0;
        for (to, area) in with {
            let way = *to - *from;
            let r2 = way.length_squared();
            arriving += area * (normals[0].dot(way) * -normals[1].dot(way)).max(0.0) / (r2 * r2);
        }
        sum += area * arriving;
    }
    sum / PI
}

/// The part of a convex polygon on the front of a plane.
pub fn clip(polygon: &[DVec3], normal: DVec3, offset: f64) -> Vec<DVec3> {
    let height = |p: &DVec3| normal.dot(*p) - offset;
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (k, p) in polygon.iter().enumerate() {
        let q = &polygon[(k + 1) % polygon.len()];
        let (here, there) = (height(p), height(q));
        if here >= 0.0 {
            kept.push(*p);
        }
        if (here < 0.0) != (there < 0.0) {
            kept.push(p.lerp(*q, here / (here - there)));
        }
    }
    kept
}

pub fn edges_of(polygon: &[DVec3]) -> impl Iterator<Item = Edge> + '_ {
    (0..polygon.len()).map(|k| [polygon[k], polygon[(k + 1) % polygon.len()]])
}

/// Halvings of an outer edge towards where the edges meet.
const HALVINGS: u32 = 9;

/// (u_e . u_f) Int Int ln r of two edges.
fn edges([p, q]: Edge, inner: Edge) -> f64 {
    let (way, across) = (q - p, inner[1] - inner[0]);
    let product = way.length() * across.length();
    let cos = way.dot(across) / product;
    if product == 0.0 || cos.abs() < 1e-12 {
        return 0.0;
    }
    let inner = Inner::new(inner, p, way);
    cos * way.length() * inner.over(p, way, [0.0, 1.0], HALVINGS)
}

struct Inner {
    from: DVec3,
    to: DVec3,
    direction: DVec3,
    length: f64,
    /// Where the outer edge's line passes this one, in shares of the outer edge, and how near.
    passes: Option<(f64, f64)>,
}

impl Inner {
    fn new([from, to]: Edge, p: DVec3, way: DVec3) -> Self {
        let length = (to - from).length();
        let direction = (to - from) / length;
        let along = way.dot(direction);
        let square = way.length_squared();
        let sin2 = 1.0 - along * along / square;
        let passes = (sin2 > 1e-8).then(|| {
            let start = p - from;
            let s = (along * start.dot(direction) - way.dot(start)) / (square * sin2);
            let t = (start + way * s).dot(direction);
            let gap = (start + way * s - direction * t).length() / sin2.sqrt();
            (s, if t > 0.0 && t < length { gap } else { f64::INFINITY })
        });
        Self { from, to, direction, length, passes }
    }

    /// The mean over the outer edge's shares s of the inner integral, times their width.
    fn over(&self, p: DVec3, way: DVec3, [low, high]: [f64; 2], halvings: u32) -> f64 {
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        let at = p + way * middle;
        let reach = half * way.length();
        let pass = self.passes.map_or(f64::INFINITY, |(s, gap)| ((s - middle) * way.length()).abs().max(gap));
        let distance = at.distance(self.from).min(at.distance(self.to)).min(pass);
        if distance < 2.0 * reach && halvings > 0 {
            return self.over(p, way, [low, middle], halvings - 1)
                + self.over(p, way, [middle, high], halvings - 1);
        }
        let rule: &[[f64; 2]] = if distance < 5.0 * reach { &GAUSS_6 } else { &GAUSS_4 };
        let pair = |[x, weight]: [f64; 2]| {
            let step = way * (half * x);
            weight * (self.integral(at - step) + self.integral(at + step))
        };
        half * rule.iter().map(|&node| pair(node)).sum::<f64>()
    }

    /// Int ln |at - y| over the edge.
    fn integral(&self, at: DVec3) -> f64 {
        let start = self.from - at;
        let low = start.dot(self.direction);
        let high = low + self.length;
        let height = start.cross(self.direction).length();
        let h2 = height * height;
        let part = |x: f64| {
            let r2 = x * x + h2;
            if r2 > 0.0 { 0.5 * x * r2.ln() } else { 0.0 }
        };
        let angle = (height * self.length).atan2(h2 + low * high);
        part(high) - part(low) - self.length + if height > 0.0 { height * angle } else { 0.0 }
    }
}

/// Nodes above 0 and weights on -1..1.
const GAUSS_4: [[f64; 2]; 2] = [
    [0.339_981_043_584_856_26, 0.652_145_154_862_546_2],
    [0.861_136_311_594_052_6, 0.347_854_845_137_453_85],
];
const GAUSS_6: [[f64; 2]; 3] = [
    [0.238_619_186_083_196_9, 0.467_913_934_572_691],
    [0.661_209_386_466_264_5, 0.360_761_573_048_138_6],
    [0.932_469_514_203_152, 0.171_324_492_379_170_36],
];

#[cfg(test)]
mod tests {
    use super::*;

    fn rectangle(corner: DVec3, first: DVec3, second: DVec3) -> Vec<Edge> {
        edges_of(&[corner, corner + first, corner + first + second, corner + second]).collect()
    }

    fn factor(of: &[Edge], with: &[Edge], area: f64) -> f64 {
        exchange(of, with) / area
    }

    fn assert_near(found: f64, wanted: f64, tolerance: f64) {
        assert!((found - wanted).abs() <= tolerance, "{found}, not {wanted}");
    }

    #[test]
    fn parallel_rectangles_have_the_factor_of_the_closed_form() {
        // Howell's catalogue, C-11, to the digits of f64.
        let closed = |x: f64, y: f64| {
            let (a, b) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
            let log = (a * a * b * b / (1.0 + x * x + y * y)).sqrt().ln();
            2.0 / (PI * x * y)
                * (log + x * b * (x / b).atan() + y * a * (y / a).atan() - x * x.atan() - y * y.atan())
        };
        for (a, b, c) in
            [(1.0, 1.0, 1.0), (1.0, 1.0, 0.1), (1.0, 1.0, 0.01), (2.0, 1.0, 1.0), (1.0, 1.0, 10.0)]
        {
            let floor = rectangle(DVec3::ZERO, DVec3::Z * b, DVec3::X * a);
            let ceiling = rectangle(DVec3::Y * c, DVec3::X * a, DVec3::Z * b);
            assert_near(factor(&floor, &ceiling, a * b), closed(a / c, b / c), 1e-7);
        }
    }

    #[test]
    fn squares_with_a_common_edge_or_corner_have_the_factor_of_the_closed_form() {
        let floor = rectangle(DVec3::ZERO, DVec3::Z, DVec3::X);
        let wall = |corner: DVec3, height: f64| rectangle(corner, DVec3::Y * height, DVec3::Z);
        assert_near(factor(&floor, &wall(DVec3::ZERO, 1.0), 1.0), 0.200_044, 1e-6);
        assert_near(factor(&floor, &wall(DVec3::ZERO, 2.0), 1.0), 0.232_853, 1e-6);
        assert_near(factor(&floor, &wall(DVec3::ZERO, 0.5), 1.0), 0.146_187, 1e-6);
        assert_near(factor(&floor, &wall(DVec3::Z, 1.0), 1.0), 0.040_592_2, 1e-6);
        // Half of an edge in common: by symmetry half of a square with a wall twice as long.
        assert_near(factor(&floor, &wall(DVec3::Z * 0.5, 1.0), 1.0), half_an_edge(), 1e-6);
    }

    /// Ehlert and Smith's perpendicular rectangles: x, y on the floor, z, y on the wall.
    fn half_an_edge() -> f64 {
        let g = |r2: f64, b: f64| {
            let r = r2.sqrt();
            let log = if r2 + b * b > 0.0 { 0.25 * (r2 - b * b) * (r2 + b * b).ln() } else { 0.0 };
            let angle = if r > 0.0 { b * r * (b / r).atan() } else { 0.0 };
            (angle - log) / TAU
        };
        let mut sum = 0.0;
        for (i, x) in [0.0, 1.0].into_iter().enumerate() {
            for (j, y) in [0.0, 1.0].into_iter().enumerate() {
                for (k, eta) in [0.5, 1.5].into_iter().enumerate() {
                    for (l, z) in [0.0, 1.0].into_iter().enumerate() {
                        let sign = if (i + j + k + l) % 2 == 0 { 1.0 } else { -1.0 };
                        sum += sign * g(x * x + z * z, y - eta);
                    }
                }
            }
        }
        sum
    }

    #[test]
    fn hinged_squares_have_the_factor_of_graded_rules() {
        let floor = rectangle(DVec3::ZERO, DVec3::Z, DVec3::X);
        for (degrees, wanted, tolerance) in [
            (1.0_f64, 0.983_00, 1e-5),
            (30.0, 0.619_028, 1e-6),
            (60.0, 0.370_905, 1e-6),
            (90.0, 0.200_044, 1e-6),
            (120.0, 0.086_615, 1e-6),
            (150.0, 0.021_345_3, 1e-6),
        ] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let leaf = rectangle(DVec3::ZERO, DVec3::new(cos, sin, 0.0), DVec3::Z);
            assert_near(factor(&floor, &leaf, 1.0), wanted, tolerance);
        }
    }
}
