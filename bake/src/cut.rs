//! Where charts cross or touch, or all but touch ([`crate::gap`]): the lines along which they are cut, so that no patch
//! and no receiver straddles a wall that stands on its floor.

use std::collections::{HashMap, HashSet};
use std::time::Duration;

use glam::{DVec2, DVec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;

use crate::chart::{Chart, Charts, Frame};
use crate::gap;
use crate::surface::Surface;

/// Lines by chart, in the chart's plane, clipped to it.
pub type Cuts = HashMap<u32, Vec<Line>>;

/// Where patches end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    pub ends: [DVec2; 2],
    /// Light goes on across it.
    pub smooth: bool,
}

impl Line {
    /// Nothing goes on across it.
    pub fn cut(ends: [DVec2; 2]) -> Self {
        Self { ends, smooth: false }
    }
}

/// `size`: the length of the pieces that charts are divided into. Charts of at least that size are cut by
/// everything; smaller ones are cut by those.
pub fn cuts(surface: &Surface, charts: &Charts, size: impl Fn(u32) -> f64) -> Cuts {
    let pairs = touching(surface, charts, &size);
    let mut cuts = Cuts::new();
    let near = gap::near(surface, charts, &size);
    let mut chart_ids: Vec<u32> = pairs.keys().chain(near.keys()).copied().collect();
    chart_ids.sort_unstable();
    chart_ids.dedup();
    for id in chart_ids {
        let chart = &charts.charts[id as usize];
        let reach = contact(size(id));
        if chart.area < (4.0 * reach).powi(2) {
            continue; // a coin on a ground of a hundred kilometres: a cut would reach beyond it, and it would grow
        }
        let mut lines: Vec<Line> = Vec::new();
        for &other in pairs.get(&id).into_iter().flatten() {
            for ends in meet(&chart.frame, surface.triangles[other as usize].positions(), reach) {
                clip(surface, chart, Line::cut(ends), reach, &mut lines);
            }
        }
        let both =
            surface.batches[surface.triangles[chart.triangles[0] as usize].batch as usize].double_sided != 0;
        for &other in near.get(&id).into_iter().flatten() {
            for line in gap::outline(charts, other, &chart.frame, both, reach, size(id)) {
                clip(surface, chart, line, reach, &mut lines);
            }
        }
        let lines = tidy(charts, chart, lines, reach);
        if !lines.is_empty() {
            cuts.insert(id, lines);
        }
    }
    cuts
}

/// Things nearer than this touch.
pub fn contact(size: f64) -> f64 {
    (1e-3 * size).clamp(2e-6, 1e-4)
}

/// By chart: triangles of other charts whose boxes meet it.
fn touching(surface: &Surface, charts: &Charts, size: &impl Fn(u32) -> f64) -> HashMap<u32, Vec<u32>> {
    let boxes: Vec<Aabb> = surface
        .triangles
        .iter()
        .map(|triangle| {
            let corners = triangle.positions().map(|p| Vec3A::from(p.as_vec3()));
            Aabb::from_points(&corners)
        })
        .collect();
    let mut pairs: HashMap<u32, HashSet<u32>> = HashMap::new();
    let boxes = Boxes::new(boxes);
    for (id, chart) in charts.charts.iter().enumerate() {
        let size = size(id as u32);
        if chart.area < size * size {
            continue;
        }
        for &t in &chart.triangles {
            boxes.meeting(t, 2.0 * contact(size), |other| {
                let other_chart = charts.chart_of[other as usize];
                if other_chart != id as u32 {
                    pairs.entry(id as u32).or_default().insert(other);
                    pairs.entry(other_chart).or_default().insert(t);
                }
            });
        }
    }
    let sorted = |set: HashSet<u32>| {
        let mut sorted: Vec<u32> = set.into_iter().collect();
        sorted.sort_unstable();
        sorted
    };
    pairs.into_iter().map(|(id, set)| (id, sorted(set))).collect()
}

/// Boxes, and a tree over them.
pub struct Boxes {
    boxes: Vec<Aabb>,
    tree: Option<Bvh2>,
}

impl Boxes {
    pub fn new(boxes: Vec<Aabb>) -> Self {
        let build = || build_bvh2(&boxes, BvhBuildParams::fast_build(), &mut Duration::default());
        let tree = (!boxes.is_empty()).then(build);
        Self { boxes, tree }
    }

