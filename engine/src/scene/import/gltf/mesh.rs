//! Meshes: primitives of triangles, strips and fans become the primitives of one mesh.

use glam::Vec3;
use gltf::accessor::{DataType, Dimensions};
use gltf::mesh::{Mode, Primitive, Semantic};

use super::accessor::{Fit, VECTORS, bytes_of, read};
use super::{Gltf, find};
use crate::scene::import::triangles::{Part, joined};
use crate::scene::{Mesh, Warning};

const TANGENTS: Fit = (&[Dimensions::Vec4], &[DataType::F32]);
const UVS: Fit = (&[Dimensions::Vec2], &[DataType::F32, DataType::U8, DataType::U16]);
const COLORS: Fit = (&[Dimensions::Vec3, Dimensions::Vec4], &[DataType::F32, DataType::U8, DataType::U16]);
const INDICES: Fit = (&[Dimensions::Scalar], &[DataType::U8, DataType::U16, DataType::U32]);

/// Whether the primitive has a place in the mesh (points and lines have none).
pub fn makes_triangles(primitive: &Primitive) -> bool {
    let has_positions = primitive.get(&Semantic::Positions).is_some();
    has_positions && matches!(primitive.mode(), Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)
}

/// The n-th mesh of the file, its primitives in the order of those that [`makes_triangles`].
pub fn mesh(gltf: &Gltf, index: usize) -> Result<(Mesh, Vec<Warning>), String> {
    let mesh = find(gltf.document.meshes(), index, "mesh")?;
    let name = mesh_name(&mesh);
    let parts = mesh.primitives().filter(makes_triangles);
    let parts = parts.map(|primitive| (primitive.index(), part(gltf, &primitive)));
    let (joined, repairs) = joined(parts).map_err(|message| format!("{name}: {message}"))?;
    let warn = |message| Warning::new(&gltf.file, format!("{name}: {message}"));
    Ok((joined, repairs.messages().map(warn).collect()))
}

/// For messages.
pub fn mesh_name(mesh: &gltf::Mesh) -> String {
    match mesh.name() {
        Some(name) => format!("mesh {} `{name}`", mesh.index()),
        None => format!("mesh {}", mesh.index()),
    }
}

fn part(gltf: &Gltf, primitive: &Primitive) -> Result<Part, String> {
    let reader = primitive.reader(bytes_of(gltf));
    let uvs = |set: u32| {
        let uvs = || reader.read_tex_coords(set).map(|uvs| uvs.into_f32());
        rows(gltf, primitive, Semantic::TexCoords(set), UVS, uvs)
    };
    let colors = || reader.read_colors(0).map(|colors| colors.into_rgba_f32());
    let positions = rows(gltf, primitive, Semantic::Positions, VECTORS, || reader.read_positions())?;
    let positions: Vec<Vec3> = positions.unwrap_or_default();
    let corners = match primitive.indices() {
        Some(accessor) => {
            read(gltf, &accessor, INDICES, 0, || reader.read_indices().map(|indices| indices.into_u32()))?
        }
        None => (0..positions.len() as u32).collect(),
    };
    Ok(Part {
        normals: rows(gltf, primitive, Semantic::Normals, VECTORS, || reader.read_normals())?,
        tangents: rows(gltf, primitive, Semantic::Tangents, TANGENTS, || reader.read_tangents())?,
        uvs: [uvs(0)?, uvs(1)?],
        colors: rows(gltf, primitive, Semantic::Colors(0), COLORS, colors)?,
        indices: triangles(primitive.mode(), corners),
        positions,
    })
}

fn rows<T: From<[f32; N]>, const N: usize, I: Iterator<Item = [f32; N]>>(
    gltf: &Gltf,
    primitive: &Primitive,
    semantic: Semantic,
    fit: Fit,
    reader: impl FnOnce() -> Option<I>,
) -> Result<Option<Vec<T>>, String> {
    let Some(accessor) = primitive.get(&semantic) else { return Ok(None) };
    let rows = read(gltf, &accessor, fit, [0.0; N], reader);
    let rows = rows.map_err(|message| format!("{}: {message}", semantic.to_string()))?;
    Ok(Some(rows.into_iter().map(T::from).collect()))
}

/// Strips and fans as single triangles, with the winding that glTF gives them.
fn triangles(mode: Mode, corners: Vec<u32>) -> Vec<u32> {
    match mode {
        Mode::TriangleStrip => {
            let turned =
                |(n, t): (usize, &[u32])| if n % 2 == 0 { [t[0], t[1], t[2]] } else { [t[0], t[2], t[1]] };
            corners.windows(3).enumerate().flat_map(turned).collect()
        }
        Mode::TriangleFan => {
            corners.get(1..).unwrap_or(&[]).windows(2).flat_map(|t| [t[0], t[1], corners[0]]).collect()
        }
        _ => corners,
    }
}
