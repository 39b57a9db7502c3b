//! Sun cascades: what the camera sees is cut by depth into four slices, each with a shadow map of its own, so that
//! what is near has fine texels.
//!
//! ```text
//! z_i = s n (f/n)^(i/4) + (1 - s) (n + (f - n) i/4)       (practical split scheme, Zhang et al. 2006)
//! ```
//! n is where the first slice begins, f where the last one ends, s = 0.85. A slice's map covers the slice's bounding
//! sphere, whose size does not change when the camera turns, moved to whole texels: shadows do not swim. What lies
//! between a slice and the sun casts into it from any distance. Beyond the last slice the map of the whole scene
//! takes over; patches and reflection captures read that one alone.

use glam::{DVec3, Mat4, Vec3, Vec4};

use super::shadow_view::{BORDER, axes};
use super::view::{Eye, orthographic, view_from_world};
use crate::scene::Projection;

pub const CASCADES: usize = 4;
/// Where the whole scene's map is at least as fine as this [m], it needs no cascades.
const FINE: f32 = 0.01;
/// s of the split scheme.
const LOGARITHMIC: f32 = 0.85;
/// The first slice begins here, as a share of where the last one ends: a near plane at a few centimetres would
/// spend all slices on the first metre.
const NEAREST: f32 = 0.01;
/// The last slice's sphere, as a share of the scene's: larger ones are hardly finer than the scene's map.
const LARGEST: f32 = 0.7;
/// The share of a slice at its end in which it passes over into the next.
const BLEND: f32 = 0.1;

/// Where the camera's slices are, for every sun.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Slices {
    /// Depth at which each ends [m]; 0: there are none.
    pub ends: Vec4,
    /// Of the eye along its view direction: depth = dot(forward, position) - eye [m].
    pub eye: f32,
    spheres: [(Vec3, f32); CASCADES],
}

/// Whether suns over a scene of this radius [m], with `size` texels across the map of all of it, need cascades.
pub fn are_needed(radius: f32, size: u32) -> bool {
    2.0 * radius / size as f32 > FINE
}

impl Slices {
    /// Of what this camera sees of a scene of this radius [m].
    pub fn new(eye: &Eye, origin: DVec3, aspect: f32, radius: f32) -> Self {
        let [right, top] = eye.half(aspect);
        let frustum = Frustum {
            diagonal: right.hypot(top),
            parallel: matches!(eye.projection, Projection::Orthographic { .. }),
        };
        let near = eye.near.max(1e-6);
        let far = frustum.depth_of(LARGEST * radius).min(eye.far.unwrap_or(f32::INFINITY));
        let from = near.max(NEAREST * far);
        if !(far > from && far.is_finite()) {
            return Self::default();
        }
        let position = (eye.position - origin).as_vec3();
        let forward = -eye.axes()[2];
        let mut slices = Self { eye: forward.dot(position), ..Self::default() };
        let mut begin = near;
        for (k, end) in splits(from, far).into_iter().enumerate() {
            let (depth, sphere) = frustum.sphere(begin, end);
            slices.ends[k] = end;
            slices.spheres[k] = (position + forward * depth, sphere);
            begin = end - BLEND * (end - begin);
        }
        slices
    }

    /// Whether this camera has slices.
    pub fn any(&self) -> bool {
        self.ends.w > 0.0
    }

    /// Widths of the slices' texels [m] in maps of this size.
    pub fn texels(&self, size: u32) -> Vec4 {
        Vec4::from_array(self.spheres.map(|(_, radius)| texel(radius, size)))
    }

    /// What a sun's map of a slice looks at. Depth spans the whole scene, `fit`.
    pub fn clip_from_world(&self, slice: usize, direction: Vec3, fit: (Vec3, f32), size: u32) -> Mat4 {
        let (centre, radius) = self.spheres[slice];
        let texel = texel(radius, size);
        let half = texel * size as f32 * 0.5;
        let [right, up, back] = axes(direction);
        let snapped = |axis: Vec3| (axis.dot(centre) / texel).floor() * texel;
        let middle = right * snapped(right) + up * snapped(up) + back * (back.dot(fit.0) + fit.1);
        orthographic(half, half, 0.0, 2.0 * fit.1) * view_from_world(middle, [right, up, back])
    }
}

fn texel(radius: f32, size: u32) -> f32 {
    2.0 * radius / (size as f32 - 2.0 * (BORDER + 1.0))
}

/// z_1 .. z_4.
fn splits(near: f32, far: f32) -> [f32; CASCADES] {
    std::array::from_fn(|k| {
        let share = (k + 1) as f32 / CASCADES as f32;
        let logarithmic = near * (far / near).powf(share);
        LOGARITHMIC * logarithmic + (1.0 - LOGARITHMIC) * (near + (far - near) * share)
    })
}

