//! A cubemap on the CPU: six square faces with all smaller levels, read like a GPU reads it.
//!
//! Faces +x -x +y -y +z -z, rows from the top; s goes right and t down in a face:
//! ```text
//! face   +x  -x  +y  -y  +z  -z
//! s      -z  +z  +x  +x  +x  -x
//! t      -y  -y  +z  -z  -y  -y
//! ```

use glam::{Vec3, Vec4};

use crate::transport::sh;

/// Along the face's middle, to its right and to its top.
pub const FACES: [[Vec3; 3]; 6] = [
    [Vec3::X, Vec3::NEG_Z, Vec3::Y],
    [Vec3::NEG_X, Vec3::Z, Vec3::Y],
    [Vec3::Y, Vec3::X, Vec3::NEG_Z],
    [Vec3::NEG_Y, Vec3::X, Vec3::Z],
    [Vec3::Z, Vec3::X, Vec3::Y],
    [Vec3::NEG_Z, Vec3::NEG_X, Vec3::Y],
];

/// Radiance by level, face, row and column.
#[derive(Clone, Debug, PartialEq)]
pub struct Cube {
    levels: Vec<Level>,
}

#[derive(Clone, Debug, PartialEq)]
struct Level {
    size: usize,
    texels: Vec<Vec3>,
}

/// The direction through a point of a face, s and t in -1 .. 1, t downwards; not unit.
pub fn direction(face: usize, s: f32, t: f32) -> Vec3 {
    let [forward, right, up] = FACES[face];
    forward + right * s - up * t
}

/// The face that a direction meets, and where. What is no direction meets the middle of a face.
pub fn face_of(direction: Vec3) -> (usize, f32, f32) {
    let direction = if direction.is_finite() && direction != Vec3::ZERO { direction } else { Vec3::X };
    let size = direction.abs();
    let face = if size.x >= size.y && size.x >= size.z {
        usize::from(direction.x < 0.0)
    } else if size.y >= size.z {
        2 + usize::from(direction.y < 0.0)
    } else {
        4 + usize::from(direction.z < 0.0)
    };
    let [forward, right, up] = FACES[face];
    let depth = forward.dot(direction);
    (face, right.dot(direction) / depth, -up.dot(direction) / depth)
}

impl Cube {
    /// Of texels in the order of face, row, column; `size` is a power of two. Each smaller level is the mean of
    /// four texels.
    pub fn new(size: usize, texels: Vec<Vec3>) -> Self {
        assert!(size.is_power_of_two() && texels.len() == 6 * size * size);
        let mut levels = vec![Level { size, texels }];
        while let Some(last) = levels.last().filter(|level| level.size > 1) {
            levels.push(last.halved());
        }
        Self { levels }
    }

    pub fn size(&self) -> usize {
        self.levels[0].size
    }

    /// Of the largest level.
    pub fn texels(&self) -> &[Vec3] {
        &self.levels[0].texels
    }

    /// Trilinear, without seams between faces.
    pub fn sample(&self, direction: Vec3, level: f32) -> Vec3 {
        let level = if level.is_nan() { 0.0 } else { level.clamp(0.0, (self.levels.len() - 1) as f32) };
        let low = level.floor() as usize;
        let high = (low + 1).min(self.levels.len() - 1);
        self.levels[low].sample(direction).lerp(self.levels[high].sample(direction), level - low as f32)
    }

    /// Blurred with directions about the mirrored one ([`super::ggx::samples`]).
    pub fn blurred(&self, direction: Vec3, samples: &[Vec4]) -> Vec3 {
        let normal = direction.normalize_or(Vec3::Y);
        let up = if normal.y.abs() < 0.9 { Vec3::Y } else { Vec3::X };
        let tangent = up.cross(normal).normalize();
        let bitangent = normal.cross(tangent);
        let mut sum = Vec3::ZERO;
        let mut weights = 0.0;
        for sample in samples {
            let way = tangent * sample.x + bitangent * sample.y + normal * sample.z;
            sum += self.sample(way, sample.w) * sample.z;
            weights += sample.z;
        }
        if weights > 0.0 { sum / weights } else { self.sample(normal, 0.0) }
    }

    /// Spherical harmonics of its radiance: a sum over the texels of the largest level up to `size`, each by its
    /// solid angle; these sum to 4 pi.
    pub fn harmonics(&self, size: usize) -> [Vec3; sh::COEFFICIENTS] {
        let level = self.levels.iter().find(|level| level.size <= size).unwrap_or(&self.levels[0]);
        let mut coefficients = [Vec3::ZERO; sh::COEFFICIENTS];
        let mut all = 0.0;
        for (index, radiance) in level.texels.iter().enumerate() {
            let (s, t, face) = level.place(index);
            let way = direction(face, s, t);
            let solid_angle = way.length_squared().powf(-1.5);
            all += solid_angle;
            for (coefficient, basis) in coefficients.iter_mut().zip(sh::basis(way.normalize())) {
                *coefficient += *radiance * (basis * solid_angle);
            }
        }
        coefficients.map(|coefficient| coefficient * (4.0 * std::f32::consts::PI / all))
    }
}

