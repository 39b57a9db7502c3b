//! Arrays of numbers out of glTF buffers. Nothing is allocated before the bytes are known to be there.

use super::Gltf;
use super::json::{Accessor, BufferView, get};

/// Accessors without bytes are zeros, as many as the file claims: no more than this are believed.
const MOST_ZEROS: usize = 1 << 20;

#[derive(Clone, Copy)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

/// Rows of `width` numbers each.
pub struct Rows<T> {
    pub width: usize,
    pub values: Vec<T>,
}

impl<T: Copy> Rows<T> {
    pub fn len(&self) -> usize {
        self.values.len() / self.width
    }

    /// Each row as an array, N being the width that was asked for.
    pub fn arrays<const N: usize>(&self) -> impl Iterator<Item = [T; N]> + '_ {
        self.values.chunks_exact(self.width).filter_map(|row| row.get(..N)?.try_into().ok())
    }
}

/// Floats, or integers as what they stand for. `widths`: which are of use, of 1 (SCALAR) to 4 (VEC4).
pub fn floats(gltf: &Gltf, index: usize, widths: &[usize]) -> Result<Rows<f32>, String> {
    let normalized = get(&gltf.root.accessors, index, "accessor")?.normalized;
    read(gltf, index, widths, |component, bytes| Ok(component.float(bytes, normalized)))
}

/// Indices of vertices.
pub fn indices(gltf: &Gltf, index: usize) -> Result<Vec<u32>, String> {
    read(gltf, index, &[1], Component::index).map(|rows| rows.values)
}

/// The bytes of a buffer view.
pub fn view_bytes(gltf: &Gltf, index: usize) -> Result<&[u8], String> {
    view(gltf, index).map(|(_, bytes)| bytes)
}

fn read<T: Copy + Default>(
    gltf: &Gltf,
    index: usize,
    widths: &[usize],
    decode: impl Fn(Component, &[u8]) -> Result<T, String>,
) -> Result<Rows<T>, String> {
    let accessor = get(&gltf.root.accessors, index, "accessor")?;
    let width = width(&accessor.r#type).filter(|width| widths.contains(width)).ok_or_else(|| {
        format!("accessor {index} is of the type `{}`, which does not fit here", accessor.r#type)
    })?;
    let named = |message: String| format!("accessor {index} {message}");
    let component = Component::of(accessor.component_type).map_err(named)?;
    let rows = base_rows(gltf, accessor, component, width, &decode).map_err(named)?;
    let mut rows = Rows { width, values: rows };
    overwrite_sparse(gltf, accessor, component, &mut rows, &decode).map_err(named)?;
    Ok(rows)
}

fn base_rows<T: Copy + Default>(
    gltf: &Gltf,
    accessor: &Accessor,
    component: Component,
    width: usize,
    decode: &impl Fn(Component, &[u8]) -> Result<T, String>,
) -> Result<Vec<T>, String> {
    let Some(view) = accessor.buffer_view else {
        let count = usize::try_from(accessor.count).ok().filter(|&count| count <= MOST_ZEROS);
        let count =
            count.ok_or_else(|| format!("claims {} elements and has no bytes for them", accessor.count))?;
        return Ok(vec![T::default(); count * width]);
    };
    let rows = rows_of(gltf, view, accessor.byte_offset, accessor.count, component.bytes() * width)?;
    let cells = rows.flat_map(|row| row.chunks_exact(component.bytes()));
    cells.map(|cell| decode(component, cell)).collect()
}

