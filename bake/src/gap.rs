//! Surfaces that stand a little off a chart: a lamp below its ceiling, a picture before its wall, a carpet.
//!
//! Light changes from full to almost none along their outline, within a gap's width; no patch can be lit and hidden at
//! once. So a chart is cut along the outlines of what stands nearer to it than a quarter of a patch, projected along
//! the chart's normal. In a stiff room this is no detail: what the lamp's back absorbs is multiplied by the cavity gain.

use std::collections::HashMap;

use glam::{DVec2, DVec3};
use obvhs::aabb::Aabb;

use crate::chart::{Chart, Charts, Frame};
use crate::cut::Boxes;
use crate::surface::Surface;

/// Of the length of the pieces that charts are divided into, which is half a patch's.
const NEAR: f64 = 0.5;
/// A chart with more corners is an ornament, not a panel.
const CORNERS: usize = 64;

/// By chart, those that stand before it and hardly off it. Only charts larger than their pieces are looked at.
pub fn near(surface: &Surface, charts: &Charts, size: &impl Fn(u32) -> f64) -> HashMap<u32, Vec<u32>> {
    let large: Vec<u32> = (0..charts.charts.len() as u32)
        .filter(|&id| charts.charts[id as usize].area >= size(id) * size(id))
        .collect();
    let boxes = Boxes::new(large.iter().map(|&id| bounds(surface, &charts.charts[id as usize])).collect());
    let mut near: HashMap<u32, Vec<u32>> = HashMap::new();
    for (k, &id) in (0..).zip(&large) {
        boxes.meeting(k, NEAR * size(id), |other| {
            if other != k {
                near.entry(id).or_default().push(large[other as usize]);
            }
        });
    }
    near.values_mut().for_each(|others| others.sort_unstable());
    near
}

fn bounds(surface: &Surface, chart: &Chart) -> Aabb {
    let mut bounds = Aabb::INVALID;
    for &t in &chart.triangles {
        for position in surface.triangles[t as usize].positions() {
            bounds.extend(position.as_vec3().into());
        }
    }
    bounds
}

/// The edges of another chart's outline that lie off a chart, in their whole length by more than `touch` and by less than
/// a quarter of a patch, in the chart's plane. `both`: the chart has two sides. What rises from the chart is a wall, which
/// cuts it where it stands.
pub fn outline(
    charts: &Charts,
    other: u32,
    frame: &Frame,
    both: bool,
    touch: f64,
    size: f64,
) -> Vec<[DVec2; 2]> {
    let edges = &charts.charts[other as usize].outline;
    if edges.len() > CORNERS {
        return Vec::new();
    }
    let ends = edges.iter().map(|edge| edge.map(|vertex| charts.positions[vertex as usize]));
    let is_near = |ends: &[DVec3; 2]| {
        let heights = ends.map(|end| frame.height(end));
        let before =
            |side: f64| heights.iter().all(|height| (touch..=NEAR * size).contains(&(side * height)));
        before(1.0) || both && before(-1.0)
    };
    ends.filter(is_near).map(|ends| ends.map(|end| frame.flat(end))).collect()
}