    /// Those that meet one of them, grown by a margin; itself among them.
    pub fn meeting(&self, of: u32, margin: f64, mut each: impl FnMut(u32)) {
        let Some(tree) = &self.tree else { return };
        let mut reach = self.boxes[of as usize];
        let margin = Vec3A::splat(margin as f32);
        reach.min -= margin;
        reach.max += margin;
        tree.aabb_traverse(reach, |tree, node| {
            let node = &tree.nodes[node as usize];
            let first = node.first_index as usize;
            let held = &tree.primitive_indices[first..first + node.prim_count as usize];
            held.iter().filter(|&&k| self.boxes[k as usize].intersect_aabb(&reach)).for_each(|&k| each(k));
            true
        });
    }
}

/// Where a triangle meets a plane: a segment, its sides where it lies in the plane, or nothing.
fn meet(frame: &Frame, triangle: [DVec3; 3], reach: f64) -> Vec<[DVec2; 2]> {
    let heights = triangle.map(|p| {
        let height = frame.height(p);
        if height.abs() <= reach { 0.0 } else { height }
    });
    let flat = triangle.map(|p| frame.flat(p));
    let on: Vec<usize> = (0..3).filter(|&k| heights[k] == 0.0).collect();
    if on.len() == 3 {
        return vec![[flat[0], flat[1]], [flat[1], flat[2]], [flat[2], flat[0]]];
    }
    if on.len() == 2 {
        return vec![[flat[on[0]], flat[on[1]]]];
    }
    let mut points: Vec<DVec2> = on.iter().map(|&k| flat[k]).collect();
    for k in 0..3 {
        let (a, b) = (heights[k], heights[(k + 1) % 3]);
        if a * b < 0.0 {
            points.push(flat[k].lerp(flat[(k + 1) % 3], a / (a - b)));
        }
    }
    if points.len() == 2 { vec![[points[0], points[1]]] } else { Vec::new() }
}

/// The parts of a line that lie in the chart.
fn clip(surface: &Surface, chart: &Chart, line: Line, reach: f64, out: &mut Vec<Line>) {
    let [a, b] = line.ends;
    let length = (b - a).length();
    if length <= reach {
        return;
    }
    let mut inside: Vec<(f64, f64)> = chart
        .triangles
        .iter()
        .filter_map(|&t| {
            let corners = surface.triangles[t as usize].positions().map(|p| chart.frame.flat(p));
            inside_triangle(corners, a, b, reach)
        })
        .collect();
    inside.sort_by(|p, q| p.0.total_cmp(&q.0));
    let mut joined: Vec<(f64, f64)> = Vec::new();
    for (from, to) in inside {
        match joined.last_mut() {
            Some(last) if from <= last.1 + reach / length => last.1 = last.1.max(to),
            _ => joined.push((from, to)),
        }
    }
    out.extend(
        joined
            .into_iter()
            .filter(|(from, to)| (to - from) * length > reach)
            .map(|(from, to)| Line { ends: [a.lerp(b, from), a.lerp(b, to)], ..line }),
    );
}

/// The share of a segment inside a counter-clockwise triangle, grown by `reach` (Cyrus and Beck).
fn inside_triangle(corners: [DVec2; 3], a: DVec2, b: DVec2, reach: f64) -> Option<(f64, f64)> {
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for k in 0..3 {
        let side = corners[(k + 1) % 3] - corners[k];
        let inward = side.perp() / side.length().max(1e-300);
        let (p, q) = (inward.dot(a - corners[k]) + reach, inward.dot(b - corners[k]) + reach);
        if p < 0.0 && q < 0.0 {
            return None;
        }
        if p < 0.0 {
            from = from.max(p / (p - q));
        } else if q < 0.0 {
            to = to.min(p / (p - q));
        }
    }
    (from < to).then_some((from, to))
}

