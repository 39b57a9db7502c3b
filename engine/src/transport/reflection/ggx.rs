//! The GGX lobe (Walter et al. 2007) for cubemaps: directions to blur them with, and how much of what is blurred
//! leaves a surface.

use std::f32::consts::PI;

use glam::{Vec3, Vec4};

/// Directions about +Z (view = normal = mirrored direction), each with the level of the cubemap that one direction
/// stands for; the weight of a direction is its z. Sampled by the visible half vectors of the lobe, on a Hammersley
/// set; the level follows from the solid angle of a sample over that of a texel (Krivanek and Colbert 2008):
/// ```text
/// level = max(0, log2(omega_sample / omega_texel) / 2 + 1)
/// omega_sample = 1 / (n D / 4)       omega_texel = 4 pi / (6 size^2)
/// ```
/// `roughness` is perceptual: alpha = roughness^2.
pub fn samples(roughness: f32, count: u32, size: u32) -> Vec<Vec4> {
    let alpha = (roughness * roughness).max(1e-4);
    let omega_texel = 4.0 * PI / (6.0 * (size * size) as f32);
    let sample = |i: u32| {
        let (u, v) = ((i as f32 + 0.5) / count as f32, radical_inverse(i));
        let cos_squared = (1.0 - u) / (1.0 + (alpha * alpha - 1.0) * u);
        let half = spherical(cos_squared.max(0.0).sqrt(), v);
        let light = half * (2.0 * half.z) - Vec3::Z;
        let spread = cos_squared * (alpha * alpha - 1.0) + 1.0;
        let distribution = alpha * alpha / (PI * spread * spread);
        let omega_sample = 4.0 / (count as f32 * distribution);
        light.extend((0.5 * (omega_sample / omega_texel).log2() + 1.0).max(0.0))
    };
    let kept: Vec<Vec4> = (0..count).map(sample).filter(|sample| sample.z > 0.0).collect();
    if roughness <= 0.0 || kept.is_empty() { vec![Vec4::new(0.0, 0.0, 1.0, 0.0)] } else { kept }
}

/// Van der Corput's sequence, base 2.
fn radical_inverse(i: u32) -> f32 {
    (f64::from(i.reverse_bits()) / 4_294_967_296.0) as f32
}

fn spherical(cos: f32, turn: f32) -> Vec3 {
    let (sin_turn, cos_turn) = (turn * 2.0 * PI).sin_cos();
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    Vec3::new(sin * cos_turn, sin * sin_turn, cos)
}

/// Scale and bias of F0 under uniform light (Karis 2013), for the cosine to the viewer and perceptual roughness:
/// a mean over visible half vectors with height-correlated masking (Heitz 2014).
pub fn split_sum(cosine: f32, roughness: f32) -> [f32; 2] {
    const COUNT: u32 = 256;
    let (cosine, roughness) = (cosine.clamp(0.0, 1.0), roughness.clamp(0.0, 1.0));
    let alpha = (roughness * roughness).max(1e-4);
    let view = Vec3::new((1.0 - cosine * cosine).max(0.0).sqrt(), 0.0, cosine);
    let [mut scale, mut bias] = [0.0_f64; 2];
    for i in 0..COUNT {
        let (u, v) = ((i as f32 + 0.5) / COUNT as f32, radical_inverse(i));
        let cos_squared = (1.0 - u) / (1.0 + (alpha * alpha - 1.0) * u);
        let half = spherical(cos_squared.max(0.0).sqrt(), v);
        let vh = view.dot(half);
        let nl = 2.0 * vh * half.z - view.z;
        if nl > 0.0 && vh > 0.0 && half.z > 0.0 {
            let share = 4.0 * masking(nl, cosine, alpha) * nl * vh / half.z;
            let fresnel = (1.0 - vh).powi(5);
            scale += f64::from((1.0 - fresnel) * share);
            bias += f64::from(fresnel * share);
        }
    }
    [scale, bias].map(|sum| (sum / f64::from(COUNT)) as f32)
}

/// Height-correlated Smith masking over 4 nl nv.
fn masking(nl: f32, nv: f32, alpha: f32) -> f32 {
    let a = alpha * alpha;
    let from_view = nl * (nv * nv * (1.0 - a) + a).sqrt();
    let from_light = nv * (nl * nl * (1.0 - a) + a).sqrt();
    0.5 / (from_view + from_light).max(1e-9)
}

/// [`split_sum`] at the middles of `size` x `size` cells: cosine across, roughness down.
pub fn table(size: u32) -> Vec<[f32; 2]> {
    let at = |i: u32| (i as f32 + 0.5) / size as f32;
    (0..size * size).map(|k| split_sum(at(k % size), at(k / size))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_perfect_mirror_gives_back_all_light() {
        for cosine in [0.05, 0.3, 0.7, 1.0] {
            let [scale, bias] = split_sum(cosine, 0.0);
            assert!((scale + bias - 1.0).abs() < 2e-3, "{cosine}: {scale} + {bias}");
            let schlick = (1.0 - cosine).powi(5);
            assert!((bias - schlick).abs() < 2e-3, "{cosine}: {bias}");
        }
    }

    #[test]
    fn nothing_gives_back_more_than_it_gets() {
        for [scale, bias] in table(16) {
            assert!(scale >= 0.0 && bias >= 0.0 && scale + bias <= 1.0 + 2e-3, "{scale} {bias}");
        }
    }

    #[test]
    fn the_lobe_widens_with_roughness_and_stays_above_the_surface() {
        let mean = |roughness| {
            let samples = samples(roughness, 64, 128);
            let weight: f32 = samples.iter().map(|sample| sample.z).sum();
            samples.iter().map(|sample| sample.z * sample.z).sum::<f32>() / weight
        };
        assert_eq!(samples(0.0, 64, 128), [Vec4::new(0.0, 0.0, 1.0, 0.0)]);
        assert!(mean(0.1) > mean(0.4) && mean(0.4) > mean(1.0) && mean(1.0) > 0.5);
        assert!(samples(0.5, 64, 128).iter().all(|sample| (sample.truncate().length() - 1.0).abs() < 1e-5));
    }
}
