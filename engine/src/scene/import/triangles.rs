//! From what files hold to a [`Mesh`]: parts that share a material, made whole and joined.
//!
//! A part may lack normals (each triangle is then flat, with vertices of its own), or hold numbers that are
//! none (such triangles are dropped, such normals replaced). Triangles without an area stay: the bake drops
//! and counts them.

use glam::{Vec2, Vec3, Vec4};

use crate::scene::Mesh;
use crate::scene::mesh::Primitive;

/// More vertices or indices than any mesh of use has: a file that repeats its arrays for ever ends here.
const MOST: usize = 1 << 25;

/// One material's triangles. Attributes that are present have one entry a vertex.
#[derive(Clone, Debug, Default)]
pub struct Part {
    pub positions: Vec<Vec3>,
    pub normals: Option<Vec<Vec3>>,
    pub tangents: Option<Vec<Vec4>>,
    pub uvs: [Option<Vec<Vec2>>; 2],
    pub colors: Option<Vec<Vec4>>,
    pub indices: Vec<u32>,
}

/// What was no number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Repairs {
    /// Triangles whose corners are not finite.
    pub dropped: usize,
    /// Normals, texture coordinates and colours that are not finite.
    pub replaced: usize,
}

impl Repairs {
    /// For people.
    pub fn messages(&self) -> impl Iterator<Item = String> {
        let Self { dropped, replaced } = *self;
        let of_triangles = format!("{dropped} triangles have corners that are not finite and were dropped");
        let of_attributes =
            format!("{replaced} normals, texture coordinates or colours are not finite and were replaced");
        [(dropped, of_triangles), (replaced, of_attributes)]
            .into_iter()
            .filter(|(count, _)| *count > 0)
            .map(|(_, message)| message)
    }
}

/// The parts (each with its number in the file, for messages) as the primitives of one mesh, and what had to be
/// repaired in them.
pub fn joined(parts: impl Iterator<Item = (usize, Result<Part, String>)>) -> Result<(Mesh, Repairs), String> {
    let mut mesh = Mesh::default();
    let mut repairs = Repairs::default();
    for (n, part) in parts {
        let (part, of_part) =
            part.and_then(repaired).map_err(|message| format!("primitive {n}: {message}"))?;
        if (mesh.positions.len() + part.positions.len()).max(mesh.indices.len() + part.indices.len()) > MOST {
            return Err(format!("has more than {MOST} vertices or indices: divide it"));
        }
        repairs.dropped += of_part.dropped;
        repairs.replaced += of_part.replaced;
        append(&mut mesh, part);
    }
    Ok((mesh, repairs))
}

fn repaired(mut part: Part) -> Result<(Part, Repairs), String> {
    check_lengths(&part)?;
    let before = part.indices.len();
    let replaced = not_finite(&part);
    drop_unusable_triangles(&mut part);
    let dropped = (before - part.indices.len()) / 3;
    if part.normals.is_none() {
        part = flat(&part);
    }
    repair_normals(&mut part);
    repair_attributes(&mut part);
    Ok((part, Repairs { dropped, replaced }))
}

fn not_finite(part: &Part) -> usize {
    let normals = part.normals.iter().flatten().filter(|normal| !normal.is_finite()).count();
    let uvs = part.uvs.iter().flatten().flatten().filter(|uv| !uv.is_finite()).count();
    normals + uvs + part.colors.iter().flatten().filter(|color| !color.is_finite()).count()
}

fn check_lengths(part: &Part) -> Result<(), String> {
    let n = part.positions.len();
    let lengths = [
        ("normals", part.normals.as_ref().map(Vec::len)),
        ("tangents", part.tangents.as_ref().map(Vec::len)),
        ("texture coordinates", part.uvs[0].as_ref().map(Vec::len)),
        ("texture coordinates", part.uvs[1].as_ref().map(Vec::len)),
        ("colours", part.colors.as_ref().map(Vec::len)),
    ];
    for (what, length) in lengths {
        if let Some(length) = length.filter(|&length| length != n) {
            return Err(format!("has {length} {what} for {n} positions"));
        }
    }
    match part.indices.iter().find(|&&index| index as usize >= n) {
        Some(index) => Err(format!("an index is {index}, but there are {n} vertices")),
        None => Ok(()),
    }
}

