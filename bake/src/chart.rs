//! Charts: the flat pieces of the surface, on which every attribute is an affine function of place.
//!
//! A chart is divided as one polygon whatever triangles an exporter cut it into. What is curved ends up as charts
//! of one triangle each, which are joined again when patches are made.

use std::collections::HashMap;

use glam::{DVec2, DVec3, Vec2, Vec3};

use crate::surface::{Corner, Surface};

/// The scene's triangles as a mesh of welded vertices, and its charts.
pub struct Charts {
    /// By triangle: welded vertices. Only vertices of one entity at the very same place are welded.
    pub welded: Vec<[u32; 3]>,
    pub positions: Vec<DVec3>,
    pub densities: Vec<f32>,
    pub charts: Vec<Chart>,
    /// By triangle.
    pub chart_of: Vec<u32>,
}

pub struct Chart {
    pub triangles: Vec<u32>,
    /// Directed edges that no other triangle of the chart has, as welded vertices.
    pub outline: Vec<[u32; 2]>,
    pub frame: Frame,
    pub area: f64,
}

/// A chart's plane: position = origin + x * u + y * v.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    pub origin: DVec3,
    pub x: DVec3,
    pub y: DVec3,
    pub normal: DVec3,
}

impl Frame {
    pub fn new(origin: DVec3, along: DVec3, normal: DVec3) -> Self {
        let x = along.normalize_or_zero();
        Self { origin, x, y: normal.cross(x), normal }
    }

    pub fn flat(&self, p: DVec3) -> DVec2 {
        DVec2::new((p - self.origin).dot(self.x), (p - self.origin).dot(self.y))
    }

    pub fn height(&self, p: DVec3) -> f64 {
        (p - self.origin).dot(self.normal)
    }

    pub fn place(&self, p: DVec2) -> DVec3 {
        self.origin + self.x * p.x + self.y * p.y
    }
}

/// How far from a plane a vertex may lie and still be on it (scaled space: f32 input has 6e-8).
const FLAT: f64 = 1e-6;

pub fn charts(surface: &Surface) -> Charts {
    let (welded, positions, densities) = weld(surface);
    let neighbours = neighbours(&welded);
    let count = surface.triangles.len();
    // Large triangles first: their planes are the best known.
    let areas: Vec<f64> = surface.triangles.iter().map(|triangle| triangle.cross().length() * 0.5).collect();
    let mut order: Vec<u32> = (0..count as u32).collect();
    order.sort_by(|&a, &b| areas[b as usize].total_cmp(&areas[a as usize]).then(a.cmp(&b)));
    let mut chart_of = vec![u32::MAX; count];
    let mut charts: Vec<Chart> = Vec::new();
    for seed in order {
        if chart_of[seed as usize] != u32::MAX {
            continue;
        }
        let id = charts.len() as u32;
        let affine = Affine::new(&surface.triangles[seed as usize].corners);
        let batch = surface.triangles[seed as usize].batch;
        chart_of[seed as usize] = id;
        let mut triangles = vec![seed];
        let mut next = 0;
        while next < triangles.len() {
            for &other in &neighbours[triangles[next] as usize] {
                if other == u32::MAX || chart_of[other as usize] != u32::MAX {
                    continue;
                }
                let candidate = &surface.triangles[other as usize];
                if candidate.batch == batch && affine.holds(&candidate.corners) {
                    chart_of[other as usize] = id;
                    triangles.push(other);
                }
            }
            next += 1;
        }
        triangles.sort_unstable();
        let area = triangles.iter().map(|&t| areas[t as usize]).sum();
        charts.push(Chart { triangles, outline: Vec::new(), frame: affine.frame, area });
    }
    for chart in &mut charts {
        chart.outline = outline(&chart.triangles, &welded);
        // The grid of pieces lies along the longest straight side.
        let side = |edge: &[u32; 2]| positions[edge[1] as usize] - positions[edge[0] as usize];
        let longest =
            chart.outline.iter().map(side).max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
        chart.frame = Frame::new(chart.frame.origin, longest.unwrap_or(chart.frame.x), chart.frame.normal);
    }
    Charts { welded, positions, densities, charts, chart_of }
}

fn weld(surface: &Surface) -> (Vec<[u32; 3]>, Vec<DVec3>, Vec<f32>) {
    let mut ids: HashMap<([u32; 2], [u64; 3]), u32> = HashMap::new();
    let (mut positions, mut densities): (Vec<DVec3>, Vec<(f32, f32)>) = (Vec::new(), Vec::new());
    let welded = surface
        .triangles
        .iter()
        .map(|triangle| {
            let entity = surface.batches[triangle.batch as usize].entity;
            triangle.corners.map(|corner| {
                let key = (entity, (corner.position + 0.0).to_array().map(f64::to_bits));
                let id = *ids.entry(key).or_insert_with(|| {
                    positions.push(corner.position);
                    densities.push((0.0, 0.0));
                    positions.len() as u32 - 1
                });
                let (sum, count) = densities[id as usize];
                densities[id as usize] = (sum + corner.density, count + 1.0);
                id
            })
        })
        .collect();
    (welded, positions, densities.into_iter().map(|(sum, count)| sum / count).collect())
}

