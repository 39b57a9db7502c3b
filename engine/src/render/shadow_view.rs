//! What shadow maps look at: one view a spot, six a point light, one a sun and one a cascade.

use glam::{Mat4, Vec3};

use super::cascades::{CASCADES, Slices};
use super::instances::{Draw, Instances};
use super::view::{orthographic, perspective, view_from_world};
use crate::scene::LightKind;
use crate::transport::direct::PlacedLight;

/// Kinds of maps.
pub const SUN: usize = 0;
pub const SPOT: usize = 1;
pub const POINT: usize = 2;
/// Metres: what is nearer to a spot or point light casts no shadow.
const NEAR: f32 = 0.02;
/// Texels beyond the edge of a map that its filter reads.
pub const BORDER: f32 = 4.0;

/// One map to be seen to.
pub struct Seen {
    /// Number of the light whose map it is.
    pub light: usize,
    pub kind: usize,
    pub layer: usize,
    pub clip_from_world: Mat4,
    /// Casters farther from the light do not matter.
    pub reach: Option<(Vec3, f32)>,
    /// A sun's map for the camera: no light changes where it does.
    pub of_camera: bool,
}

/// Where a light's maps are.
pub struct Place {
    pub light: usize,
    /// The first one, and texels across each.
    pub layer: usize,
    pub size: u32,
    /// The sphere that the map of the whole scene covers.
    pub fit: (Vec3, f32),
}

/// Adds the maps of one light: a sun's one over the whole scene and one a slice of the camera's, if there are any,
/// a spot's one, a point light's six. Returns the width of a texel: a sun's everywhere, others' at distance 1.
pub fn see(light: &PlacedLight, place: &Place, slices: &Slices, seen: &mut Vec<Seen>) -> f32 {
    let (kind, size) = (kind_of(light), place.size as f32);
    let reach = light.light.range.filter(|_| kind != SUN).map(|range| (light.position, range));
    let mut add = |above: usize, clip_from_world| {
        let of_camera = kind == SUN && above > 0;
        let layer = place.layer + above;
        seen.push(Seen { light: place.light, kind, layer, clip_from_world, reach, of_camera });
    };
    match light.light.kind {
        LightKind::Sun => {
            let (clip_from_world, texel) = sun_view(light.direction, place.fit, size);
            add(0, clip_from_world);
            for slice in (0..CASCADES).filter(|_| slices.any()) {
                add(1 + slice, slices.clip_from_world(slice, light.direction, place.fit, place.size));
            }
            texel
        }
        LightKind::Spot { outer, .. } => {
            let half = outer.clamp(0.01, 1.4).tan() * (1.0 + 2.0 * BORDER / size);
            let clip_from_view = perspective(half, half, NEAR, None);
            add(0, clip_from_view * view_from_world(light.position, axes(light.direction)));
            2.0 * half / size
        }
        LightKind::Point => {
            let half = 1.0 + 2.0 * BORDER / size;
            let clip_from_view = perspective(half, half, NEAR, None);
            for (face, direction) in FACES.into_iter().enumerate() {
                add(face, clip_from_view * view_from_world(light.position, axes(direction)));
            }
            2.0 * half / size
        }
    }
}

impl Seen {
    /// Whether the light reaches what may stand in it.
    pub fn reaches(&self, draw: &Draw) -> bool {
        let near = |(centre, reach): (Vec3, f32)| draw.centre.distance(centre) <= reach + draw.radius;
        draw.casts && !draw.indices.is_empty() && self.reach.is_none_or(near)
    }

    /// Whether what the light reaches is inside the sides of the map; what lies in front of a sun's near side counts,
    /// too.
    pub fn sees(&self, draw: &Draw) -> bool {
        in_sight(&self.clip_from_world, draw.centre, draw.radius)
    }
}

/// Whether a sphere is inside the sides of a view, or across them.
pub fn in_sight(clip_from_world: &Mat4, centre: Vec3, radius: f32) -> bool {
    let row = |i| clip_from_world.row(i);
    let planes = [row(3) + row(0), row(3) - row(0), row(3) + row(1), row(3) - row(1)];
    planes.iter().all(|plane| plane.dot(centre.extend(1.0)) >= -radius * plane.truncate().length())
}

pub fn kind_of(light: &PlacedLight) -> usize {
    match light.light.kind {
        LightKind::Sun => SUN,
        LightKind::Spot { .. } => SPOT,
        LightKind::Point => POINT,
    }
}

const FACES: [Vec3; 6] = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];

/// Right, up and back for a view along `direction`.
pub fn axes(direction: Vec3) -> [Vec3; 3] {
    let up = if direction.y.abs() > 0.9 { Vec3::X } else { Vec3::Y };
    let right = direction.cross(up).normalize();
    [right, right.cross(direction), -direction]
}

/// A box about the sphere, seen along `direction`. The sphere's middle is moved to whole texels, so that
/// shadows do not swim when the scene's extent changes. Returns the width of a texel.
fn sun_view(direction: Vec3, (centre, radius): (Vec3, f32), size: f32) -> (Mat4, f32) {
    let half = radius * (1.0 + 2.0 * (BORDER + 1.0) / size);
    let texel = 2.0 * half / size;
    let [right, up, back] = axes(direction);
    let snapped = |axis: Vec3| (axis.dot(centre) / texel).floor() * texel;
    let middle = right * snapped(right) + up * snapped(up) + back * back.dot(centre);
    let eye = middle + back * half;
    (orthographic(half, half, 0.0, 2.0 * half) * view_from_world(eye, [right, up, back]), texel)
}

/// A sphere about everything that casts. The old one is kept while it fits well.
pub fn fit(old: (Vec3, f32), instances: &Instances) -> (Vec3, f32) {
    let mut box_of_all: Option<(Vec3, Vec3)> = None;
    let mut kept = true;
    for draw in instances.draws.iter().filter(|draw| draw.casts && draw.radius.is_finite()) {
        kept &= draw.centre.distance(old.0) + draw.radius <= old.1;
        let (low, high) = (draw.centre - draw.radius, draw.centre + draw.radius);
        box_of_all = Some(box_of_all.map_or((low, high), |(l, h)| (l.min(low), h.max(high))));
    }
    let Some((low, high)) = box_of_all else { return old };
    let centre = (low + high) * 0.5;
    let reach = |draw: &Draw| draw.centre.distance(centre) + draw.radius;
    let casters = instances.draws.iter().filter(|draw| draw.casts && draw.radius.is_finite());
    let radius = casters.map(reach).fold(1e-3, f32::max);
    if kept && radius > 0.6 * old.1 { old } else { (centre, radius * 1.02) }
}
