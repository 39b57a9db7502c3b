//! Large charts are divided: a constrained Delaunay triangulation (`spade`) of each chart in its plane, with its
//! outline and its cuts as constraints.
//!
//! Points on an edge are made from the edge alone, in one direction, with the places where cuts end on it; the
//! charts on both sides get the very same points, and no crack.

use std::collections::{HashMap, HashSet};

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use spade::handles::{FaceHandle, FixedVertexHandle, InnerTag};
use spade::{CdtEdge, ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation};

use crate::Watcher;
use crate::chart::{Affine, Chart, Charts};
use crate::cut::{Cuts, Line, contact, foot};
use crate::surface::{Corner, Surface};

/// The refined triangles of the whole scene.
#[derive(Default)]
pub struct Fine {
    pub corners: Vec<Corner>,
    pub triangles: Vec<FineTriangle>,
}

#[derive(Clone, Copy, Debug)]
pub struct FineTriangle {
    pub corners: [u32; 3],
    pub batch: u32,
    /// Of the sides from corner k to k + 1.
    pub sides: [Side; 3],
}

/// What a side of a refined triangle is to patches and to receivers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Side {
    #[default]
    Open,
    /// Patches end, light goes on.
    Smooth,
    /// Nothing goes on.
    Cut,
}

/// `size`: the length of pieces where the density is 1, in scaled units. Told to stop, it gives what it has.
pub fn split(surface: &Surface, charts: &Charts, cuts: &Cuts, size: f64, watcher: &dyn Watcher) -> Fine {
    let ends = ends_on_edges(charts, cuts, size);
    let pieces: Vec<Fine> = (0..charts.charts.len())
        .into_par_iter()
        .map(|id| {
            if watcher.cancelled() {
                return Fine::default();
            }
            split_chart(
                surface,
                charts,
                cuts.get(&(id as u32)).map_or(&[], Vec::as_slice),
                &ends,
                size,
                id as u32,
            )
        })
        .collect();
    let mut fine = Fine::default();
    for piece in pieces {
        let first = fine.corners.len() as u32;
        fine.corners.extend(piece.corners);
        fine.triangles.extend(piece.triangles.into_iter().map(|mut triangle| {
            triangle.corners = triangle.corners.map(|corner| corner + first);
            triangle
        }));
    }
    fine
}

/// The density at a welded vertex or in a chart, as a length.
fn size_at(charts: &Charts, vertex: u32, size: f64) -> f64 {
    size / f64::from(charts.densities[vertex as usize]).max(1e-3)
}

/// Where cuts end on edges, as shares of the way from the edge's lower vertex to its higher one.
type Ends = HashMap<[u32; 2], Vec<f64>>;

fn ends_on_edges(charts: &Charts, cuts: &Cuts, size: f64) -> Ends {
    let mut ends = Ends::new();
    for (&id, lines) in cuts {
        let chart = &charts.charts[id as usize];
        for &[a, b] in &chart.outline {
            let (low, high) = (a.min(b), a.max(b));
            let flat = [low, high].map(|v| chart.frame.flat(charts.positions[v as usize]));
            let length = flat[0].distance(flat[1]);
            for p in lines.iter().flat_map(|line| line.ends) {
                let foot = foot(flat, p);
                let t = foot.distance(flat[0]) / length;
                if foot.distance(p) <= 1e-9 && t * length > 1e-9 && (1.0 - t) * length > 1e-9 {
                    ends.entry([low, high]).or_default().push(t);
                }
            }
        }
    }
    for (edge, ts) in &mut ends {
        let length = charts.positions[edge[0] as usize].distance(charts.positions[edge[1] as usize]);
        ts.sort_by(f64::total_cmp);
        ts.dedup_by(|a, b| (*a - *b) * length <= contact(size));
    }
    ends
}

/// The points that divide an edge, from `a` to `b`, both left out.
fn divide(charts: &Charts, ends: &Ends, [a, b]: [u32; 2], size: f64) -> Vec<DVec3> {
    let (low, high) = (a.min(b), a.max(b));
    let [from, to] = [low, high].map(|v| charts.positions[v as usize]);
    let length = from.distance(to);
    let step = 0.5 * (size_at(charts, low, size) + size_at(charts, high, size));
    let fixed = ends.get(&[low, high]).map_or(&[][..], Vec::as_slice);
    let mut ts: Vec<f64> = Vec::new();
    let mut last = 0.0;
    for &stop in fixed.iter().chain(&[1.0]) {
        let n = ((stop - last) * length / step - 0.3).ceil().max(1.0) as usize;
        ts.extend((1..=n).map(|i| if i == n { stop } else { last + (stop - last) * i as f64 / n as f64 }));
        last = stop;
    }
    ts.pop();
    if a > b {
        ts.reverse();
    }
    ts.into_iter().map(|t| from + (to - from) * t).collect()
}

