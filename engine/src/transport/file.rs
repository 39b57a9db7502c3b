//! The light file: the only place that knows its bytes.
//!
//! ```text
//! "HOHLRAUM"   version u32   header length u32   header (JSON: certificate, sections: name, offset, length)
//! sections, little-endian, each at a multiple of 64        BLAKE3 of everything before it (32 bytes)
//! ```

use std::borrow::Cow;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use bytemuck::Pod;
use serde::{Deserialize, Serialize};

use super::{Certificate, Depths, Rows, Surface, Transport, packed};

const MAGIC: &[u8; 8] = b"HOHLRAUM";
pub const VERSION: u32 = 1;
/// Only where some probe does not see a neighbour; files of before they were known have none.
const DEPTH_PROBES: &str = "probe_depths.probes";
const DEPTHS: &str = "probe_depths";
/// Only where a static surface has a normal map.
const DIRECTIONAL: &str = "directional";

/// Where a scene's light file is.
pub fn path(project: &Path, scene: &str) -> PathBuf {
    crate::scene::file::baked_dir(project, scene).join("light.hohlraum")
}

#[derive(Debug, thiserror::Error)]
pub enum TransportError {
    #[error("{}: {source}", path.display())]
    Io { path: PathBuf, source: std::io::Error },
    #[error("{}: {message}; delete it and bake again", path.display())]
    Broken { path: PathBuf, message: String },
    #[error("{}: its certificate does not hold: {message}; bake it again (`hohlraum-bake --force`), or play it all the same (`hohlraum-play --force`)", path.display())]
    Uncertified { path: PathBuf, message: String },
}

/// What is hashed and stored, by name, in this order.
pub fn arrays(transport: &Transport) -> Vec<(&'static str, Cow<'_, [u8]>)> {
    fn plain<T: Pod>(items: &[T]) -> Cow<'_, [u8]> {
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
    let mut rows = vec![
        (["patch.starts", "patch.columns", "patch.weights", "patch.packed"], &transport.patch_from_patch),
        (
            ["receiver.starts", "receiver.columns", "receiver.weights", "receiver.packed"],
            &transport.receiver_from_patch,
        ),
        (["probe.starts", "probe.columns", "probe.weights", "probe.packed"], &transport.probe_from_patch),
    ];
    if !transport.directional_from_patch.is_empty() {
        let names =
            ["directional.starts", "directional.columns", "directional.weights", "directional.packed"];
        rows.push((names, &transport.directional_from_patch));
    }
    for ([starts, columns, weights, packed], rows) in rows {
        arrays.push((starts, plain(&rows.starts)));
        match packed::pack_all(&rows.columns, &rows.weights) {
            Some(entries) => {
                arrays.push((packed, Cow::Owned(bytemuck::cast_slice(&entries).to_vec())));
            }
            None => {
                arrays.push((columns, plain(&rows.columns)));
                arrays.push((weights, plain(&rows.weights)));
            }
        }
    }
    if !transport.depths.probes.is_empty() {
        arrays.push((DEPTH_PROBES, plain(&transport.depths.probes)));
        arrays.push((DEPTHS, plain(&transport.depths.nearness)));
    }
    arrays
}

#[derive(Serialize, Deserialize)]
struct Header {
    certificate: Certificate,
    sections: Vec<Section>,
}

#[derive(Serialize, Deserialize)]
struct Section {
    name: String,
    /// From the end of the header, rounded up to 64.
    offset: u64,
    length: u64,
}

fn aligned(at: u64) -> u64 {
    at.next_multiple_of(64)
}

/// Bytes of all arrays, as stored.
pub fn length(transport: &Transport) -> u64 {
    arrays(transport).iter().map(|(_, bytes)| aligned(bytes.len() as u64)).sum()
}

/// Atomic: a reader sees the old file or the new one. Returns the file's length.
pub fn save(path: &Path, transport: &Transport) -> Result<u64, TransportError> {
    write(path, transport).map_err(|source| TransportError::Io { path: path.to_owned(), source })
}