impl Level {
    /// s, t and the face of the middle of a texel.
    fn place(&self, index: usize) -> (f32, f32, usize) {
        let (face, at) = (index / (self.size * self.size), index % (self.size * self.size));
        let middle = |i: usize| (i as f32 + 0.5) / self.size as f32 * 2.0 - 1.0;
        (middle(at % self.size), middle(at / self.size), face)
    }

    fn halved(&self) -> Self {
        let size = self.size / 2;
        let texel = |k: usize| {
            let (face, y, x) = (k / (size * size), k / size % size, k % size);
            let at = |x: usize, y: usize| self.texels[(face * self.size + y) * self.size + x];
            (at(2 * x, 2 * y) + at(2 * x + 1, 2 * y) + at(2 * x, 2 * y + 1) + at(2 * x + 1, 2 * y + 1)) * 0.25
        };
        Self { size, texels: (0..6 * size * size).map(texel).collect() }
    }

    fn sample(&self, way: Vec3) -> Vec3 {
        let (face, s, t) = face_of(way);
        let x = (s * 0.5 + 0.5) * self.size as f32 - 0.5;
        let y = (t * 0.5 + 0.5) * self.size as f32 - 0.5;
        let (x0, y0) = (x.floor(), y.floor());
        let row = |y: f32| self.texel(face, x0, y).lerp(self.texel(face, x0 + 1.0, y), x - x0);
        row(y0).lerp(row(y0 + 1.0), y - y0)
    }

    /// A texel beyond a face's edge is the one of the next face that lies there.
    fn texel(&self, face: usize, x: f32, y: f32) -> Vec3 {
        let size = self.size as f32;
        let (mut face, mut x, mut y) = (face, x, y);
        if x < 0.0 || y < 0.0 || x >= size || y >= size {
            let middle = |i: f32| (i + 0.5) / size * 2.0 - 1.0;
            let (next, s, t) = face_of(direction(face, middle(x), middle(y)));
            let index = |s: f32| ((s * 0.5 + 0.5) * size).floor().clamp(0.0, size - 1.0);
            (face, x, y) = (next, index(s), index(t));
        }
        self.texels[(face * self.size + y as usize) * self.size + x as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_go_there_and_back() {
        for face in 0..6 {
            for (s, t) in [(0.0, 0.0), (0.7, -0.2), (-0.9, 0.95)] {
                let (found, u, v) = face_of(direction(face, s, t));
                assert_eq!(found, face);
                assert!((u - s).abs() < 1e-6 && (v - t).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn a_constant_cube_is_constant_everywhere() {
        let cube = Cube::new(16, vec![Vec3::new(1.0, 2.0, 3.0); 6 * 256]);
        for roughness in [0.0, 0.3, 1.0] {
            let samples = super::super::ggx::samples(roughness, 32, 16);
            let blurred = cube.blurred(Vec3::new(0.3, -0.8, 0.5), &samples);
            assert!(blurred.abs_diff_eq(Vec3::new(1.0, 2.0, 3.0), 1e-5));
        }
        let harmonics = cube.harmonics(8);
        assert!((harmonics[0].x - 2.0 * std::f32::consts::PI.sqrt()).abs() < 1e-4);
        assert!(harmonics[1..].iter().all(|band| band.abs().max_element() < 1e-3));
    }

    #[test]
    fn a_linear_field_has_its_own_harmonics_and_no_seams() {
        let size = 32;
        let level = Level { size, texels: vec![Vec3::ZERO; 6 * size * size] };
        let field = |way: Vec3| Vec3::splat(1.0 + 0.5 * way.normalize().y);
        let texels = (0..6 * size * size)
            .map(|index| {
                let (s, t, face) = level.place(index);
                field(direction(face, s, t))
            })
            .collect();
        let cube = Cube::new(size, texels);
        // Across the edge from +x to +y.
        for i in -20..=20 {
            let way = Vec3::new(1.0, 1.0 + 0.004 * i as f32, 0.13);
            assert!((cube.sample(way, 0.0) - field(way)).abs().max_element() < 4e-3);
        }
        let harmonics = cube.harmonics(size);
        let wanted = 0.5 / 0.488_602_5;
        assert!((harmonics[1].x - wanted).abs() < 2e-3 * wanted, "{}", harmonics[1].x);
    }
}