/// Positions that are not finite are then used by no triangle; they are moved onto one that is, so that
/// bounds of the mesh make sense.
fn drop_unusable_triangles(part: &mut Part) {
    part.indices.truncate(part.indices.len() / 3 * 3);
    if part.positions.iter().all(|p| p.is_finite()) {
        return;
    }
    let usable = |t: &&[u32]| t.iter().all(|&index| part.positions[index as usize].is_finite());
    part.indices = part.indices.chunks_exact(3).filter(usable).flatten().copied().collect();
    let finite = part.positions.iter().copied().find(|p| p.is_finite()).unwrap_or(Vec3::ZERO);
    part.positions.iter_mut().filter(|p| !p.is_finite()).for_each(|p| *p = finite);
}

/// Every triangle with three vertices of its own, which carry its normal.
fn flat(part: &Part) -> Part {
    let normals =
        part.indices.chunks_exact(3).flat_map(|t| [face_normal(&part.positions, t).unwrap_or(Vec3::Y); 3]);
    Part {
        normals: Some(normals.collect()),
        positions: spread(&part.positions, &part.indices),
        tangents: None, // they belong to normals that are not there
        uvs: [0, 1].map(|set| part.uvs[set].as_ref().map(|uvs| spread(uvs, &part.indices))),
        colors: part.colors.as_ref().map(|colors| spread(colors, &part.indices)),
        indices: (0..part.indices.len() as u32).collect(),
    }
}

fn spread<T: Copy>(values: &[T], indices: &[u32]) -> Vec<T> {
    indices.iter().map(|&index| values[index as usize]).collect()
}

/// In f64, where no finite corner overflows.
fn face_normal(positions: &[Vec3], triangle: &[u32]) -> Option<Vec3> {
    let [a, b, c] = [0, 1, 2].map(|corner| positions[triangle[corner] as usize].as_dvec3());
    (b - a).cross(c - a).try_normalize().map(|normal| normal.as_vec3())
}

/// Makes normals unit length; where one has no direction, it gets that of the first face around it that has
/// one.
fn repair_normals(part: &mut Part) {
    let Some(normals) = &mut part.normals else { return };
    for normal in normals.iter_mut() {
        *normal = normal.as_dvec3().try_normalize().map_or(Vec3::ZERO, |normal| normal.as_vec3());
    }
    if !normals.contains(&Vec3::ZERO) {
        return;
    }
    for triangle in part.indices.chunks_exact(3) {
        let mut lacking =
            triangle.iter().map(|&index| index as usize).filter(|&at| normals[at] == Vec3::ZERO).peekable();
        let Some(_) = lacking.peek() else { continue };
        let lacking: Vec<usize> = lacking.collect();
        if let Some(face) = face_normal(&part.positions, triangle) {
            lacking.into_iter().for_each(|at| normals[at] = face);
        }
    }
    normals.iter_mut().filter(|normal| **normal == Vec3::ZERO).for_each(|normal| *normal = Vec3::Y);
}

fn repair_attributes(part: &mut Part) {
    for uv in part.uvs.iter_mut().flatten().flatten().filter(|uv| !uv.is_finite()) {
        *uv = Vec2::ZERO;
    }
    for color in part.colors.iter_mut().flatten() {
        *color = if color.is_finite() { color.max(Vec4::ZERO) } else { Vec4::ONE };
    }
    // One broken tangent makes all of them useless.
    part.tangents =
        part.tangents.take().filter(|tangents| tangents.iter().all(|tangent| tangent.is_finite()));
}

fn append(mesh: &mut Mesh, part: Part) {
    let (base, added) = (mesh.positions.len(), part.positions.len());
    let first = mesh.indices.len() as u32;
    mesh.primitives.push(Primitive { first, count: part.indices.len() as u32 });
    mesh.indices.extend(part.indices.iter().map(|index| index + base as u32));
    mesh.positions.extend(part.positions);
    mesh.normals.extend(part.normals.unwrap_or_default());
    append_optional(&mut mesh.tangents, part.tangents, base, added, Vec4::ZERO);
    append_optional(&mut mesh.colors, part.colors, base, added, Vec4::ONE);
    let uvs = mesh.uvs.iter_mut().zip(part.uvs);
    uvs.for_each(|(to, from)| append_optional(to, from, base, added, Vec2::ZERO));
}

/// An attribute that only some parts have is filled up for the others.
fn append_optional<T: Clone>(
    to: &mut Option<Vec<T>>,
    from: Option<Vec<T>>,
    base: usize,
    added: usize,
    fill: T,
) {
    if to.is_none() && from.is_none() {
        return;
    }
    let to = to.get_or_insert_with(|| vec![fill.clone(); base]);
    match from {
        Some(from) => to.extend(from),
        None => to.resize(base + added, fill),
    }
}