fn write(path: &Path, transport: &Transport) -> std::io::Result<u64> {
    let arrays = arrays(transport);
    let mut offset = 0;
    let mut sections = Vec::new();
    for (name, bytes) in &arrays {
        sections.push(Section { name: (*name).to_owned(), offset, length: bytes.len() as u64 });
        offset = aligned(offset + bytes.len() as u64);
    }
    let header = Header { certificate: transport.certificate.clone(), sections };
    let json = serde_json::to_vec(&header).map_err(std::io::Error::other)?;
    let folder = path.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder)?;
    // Not `NamedTempFile::new_in`, whose files nobody but their owner may read.
    let create = |path: &Path| std::fs::File::options().write(true).create_new(true).open(path);
    let file = tempfile::Builder::new().make_in(folder, create)?;
    let mut out =
        Hashing { file: BufWriter::with_capacity(1 << 20, file), hasher: blake3::Hasher::new(), at: 0 };
    out.put(MAGIC)?;
    out.put(&VERSION.to_le_bytes())?;
    out.put(&(json.len() as u32).to_le_bytes())?;
    out.put(&json)?;
    for (_, bytes) in &arrays {
        out.align()?;
        out.put(bytes)?;
    }
    let sum = out.hasher.finalize();
    out.put(sum.as_bytes())?;
    let length = out.at;
    let file = out.file.into_inner().map_err(std::io::IntoInnerError::into_error)?;
    file.as_file().sync_all()?;
    file.persist(path).map_err(|error| error.error)?;
    Ok(length)
}

struct Hashing<W: Write> {
    file: W,
    hasher: blake3::Hasher,
    at: u64,
}

impl<W: Write> Hashing<W> {
    fn put(&mut self, bytes: &[u8]) -> std::io::Result<()> {
        self.hasher.update(bytes);
        self.at += bytes.len() as u64;
        self.file.write_all(bytes)
    }

    fn align(&mut self) -> std::io::Result<()> {
        let padding = aligned(self.at) - self.at;
        self.put(&[0; 64][..padding as usize])
    }
}

/// The certificate alone, without reading the arrays or the checksum.
pub fn load_certificate(path: &Path) -> Result<Certificate, TransportError> {
    use std::io::Read;
    let failed = |source| TransportError::Io { path: path.to_owned(), source };
    let mut file = std::fs::File::open(path).map_err(failed)?;
    let length = file.metadata().map_err(failed)?.len();
    let mut start = [0; 16];
    file.read_exact(&mut start).map_err(failed)?;
    let header = u64::from(u32::from_le_bytes([start[12], start[13], start[14], start[15]]));
    let broken =
        |message: &str| TransportError::Broken { path: path.to_owned(), message: message.to_owned() };
    if start[..8] != *MAGIC || header > length {
        return Err(broken("is no light file"));
    }
    let mut json = vec![0; header as usize];
    file.read_exact(&mut json).map_err(failed)?;
    let header: Header = serde_json::from_slice(&json).map_err(|error| broken(&error.to_string()))?;
    Ok(header.certificate)
}

/// Checks the checksum, every length and every index before anything is used.
pub fn load(path: &Path) -> Result<Transport, TransportError> {
    let transport = load_uncertified(path)?;
    match transport.certificate.broken() {
        Some(message) => Err(TransportError::Uncertified { path: path.to_owned(), message }),
        None => Ok(transport),
    }
}

/// The same whatever its certificate says: for those who check it, or want it all the same.
pub fn load_uncertified(path: &Path) -> Result<Transport, TransportError> {
    let bytes = std::fs::read(path).map_err(|source| TransportError::Io { path: path.to_owned(), source })?;
    let broken = |message: String| TransportError::Broken { path: path.to_owned(), message };
    let transport = parse(&bytes).map_err(broken)?;
    transport.validate().map_err(broken)?;
    Ok(transport)
}

fn parse(bytes: &[u8]) -> Result<Transport, String> {
    let word = |at: usize| -> Result<u32, String> {
        let word = bytes.get(at..at + 4).ok_or("is cut off")?;
        Ok(u32::from_le_bytes([word[0], word[1], word[2], word[3]]))
    };
    if bytes.get(..8) != Some(MAGIC) {
        return Err("is no light file".to_owned());
    }
    let version = word(8)?;
    if version != VERSION {
        return Err(format!("is of version {version}; this program reads version {VERSION}"));
    }
    let end = bytes.len().checked_sub(32).ok_or("is cut off")?;
    if blake3::hash(&bytes[..end]).as_bytes()[..] != bytes[end..] {
        return Err("is damaged: its checksum does not fit".to_owned());
    }
    let body = 16 + word(12)? as usize;
    let json = bytes[..end].get(16..body).ok_or("is cut off")?;
    let header: Header = serde_json::from_slice(json).map_err(|error| error.to_string())?;
    let sections = Sections { bytes: &bytes[..end], base: aligned(body as u64), sections: header.sections };
    let origin: Vec<f64> = sections.read("origin")?;
    let sky: Vec<u32> = sections.read("sky")?;
    Ok(Transport {
        origin: <[f64; 3]>::try_from(origin).map_err(|_| "has no origin")?.into(),
        surface: Surface {
            vertices: sections.read("vertices")?,
            blends: sections.read("blends")?,
            back_blends: sections.read("back_blends")?,
            triangles: sections.read("triangles")?,
            patches: sections.read("triangle_patches")?,
            batches: sections.read("batches")?,
        },
        patches: sections.read("patches")?,
        samples: sections.read("samples")?,
        receivers: sections.read("receivers")?,
        probes: sections.read("probes")?,
        depths: Depths {
            probes: sections.read_where_there(DEPTH_PROBES)?,
            nearness: sections.read_where_there(DEPTHS)?,
        },
        sky_patches: *sky.first().ok_or("has no sky")?,
        patch_from_patch: sections.rows("patch")?,
        receiver_from_patch: sections.rows("receiver")?,
        probe_from_patch: sections.rows("probe")?,
        directional_from_patch: sections.rows_where_there(DIRECTIONAL)?,
        certificate: header.certificate,
    })
}

