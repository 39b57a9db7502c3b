//! Irradiance that is nowhere negative. Two bands of spherical harmonics about a small bright patch ring: on the far
//! side their irradiance falls below 0. Windowing takes that away (Sloan, "Stupid spherical harmonics (SH) tricks",
//! GDC 2008):
//! ```text
//! L_l *= 1 / (1 + lambda l^2 (l + 1)^2)
//! ```
//! with the smallest lambda for which the least irradiance is not negative, channel by channel. The mean stays.
//!
//! With a the mean, b the vector of band 1 and Q the matrix of band 2, E(n) = a + b.n + n.Qn. Its least value over all
//! directions is known exactly by duality, as that of any quadratic form on a sphere: in the axes of Q, with q_0 the
//! least of its eigenvalues,
//! ```text
//! min E = max over nu > 0 of   a + q_0 - nu - Sum (b_i / 2)^2 / (q_i - q_0 + nu)
//! ```
//! and every nu gives a lower bound, so that rounding errs on the safe side.

use glam::Vec3;

use super::sh::{COEFFICIENTS, COSINE};

/// Halvings of an interval: as fine as f32.
const STEPS: u32 = 24;
/// How far above 0 the least irradiance is held, of the mean.
const MARGIN: f32 = 1e-6;

/// Windows nine coefficients of radiance.
pub fn dering(l: &mut [Vec3; COEFFICIENTS]) {
    for channel in 0..3 {
        let [one, two] = window(&l.map(|l| l[channel]));
        if l.iter().any(|l| !l[channel].is_finite()) {
            l.iter_mut().for_each(|l| l[channel] = 0.0); // no light that anybody knows
            continue;
        }
        l[1..4].iter_mut().for_each(|l| l[channel] *= one);
        l[4..].iter_mut().for_each(|l| l[channel] *= two);
    }
}

/// E(n) of one channel as shares of its mean, in the axes of Q.
#[derive(Clone, Copy, Debug)]
struct Form {
    b: [f32; 3],
    q: [f32; 3],
}

/// What is left of bands 1 and 2.
fn window(l: &[f32; COEFFICIENTS]) -> [f32; 2] {
    if l[0] <= 0.0 {
        return [0.0; 2];
    }
    let form = Form::new(l);
    if !form.b.iter().chain(&form.q).all(|part| part.is_finite() && part.abs() < 1e15) {
        return [0.0; 2]; // beside the others the mean is nothing
    }
    let kept = |w: f32| [w / (w + 4.0 * (1.0 - w)), w / (w + 36.0 * (1.0 - w))];
    if form.least(kept(1.0)) >= MARGIN {
        return [1.0; 2];
    }
    // w = 1 / (1 + lambda)
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..STEPS {
        let middle = 0.5 * (low + high);
        if form.least(kept(middle)) >= MARGIN { low = middle } else { high = middle }
    }
    kept(low)
}

impl Form {
    fn new(l: &[f32; COEFFICIENTS]) -> Self {
        let mean = COSINE[0] * 0.282_094_8 * l[0];
        let band_1 = COSINE[1] * 0.488_602_5 / mean;
        let mixed = COSINE[4] * 0.546_274_2 / mean;
        let axial = COSINE[4] * 0.315_391_57 * l[6] / mean;
        let b = [l[3], l[1], l[2]].map(|l| l * band_1);
        let (xy, yz, xz) = (l[4] * mixed, l[5] * mixed, l[7] * mixed);
        let diagonal = [l[8] * mixed - axial, -l[8] * mixed - axial, 2.0 * axial];
        diagonalised([[diagonal[0], xy, xz], [xy, diagonal[1], yz], [xz, yz, diagonal[2]]], b)
    }

    /// The least value, with these shares of bands 1 and 2.
    fn least(&self, [one, two]: [f32; 2]) -> f32 {
        let lowest = self.q[0].min(self.q[1]).min(self.q[2]);
        let above = self.q.map(|q| two * (q - lowest));
        let pull = self.b.map(|b| (0.5 * one * b) * (0.5 * one * b));
        let (mut low, mut high) = (0.0, (pull[0] + pull[1] + pull[2]).sqrt());
        if high <= 0.0 {
            return 1.0 + two * lowest;
        }
        for _ in 0..STEPS {
            let middle: f32 = 0.5 * (low + high);
            let slope: f32 = (0..3).map(|i| pull[i] / ((above[i] + middle) * (above[i] + middle))).sum();
            if slope > 1.0 { low = middle } else { high = middle }
        }
        1.0 + two * lowest - high - (0..3).map(|i| pull[i] / (above[i] + high)).sum::<f32>()
    }
}

