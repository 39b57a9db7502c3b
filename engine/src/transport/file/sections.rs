//! What is in a light file, section by section. A section whose array is empty is absent.
//!
//! ```text
//! patch.starts, .columns, .weights    rows: where each starts, f32 weights beside u32 columns; receiver, probe, directional likewise
//! patch.starts, .packed               the same in four bytes an entry, where those hold all of them
//! patch.dense                         f32 weights of all columns (patches, then sky), row after row: where the transport
//!                                     is `dense` and that is shorter; a transport that is read from such is `dense`
//! solved.0.radiosity ..               f32 rgb by response and array; with `.grey` behind it one f32 for all channels
//! ```

use std::borrow::Cow;

use bytemuck::Pod;
use glam::Vec3;

use super::Section;
use crate::transport::solved::{Response, Source, Spread};
use crate::transport::{Depths, Rows, Solved, Surface, Transport, packed};

/// Only where some probe does not see a neighbour; files of before they were known have none.
const DEPTH_PROBES: &str = "probe_depths.probes";
const DEPTHS: &str = "probe_depths";
const DENSE: &str = "patch.dense";

type Array<'a, Name> = (Name, Cow<'a, [u8]>);

fn plain<T: Pod>(items: &[T]) -> Cow<'_, [u8]> {
    Cow::Borrowed(bytemuck::cast_slice(items))
}

/// What is hashed, by name, in this order.
pub fn arrays(transport: &Transport) -> Vec<Array<'_, &'static str>> {
    let mut arrays = places(transport);
    arrays.extend(sparse(ROWS[0], &transport.patch_from_patch));
    arrays.extend(sparse(ROWS[1], &transport.receiver_from_patch));
    arrays.extend(sparse(ROWS[2], &transport.probe_from_patch));
    if !transport.directional_from_patch.is_empty() {
        arrays.extend(sparse(ROWS[3], &transport.directional_from_patch));
    }
    if !transport.depths.probes.is_empty() {
        arrays.push((DEPTH_PROBES, plain(&transport.depths.probes)));
        arrays.push((DEPTHS, plain(&transport.depths.nearness)));
    }
    arrays
}

/// What is stored: the same without what is empty, in the shortest form; and the light that is solved.
pub fn stored(transport: &Transport) -> Vec<Array<'_, String>> {
    let dense = transport.dense.then(|| dense(transport)).flatten();
    let is_row = |name: &str| name.starts_with("patch.");
    let named = arrays(transport).into_iter().filter(|(name, _)| dense.is_none() || !is_row(name));
    let mut stored: Vec<_> = named.map(|(name, bytes)| (name.to_owned(), bytes)).collect();
    stored.extend(dense.map(|weights| (DENSE.to_owned(), Cow::Owned(weights))));
    for (index, response) in transport.solved.iter().flat_map(|solved| solved.responses.iter().enumerate()) {
        for (name, values) in Spread::NAMES.into_iter().zip(response.spread.arrays()) {
            stored.push(light(format!("solved.{index}.{name}"), values));
        }
    }
    // A sky without patches is four bytes, rows without rows are the eight of their end.
    let is_empty = |name: &str, bytes: &[u8]| match name {
        "sky" => transport.sky_patches == 0,
        _ => bytes.is_empty() || (name.ends_with(".starts") && bytes.len() == 8),
    };
    stored.retain(|(name, bytes)| !is_empty(name, bytes));
    stored
}

fn places(transport: &Transport) -> Vec<Array<'_, &'static str>> {
    let surface = &transport.surface;
    vec![
        ("origin", Cow::Owned(bytemuck::bytes_of(&transport.origin.to_array()).to_vec())),
        ("vertices", plain(&surface.vertices)),
        ("blends", plain(&surface.blends)),
        ("back_blends", plain(&surface.back_blends)),
        ("triangles", plain(&surface.triangles)),
        ("triangle_patches", plain(&surface.patches)),
        ("batches", plain(&surface.batches)),
        ("patches", plain(&transport.patches)),
        ("samples", plain(&transport.samples)),
        ("receivers", plain(&transport.receivers)),
        ("probes", plain(&transport.probes)),
        ("sky", Cow::Owned(transport.sky_patches.to_le_bytes().to_vec())),
    ]
}

const ROWS: [[&str; 4]; 4] = [
    ["patch.starts", "patch.columns", "patch.weights", "patch.packed"],
    ["receiver.starts", "receiver.columns", "receiver.weights", "receiver.packed"],
    ["probe.starts", "probe.columns", "probe.weights", "probe.packed"],
    ["directional.starts", "directional.columns", "directional.weights", "directional.packed"],
];

fn sparse<'a>(
    [starts, columns, weights, packed]: [&'static str; 4],
    rows: &'a Rows,
) -> Vec<Array<'a, &'static str>> {
    let starts = (starts, plain(&rows.starts));
    match packed::pack_all(&rows.columns, &rows.weights) {
        Some(entries) => vec![starts, (packed, Cow::Owned(bytemuck::cast_slice(&entries).to_vec()))],
        None => vec![starts, (columns, plain(&rows.columns)), (weights, plain(&rows.weights))],
    }
}