struct Sections<'a> {
    bytes: &'a [u8],
    base: u64,
    sections: Vec<Section>,
}

impl Sections<'_> {
    fn read<T: Pod>(&self, name: &str) -> Result<Vec<T>, String> {
        let section = self.sections.iter().find(|section| section.name == name);
        let section = section.ok_or_else(|| format!("has no section `{name}`"))?;
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

    fn read_where_there<T: Pod>(&self, name: &str) -> Result<Vec<T>, String> {
        let is_there = self.sections.iter().any(|section| section.name == name);
        if is_there { self.read(name) } else { Ok(Vec::new()) }
    }

    fn rows_where_there(&self, name: &str) -> Result<Rows, String> {
        let starts = format!("{name}.starts");
        let is_there = self.sections.iter().any(|section| section.name == starts);
        if is_there { self.rows(name) } else { Ok(Rows::default()) }
    }

    fn rows(&self, name: &str) -> Result<Rows, String> {
        let packed = format!("{name}.packed");
        if self.sections.iter().any(|section| section.name == packed) {
            let entries: Vec<u32> = self.read(&packed)?;
            let (columns, weights) = entries.into_iter().map(packed::unpack).unzip();
            return Ok(Rows { starts: self.read(&format!("{name}.starts"))?, columns, weights });
        }
        Ok(Rows {
            starts: self.read(&format!("{name}.starts"))?,
            columns: self.read(&format!("{name}.columns"))?,
            weights: self.read(&format!("{name}.weights"))?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transport::{Patch, Receiver};

    fn transport(weight: f32) -> Transport {
        let patch = Patch { area: 1.0, ..Patch::default() };
        let mut transport = Transport { patches: vec![patch; 40], ..Transport::default() };
        transport.surface.batches.push(Default::default());
        transport.receivers = vec![Receiver::default(); 100];
        (0..40).for_each(|_| transport.patch_from_patch.push([(3, 0.3)]));
        (0..100).for_each(|_| transport.receiver_from_patch.push((0..40).map(|j| (j, weight))));
        transport
    }

    #[test]
    fn rows_come_back_as_they_were_packed_or_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("light");
        let lengths = [1.0 / 64.0, 0.02].map(|weight| {
            let transport = transport(weight);
            let length = save(&path, &transport).unwrap();
            let loaded = load(&path).unwrap();
            assert_eq!(loaded.receiver_from_patch, transport.receiver_from_patch);
            assert_eq!(loaded.patch_from_patch, transport.patch_from_patch);
            assert_eq!(loaded.hash(), transport.hash());
            length
        });
        assert!(lengths[0] + 4 * 4000 < lengths[1] + 256, "{lengths:?}");
    }

    #[test]
    fn directional_rows_come_back_and_without_them_there_is_no_section() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("light");
        let has_section = || {
            let bytes = std::fs::read(&path).unwrap();
            bytes.windows(DIRECTIONAL.len() + 1).any(|word| word == format!("{DIRECTIONAL}.").as_bytes())
        };
        let mut transport = transport(1.0 / 64.0);
        save(&path, &transport).unwrap();
        let without = transport.hash();
        assert!(!has_section() && load(&path).unwrap().directional_from_patch.is_empty());
        (0..6).for_each(|k| transport.directional_from_patch.push([(k, 0.25), (9, -0.5)]));
        save(&path, &transport).unwrap();
        let loaded = load(&path).unwrap();
        assert!(has_section() && loaded.directional_from_patch == transport.directional_from_patch);
        assert_eq!((loaded.directional_receivers(), loaded.hash()), (2, transport.hash()));
        assert_ne!(transport.hash(), without, "the transport hash covers them");
        transport.directional_from_patch.push([(0, 0.25)]);
        save(&path, &transport).unwrap();
        assert!(load(&path).unwrap_err().to_string().contains("directional rows"));
    }
}
