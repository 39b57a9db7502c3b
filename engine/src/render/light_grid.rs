//! Which lights reach which part of the scene: a grid of cells over everything that is drawn, each with the list of
//! the lights whose range touches it ("clustered shading", Olsson, Billeter and Assarsson 2012, but in the world
//! instead of one view's frustum: camera, reflection captures and patches read the same lists).
//!
//! A range bounds its light exactly, by the window of KHR_lights_punctual; a spot's cone does too. Suns and lights
//! without a range reach all: they stand first among the lights and in no list. A point adds up its lights in the
//! order in which they stand, so that the picture is the one without a grid to the last bit.

use bytemuck::{Pod, Zeroable};
use glam::{UVec3, Vec3};
use wgpu::BufferUsages as Usage;

use super::instances::Instances;
use crate::gpu::Gpu;
use crate::gpu::buffer::Held;
use crate::scene::LightKind;
use crate::transport::direct::PlacedLight;

/// `LightGrid` in `scene/light.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct GridUniform {
    pub low: Vec3,
    pub everywhere: u32,
    pub cells_per_metre: Vec3,
    pub padding: u32,
    pub counts: UVec3,
    pub padding_2: u32,
}

/// The most cells along an axis: rooms and landscapes are wider than high.
const MOST: Vec3 = Vec3::new(16.0, 8.0, 16.0);
/// Share of its size by which the grid reaches beyond what it holds, so that movers do not shift it every frame.
const MARGIN: f32 = 0.05;

pub struct LightGrid {
    pub uniform: Held<GridUniform>,
    /// First and count of each cell (x fastest, then y), then the lights.
    pub lists: Held<u32>,
    bounds: (Vec3, Vec3),
    cells: Cells,
}

impl LightGrid {
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            uniform: Held::new(gpu, "light grid", Usage::UNIFORM),
            lists: Held::new(gpu, "light lists", Usage::STORAGE),
            bounds: (Vec3::ZERO, Vec3::ZERO),
            cells: Cells::new((Vec3::ZERO, Vec3::ZERO)),
        }
    }

    /// Follows the scene. `lights` are as on the GPU, the first `everywhere` of them in no list; `changed` says
    /// whether they differ from the last time.
    pub fn update(
        &mut self,
        gpu: &Gpu,
        lights: &[&PlacedLight],
        everywhere: usize,
        instances: &Instances,
        changed: bool,
    ) {
        let bounds = bounds(self.bounds, instances);
        if !changed && bounds == self.bounds && !self.uniform.items().is_empty() {
            return;
        }
        self.bounds = bounds;
        self.cells = Cells::new(bounds);
        let spaces: Vec<LitSpace> = lights[everywhere..].iter().map(|light| LitSpace::of(light)).collect();
        self.lists.write(gpu, &self.cells.lists(&spaces, everywhere as u32));
        self.uniform.write(gpu, &[self.cells.uniform(everywhere as u32)]);
    }

    /// Lights in a cell, on average: those everywhere and those of its list.
    pub fn mean_lights(&self) -> f32 {
        let cells = self.cells.count() as f32;
        let everywhere = self.uniform.items().first().map_or(0, |uniform| uniform.everywhere);
        everywhere as f32 + (self.lists.items().len() as f32 - 2.0 * cells).max(0.0) / cells
    }
}

/// A box about everything that is drawn. The old one is kept while it fits well.
fn bounds(old: (Vec3, Vec3), instances: &Instances) -> (Vec3, Vec3) {
    let finite = instances.draws.iter().filter(|draw| draw.centre.is_finite() && draw.radius.is_finite());
    let boxes = finite.map(|draw| (draw.centre - draw.radius, draw.centre + draw.radius));
    let Some((low, high)) = boxes.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))) else { return old };
    let (size, old_size) = (high - low, old.1 - old.0);
    let fits = old.0.cmple(low).all() && old.1.cmpge(high).all();
    if fits && old_size.cmple(size * (1.0 + 6.0 * MARGIN) + 1e-2).all() {
        return old;
    }
    let margin = size * MARGIN + 1e-3;
    (low - margin, high + margin)
}

struct Cells {
    low: Vec3,
    size: Vec3,
    counts: UVec3,
}

impl Cells {
    /// About cubes, as many as fit.
    fn new((low, high): (Vec3, Vec3)) -> Self {
        let extent = (high - low).max(Vec3::splat(1e-3));
        let edge = (extent / MOST).max_element();
        let counts = (extent / edge).round().clamp(Vec3::ONE, MOST);
        Self { low, size: extent / counts, counts: counts.as_uvec3() }
    }

    fn count(&self) -> u32 {
        self.counts.element_product()
    }

    fn uniform(&self, everywhere: u32) -> GridUniform {
        GridUniform {
            low: self.low,
            everywhere,
            cells_per_metre: self.size.recip(),
            padding: 0,
            counts: self.counts,
            padding_2: 0,
        }
    }

