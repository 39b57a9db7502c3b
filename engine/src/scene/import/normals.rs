//! Normals other than the file's own: flat ones, or the mean of the triangles around a point.

use std::collections::HashMap;

use glam::{DVec3, Vec3};

use super::settings::Normals;
use crate::scene::Mesh;

/// Tangents belong to normals: where these change, those go.
pub fn settle(mesh: &mut Mesh, normals: Normals) {
    match normals {
        Normals::File => {}
        Normals::Flat => flatten(mesh),
        Normals::Smooth => smooth(mesh),
    }
}

/// Every triangle with three vertices of its own, which carry its normal.
fn flatten(mesh: &mut Mesh) {
    let indices = std::mem::take(&mut mesh.indices);
    let uvs = [0, 1].map(|set| mesh.uvs[set].as_ref().map(|uvs| spread(uvs, &indices)));
    let colors = mesh.colors.as_ref().map(|colors| spread(colors, &indices));
    let positions = spread(&mesh.positions, &indices);
    let faces = positions.chunks_exact(3).map(|corners| weighted_normal(corners).as_vec3());
    mesh.normals = faces.flat_map(|normal| [unit(normal); 3]).collect();
    mesh.indices = (0..indices.len() as u32).collect();
    (mesh.positions, mesh.uvs, mesh.colors) = (positions, uvs, colors);
    (mesh.tangents, mesh.copies) = (None, Vec::new());
}

/// Vertices of one place share a normal, whatever else tells them apart.
fn smooth(mesh: &mut Mesh) {
    let place = |position: Vec3| (position + Vec3::ZERO).to_array().map(f32::to_bits); // no negative zero
    let mut around: HashMap<[u32; 3], DVec3> = HashMap::new();
    for triangle in mesh.triangles() {
        let corners = triangle.map(|index| mesh.positions[index as usize]);
        let normal = weighted_normal(&corners);
        for corner in corners {
            *around.entry(place(corner)).or_default() += normal;
        }
    }
    let normal = |position: &Vec3| {
        let sum = around.get(&place(*position)).copied().unwrap_or_default();
        unit(sum.try_normalize().unwrap_or_default().as_vec3())
    };
    mesh.normals = mesh.positions.iter().map(normal).collect();
    mesh.tangents = None;
}

/// Along the triangle's normal, twice as long as its area.
fn weighted_normal(corners: &[Vec3]) -> DVec3 {
    let [a, b, c] = [0, 1, 2].map(|corner| corners[corner].as_dvec3());
    (b - a).cross(c - a)
}

fn unit(normal: Vec3) -> Vec3 {
    normal.as_dvec3().try_normalize().map_or(Vec3::Y, |normal| normal.as_vec3())
}

fn spread<T: Copy>(values: &[T], indices: &[u32]) -> Vec<T> {
    indices.iter().map(|&index| values[index as usize]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::shape::{Shape, mesh};

    #[test]
    fn a_cube_made_smooth_shines_like_a_ball_and_made_flat_is_a_cube_again() {
        let mut cube = mesh(Shape::Cube);
        let own = cube.clone();
        settle(&mut cube, Normals::File);
        assert_eq!(cube, own);
        settle(&mut cube, Normals::Smooth);
        cube.validate().unwrap();
        for (position, normal) in cube.positions.iter().zip(&cube.normals) {
            // Each corner belongs to three faces, with one or two triangles of each.
            assert!(normal.dot(position.normalize()) > 0.9 && normal.is_normalized(), "{position} {normal}");
        }
        settle(&mut cube, Normals::Flat);
        cube.validate().unwrap();
        assert_eq!(cube.positions.len(), 36);
        for normal in &cube.normals {
            assert_eq!(normal.abs().max_element(), 1.0);
        }
    }
}
