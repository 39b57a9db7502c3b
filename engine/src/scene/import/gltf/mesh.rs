//! Meshes: primitives of triangles, strips and fans become the primitives of one mesh.

use glam::{Vec2, Vec3, Vec4};

use super::Gltf;
use super::accessor::{floats, indices};
use super::json::{Primitive, get};
use crate::scene::import::triangles::{Part, joined};
use crate::scene::{Mesh, Warning};

/// Whether the primitive has a place in the mesh (points and lines have none).
pub fn makes_triangles(primitive: &Primitive) -> bool {
    matches!(primitive.mode.unwrap_or(4), 4..=6) && primitive.attributes.contains_key("POSITION")
}

/// The n-th mesh of the file, its primitives in the order of those that [`makes_triangles`].
pub fn mesh(gltf: &Gltf, index: usize) -> Result<(Mesh, Vec<Warning>), String> {
    let mesh = get(&gltf.root.meshes, index, "mesh")?;
    let name = mesh_name(gltf, index);
    let drawn = mesh.primitives.iter().enumerate().filter(|(_, primitive)| makes_triangles(primitive));
    let parts = drawn.map(|(n, primitive)| (n, part(gltf, primitive)));
    let (joined, dropped) = joined(parts).map_err(|message| format!("{name}: {message}"))?;
    let mut warnings = Vec::new();
    if dropped > 0 {
        let message =
            format!("{name}: {dropped} triangles have corners that are not finite and were dropped");
        warnings.push(Warning::new(&gltf.file, message));
    }
    Ok((joined, warnings))
}

/// For messages.
pub fn mesh_name(gltf: &Gltf, index: usize) -> String {
    match gltf.root.meshes.get(index).and_then(|mesh| mesh.name.as_deref()) {
        Some(name) => format!("mesh {index} `{name}`"),
        None => format!("mesh {index}"),
    }
}

fn part(gltf: &Gltf, primitive: &Primitive) -> Result<Part, String> {
    let positions = vec3s(gltf, primitive, "POSITION")?.unwrap_or_default();
    let corners = match primitive.indices {
        Some(accessor) => indices(gltf, accessor)?,
        None => (0..positions.len() as u32).collect(),
    };
    Ok(Part {
        normals: vec3s(gltf, primitive, "NORMAL")?,
        tangents: rows(gltf, primitive, "TANGENT", &[4], |row| Vec4::from_slice(row))?,
        uvs: [uvs(gltf, primitive, "TEXCOORD_0")?, uvs(gltf, primitive, "TEXCOORD_1")?],
        colors: rows(gltf, primitive, "COLOR_0", &[3, 4], color)?,
        indices: triangles(primitive.mode.unwrap_or(4), corners),
        positions,
    })
}

fn vec3s(gltf: &Gltf, primitive: &Primitive, name: &str) -> Result<Option<Vec<Vec3>>, String> {
    rows(gltf, primitive, name, &[3], |row| Vec3::from_slice(row))
}

fn uvs(gltf: &Gltf, primitive: &Primitive, name: &str) -> Result<Option<Vec<Vec2>>, String> {
    rows(gltf, primitive, name, &[2], |row| Vec2::from_slice(row))
}

fn color(row: &[f32]) -> Vec4 {
    Vec4::new(row[0], row[1], row[2], row.get(3).copied().unwrap_or(1.0))
}

fn rows<T>(
    gltf: &Gltf,
    primitive: &Primitive,
    name: &str,
    widths: &[usize],
    make: impl Fn(&[f32]) -> T,
) -> Result<Option<Vec<T>>, String> {
    let Some(&accessor) = primitive.attributes.get(name) else { return Ok(None) };
    let rows = floats(gltf, accessor, widths).map_err(|message| format!("{name}: {message}"))?;
    Ok(Some(rows.values.chunks_exact(rows.width).map(make).collect()))
}

/// Strips and fans as single triangles, with the winding that glTF gives them.
fn triangles(mode: u32, corners: Vec<u32>) -> Vec<u32> {
    match mode {
        5 => {
            let turned =
                |(n, t): (usize, &[u32])| if n % 2 == 0 { [t[0], t[1], t[2]] } else { [t[0], t[2], t[1]] };
            corners.windows(3).enumerate().flat_map(turned).collect()
        }
        6 => corners.get(1..).unwrap_or(&[]).windows(2).flat_map(|t| [t[0], t[1], corners[0]]).collect(),
        _ => corners,
    }
}
