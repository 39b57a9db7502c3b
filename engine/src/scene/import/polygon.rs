//! Polygons as triangles: a fan where the polygon is convex, else ears are cut off (Meisters 1975).

use glam::{DVec2, DVec3, Vec3};

/// Polygons with more corners are fanned whatever their shape: ears take time cubic in the corners.
const MOST_CORNERS: usize = 512;

/// Triangles as places in `corners`, wound as the polygon is. Fewer than three corners make none.
pub fn triangulated(corners: &[Vec3]) -> Vec<[usize; 3]> {
    let flat = flattened(corners);
    if corners.len() <= 3 || corners.len() > MOST_CORNERS || is_convex(&flat) {
        return (2..corners.len()).map(|n| [0, n - 1, n]).collect();
    }
    let mut left: Vec<usize> = (0..corners.len()).collect();
    let mut triangles = Vec::with_capacity(corners.len() - 2);
    while left.len() > 2 {
        // A polygon that crosses itself may have no ear: then any corner goes.
        let at = (0..left.len()).find(|&at| is_ear(&flat, &left, at)).unwrap_or(1);
        triangles.push(around(&left, at));
        left.remove(at);
    }
    triangles
}

/// In the polygon's plane (Newell's normal points at the viewer), counter-clockwise.
fn flattened(corners: &[Vec3]) -> Vec<DVec2> {
    let next = corners.iter().cycle().skip(1);
    let sides = corners.iter().zip(next).map(|(a, b)| (a.as_dvec3(), b.as_dvec3()));
    let normal: DVec3 =
        sides.map(|(a, b)| (a - corners[0].as_dvec3()).cross(b - corners[0].as_dvec3())).sum();
    let normal = normal.try_normalize().unwrap_or(DVec3::Z);
    let (right, up) = normal.any_orthonormal_pair();
    corners.iter().map(|corner| DVec2::new(right.dot(corner.as_dvec3()), up.dot(corner.as_dvec3()))).collect()
}

fn is_convex(flat: &[DVec2]) -> bool {
    let n = flat.len();
    (0..n).all(|at| turn(flat[(at + n - 1) % n], flat[at], flat[(at + 1) % n]) >= 0.0)
}

/// Twice the signed area.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

fn around(left: &[usize], at: usize) -> [usize; 3] {
    let n = left.len();
    [left[(at + n - 1) % n], left[at], left[(at + 1) % n]]
}

fn is_ear(flat: &[DVec2], left: &[usize], at: usize) -> bool {
    let [a, b, c] = around(left, at).map(|corner| flat[corner]);
    let holds = |p: DVec2| turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0;
    let others = left.iter().map(|&corner| flat[corner]).filter(|&p| p != a && p != b && p != c);
    turn(a, b, c) > 0.0 && !others.into_iter().any(holds)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_concave_polygon_keeps_its_area() {
        // An L, in a slanted plane.
        let l = [(0., 0.), (2., 0.), (2., 1.), (1., 1.), (1., 2.), (0., 2.)];
        for shift in 0..6 {
            let corners: Vec<Vec3> =
                (0..6).map(|n| l[(n + shift) % 6]).map(|(x, y)| Vec3::new(x, y, x + y)).collect();
            let triangles = triangulated(&corners);
            let area = |t: &[usize; 3]| {
                (corners[t[1]] - corners[t[0]])
                    .cross(corners[t[2]] - corners[t[0]])
                    .dot(Vec3::new(-1., -1., 1.))
                    / 6.0
            };
            assert_eq!(triangles.len(), 4);
            assert!(triangles.iter().all(|t| area(t) > 0.0), "{shift}");
            assert!((triangles.iter().map(area).sum::<f32>() - 3.0).abs() < 1e-5);
        }
    }

    #[test]
    fn odd_polygons_do_no_harm() {
        for n in 0..3 {
            assert!(triangulated(&vec![Vec3::ONE; n]).is_empty());
        }
        assert_eq!(triangulated(&[Vec3::ONE; 9]).len(), 7);
        assert_eq!(triangulated(&[Vec3::NAN; 9]).len(), 7);
        let bow = [(0., 0.), (1., 1.), (1., 0.), (0., 1.), (0.5, 3.0)].map(|(x, y)| Vec3::new(x, y, 0.));
        assert_eq!(triangulated(&bow).len(), 3);
    }
}
