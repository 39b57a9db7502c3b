//! A matrix as translation, rotation and scale, or as two such where it is sheared.
//!
//! A = R1 S R2 exists for every A: one-sided Jacobi turns A's columns about R2 until they are
//! orthogonal, A R2^T = R1 S, whose columns are R1's times the scales.

use glam::{DMat3, DMat4, DQuat, DVec3};

use crate::scene::Transform;

/// Columns of glTF matrices are orthogonal up to the rounding of f32.
const ORTHOGONAL: f64 = 1e-5;

/// `parent_from_local`, and for a sheared matrix the rotation that comes before it:
/// matrix = first.parent_from_local * second.
pub fn decomposed(matrix: DMat4) -> (Transform, Option<DQuat>) {
    let linear = DMat3::from_mat4(matrix);
    let translation = matrix.w_axis.truncate();
    if is_orthogonal(linear) {
        return (rotation_and_scale(linear, translation), None);
    }
    let (turned, before) = orthogonalised(linear);
    (rotation_and_scale(turned, translation), Some(DQuat::from_mat3(&before).normalize()))
}

fn is_orthogonal(m: DMat3) -> bool {
    let apart = |a: DVec3, b: DVec3| a.dot(b).abs() <= ORTHOGONAL * a.length() * b.length();
    apart(m.x_axis, m.y_axis) && apart(m.y_axis, m.z_axis) && apart(m.z_axis, m.x_axis)
}

/// Of a matrix with orthogonal columns. A mirror is a negative scale in x; a column of no length gets an
/// axis that completes the others.
fn rotation_and_scale(m: DMat3, translation: DVec3) -> Transform {
    let mut scale = DVec3::new(m.x_axis.length(), m.y_axis.length(), m.z_axis.length());
    let mut axes = [0, 1, 2].map(|n| m.col(n).try_normalize());
    if m.determinant() < 0.0 {
        scale.x = -scale.x;
        axes[0] = axes[0].map(|axis| -axis);
    }
    let [x, y, z] = completed(axes);
    Transform { translation, rotation: DQuat::from_mat3(&DMat3::from_cols(x, y, z)).normalize(), scale }
}

fn completed(axes: [Option<DVec3>; 3]) -> [DVec3; 3] {
    match axes {
        [Some(x), Some(y), _] => [x, y, x.cross(y).normalize()],
        [Some(x), None, Some(z)] => [x, z.cross(x).normalize(), z],
        [None, Some(y), Some(z)] => [y.cross(z).normalize(), y, z],
        [Some(x), None, None] => {
            let y = x.any_orthonormal_vector();
            [x, y, x.cross(y)]
        }
        [None, Some(y), None] => {
            let z = y.any_orthonormal_vector();
            [y.cross(z), y, z]
        }
        [None, None, Some(z)] => {
            let x = z.any_orthonormal_vector();
            [x, z.cross(x), z]
        }
        [None, None, None] => [DVec3::X, DVec3::Y, DVec3::Z],
    }
}

/// (B, R) with orthogonal columns in B and m = B R.
fn orthogonalised(m: DMat3) -> (DMat3, DMat3) {
    let mut b = m.to_cols_array_2d().map(DVec3::from);
    let mut v = DMat3::IDENTITY.to_cols_array_2d().map(DVec3::from);
    for _ in 0..32 {
        for (p, q) in [(0, 1), (1, 2), (0, 2)] {
            let Some((cos, sin)) = jacobi(b[p], b[q]) else { continue };
            for columns in [&mut b, &mut v] {
                let (at_p, at_q) = (columns[p], columns[q]);
                columns[p] = cos * at_p - sin * at_q;
                columns[q] = sin * at_p + cos * at_q;
            }
        }
    }
    let v = DMat3::from_cols(v[0], v[1], v[2]);
    (DMat3::from_cols(b[0], b[1], b[2]), v.transpose())
}

/// The plane rotation that makes two columns orthogonal (Hestenes 1958), if they are not yet.
fn jacobi(p: DVec3, q: DVec3) -> Option<(f64, f64)> {
    let dot = p.dot(q);
    if dot.abs() <= 1e-16 * p.length() * q.length() {
        return None;
    }
    let zeta = (q.length_squared() - p.length_squared()) / (2.0 * dot);
    let tan = 1f64.copysign(zeta) / (zeta.abs() + zeta.hypot(1.0));
    let cos = 1.0 / tan.hypot(1.0);
    Some((cos, cos * tan))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn composed((first, second): (Transform, Option<DQuat>)) -> DMat4 {
        DMat4::from(first.parent_from_local()) * DMat4::from_quat(second.unwrap_or(DQuat::IDENTITY))
    }

    #[test]
    fn every_matrix_is_what_it_decomposes_into() {
        let turn = DMat4::from_quat(DQuat::from_xyzw(0.1, -0.7, 0.3, 0.4).normalize());
        let shear = DMat4::from_cols_array_2d(&[
            [1.0, 0.2, 0.0, 0.0],
            [0.5, 2.0, 0.1, 0.0],
            [-3.0, 0.0, 0.5, 0.0],
            [4.0, 5.0, 6.0, 1.0],
        ]);
        let flat = DMat4::from_scale(DVec3::new(2.0, 0.0, 0.5));
        let mirror = DMat4::from_scale(DVec3::new(1.0, -2.0, 3.0));
        let nothing = DMat4::from_scale(DVec3::ZERO);
        for matrix in
            [turn, shear, turn * shear, flat * turn, turn * flat, mirror * turn, shear * mirror, nothing]
        {
            let found = decomposed(matrix);
            assert!(composed(found).abs_diff_eq(matrix, 1e-12), "{matrix} {found:?}");
        }
        assert!(decomposed(turn * mirror).1.is_none());
        assert!(decomposed(shear).1.is_some());
    }
}
