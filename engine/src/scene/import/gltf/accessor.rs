//! Arrays of numbers out of glTF buffers: the crate's readers, which believe what an accessor says, after a
//! check of it. Nothing is allocated before the bytes are known to be there.

use gltf::Accessor;
use gltf::accessor::sparse::{IndexType, Sparse};
use gltf::accessor::util::{ItemIter, SparseIndicesIter};
use gltf::accessor::{DataType, Dimensions};
use gltf::buffer::View;

use super::Gltf;

/// Accessors without bytes are zeros, as many as the file claims: no more than this are believed.
const MOST_ZEROS: usize = 1 << 20;

/// What of an accessor a reader can read.
pub type Fit = (&'static [Dimensions], &'static [DataType]);

pub const SCALARS: Fit = (&[Dimensions::Scalar], &[DataType::F32]);
pub const VECTORS: Fit = (&[Dimensions::Vec3], &[DataType::F32]);
pub const ROTATIONS: Fit =
    (&[Dimensions::Vec4], &[DataType::F32, DataType::I8, DataType::U8, DataType::I16, DataType::U16]);

/// The accessor's elements, which `reader` makes of it. Without bytes, all are `zero`.
pub fn read<T: Clone, I: Iterator<Item = T>>(
    gltf: &Gltf,
    accessor: &Accessor,
    fit: Fit,
    zero: T,
    reader: impl FnOnce() -> Option<I>,
) -> Result<Vec<T>, String> {
    check(gltf, accessor, fit).map_err(|message| format!("accessor {} {message}", accessor.index()))?;
    if accessor.count() == 0 {
        return Ok(Vec::new());
    }
    Ok(reader().map_or_else(|| vec![zero; accessor.count()], Iterator::collect))
}

/// For the crate's readers.
pub fn bytes_of<'a>(gltf: &'a Gltf) -> impl Clone + Fn(gltf::Buffer<'a>) -> Option<&'a [u8]> {
    |buffer| gltf.buffers.get(buffer.index()).map(Vec::as_slice)
}

/// The bytes of a buffer view.
pub fn view_bytes<'a>(gltf: &'a Gltf, view: &View) -> Result<&'a [u8], String> {
    let buffer = gltf.buffers.get(view.buffer().index()).map_or(&[][..], Vec::as_slice);
    let end = view.offset().checked_add(view.length());
    end.and_then(|end| buffer.get(view.offset()..end)).ok_or_else(|| {
        let (view, len, buffer) = (view.index(), buffer.len(), view.buffer().index());
        format!("refers to buffer view {view}, which leads beyond the {len} bytes of buffer {buffer}")
    })
}

fn check(gltf: &Gltf, accessor: &Accessor, (dimensions, types): Fit) -> Result<(), String> {
    let (is, of) = (accessor.dimensions(), accessor.data_type());
    if !dimensions.contains(&is) || !types.contains(&of) {
        let quantized = gltf.document.extensions_used().any(|name| name == "KHR_mesh_quantization");
        let why = if quantized { "KHR_mesh_quantization cannot be read" } else { "that does not fit here" };
        return Err(format!("holds {is:?} of {of:?}: {why}"));
    }
    let count = accessor.count();
    match accessor.view() {
        Some(view) => drop(rows(gltf, &view, accessor.offset(), count, accessor.size())?),
        None if count > MOST_ZEROS => {
            return Err(format!("claims {count} elements and has no bytes for them"));
        }
        None => {}
    }
    accessor.sparse().map_or(Ok(()), |sparse| check_sparse(gltf, &sparse, count, accessor.size()))
}

/// The crate takes the places in ascending order.
fn check_sparse(gltf: &Gltf, sparse: &Sparse, len: usize, size: usize) -> Result<(), String> {
    let (places, values) = (sparse.indices(), sparse.values());
    rows(gltf, &values.view(), values.offset(), sparse.count(), size)?;
    let size = places.index_type().size();
    let bytes = rows(gltf, &places.view(), places.offset(), sparse.count(), size)?;
    let stride = places.view().stride().unwrap_or(size);
    let mut places = match places.index_type() {
        IndexType::U8 => SparseIndicesIter::U8(ItemIter::new(bytes, stride)),
        IndexType::U16 => SparseIndicesIter::U16(ItemIter::new(bytes, stride)),
        IndexType::U32 => SparseIndicesIter::U32(ItemIter::new(bytes, stride)),
    };
    let mut least = 0;
    let is_next = |place: u32| {
        let fits = (least..len).contains(&(place as usize));
        least = place as usize + 1;
        fits
    };
    if places.all(is_next) {
        Ok(())
    } else {
        Err(format!("has sparse places that do not ascend below {len}"))
    }
}

/// The bytes of `count` elements of `size` bytes.
fn rows<'a>(
    gltf: &'a Gltf,
    view: &View,
    offset: usize,
    count: usize,
    size: usize,
) -> Result<&'a [u8], String> {
    let bytes = view_bytes(gltf, view)?;
    let stride = view.stride().unwrap_or(size);
    if stride < size {
        return Err(format!("has elements of {size} bytes, {stride} bytes apart"));
    }
    let Some(last) = count.checked_sub(1) else { return Ok(&[]) };
    let end = last.checked_mul(stride).and_then(|at| at.checked_add(size)?.checked_add(offset));
    end.and_then(|end| bytes.get(offset..end)).ok_or_else(|| {
        let (len, view) = (bytes.len(), view.index());
        format!("needs more bytes than the {len} of buffer view {view} ({count} elements)")
    })
}