/// A vertex of the triangulation: its place in the plane, and in space where an edge says it exactly.
struct Point {
    flat: DVec2,
    exact: Option<DVec3>,
}

impl HasPosition for Point {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        let clean = |x: f64| if x.abs() < 1e-40 { 0.0 } else { x };
        Point2::new(clean(self.flat.x), clean(self.flat.y))
    }
}

type Cdt = ConstrainedDelaunayTriangulation<Point>;

/// A chart's triangulation.
struct Divided {
    cdt: Cdt,
    /// Constraints across which light goes on, in both directions.
    smooth: HashSet<[FixedVertexHandle; 2]>,
}

type Face<'a> = FaceHandle<'a, InnerTag, Point, (), CdtEdge<()>, ()>;

fn split_chart(surface: &Surface, charts: &Charts, cuts: &[Line], ends: &Ends, size: f64, id: u32) -> Fine {
    let chart = &charts.charts[id as usize];
    let edges: Vec<Vec<DVec3>> = chart.outline.iter().map(|&edge| divide(charts, ends, edge, size)).collect();
    let finest =
        chart.outline.iter().map(|edge| size_at(charts, edge[0], size)).fold(f64::INFINITY, f64::min);
    let whole = cuts.is_empty() && edges.iter().all(Vec::is_empty) && chart.area <= 1.5 * finest * finest;
    if whole {
        return as_it_is(surface, chart);
    }
    let Some(divided) = triangulate(charts, chart, surface, cuts, &edges, size) else {
        return as_it_is(surface, chart);
    };
    let fine = read_off(surface, chart, &divided);
    // A sliver as narrow as what rounding leaves beside an edge stays whole.
    if area(&fine) < 0.5 * chart.area { as_it_is(surface, chart) } else { fine }
}

fn area(fine: &Fine) -> f64 {
    let of = |triangle: &FineTriangle| {
        let [a, b, c] = triangle.corners.map(|corner| fine.corners[corner as usize].position);
        0.5 * (b - a).cross(c - a).length()
    };
    fine.triangles.iter().map(of).sum()
}

fn as_it_is(surface: &Surface, chart: &Chart) -> Fine {
    let mut fine = Fine::default();
    for &t in &chart.triangles {
        let triangle = &surface.triangles[t as usize];
        let first = fine.corners.len() as u32;
        fine.corners.extend(triangle.corners);
        let corners = [first, first + 1, first + 2];
        fine.triangles.push(FineTriangle { corners, batch: triangle.batch, sides: [Side::Open; 3] });
    }
    fine
}

fn triangulate(
    charts: &Charts,
    chart: &Chart,
    surface: &Surface,
    cuts: &[Line],
    edges: &[Vec<DVec3>],
    size: f64,
) -> Option<Divided> {
    let mut cdt = Cdt::new();
    let mut outline: Vec<[FixedVertexHandle; 2]> = Vec::new();
    for (&[a, b], between) in chart.outline.iter().zip(edges) {
        let ends = [a, b].map(|vertex| charts.positions[vertex as usize]);
        let mut last = None;
        for p in [ends[0]].into_iter().chain(between.iter().copied()).chain([ends[1]]) {
            let vertex = insert(&mut cdt, chart.frame.flat(p), Some(p))?;
            if let Some(last) = last {
                outline.push([last, vertex]);
            }
            last = Some(vertex);
        }
    }
    for [a, b] in outline {
        constrain(&mut cdt, a, b);
    }
    let mut smooth = HashSet::new();
    for &Line { ends: [a, b], smooth: is_smooth } in cuts {
        let middle = chart.frame.place(a.midpoint(b));
        let step = size / f64::from(affine_of(surface, chart).at(middle).density).max(1e-3);
        let n = (a.distance(b) / step - 0.3).ceil().max(1.0) as usize;
        let mut last = insert(&mut cdt, a, None)?;
        for i in 1..=n {
            let next = insert(&mut cdt, a.lerp(b, i as f64 / n as f64), None)?;
            constrain(&mut cdt, last, next);
            if is_smooth {
                smooth.extend([[last, next], [next, last]]);
            }
            last = next;
        }
    }
    fill(&mut cdt, surface, chart, size);
    Some(Divided { cdt, smooth })
}

