//! Meshes that the engine makes itself.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};
use serde::{Deserialize, Serialize};

use super::Mesh;
use super::mesh::Primitive;

/// One metre across, about the origin.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    Cube,
    Sphere,
    Cylinder,
    /// In the XZ plane, facing +Y.
    Plane,
    /// In the XY plane, facing +Z.
    Quad,
}

const SEGMENTS: u32 = 32;
const RINGS: u32 = 16;

/// The shape's mesh: one primitive, with texture coordinates 0 (v downwards).
pub fn mesh(shape: Shape) -> Mesh {
    let mut mesh = Mesh { uvs: [Some(Vec::new()), None], ..Mesh::default() };
    match shape {
        Shape::Cube => cube(&mut mesh),
        Shape::Sphere => sphere(&mut mesh),
        Shape::Cylinder => cylinder(&mut mesh),
        Shape::Plane => square(&mut mesh, Vec3::X, Vec3::NEG_Z, 0.0),
        Shape::Quad => square(&mut mesh, Vec3::X, Vec3::Y, 0.0),
    }
    mesh.primitives = vec![Primitive { first: 0, count: mesh.indices.len() as u32 }];
    mesh
}

fn vertex(mesh: &mut Mesh, position: Vec3, normal: Vec3, uv: Vec2) {
    mesh.positions.push(position);
    mesh.normals.push(normal);
    mesh.uvs[0].get_or_insert_default().push(uv);
}

/// A square of side 1 that faces right x up, `distance` from the origin.
fn square(mesh: &mut Mesh, right: Vec3, up: Vec3, distance: f32) {
    let first = mesh.positions.len() as u32;
    let normal = right.cross(up);
    for (x, y) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
        let position = normal * distance + right * (x - 0.5) + up * (y - 0.5);
        vertex(mesh, position, normal, Vec2::new(x, 1.0 - y));
    }
    mesh.indices.extend([0, 1, 2, 0, 2, 3].map(|index| first + index));
}

fn cube(mesh: &mut Mesh) {
    for (right, up) in [
        (Vec3::X, Vec3::Y),
        (Vec3::NEG_X, Vec3::Y),
        (Vec3::NEG_Z, Vec3::Y),
        (Vec3::Z, Vec3::Y),
        (Vec3::X, Vec3::NEG_Z),
        (Vec3::X, Vec3::Z),
    ] {
        square(mesh, right, up, 0.5);
    }
}

/// Rings from the north pole down; the seam's vertices are double.
fn sphere(mesh: &mut Mesh) {
    for ring in 0..=RINGS {
        let v = ring as f32 / RINGS as f32;
        let (radius, y) = (PI * v).sin_cos();
        for segment in 0..=SEGMENTS {
            let u = segment as f32 / SEGMENTS as f32;
            let normal = on_ring(segment, radius, y).normalize();
            vertex(mesh, normal * 0.5, normal, Vec2::new(u, v));
        }
    }
    for ring in 0..RINGS {
        let [above, below] = [ring, ring + 1].map(|ring| ring * (SEGMENTS + 1));
        for segment in 0..SEGMENTS {
            let [a, b] = [above + segment, above + segment + 1];
            let [c, d] = [below + segment, below + segment + 1];
            if ring > 0 {
                mesh.indices.extend([a, c, b]);
            }
            if ring + 1 < RINGS {
                mesh.indices.extend([b, c, d]);
            }
        }
    }
}

fn cylinder(mesh: &mut Mesh) {
    for segment in 0..=SEGMENTS {
        let u = segment as f32 / SEGMENTS as f32;
        let normal = on_ring(segment, 1.0, 0.0);
        vertex(mesh, normal * 0.5 + Vec3::Y * 0.5, normal, Vec2::new(u, 0.0));
        vertex(mesh, normal * 0.5 - Vec3::Y * 0.5, normal, Vec2::new(u, 1.0));
    }
    for first in (0..SEGMENTS).map(|segment| 2 * segment) {
        mesh.indices.extend([0, 1, 2, 2, 1, 3].map(|index| first + index));
    }
    cap(mesh, 1.0);
    cap(mesh, -1.0);
}

/// A disc at the top (1) or the bottom (-1).
fn cap(mesh: &mut Mesh, side: f32) {
    let first = mesh.positions.len() as u32;
    let normal = Vec3::Y * side;
    vertex(mesh, normal * 0.5, normal, Vec2::splat(0.5));
    for segment in 0..SEGMENTS {
        let around = on_ring(segment, 1.0, 0.0);
        let uv = Vec2::new(0.5 + 0.5 * around.x, 0.5 + 0.5 * around.z * side);
        vertex(mesh, 0.5 * (around + normal), normal, uv);
    }
    for segment in 0..SEGMENTS {
        let [a, b] = [segment, (segment + 1) % SEGMENTS].map(|segment| first + 1 + segment);
        mesh.indices.extend(if side > 0.0 { [first, a, b] } else { [first, b, a] });
    }
}

/// Counter-clockwise as seen from above, from +X.
fn on_ring(segment: u32, radius: f32, y: f32) -> Vec3 {
    let angle = TAU * (segment % SEGMENTS) as f32 / SEGMENTS as f32;
    Vec3::new(radius * angle.cos(), y, -radius * angle.sin())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area_and_volume(mesh: &Mesh) -> (f32, f32) {
        let triangle = |t: [u32; 3]| {
            let [a, b, c] = t.map(|index| mesh.positions[index as usize]);
            ((b - a).cross(c - a).length() / 2.0, a.dot(b.cross(c)) / 6.0)
        };
        mesh.triangles().map(triangle).fold((0.0, 0.0), |sum, one| (sum.0 + one.0, sum.1 + one.1))
    }

    #[test]
    fn shapes_are_closed_and_one_metre_across() {
        let (round_area, round_volume) = (PI, PI / 6.0);
        for (shape, area, volume, tolerance) in [
            (Shape::Cube, 6.0, 1.0, 1e-5),
            (Shape::Sphere, round_area, round_volume, 0.02),
            (Shape::Cylinder, 1.5 * PI, PI / 4.0, 0.01),
            (Shape::Plane, 1.0, 0.0, 1e-5),
            (Shape::Quad, 1.0, 0.0, 1e-5),
        ] {
            let mesh = mesh(shape);
            mesh.validate().unwrap();
            let found = area_and_volume(&mesh);
            assert!((found.0 / area - 1.0).abs() < tolerance, "{shape:?} {found:?}");
            assert!((found.1 - volume).abs() <= tolerance, "{shape:?} {found:?}");
        }
    }

    #[test]
    fn faces_of_shapes_look_where_their_normals_do() {
        for shape in [Shape::Cube, Shape::Sphere, Shape::Cylinder, Shape::Plane, Shape::Quad] {
            let mesh = mesh(shape);
            for t in mesh.triangles() {
                let [a, b, c] = t.map(|index| mesh.positions[index as usize]);
                let face = (b - a).cross(c - a).normalize();
                for index in t {
                    let normal = mesh.normals[index as usize];
                    assert!(normal.is_normalized() && normal.dot(face) > 0.9, "{shape:?}");
                }
            }
        }
    }
}
