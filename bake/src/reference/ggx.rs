//! The GGX lobe in its own frame, f64: height-correlated Smith (Heitz 2014), drawn by visible normals (Heitz 2018).
//!
//! ```text
//! f = F D G2 / (4 nl nv)         D = a^2 / (pi (nh^2 (a^2 - 1) + 1)^2)
//! density of l = G1(v) D / (4 nv)
//! ```

use std::f64::consts::{PI, TAU};

use engine::transport::reflection::ggx;
use glam::DVec3;

/// Scale and bias of F0 under uniform light, as the player looks them up.
pub struct SplitSum {
    table: Vec<[f32; 2]>,
}

const TABLE: u32 = 64;

impl SplitSum {
    pub fn new() -> Self {
        Self { table: ggx::table(TABLE) }
    }

    /// Between the four nearest of the table.
    pub fn at(&self, cosine: f64, roughness: f64) -> [f64; 2] {
        let place = |x: f64| {
            let x = (x * f64::from(TABLE) - 0.5).clamp(0.0, f64::from(TABLE - 1));
            let low = (x as usize).min(TABLE as usize - 2);
            (low, x - low as f64)
        };
        let ((i, s), (j, t)) = (place(cosine), place(roughness));
        let texel = |i: usize, j: usize, k: usize| f64::from(self.table[j * TABLE as usize + i][k]);
        [0, 1].map(|k| {
            let row = |j: usize| texel(i, j, k) * (1.0 - s) + texel(i + 1, j, k) * s;
            row(j) * (1.0 - t) + row(j + 1) * t
        })
    }
}

/// D G2 / (4 nl nv) of unit directions about +Z, alpha = roughness^2.
pub fn lobe(view: DVec3, light: DVec3, alpha: f64) -> f64 {
    let half = (view + light).normalize_or_zero();
    let a = alpha * alpha;
    let from_view = light.z * (view.z * view.z * (1.0 - a) + a).sqrt();
    let from_light = view.z * (light.z * light.z * (1.0 - a) + a).sqrt();
    distribution(half.z, alpha) * 0.5 / (from_view + from_light)
}

/// With which [`draw`] finds a light direction, per solid angle.
pub fn density(view: DVec3, light: DVec3, alpha: f64) -> f64 {
    let half = (view + light).normalize_or_zero();
    let a = alpha * alpha;
    let g1_over_nv = 2.0 / (view.z + (a + (1.0 - a) * view.z * view.z).sqrt());
    0.25 * g1_over_nv * distribution(half.z, alpha)
}

fn distribution(nh: f64, alpha: f64) -> f64 {
    let a = alpha * alpha;
    // 1 - nh^2 without losing its digits to the 1.
    let spread = a * nh * nh + (1.0 - nh) * (1.0 + nh);
    a / (PI * spread * spread)
}

/// A direction that the lobe mirrors to the view; it may lie below the surface.
pub fn draw(view: DVec3, alpha: f64, u: f64, v: f64) -> DVec3 {
    let stretched = DVec3::new(alpha * view.x, alpha * view.y, view.z).normalize();
    let x = DVec3::new(-stretched.y, stretched.x, 0.0).normalize_or(DVec3::X);
    let y = stretched.cross(x);
    // A disc, its lower half pressed into what of the half sphere is seen.
    let (radius, angle) = (u.sqrt(), TAU * v);
    let p = radius * angle.cos();
    let s = 0.5 * (1.0 + stretched.z);
    let q = (1.0 - s) * (1.0 - p * p).max(0.0).sqrt() + s * radius * angle.sin();
    let normal = x * p + y * q + stretched * (1.0 - p * p - q * q).max(0.0).sqrt();
    let half = DVec3::new(alpha * normal.x, alpha * normal.y, normal.z.max(1e-12)).normalize();
    half * (2.0 * view.dot(half)) - view
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::directions::Sobol;

    #[test]
    fn what_is_drawn_has_the_density_that_is_told_and_the_tables_albedo() {
        let table = SplitSum::new();
        let sobol = Sobol::new(1 << 14);
        for roughness in [0.2_f64, 0.5, 0.8, 0.95] {
            for cosine in [0.2_f64, 0.6, 1.0] {
                let view = DVec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
                let alpha = roughness * roughness;
                let (mut albedo, mut solid_angle) = (0.0, 0.0);
                for i in 0..1 << 14 {
                    let [u, v, ..] = sobol.point(i, 5);
                    let light = draw(view, alpha, f64::from(u), f64::from(v));
                    if light.z > 0.0 {
                        let density = density(view, light, alpha);
                        albedo += lobe(view, light, alpha) * light.z / density;
                        solid_angle += (light.z * light.z) / density;
                    }
                }
                let count = f64::from(1 << 14);
                let [scale, bias] = table.at(cosine, roughness);
                assert!((albedo / count - scale - bias).abs() < 5e-3, "{roughness} {cosine}: {albedo}");
                // Int cos^2 over the half sphere; narrow lobes hardly see its rim.
                if roughness >= 0.8 {
                    assert!((solid_angle / count / (TAU / 3.0) - 1.0).abs() < 0.05, "{solid_angle}");
                }
            }
        }
    }
}