    /// The cells that hold a point, or the nearest ones.
    fn at(&self, point: Vec3) -> UVec3 {
        let cell = ((point - self.low) / self.size).floor();
        cell.clamp(Vec3::ZERO, (self.counts - 1).as_vec3()).as_uvec3()
    }

    /// The lists as the GPU reads them; light `k` of `spaces` is number `first_light + k`.
    fn lists(&self, spaces: &[LitSpace], first_light: u32) -> Vec<u32> {
        let mut lights: Vec<Vec<u32>> = vec![Vec::new(); self.count() as usize];
        for (number, space) in (first_light..).zip(spaces) {
            let (from, to) = (self.at(space.centre - space.range), self.at(space.centre + space.range));
            for z in from.z..=to.z {
                for y in from.y..=to.y {
                    for x in from.x..=to.x {
                        let low = self.low + self.size * UVec3::new(x, y, z).as_vec3();
                        if space.touches(low, low + self.size) {
                            lights[((z * self.counts.y + y) * self.counts.x + x) as usize].push(number);
                        }
                    }
                }
            }
        }
        let mut lists = Vec::with_capacity(lights.len() * 2);
        let mut first = self.count() * 2;
        for list in &lights {
            lists.extend([first, list.len() as u32]);
            first += list.len() as u32;
        }
        lists.extend(lights.iter().flatten());
        lists
    }
}

/// Where a light with a range shines: a ball, of a spot the part inside its cone.
struct LitSpace {
    centre: Vec3,
    range: f32,
    direction: Vec3,
    /// Half angle of the cone.
    outer: Option<f32>,
}

impl LitSpace {
    fn of(light: &PlacedLight) -> Self {
        let outer = match light.light.kind {
            LightKind::Spot { outer, .. } if outer < 1.5 => Some(outer.max(0.0)),
            _ => None,
        };
        let range = light.light.range.unwrap_or(f32::INFINITY);
        Self { centre: light.position, range, direction: light.direction, outer }
    }

    /// Never false where the light reaches the box.
    fn touches(&self, low: Vec3, high: Vec3) -> bool {
        let nearest = self.centre.clamp(low, high);
        nearest.distance_squared(self.centre) <= self.range * self.range
            && self
                .outer
                .is_none_or(|outer| self.cone_touches(outer, (low + high) * 0.5, (high - low).length() * 0.5))
    }

    /// Whether a ball reaches into the cone, by its distance to the cone's mantle.
    fn cone_touches(&self, outer: f32, centre: Vec3, radius: f32) -> bool {
        let way = centre - self.centre;
        let along = way.dot(self.direction);
        let across = (way.length_squared() - along * along).max(0.0).sqrt();
        along >= -radius && across * outer.cos() - along * outer.sin() <= radius
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn space(centre: Vec3, range: f32, outer: Option<f32>) -> LitSpace {
        LitSpace { centre, range, direction: Vec3::NEG_Y, outer }
    }

    #[test]
    fn cells_are_about_cubes_and_cover_the_box() {
        let cells = Cells::new((Vec3::new(-30.0, 0.0, -30.0), Vec3::new(30.0, 6.0, 30.0)));
        assert_eq!(cells.counts, UVec3::new(16, 2, 16));
        assert_eq!(cells.at(Vec3::new(-31.0, 9.0, 29.9)), UVec3::new(0, 1, 15));
        assert_eq!(Cells::new((Vec3::ZERO, Vec3::ZERO)).count(), 8 * 8 * 8);
    }

    /// What any point is lit by stands in the list of the point's cell.
    #[test]
    fn no_light_is_missed() {
        let cells = Cells::new((Vec3::ZERO, Vec3::new(8.0, 4.0, 8.0)));
        let at = |k: f32| Vec3::new((k * 1.7) % 8.0, (k * 0.9) % 4.0, (k * 2.9) % 8.0);
        let spaces: Vec<LitSpace> = (0..40)
            .map(|k| space(at(k as f32), 0.5 + 0.05 * k as f32, (k % 2 == 0).then_some(0.4)))
            .collect();
        let lists = cells.lists(&spaces, 3);
        let mut listed = 0;
        for k in 0..4000 {
            let point = at(k as f32 * 0.137);
            let cell = cells.at(point);
            let index = ((cell.z * cells.counts.y + cell.y) * cells.counts.x + cell.x) as usize;
            let list = &lists[lists[index * 2] as usize..][..lists[index * 2 + 1] as usize];
            listed += list.len();
            for (number, space) in (3..).zip(&spaces) {
                let way = point - space.centre;
                let inside = way.length() < space.range
                    && space.outer.is_none_or(|outer| way.angle_between(Vec3::NEG_Y) < outer);
                assert!(!inside || list.contains(&number), "light {number} at {point}");
            }
        }
        assert!(listed < 4000 * 8, "{listed}");
    }
}