struct Frustum {
    /// From the middle of the picture to its corner at distance 1; with parallel rays in metres.
    diagonal: f32,
    parallel: bool,
}

impl Frustum {
    /// Depth and radius of the smallest sphere on the view axis about the slice.
    fn sphere(&self, begin: f32, end: f32) -> (f32, f32) {
        if self.parallel {
            return ((begin + end) * 0.5, self.diagonal.hypot((end - begin) * 0.5));
        }
        let slope = self.diagonal * self.diagonal;
        let depth = ((begin + end) * 0.5 * (1.0 + slope)).min(end);
        (depth, (end - depth).hypot(end * self.diagonal))
    }

    /// How deep a slice can end that has a sphere of this radius at most.
    fn depth_of(&self, radius: f32) -> f32 {
        match (self.parallel, self.diagonal < radius) {
            (false, _) => radius / self.diagonal.max(0.5),
            (true, true) => (radius * radius - self.diagonal * self.diagonal).sqrt() * 2.0,
            (true, false) => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn eye(position: DVec3, at: DVec3) -> Eye {
        Eye::looking(position, at)
    }

    #[test]
    fn slices_follow_on_each_other_and_grow() {
        let slices = Slices::new(&eye(DVec3::ZERO, DVec3::Z), DVec3::ZERO, 1.5, 50.0);
        let ends = slices.ends.to_array();
        assert!(ends[0] > 0.5 && ends.is_sorted(), "{ends:?}");
        let texels = slices.texels(2048).to_array();
        assert!(texels.is_sorted() && texels[3] < 2.0 * 50.0 / 2048.0, "{texels:?}");
    }

    /// Corners of all slices lie inside their maps, wherever the camera stands and looks.
    #[test]
    fn a_map_covers_its_slice() {
        let sun = Vec3::new(0.3, -0.8, 0.2).normalize();
        let fit = (Vec3::ZERO, 50.0);
        for step in 0..50 {
            let turn = f64::from(step) * 0.37;
            let position = DVec3::new(turn.sin() * 20.0, 2.0, turn * 0.3);
            let eye = eye(position, position + DVec3::new(turn.cos(), 0.1 * turn.sin(), turn.sin()));
            let slices = Slices::new(&eye, DVec3::ZERO, 1.5, fit.1);
            let (_, [forward, right, up]) = eye.rays(DVec3::ZERO, 1.5);
            let mut begin = eye.near;
            for k in 0..CASCADES {
                let clip = slices.clip_from_world(k, sun, fit, 1024);
                for corner in 0..8 {
                    let sign = |bit: i32| if corner >> bit & 1 == 1 { 1.0 } else { -1.0 };
                    let depth = if corner >> 2 == 1 { slices.ends[k] } else { begin };
                    let way = forward + right * sign(0) + up * sign(1);
                    let seen = clip.project_point3(position.as_vec3() + way * depth);
                    assert!(seen.truncate().abs().max_element() < 1.0, "{seen}");
                }
                begin = slices.ends[k] * 0.9;
            }
        }
    }

    /// However the camera turns and moves: a texel is where texels were.
    #[test]
    fn texels_stay_where_they_are() {
        let sun = Vec3::new(0.3, -0.8, 0.2).normalize();
        let fit = (Vec3::ZERO, 50.0);
        let texel_of = |eye: &Eye| {
            let slices = Slices::new(eye, DVec3::ZERO, 1.5, fit.1);
            let clip = slices.clip_from_world(1, sun, fit, 1024);
            (clip.project_point3(Vec3::new(1.0, 0.5, 2.0)).truncate() * 512.0, slices.texels(1024).y)
        };
        let (first, width) = texel_of(&eye(DVec3::ZERO, DVec3::Z));
        for step in 1..40 {
            let turn = f64::from(step) * 0.11;
            let position = DVec3::new(turn * 0.7, turn.sin(), 1.3 * turn);
            let (now, same) = texel_of(&eye(position, position + DVec3::new(turn.sin(), 0.2, turn.cos())));
            let apart = now - first;
            assert_eq!(width, same);
            assert!((apart - apart.round()).abs().max_element() < 0.02, "{apart}");
        }
    }

    #[test]
    fn a_wide_parallel_view_has_no_slices() {
        let mut eye = eye(DVec3::ZERO, DVec3::Z);
        eye.projection = Projection::Orthographic { half_height: 60.0 };
        assert!(!Slices::new(&eye, DVec3::ZERO, 1.5, 50.0).any());
        eye.projection = Projection::Orthographic { half_height: 5.0 };
        assert!(Slices::new(&eye, DVec3::ZERO, 1.5, 50.0).any());
    }
}
