//! Surfaces that stand a little off a chart: a lamp below its ceiling, a picture before its wall, a carpet.
//!
//! Light changes from full to almost none along their outline, within a gap's width; no patch can be lit and hidden at
//! once. So a chart is cut along the outlines of what stands nearer to it than a quarter of a patch, projected along
//! the chart's normal. Beside such a cut, on both of its sides, light still changes over the width of the gap: what comes in
//! under the edge leaves again close to it, and a patch that spread it further would lose more to the lamp's back. So
//! patches end at a second line there, as far off as the gap is wide, across which light goes on smoothly. In a stiff room
//! this is no detail: what the lamp's back absorbs is multiplied by the cavity gain.

use std::collections::HashMap;

use glam::DVec2;
use obvhs::aabb::Aabb;

use crate::chart::{Chart, Charts, Frame};
use crate::cut::{Boxes, Line};
use crate::surface::Surface;

/// Of the length of the pieces that charts are divided into, which is half a patch's.
const NEAR: f64 = 0.5;
/// A gap that is narrower, in the same lengths, has no lines beside it: too little light enters it.
const NARROW: f64 = 1.0 / 16.0;
/// The least of 1 + cos of the turn from one edge to the next for which a line's corner is mitred in full.
const MITRE: f64 = 0.3;
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
/// a quarter of a patch, in the chart's plane, and lines beside them as far off as the gap is wide. `both`: the chart has
/// two sides. What rises from the chart is a wall, which cuts it where it stands.
pub fn outline(charts: &Charts, other: u32, frame: &Frame, both: bool, touch: f64, size: f64) -> Vec<Line> {
    let edges = &charts.charts[other as usize].outline;
    if edges.len() > CORNERS {
        return Vec::new();
    }
    let place = |vertex: u32| charts.positions[vertex as usize];
    let is_near = |edge: &&[u32; 2]| {
        let heights = edge.map(|vertex| frame.height(place(vertex)));
        let before =
            |side: f64| heights.iter().all(|height| (touch..=NEAR * size).contains(&(side * height)));
        before(1.0) || both && before(-1.0)
    };
    let near: Vec<[u32; 2]> = edges.iter().filter(is_near).copied().collect();
    let flat = |vertex: u32| frame.flat(place(vertex));
    let width = |vertex: u32| frame.height(place(vertex)).abs();
    let mut lines: Vec<Line> = near.iter().map(|edge| Line::cut(edge.map(flat))).collect();
    if near.iter().flatten().all(|&vertex| width(vertex) >= NARROW * size) {
        for side in [-1.0, 1.0] {
            let beside = beside(&near, &flat, &|vertex| side * width(vertex));
            lines.extend(beside.into_iter().map(|ends| Line { ends, smooth: true }));
        }
    }
    lines
}

/// Lines along edges, moved to their left by as much as is said of their ends, mitred where edges follow each other; none
/// beside an edge that is too short for it.
fn beside(edges: &[[u32; 2]], flat: &impl Fn(u32) -> DVec2, by: &impl Fn(u32) -> f64) -> Vec<[DVec2; 2]> {
    let left = |&[a, b]: &[u32; 2]| (flat(b) - flat(a)).normalize_or_zero().perp();
    let moved = |vertex: u32, own: DVec2, next: Option<&[u32; 2]>| {
        let other = next.map_or(own, left);
        flat(vertex) + (own + other) * (by(vertex) / (1.0 + own.dot(other)).max(MITRE))
    };
    let line = |edge: &[u32; 2]| {
        let (own, [a, b]) = (left(edge), *edge);
        let before = edges.iter().find(|other| other[1] == a);
        let after = edges.iter().find(|other| other[0] == b);
        let line = [moved(a, own, before), moved(b, own, after)];
        let along = (line[1] - line[0]).dot(flat(b) - flat(a));
        (along > 0.25 * flat(a).distance_squared(flat(b))).then_some(line)
    };
    edges.iter().filter_map(line).collect()
}