fn affine_of(surface: &Surface, chart: &Chart) -> Affine {
    let area = |&&t: &&u32| surface.triangles[t as usize].cross().length_squared();
    let largest = chart.triangles.iter().max_by(|a, b| area(a).total_cmp(&area(b)).then(b.cmp(a)));
    Affine::new(&surface.triangles[*largest.unwrap_or(&0) as usize].corners)
}

fn insert(cdt: &mut Cdt, flat: DVec2, exact: Option<DVec3>) -> Option<FixedVertexHandle> {
    let p = Point { flat, exact };
    let position = p.position();
    // A second point at the same place must not take the first one's exact place away.
    if let spade::PositionInTriangulation::OnVertex(vertex) = cdt.locate(position) {
        return Some(vertex);
    }
    cdt.insert(p).ok()
}

fn constrain(cdt: &mut Cdt, a: FixedVertexHandle, b: FixedVertexHandle) {
    if a == b {
        return;
    }
    // Cuts meet in their ends alone; what rounding makes cross all the same is left out.
    if cdt.can_add_constraint(a, b) {
        cdt.add_constraint(a, b);
    }
}

/// Points inside: a staggered grid, finer by halves where the density asks for it, kept off the constraints.
fn fill(cdt: &mut Cdt, surface: &Surface, chart: &Chart, size: f64) {
    let affine = affine_of(surface, chart);
    let corners: Vec<[DVec2; 3]> = chart
        .triangles
        .iter()
        .map(|&t| surface.triangles[t as usize].positions().map(|p| chart.frame.flat(p)))
        .collect();
    let low = corners.iter().flatten().fold(DVec2::INFINITY, |low, &p| low.min(p));
    let high = corners.iter().flatten().fold(DVec2::NEG_INFINITY, |high, &p| high.max(p));
    let extent = high - low;
    // The coarsest step that occurs; every cell of the grid is halved until it fits.
    let densities =
        chart.triangles.iter().flat_map(|&t| surface.triangles[t as usize].corners.map(|c| c.density));
    let coarsest = size / f64::from(densities.fold(f32::INFINITY, f32::min)).max(1e-3);
    let cells = (extent / coarsest).round().max(DVec2::ONE);
    let step = extent / cells;
    for j in 0..cells.y as i64 {
        for i in 0..cells.x as i64 {
            let cell = low + DVec2::new(i as f64, j as f64) * step;
            fill_cell(cdt, &affine, chart, &corners, cell, step, j & 1 == 1, size);
        }
    }
}

#[expect(clippy::too_many_arguments, reason = "one recursive step over what `fill` knows")]
fn fill_cell(
    cdt: &mut Cdt,
    affine: &Affine,
    chart: &Chart,
    corners: &[[DVec2; 3]],
    cell: DVec2,
    step: DVec2,
    odd: bool,
    size: f64,
) {
    let centre = chart.frame.place(cell + step * 0.5);
    let wanted = size / f64::from(affine.at(centre).density.clamp(1.0 / 16.0, 16.0));
    if step.max_element() > 1.42 * wanted {
        for k in 0..4 {
            let at = cell + step * 0.5 * DVec2::new(f64::from(k & 1), f64::from(k >> 1));
            fill_cell(cdt, affine, chart, corners, at, step * 0.5, k >> 1 == 1, size);
        }
        return;
    }
    let shift = if odd { 0.25 } else { -0.25 };
    let p = cell + DVec2::new(shift * step.x, 0.0);
    if inside(corners, p) && is_clear(cdt, p, step.min_element()) {
        insert(cdt, p, None);
    }
}

/// Is a point well away from the vertices and constraints of the triangles that it would divide? Two where it lies on the
/// side between them, as the rows of a grid do where the points on an outline are as far apart.
fn is_clear(cdt: &Cdt, p: DVec2, step: f64) -> bool {
    match cdt.locate(Point2::new(p.x, p.y)) {
        spade::PositionInTriangulation::OnFace(face) => is_clear_in(cdt.face(face), p, step),
        spade::PositionInTriangulation::OnEdge(edge) => {
            let edge = cdt.directed_edge(edge);
            let mut beside = [edge.face(), edge.rev().face()].into_iter().filter_map(|face| face.as_inner());
            !edge.is_constraint_edge() && beside.all(|face| is_clear_in(face, p, step))
        }
        _ => false,
    }
}

fn is_clear_in(face: Face, p: DVec2, step: f64) -> bool {
    let far_from_edges = face.adjacent_edges().iter().all(|edge| {
        let ends = [edge.from().data().flat, edge.to().data().flat];
        !edge.is_constraint_edge() || foot(ends, p).distance(p) > 0.4 * step
    });
    far_from_edges && face.vertices().iter().all(|vertex| vertex.data().flat.distance(p) > 0.6 * step)
}