/// None where it is no shorter, or would forget an entry that is 0.
fn dense(transport: &Transport) -> Option<Vec<u8>> {
    let (rows, columns) = (&transport.patch_from_patch, transport.columns());
    let sparse: usize = sparse(ROWS[0], rows).iter().map(|(_, bytes)| bytes.len()).sum();
    let is_shorter = rows.len().checked_mul(columns * size_of::<f32>())? < sparse;
    if !is_shorter || rows.weights.contains(&0.0) {
        return None;
    }
    let mut weights = vec![0.0_f32; rows.len() * columns];
    for row in 0..rows.len() {
        rows.row(row).for_each(|(column, weight)| weights[row * columns + column as usize] = weight);
    }
    Some(bytemuck::cast_slice(&weights).to_vec())
}

fn light(name: String, values: &[Vec3]) -> Array<'_, String> {
    let is_grey = values.iter().all(|value| value.x == value.y && value.y == value.z);
    if !is_grey {
        return (name, plain(values));
    }
    let one: Vec<f32> = values.iter().map(|value| value.x).collect();
    (format!("{name}.grey"), Cow::Owned(bytemuck::cast_slice(&one).to_vec()))
}

pub struct Sections<'a> {
    pub bytes: &'a [u8],
    /// Where the first one starts.
    pub base: u64,
    pub sections: Vec<Section>,
}

impl Sections<'_> {
    /// All but what stands in the header.
    pub fn transport(&self, responses: Option<&[Source]>) -> Result<Transport, String> {
        let origin: Vec<f64> = self.read("origin")?;
        let sky: Vec<u32> = self.read("sky")?;
        let mut transport = Transport {
            origin: <[f64; 3]>::try_from(origin).map_err(|_| "has no origin")?.into(),
            surface: Surface {
                vertices: self.read("vertices")?,
                blends: self.read("blends")?,
                back_blends: self.read("back_blends")?,
                triangles: self.read("triangles")?,
                patches: self.read("triangle_patches")?,
                batches: self.read("batches")?,
            },
            patches: self.read("patches")?,
            samples: self.read("samples")?,
            receivers: self.read("receivers")?,
            probes: self.read("probes")?,
            depths: Depths { probes: self.read(DEPTH_PROBES)?, nearness: self.read(DEPTHS)? },
            sky_patches: sky.first().copied().unwrap_or(0),
            receiver_from_patch: self.rows("receiver")?,
            probe_from_patch: self.rows("probe")?,
            directional_from_patch: self.rows("directional")?,
            dense: self.has(DENSE),
            solved: responses.map(|sources| self.solved(sources)).transpose()?,
            ..Transport::default()
        };
        transport.patch_from_patch =
            if transport.dense { self.dense_rows(transport.columns())? } else { self.rows("patch")? };
        Ok(transport)
    }

    fn has(&self, name: &str) -> bool {
        self.sections.iter().any(|section| section.name == name)
    }

    /// Empty where it is absent: what should not be is found by [`Transport::validate`].
    fn read<T: Pod>(&self, name: &str) -> Result<Vec<T>, String> {
        let Some(section) = self.sections.iter().find(|section| section.name == name) else {
            return Ok(Vec::new());
        };
        let range = self
            .base
            .checked_add(section.offset)
            .and_then(|first| Some(first as usize..first.checked_add(section.length)? as usize));
        let bytes = range.and_then(|range| self.bytes.get(range));
        let bytes = bytes.ok_or_else(|| format!("section `{name}` reaches past its end"))?;
        if bytes.len() % size_of::<T>() != 0 {
            return Err(format!("section `{name}` has {} bytes", bytes.len()));
        }
        Ok(bytemuck::pod_collect_to_vec(bytes))
    }

    fn rows(&self, name: &str) -> Result<Rows, String> {
        let mut starts: Vec<u64> = self.read(&format!("{name}.starts"))?;
        if starts.is_empty() {
            starts.push(0);
        }
        let packed = format!("{name}.packed");
        if self.has(&packed) {
            let entries: Vec<u32> = self.read(&packed)?;
            let (columns, weights) = entries.into_iter().map(packed::unpack).unzip();
            return Ok(Rows { starts, columns, weights });
        }
        Ok(Rows {
            starts,
            columns: self.read(&format!("{name}.columns"))?,
            weights: self.read(&format!("{name}.weights"))?,
        })
    }

    fn dense_rows(&self, columns: usize) -> Result<Rows, String> {
        let weights: Vec<f32> = self.read(DENSE)?;
        if columns == 0 || !weights.len().is_multiple_of(columns) {
            return Err(format!("section `{DENSE}` has {} weights in {columns} columns", weights.len()));
        }
        let mut rows = Rows::default();
        for row in weights.chunks_exact(columns) {
            rows.push((0..).zip(row.iter().copied()).filter(|(_, weight)| *weight != 0.0));
        }
        Ok(rows)
    }

    fn solved(&self, sources: &[Source]) -> Result<Solved, String> {
        let response = |(index, &source): (usize, &Source)| {
            let mut spread = Spread::default();
            for (name, values) in Spread::NAMES.into_iter().zip(spread.arrays_mut()) {
                *values = self.light(&format!("solved.{index}.{name}"))?;
            }
            Ok(Response { source, spread })
        };
        Ok(Solved { responses: sources.iter().enumerate().map(response).collect::<Result<_, String>>()? })
    }

    fn light(&self, name: &str) -> Result<Vec<Vec3>, String> {
        let grey = format!("{name}.grey");
        if self.has(&grey) {
            return Ok(self.read::<f32>(&grey)?.into_iter().map(Vec3::splat).collect());
        }
        self.read(name)
    }
}
