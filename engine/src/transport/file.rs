//! The light file: the only place that knows its bytes.
//!
//! ```text
//! "HOHLRAUM"  version u32  header length u32  header (JSON: certificate, sections by name, offset, length)
//! sections, each little-endian, 64-byte aligned; then the BLAKE3 of everything before it
//! ```

use std::borrow::Cow;
use std::path::Path;

use super::Transport;

/// What is hashed and stored, by name, in this order.
pub fn arrays(transport: &Transport) -> Vec<(&'static str, Cow<'_, [u8]>)> {
    fn plain<T: bytemuck::Pod>(items: &[T]) -> Cow<'_, [u8]> {
        Cow::Borrowed(bytemuck::cast_slice(items))
    }
    let surface = &transport.surface;
    let mut arrays = vec![
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
    ];
    let rows = [
        (["patch.starts", "patch.columns", "patch.weights"], &transport.patch_from_patch),
        (["receiver.starts", "receiver.columns", "receiver.weights"], &transport.receiver_from_patch),
        (["probe.starts", "probe.columns", "probe.weights"], &transport.probe_from_patch),
    ];
    for ([starts, columns, weights], rows) in rows {
        arrays.push((starts, plain(&rows.starts)));
        arrays.push((columns, plain(&rows.columns)));
        arrays.push((weights, plain(&rows.weights)));
    }
    arrays
}

#[derive(Debug, thiserror::Error)]
pub enum TransportError {
    #[error("{}: {source}", path.display())]
    Io { path: std::path::PathBuf, source: std::io::Error },
    #[error("{}: {message}; delete it and bake again", path.display())]
    Broken { path: std::path::PathBuf, message: String },
}

/// Atomic: a reader sees the old file or the new one.
pub fn save(_path: &Path, _transport: &Transport) -> Result<(), TransportError> {
    todo!()
}

/// Checks the checksum, every length and every index before anything is used.
pub fn load(_path: &Path) -> Result<Transport, TransportError> {
    todo!()
}