/// In one of the triangles; on a side that two of them share counts, whatever rounding says.
fn inside(corners: &[[DVec2; 3]], p: DVec2) -> bool {
    corners.iter().any(|c| (0..3).all(|k| (c[(k + 1) % 3] - c[k]).perp_dot(p - c[k]) >= -1e-12))
}

/// The triangles inside the chart, with their attributes.
fn read_off(surface: &Surface, chart: &Chart, Divided { cdt, smooth }: &Divided) -> Fine {
    let affine = affine_of(surface, chart);
    let batch = surface.triangles[chart.triangles[0] as usize].batch;
    let corners: Vec<[DVec2; 3]> = chart
        .triangles
        .iter()
        .map(|&t| surface.triangles[t as usize].positions().map(|p| chart.frame.flat(p)))
        .collect();
    let is_inside: Vec<bool> = {
        let mut is_inside = vec![false; cdt.num_all_faces()];
        for face in cdt.inner_faces() {
            let [a, b, c] = face.vertices().map(|vertex| vertex.data().flat);
            is_inside[face.index()] = inside(&corners, (a + b + c) / 3.0);
        }
        is_inside
    };
    let place = |point: &Point| point.exact.unwrap_or_else(|| chart.frame.place(point.flat));
    let corners = cdt.vertices().map(|vertex| affine.at(place(vertex.data()))).collect();
    let mut fine = Fine { corners, triangles: Vec::new() };
    for face in cdt.inner_faces().filter(|face| is_inside[face.index()]) {
        let corners = face.vertices().map(|vertex| vertex.index() as u32);
        let [a, b, c] = corners.map(|corner| fine.corners[corner as usize].position);
        let cross = (b - a).cross(c - a).length();
        let longest = (b - a).length_squared().max((c - a).length_squared()).max((c - b).length_squared());
        if cross <= 1e-5 * longest {
            continue; // what rounding leaves between an edge and the points that divide it
        }
        let sides = face.adjacent_edges().map(|edge| {
            let other = edge.rev().face();
            match edge.is_constraint_edge() && !other.is_outer() && is_inside[other.index()] {
                true if smooth.contains(&[edge.from().fix(), edge.to().fix()]) => Side::Smooth,
                true => Side::Cut,
                false => Side::Open,
            }
        });
        fine.triangles.push(FineTriangle { corners, batch, sides });
    }
    fine
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use engine::scene::assets::Assets;
    use engine::scene::shape::{self, Shape};
    use engine::scene::{Entity, EntityId, MeshRenderer, MeshSource, Scene, Transform};

    use super::*;
    use crate::layout::layout;
    use crate::surface::sanitise;

    /// The longest side of a triangle in a rectangle whose pieces are to be `spacing` long, in spacings.
    fn longest_side(width: f64, height: f64, spacing: f64) -> f32 {
        let mesh = MeshSource::Shape(Shape::Plane);
        let renderer = MeshRenderer {
            mesh: mesh.clone(),
            materials: Vec::new(),
            casts_shadows: true,
            density: Default::default(),
            reflection: Default::default(),
        };
        let transform = Transform { scale: DVec3::new(width, 1.0, height), ..Transform::default() };
        let plane =
            Entity { id: EntityId(1), is_static: true, mesh: Some(renderer), transform, ..Entity::default() };
        let scene = Scene { entities: vec![plane], ..Scene::default() };
        let mut assets = Assets::default();
        assets.meshes.insert(mesh, Arc::new(shape::mesh(Shape::Plane)));
        let surface = sanitise(&scene, &assets).unwrap();
        let transport = layout(&scene, &assets, &surface, 2.0 * spacing, &crate::Silent).unwrap().transport;
        let longest = |t: usize| {
            let [a, b, c] = transport.surface.positions(t);
            a.distance(b).max(b.distance(c)).max(c.distance(a))
        };
        (0..transport.surface.triangles.len()).map(longest).fold(0.0, f32::max) / spacing as f32
    }

    #[test]
    fn no_point_of_the_grid_is_lost_where_it_lies_on_a_side() {
        for step in 0..40 {
            let spacing = 0.12 + 0.005 * f64::from(step);
            for [width, height] in [[2.2, 2.0], [6.0, 3.2], [2.0, 2.0]] {
                let longest = longest_side(width, height, spacing);
                assert!(longest < 2.2, "{width} x {height} m, {spacing:.3} m apart: a side of {longest}");
            }
        }
    }
}
