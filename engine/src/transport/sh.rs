//! Real orthonormal spherical harmonics to order 2, in the scene's axes (Y up), without the
//! Condon-Shortley sign: order (0,0), (1,-1), (1,0), (1,1), (2,-2) .. (2,2).

use glam::Vec3;

pub const COEFFICIENTS: usize = 9;

/// Y_lm of a unit direction.
pub fn basis(d: Vec3) -> [f32; COEFFICIENTS] {
    let Vec3 { x, y, z } = d;
    [
        0.282_094_8,
        0.488_602_5 * y,
        0.488_602_5 * z,
        0.488_602_5 * x,
        1.092_548_4 * x * y,
        1.092_548_4 * y * z,
        0.315_391_57 * (3.0 * z * z - 1.0),
        1.092_548_4 * x * z,
        0.546_274_2 * (x * x - y * y),
    ]
}

/// What the clamped cosine leaves of each band (Ramamoorthi and Hanrahan 2001): pi, 2 pi/3, pi/4.
pub const COSINE: [f32; COEFFICIENTS] = {
    use std::f32::consts::PI;
    let (a1, a2) = (2.0 * PI / 3.0, PI / 4.0);
    [PI, a1, a1, a1, a2, a2, a2, a2, a2]
};

/// Irradiance on a surface with this normal: sum of COSINE * L_lm * Y_lm(n).
pub fn irradiance(l: &[Vec3; COEFFICIENTS], normal: Vec3) -> Vec3 {
    let y = basis(normal);
    (0..COEFFICIENTS).map(|i| l[i] * (COSINE[i] * y[i])).sum()
}
