//! The slow plain twin: random rays, counted. No even points, no pooling of both directions, no closed form, no
//! balance.

use engine::transport::Rows;
use engine::transport::bvh::{Bvh, patch_of};
use glam::Vec3;
use rayon::prelude::*;

use super::{Faces, FormFactors, Solid};
use crate::BakeError;
use crate::directions::{cosine_direction, frame, hash, unit};

/// As [`super::of_faces`]; `seed` makes runs independent.
pub fn by_plain_rays(faces: &[[Vec3; 3]], rays: u32, seed: u64) -> Result<FormFactors, BakeError> {
    let scene = Faces::new(faces)?;
    let bvh = Bvh::new(&scene.rays.triangles, Vec::new());
    let n = scene.numbers.len();
    let traced: Vec<(Vec<(u32, f32)>, f64)> = (0..n)
        .into_par_iter()
        .map(|i| {
            let mut state = hash(seed ^ hash(i as u64));
            let mut counts = vec![0_u32; n];
            for _ in 0..rays {
                let (position, normal) = point_on(&scene.rays.triangles[i], random_pair(&mut state));
                let [u, v] = random_pair(&mut state);
                let local = cosine_direction(u, v);
                let (x, y) = frame(normal);
                let direction = x * local.x + y * local.y + normal * local.z;
                let hit = bvh.closest(position, normal, direction, 0.0, &Solid);
                if let Some(patch) = hit.and_then(|hit| patch_of(&hit, &scene.rays.patches)) {
                    counts[patch as usize] += 1;
                }
            }
            let found: u32 = counts.iter().sum();
            let share = |(j, &count): (usize, &u32)| (j as u32, count as f32 / rays as f32);
            let row = counts.iter().enumerate().filter(|(_, count)| **count > 0).map(share).collect();
            (row, 1.0 - f64::from(found) / f64::from(rays))
        })
        .collect();
    let mut rows = Rows::default();
    let mut lost = Vec::with_capacity(n);
    for (row, share) in traced {
        rows.push(row);
        lost.push(share);
    }
    Ok(scene.spread(&rows, &lost))
}

/// Uniform; the parallelogram's other half folded back.
fn point_on([a, b, c]: &[Vec3; 3], [u, v]: [f32; 2]) -> (Vec3, Vec3) {
    let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
    let (first, second) = (*b - *a, *c - *a);
    (*a + first * u + second * v, first.cross(second).normalize_or(Vec3::Y))
}

/// Two numbers in 0..1 (splitmix64).
fn random_pair(state: &mut u64) -> [f32; 2] {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let bits = hash(*state);
    [unit(bits as u32), unit((bits >> 32) as u32)]
}
