//! Probes in one plane: the triangle of their Delaunay triangulation below the place, or the nearest point of the
//! triangulation's outline.

use glam::{DVec2, DVec3};
use spade::{
    DelaunayTriangulation, HasPosition, HierarchyHintGenerator, Point2, PositionInTriangulation,
    Triangulation,
};

use super::{Blend, HOLLOW, only};

#[derive(Clone, Debug)]
pub struct Plane {
    start: DVec3,
    axes: [DVec3; 2],
    /// The outline is made smaller about its middle, as in [`super::space`], to this share.
    middle: DVec2,
    size: f64,
    triangles: DelaunayTriangulation<Corner, (), (), (), HierarchyHintGenerator<f64>>,
}

#[derive(Clone, Copy, Debug)]
struct Corner {
    at: Point2<f64>,
    point: u32,
}

impl HasPosition for Corner {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.at
    }
}

impl Plane {
    /// `None` where the points cannot be told apart in the plane.
    pub fn new(points: &[DVec3], corners: [u32; 3]) -> Option<Self> {
        let [a, b, c] = corners.map(|corner| points[corner as usize]);
        let axes = axes(b - a, c - a);
        let at = |point: DVec3| axes.map(|axis| (point - a).dot(axis));
        let corners = (0..).zip(points).map(|(point, &position)| {
            // Far below a step of the grid, and nothing too small for `spade`.
            let [x, y] = at(position).map(|x| (x * 1024.0).round() / 1024.0);
            Corner { at: Point2::new(x, y), point }
        });
        let triangles = DelaunayTriangulation::bulk_load_stable(corners.collect()).ok()?;
        let mut plane = Self { start: a, axes, middle: DVec2::ZERO, size: 1.0, triangles };
        plane.middle = plane.triangles.vertices().map(|vertex| corner(vertex.data()).0).sum::<DVec2>()
            / points.len() as f64;
        let depth = plane
            .outline()
            .map(|[(from, _), (to, _)]| (to - from).normalize().perp_dot(plane.middle - from).abs());
        plane.size = 1.0 - (HOLLOW / depth.fold(f64::INFINITY, f64::min)).min(0.5);
        (plane.triangles.num_inner_faces() > 0).then_some(plane)
    }

    fn outline(&self) -> impl Iterator<Item = [(DVec2, u32); 2]> + '_ {
        self.triangles.convex_hull().map(|edge| edge.vertices().map(|end| corner(end.data())))
    }

    pub fn blend(&self, at: DVec3) -> Blend {
        let at = DVec2::from(self.axes.map(|axis| (at - self.start).dot(axis)));
        let outer = self.middle + (at - self.middle) / self.size;
        let is_outside = matches!(self.locate(outer), PositionInTriangulation::OutsideOfConvexHull(_));
        self.at(if is_outside {
            self.middle + (self.on_outline(outer) - self.middle) * self.size
        } else {
            at
        })
    }

    fn locate(&self, at: DVec2) -> PositionInTriangulation {
        self.triangles.locate(Point2::new(at.x, at.y))
    }

    fn at(&self, at: DVec2) -> Blend {
        match self.locate(at) {
            PositionInTriangulation::OnVertex(vertex) => only(self.triangles.vertex(vertex).data().point),
            PositionInTriangulation::OnEdge(edge) => {
                let [(a, i), (b, j)] =
                    self.triangles.directed_edge(edge).vertices().map(|end| corner(end.data()));
                let t = along(a, b, at);
                [(i, 1.0 - t), (j, t), (i, 0.0), (i, 0.0)]
            }
            PositionInTriangulation::OnFace(face) => {
                let corners = self.triangles.face(face).vertices().map(|vertex| corner(vertex.data()));
                in_triangle(corners, at)
            }
            _ => only(0),
        }
    }

    /// The outline's nearest point.
    fn on_outline(&self, at: DVec2) -> DVec2 {
        let nearest = self.outline().map(|[(a, _), (b, _)]| a + (b - a) * along(a, b, at));
        let least = |a: &DVec2, b: &DVec2| a.distance_squared(at).total_cmp(&b.distance_squared(at));
        nearest.min_by(least).unwrap_or(at)
    }

    pub fn edges(&self) -> Vec<([u32; 2], bool)> {
        let edge = |edge: spade::handles::UndirectedEdgeHandle<'_, Corner, (), (), ()>| {
            (edge.vertices().map(|end| end.data().point), edge.is_part_of_convex_hull())
        };
        self.triangles.undirected_edges().map(edge).collect()
    }
}

/// Two unit vectors in the plane; the axes' own where it lies along them, so that grids stay grids.
fn axes(first: DVec3, second: DVec3) -> [DVec3; 2] {
    let normal = first.cross(second);
    let is_along = |axis: DVec3| normal.cross(axis) == DVec3::ZERO;
    match [DVec3::X, DVec3::Y, DVec3::Z].map(is_along) {
        [true, ..] => [DVec3::Y, DVec3::Z],
        [_, true, _] => [DVec3::Z, DVec3::X],
        [.., true] => [DVec3::X, DVec3::Y],
        _ => [first.normalize(), normal.cross(first).normalize()],
    }
}

fn corner(data: &Corner) -> (DVec2, u32) {
    (DVec2::new(data.at.x, data.at.y), data.point)
}

/// Share of the way from a to b at the nearest point between them.
fn along(a: DVec2, b: DVec2, at: DVec2) -> f64 {
    ((at - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0)
}

fn in_triangle([(a, i), (b, j), (c, k)]: [(DVec2, u32); 3], at: DVec2) -> Blend {
    let weights = [(b, c), (c, a), (a, b)].map(|(from, to)| (to - from).perp_dot(at - from).max(0.0));
    let sum: f64 = weights.iter().sum();
    [(i, weights[0] / sum), (j, weights[1] / sum), (k, weights[2] / sum), (i, 0.0)]
}