/// Ends snap to the outline where they are near it; lines along the outline and doubles are dropped. Of doubles the cut
/// stays.
fn tidy(charts: &Charts, chart: &Chart, mut lines: Vec<Line>, reach: f64) -> Vec<Line> {
    lines.sort_by_key(|line| line.smooth);
    let snap = 2.0 * reach;
    let outline: Vec<[DVec2; 2]> = chart
        .outline
        .iter()
        .map(|edge| edge.map(|vertex| chart.frame.flat(charts.positions[vertex as usize])))
        .collect();
    let mut known: Vec<DVec2> = Vec::new();
    let mut snapped = |p: DVec2| {
        let corner = outline.iter().flatten().find(|corner| corner.distance(p) <= snap);
        let on_edge = || outline.iter().map(|&edge| foot(edge, p)).find(|foot| foot.distance(p) <= snap);
        let p = corner.copied().or_else(on_edge).unwrap_or(p);
        if let Some(&same) = known.iter().find(|known| known.distance(p) <= snap) {
            return same;
        }
        known.push(p);
        p
    };
    let mut seen = HashSet::new();
    let mut tidy = Vec::new();
    for line in lines {
        let [a, b] = line.ends.map(&mut snapped);
        let bits = |p: DVec2| p.to_array().map(f64::to_bits);
        let along = outline
            .iter()
            .any(|&edge| foot(edge, a).distance(a) <= snap && foot(edge, b).distance(b) <= snap);
        let key = if bits(a) < bits(b) { (bits(a), bits(b)) } else { (bits(b), bits(a)) };
        if a != b && !along && seen.insert(key) {
            tidy.push(Line { ends: [a, b], ..line });
        }
    }
    part(tidy, snap)
}

/// Lines parted where they cross or touch each other, so that they meet in their ends alone.
fn part(mut lines: Vec<Line>, snap: f64) -> Vec<Line> {
    let low = |line: &Line| line.ends[0].x.min(line.ends[1].x);
    let high = |line: &Line| line.ends[0].x.max(line.ends[1].x);
    lines.sort_by(|p, q| low(p).total_cmp(&low(q)));
    let mut stops: Vec<Vec<DVec2>> = lines.iter().map(|line| line.ends.to_vec()).collect();
    for i in 0..lines.len() {
        for j in i + 1..lines.len() {
            if low(&lines[j]) > high(&lines[i]) + snap {
                break;
            }
            let touches = |p: DVec2, segment: [DVec2; 2]| foot(segment, p).distance(p) <= snap;
            let (p, q) = (lines[i].ends, lines[j].ends);
            let ends_on_i = q.into_iter().filter(|&end| touches(end, p));
            let ends_on_j = p.into_iter().filter(|&end| touches(end, q));
            let (on_i, on_j): (Vec<DVec2>, Vec<DVec2>) = (ends_on_i.collect(), ends_on_j.collect());
            let crossing = if on_i.is_empty() && on_j.is_empty() { cross(p, q) } else { None };
            stops[i].extend(on_i.into_iter().chain(crossing));
            stops[j].extend(on_j.into_iter().chain(crossing));
        }
    }
    let bits = |p: DVec2| p.to_array().map(f64::to_bits);
    let mut parted: Vec<(Line, Vec<DVec2>)> = lines.into_iter().zip(stops).collect();
    parted.sort_by_key(|(line, _)| line.smooth);
    let mut seen = HashSet::new();
    let mut parts = Vec::new();
    for (line, mut stops) in parted {
        let [a, b] = line.ends;
        let along = |p: DVec2| (p - a).dot(b - a);
        stops.sort_by(|&p, &q| along(p).total_cmp(&along(q)));
        stops.dedup_by(|p, q| p.distance(*q) <= snap);
        for pair in stops.windows(2) {
            let (p, q) = (bits(pair[0]), bits(pair[1]));
            if seen.insert(if p < q { (p, q) } else { (q, p) }) {
                parts.push(Line { ends: [pair[0], pair[1]], ..line });
            }
        }
    }
    parts
}

/// Where two segments cross, both inside.
fn cross([a, b]: [DVec2; 2], [c, d]: [DVec2; 2]) -> Option<DVec2> {
    let side = |p: DVec2, q: DVec2, r: DVec2| (q - p).perp_dot(r - p);
    let (s, t) = (side(a, b, c), side(a, b, d));
    let (u, v) = (side(c, d, a), side(c, d, b));
    (s * t < 0.0 && u * v < 0.0).then(|| c.lerp(d, s / (s - t)))
}

/// The nearest point of a segment.
pub fn foot([a, b]: [DVec2; 2], p: DVec2) -> DVec2 {
    let along = b - a;
    let t = ((p - a).dot(along) / along.length_squared().max(1e-300)).clamp(0.0, 1.0);
    a + along * t
}
