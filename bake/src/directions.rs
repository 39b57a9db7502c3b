//! Where rays go: Owen-scrambled Sobol points, and the directions and places made of them.
//!
//! The first four dimensions of Sobol's sequence (direction numbers of Joe and Kuo 2008), scrambled as Owen
//! asks by a hash (Laine and Karras 2011, Burley 2020, Vegdahl's constants). The first two dimensions are the most
//! even ones: a power of two of points puts as many into each cell of any grid of that many cells.

use glam::{Vec2, Vec3};

/// Sobol's first `n` points in four dimensions, each as a 32-bit fraction with its bits reversed (that is how
/// the scrambling wants them).
pub struct Sobol {
    reversed: Vec<[u32; 4]>,
}

impl Sobol {
    pub fn new(n: u32) -> Self {
        let matrices = [
            direction_numbers(&[1], 0),
            direction_numbers(&[1], 1),
            direction_numbers(&[1, 3], 1),
            direction_numbers(&[1, 3, 1], 1),
        ];
        let mut reversed = Vec::with_capacity(n as usize);
        for i in 0..n {
            let mut point = [i.reverse_bits(), 0, 0, 0];
            for dimension in 1..4 {
                let bits = (0..32).filter(|bit| i >> bit & 1 == 1);
                point[dimension] = bits.fold(0, |x, bit| x ^ matrices[dimension][bit]);
            }
            reversed.push(point.map(u32::reverse_bits));
        }
        Self { reversed }
    }

    /// Point i, scrambled by a seed: four numbers in 0..1.
    pub fn point(&self, i: u32, seed: u64) -> [f32; 4] {
        let seeds = [hash(seed), hash(seed ^ 0x5bd1), hash(seed ^ 0x9e37), hash(seed ^ 0x7f4a)];
        let reversed = self.reversed[i as usize];
        std::array::from_fn(|d| unit(scramble(reversed[d], seeds[d] as u32)))
    }
}

/// Of a primitive polynomial of degree m.len() with middle coefficients `a`: v_k = m_k << (32 - k).
fn direction_numbers(m: &[u32], a: u32) -> [u32; 32] {
    let s = m.len();
    let mut v = [0_u32; 32];
    for k in 0..32 {
        v[k] = if k < s {
            m[k] << (31 - k)
        } else {
            let terms = (1..s).filter(|j| a >> (s - 1 - j) & 1 == 1);
            terms.fold(v[k - s] ^ (v[k - s] >> s), |x, j| x ^ v[k - j])
        };
    }
    v
}

/// Owen's nested scrambling of a reversed fraction; the result is in the usual order of bits.
fn scramble(reversed: u32, seed: u32) -> u32 {
    let mut x = reversed;
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    x.reverse_bits()
}

/// 0 <= result < 1.
pub fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// A well-mixed hash of 64 bits (the finaliser of splitmix64).
pub fn hash(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

pub fn hash_of(words: impl IntoIterator<Item = u64>) -> u64 {
    words.into_iter().fold(0x243f_6a88_85a3_08d3, |h, word| hash(h ^ word))
}

/// Cosine-distributed about +Z (Shirley and Chiu's concentric map, which keeps the points' evenness).
pub fn cosine_direction(u: f32, v: f32) -> Vec3 {
    let disk = concentric_disk(u, v);
    Vec3::new(disk.x, disk.y, (1.0 - disk.length_squared()).max(1e-8).sqrt())
}

fn concentric_disk(u: f32, v: f32) -> Vec2 {
    let (a, b) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    if a == 0.0 && b == 0.0 {
        return Vec2::ZERO;
    }
    let quarter = std::f32::consts::FRAC_PI_4;
    let (r, angle) =
        if a.abs() > b.abs() { (a, quarter * (b / a)) } else { (b, 2.0 * quarter - quarter * (a / b)) };
    Vec2::from_angle(angle) * r
}

/// Uniform over the half space of +Z.
pub fn hemisphere_direction(u: f32, v: f32) -> Vec3 {
    let z = u.max(1e-4);
    (Vec2::from_angle(std::f32::consts::TAU * v) * (1.0 - z * z).sqrt()).extend(z)
}

/// Uniform over all directions.
pub fn sphere_direction(u: f32, v: f32) -> Vec3 {
    let z = 1.0 - 2.0 * u;
    (Vec2::from_angle(std::f32::consts::TAU * v) * (1.0 - z * z).max(0.0).sqrt()).extend(z)
}

/// Uniform over a triangle: barycentric weights of its second and third corner (Heitz 2019, low distortion).
pub fn in_triangle(u: f32, v: f32) -> (f32, f32) {
    if v > u {
        let b = u * 0.5;
        (b, v - b)
    } else {
        let c = v * 0.5;
        (u - c, c)
    }
}

/// Two unit vectors that make a right-handed frame with a unit normal (Duff et al. 2017).
pub fn frame(n: Vec3) -> (Vec3, Vec3) {
    let sign = 1.0_f32.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    (Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), Vec3::new(b, sign + n.y * n.y * a, -n.y))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_two_dimensions_are_a_net_and_no_pair_clumps() {
        let sobol = Sobol::new(256);
        for (a, b, most) in [(0, 1, 1), (1, 2, 4), (2, 3, 4)] {
            let mut cells = [0; 256];
            for i in 0..256 {
                let p = sobol.point(i, 99);
                cells[(p[a] * 16.0) as usize * 16 + (p[b] * 16.0) as usize] += 1;
            }
            assert!(cells.iter().all(|&count| count <= most), "{a},{b}: {cells:?}");
        }
        for d in 0..4 {
            let mut bins = [0; 256];
            (0..256).for_each(|i| bins[(sobol.point(i, 7)[d] * 256.0) as usize] += 1);
            assert!(bins.iter().all(|&count| count == 1), "dimension {d}");
        }
    }

    #[test]
    fn cosine_directions_have_the_mean_of_a_cosine() {
        let sobol = Sobol::new(4096);
        let mean =
            (0..4096).map(|i| sobol.point(i, 3)).map(|p| cosine_direction(p[0], p[1])).sum::<Vec3>() / 4096.0;
        assert!((mean - Vec3::new(0.0, 0.0, 2.0 / 3.0)).length() < 1e-3, "{mean}");
    }

    #[test]
    fn frames_are_orthonormal() {
        for n in [Vec3::Z, -Vec3::Z, Vec3::X, Vec3::new(0.6, 0.0, -0.8)] {
            let (x, y) = frame(n);
            assert!((x.cross(y) - n).length() < 1e-6);
        }
    }
}