/// By triangle and side (corner k to k + 1): the one other triangle there that faces the same way round.
fn neighbours(welded: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut sides: HashMap<[u32; 2], (u32, u32)> = HashMap::with_capacity(welded.len() * 3);
    for (t, corners) in welded.iter().enumerate() {
        for k in 0..3 {
            let side = sides.entry([corners[k], corners[(k + 1) % 3]]).or_insert((t as u32, 0));
            side.1 += 1;
        }
    }
    let one = |side: [u32; 2]| sides.get(&side).filter(|(_, count)| *count == 1).map(|&(t, _)| t);
    welded
        .iter()
        .map(|corners| {
            std::array::from_fn(|k| {
                let side = [corners[k], corners[(k + 1) % 3]];
                one(side).and_then(|_| one([side[1], side[0]])).unwrap_or(u32::MAX)
            })
        })
        .collect()
}

fn outline(triangles: &[u32], welded: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let sides = || {
        triangles.iter().flat_map(|&t| {
            let c = welded[t as usize];
            [[c[0], c[1]], [c[1], c[2]], [c[2], c[0]]]
        })
    };
    if triangles.len() == 1 {
        return sides().collect();
    }
    let all: std::collections::HashSet<[u32; 2]> = sides().collect();
    sides().filter(|side| !all.contains(&[side[1], side[0]])).collect()
}

/// What a triangle says of its plane: every attribute as an affine function of place.
pub struct Affine {
    pub frame: Frame,
    corner: [Corner; 3],
    /// Takes flat coordinates to the weights of the second and third corner.
    weights_from_flat: glam::DMat2,
}

impl Affine {
    pub fn new(corners: &[Corner; 3]) -> Self {
        let [a, b, c] = corners.map(|corner| corner.position);
        // The longest side lies along x, so that slivers lose least.
        let along = [b - a, c - b, a - c]
            .into_iter()
            .max_by(|p, q| p.length_squared().total_cmp(&q.length_squared()));
        let frame = Frame::new(a, along.unwrap_or(DVec3::X), (b - a).cross(c - a).normalize_or_zero());
        let flat = glam::DMat2::from_cols(frame.flat(b), frame.flat(c));
        Self { frame, corner: *corners, weights_from_flat: flat.inverse() }
    }

    pub fn at(&self, p: DVec3) -> Corner {
        let weights = self.weights_from_flat * self.frame.flat(p);
        blend(&self.corner, [weights.x as f32, weights.y as f32], p)
    }

    fn holds(&self, corners: &[Corner; 3]) -> bool {
        let [a, b, c] = corners.map(|corner| corner.position);
        corners.iter().all(|corner| {
            self.frame.height(corner.position).abs() <= FLAT && near(&self.at(corner.position), corner)
        }) && (b - a).cross(c - a).dot(self.frame.normal) > 0.0
    }
}

/// The attributes at a place by the weights of the second and third corner.
pub fn blend(corners: &[Corner; 3], [v, w]: [f32; 2], position: DVec3) -> Corner {
    let u = 1.0 - v - w;
    let [a, b, c] = corners;
    let mix2 = |i: usize| -> Vec2 { a.uv[i] * u + b.uv[i] * v + c.uv[i] * w };
    let mix4 =
        |p: &[f32; 4], q: &[f32; 4], r: &[f32; 4]| std::array::from_fn(|i| p[i] * u + q[i] * v + r[i] * w);
    let tangent: [f32; 4] = mix4(&a.tangent, &b.tangent, &c.tangent);
    Corner {
        position,
        normal: (a.normal * u + b.normal * v + c.normal * w).normalize_or_zero(),
        tangent: Vec3::new(tangent[0], tangent[1], tangent[2])
            .normalize_or_zero()
            .extend(a.tangent[3])
            .to_array(),
        uv: [mix2(0), mix2(1)],
        color: mix4(&a.color, &b.color, &c.color),
        density: a.density * u + b.density * v + c.density * w,
    }
}

fn near(a: &Corner, b: &Corner) -> bool {
    let near4 = |p: [f32; 4], q: [f32; 4]| (0..4).all(|i| (p[i] - q[i]).abs() < 2e-3);
    (a.normal - b.normal).length_squared() < 1e-5
        && (0..2).all(|i| (a.uv[i] - b.uv[i]).abs().max_element() < 1e-4)
        && near4(a.color, b.color)
        && near4(a.tangent, b.tangent)
        && (a.density - b.density).abs() < 1e-3
}