/// Jacobi's rotations: the matrix becomes diagonal, the vector turns with it.
fn diagonalised(mut m: [[f32; 3]; 3], mut b: [f32; 3]) -> Form {
    for _ in 0..5 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let off = m[p][q];
            if off.abs() < 1e-9 {
                continue;
            }
            let ratio = (m[q][q] - m[p][p]) / (2.0 * off);
            let t = (if ratio < 0.0 { -1.0 } else { 1.0 }) / (ratio.abs() + (ratio * ratio + 1.0).sqrt());
            let c = 1.0 / (t * t + 1.0).sqrt();
            let s = t * c;
            m[p][p] -= t * off;
            m[q][q] += t * off;
            (m[p][q], m[q][p]) = (0.0, 0.0);
            let r = 3 - p - q;
            let (rp, rq) = (c * m[r][p] - s * m[r][q], s * m[r][p] + c * m[r][q]);
            (m[r][p], m[p][r], m[r][q], m[q][r]) = (rp, rp, rq, rq);
            (b[p], b[q]) = (c * b[p] - s * b[q], s * b[p] + c * b[q]);
        }
    }
    Form { b, q: [m[0][0], m[1][1], m[2][2]] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transport::sh::basis;
    use glam::Vec3Swizzles;

    fn directions(n: u32) -> impl Iterator<Item = Vec3> {
        let golden = std::f32::consts::PI * (3.0 - 5.0_f32.sqrt());
        (0..n).map(move |k| {
            let z = 1.0 - (2 * k + 1) as f32 / n as f32;
            let r = (1.0 - z * z).sqrt();
            Vec3::new(r * (golden * k as f32).cos(), r * (golden * k as f32).sin(), z)
        })
    }

    /// Without the clamp that shaders have.
    fn irradiance(l: &[Vec3; COEFFICIENTS], n: Vec3) -> Vec3 {
        let y = basis(n);
        (0..COEFFICIENTS).map(|i| l[i] * (COSINE[i] * y[i])).sum()
    }

    fn light_from(sources: &[(Vec3, Vec3)]) -> [Vec3; COEFFICIENTS] {
        std::array::from_fn(|i| sources.iter().map(|(way, light)| *light * basis(way.normalize())[i]).sum())
    }

    /// Numerics case 51.
    #[test]
    fn a_tiny_bright_patch_lights_nothing_negatively_and_keeps_its_mean() {
        for (k, way) in directions(40).enumerate() {
            let other = Vec3::new(0.3, -0.8, 0.1 * k as f32 - 2.0);
            let mut l = light_from(&[(way, Vec3::new(5.0, 0.5, 1e-3)), (other, Vec3::new(0.0, 1.0, 2e-3))]);
            let before = l;
            assert!(directions(642).any(|n| irradiance(&before, n).min_element() < 0.0));
            dering(&mut l);
            assert_eq!(l[0], before[0]);
            for channel in 0..3 {
                let of = |n: Vec3| irradiance(&l, n)[channel] / (COSINE[0] * 0.282_094_8 * l[0][channel]);
                let least = directions(642).map(of).fold(f32::INFINITY, f32::min);
                assert!(least >= -1e-6, "{way} {channel}: {least}");
                // No more than is needed.
                let windowed = l[1][channel] != before[1][channel];
                let exact = directions(20_000).map(of).fold(f32::INFINITY, f32::min);
                assert!(!windowed || exact < 2e-3, "{way} {channel}: {exact}");
            }
        }
    }

    #[test]
    fn light_that_does_not_ring_stays_as_it_is() {
        let mut l = light_from(&[(Vec3::Y, Vec3::ONE)]);
        l[0] *= 8.0;
        let before = l;
        dering(&mut l);
        assert_eq!(l, before);
        let mut dark = [Vec3::ZERO; COEFFICIENTS];
        dering(&mut dark);
        assert_eq!(dark, [Vec3::ZERO; COEFFICIENTS]);
    }

    #[test]
    fn the_least_value_is_that_of_a_search() {
        for (k, way) in directions(30).enumerate() {
            let other = (way.yzx() * Vec3::new(1.0, -0.4, 0.03 * k as f32), Vec3::splat(0.7));
            let l = light_from(&[(way, Vec3::ONE), other]).map(|l| l.x);
            let form = Form::new(&l);
            let y = |n: Vec3| (0..COEFFICIENTS).map(|i| l[i] * COSINE[i] * basis(n)[i]).sum::<f32>();
            let mean = COSINE[0] * 0.282_094_8 * l[0];
            let searched = directions(50_000).map(y).fold(f32::INFINITY, f32::min) / mean;
            let found = form.least([1.0, 1.0]);
            assert!(found <= searched + 1e-5 && found > searched - 2e-3, "{found} {searched}");
        }
    }
}