fn overwrite_sparse<T: Copy>(
    gltf: &Gltf,
    accessor: &Accessor,
    component: Component,
    rows: &mut Rows<T>,
    decode: &impl Fn(Component, &[u8]) -> Result<T, String>,
) -> Result<(), String> {
    let Some(sparse) = &accessor.sparse else { return Ok(()) };
    let (places, values) = (&sparse.indices, &sparse.values);
    let place = Component::of(places.component_type)?;
    let place_rows = rows_of(gltf, places.buffer_view, places.byte_offset, sparse.count, place.bytes())?;
    let size = component.bytes() * rows.width;
    let value_rows = rows_of(gltf, values.buffer_view, values.byte_offset, sparse.count, size)?;
    for (at, row) in place_rows.zip(value_rows) {
        let at = place.index(at)? as usize;
        let len = rows.len();
        if at >= len {
            return Err(format!("has a sparse value at {at}, and {len} elements"));
        }
        let cells = row.chunks_exact(component.bytes());
        for (to, cell) in rows.values[at * rows.width..].iter_mut().zip(cells) {
            *to = decode(component, cell)?;
        }
    }
    Ok(())
}

/// `count` runs of `size` bytes out of a view, all of them known to lie inside it.
fn rows_of(
    gltf: &Gltf,
    view_index: usize,
    offset: u64,
    count: u64,
    size: usize,
) -> Result<impl Iterator<Item = &[u8]>, String> {
    let (view, bytes) = view(gltf, view_index)?;
    let size = size as u64;
    let stride = if view.byte_stride == 0 { size } else { view.byte_stride };
    if stride < size {
        return Err(format!("has elements of {size} bytes, {stride} bytes apart"));
    }
    let end = count
        .checked_sub(1)
        .map_or(Some(0), |last| last.checked_mul(stride)?.checked_add(size)?.checked_add(offset));
    if end.is_none_or(|end| end > bytes.len() as u64) {
        let len = bytes.len();
        return Err(format!(
            "needs more bytes than the {len} of buffer view {view_index} ({count} elements)"
        ));
    }
    let at = move |n: u64| &bytes[(offset + n * stride) as usize..][..size as usize];
    Ok((0..count).map(at))
}

fn view(gltf: &Gltf, index: usize) -> Result<(&BufferView, &[u8]), String> {
    let view = get(&gltf.root.buffer_views, index, "buffer view")?;
    let buffer = get(&gltf.buffers, view.buffer, "buffer")?;
    let end = view.byte_offset.checked_add(view.byte_length).filter(|&end| end <= buffer.len() as u64);
    let end = end.ok_or_else(|| {
        format!(
            "refers to buffer view {index}, which leads beyond the {} bytes of buffer {}",
            buffer.len(),
            view.buffer
        )
    })?;
    Ok((view, &buffer[view.byte_offset as usize..end as usize]))
}

fn width(kind: &str) -> Option<usize> {
    ["SCALAR", "VEC2", "VEC3", "VEC4"].iter().position(|&name| name == kind).map(|at| at + 1)
}

impl Component {
    fn of(code: u32) -> Result<Self, String> {
        Ok(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return Err(format!("has the component type {code}, which glTF does not know")),
        })
    }

    fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// `cell` holds as many bytes as the component has.
    fn float(self, cell: &[u8], normalized: bool) -> f32 {
        let (value, most) = match self {
            Self::I8 => (f32::from(cell[0] as i8), 127.0),
            Self::U8 => (f32::from(cell[0]), 255.0),
            Self::I16 => (f32::from(i16::from_le_bytes([cell[0], cell[1]])), 32767.0),
            Self::U16 => (f32::from(u16::from_le_bytes([cell[0], cell[1]])), 65535.0),
            Self::U32 => (word(cell) as f32, u32::MAX as f32),
            Self::F32 => return f32::from_bits(word(cell)),
        };
        if normalized { (value / most).max(-1.0) } else { value }
    }

    fn index(self, cell: &[u8]) -> Result<u32, String> {
        match self {
            Self::U8 => Ok(u32::from(cell[0])),
            Self::U16 => Ok(u32::from(u16::from_le_bytes([cell[0], cell[1]]))),
            Self::U32 => Ok(word(cell)),
            _ => Err("holds indices that are not unsigned integers".to_owned()),
        }
    }
}

fn word(cell: &[u8]) -> u32 {
    u32::from_le_bytes([cell[0], cell[1], cell[2], cell[3]])
}
