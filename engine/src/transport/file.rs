//! The light file: the only place that knows its bytes.
//!
//! ```text
//! "HOHLRAUM"   version u32   header length u32   header (JSON: certificate, sections: name, offset, length, omissions)
//! sections, little-endian, each at a multiple of 64        BLAKE3 of everything before it (32 bytes)
//! ```
//! What is in it, and in which form: [`sections`](self::sections()). A bake is one file or two ([`pair`]).

mod pair;
mod sections;

use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::solved::Source;
use super::{Certificate, Omission, Transport};
pub use pair::{belong, full_path, is_whole, load_full, load_full_uncertified, names, path, save_pair};
pub use sections::arrays;

const MAGIC: &[u8; 8] = b"HOHLRAUM";
/// 2: what is empty is absent; light that is solved. Files of version 1 are read as they are.
pub const VERSION: u32 = 2;
const OLDEST: u32 = 1;

#[derive(Debug, thiserror::Error)]
pub enum TransportError {
    #[error("{}: {source}", path.display())]
    Io { path: PathBuf, source: std::io::Error },
    #[error("{}: {message}; delete it and bake again", path.display())]
    Broken { path: PathBuf, message: String },
    #[error("{}: it leaves out {left_out}, and {} beside it, which has that, is missing; bake again", path.display(), pair::FULL)]
    Parted { path: PathBuf, left_out: String },
    #[error("{}: its certificate does not hold: {message}; bake it again (`hohlraum-bake --force`), or play it all the same (`hohlraum-play --force`)", path.display())]
    Uncertified { path: PathBuf, message: String },
}

#[derive(Serialize, Deserialize)]
struct Header {
    certificate: Certificate,
    sections: Vec<Section>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    omissions: Vec<Omission>,
    /// What `solved.0`, `solved.1` .. are responses to; none where there are rows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    solved: Option<Vec<Source>>,
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
    sections::stored(transport).iter().map(|(_, bytes)| aligned(bytes.len() as u64)).sum()
}

/// Atomic: a reader sees the old file or the new one. Returns the file's length.
pub fn save(path: &Path, transport: &Transport) -> Result<u64, TransportError> {
    write(path, transport).map_err(|source| TransportError::Io { path: path.to_owned(), source })
}

fn write(path: &Path, transport: &Transport) -> std::io::Result<u64> {
    let arrays = sections::stored(transport);
    let mut offset = 0;
    let mut sections = Vec::new();
    for (name, bytes) in &arrays {
        sections.push(Section { name: name.clone(), offset, length: bytes.len() as u64 });
        offset = aligned(offset + bytes.len() as u64);
    }
    let sources = |solved: &super::Solved| solved.responses.iter().map(|response| response.source).collect();
    let header = Header {
        certificate: transport.certificate.clone(),
        sections,
        omissions: transport.omissions.clone(),
        solved: transport.solved.as_ref().map(sources),
    };
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
    Ok(header(path)?.certificate)
}

/// What a file leaves out of the full transport, likewise.
pub fn load_omissions(path: &Path) -> Result<Vec<Omission>, TransportError> {
    Ok(header(path)?.omissions)
}

/// Bytes by section, in the file's order, likewise.
pub fn sections(path: &Path) -> Result<Vec<(String, u64)>, TransportError> {
    let sections = header(path)?.sections.into_iter();
    Ok(sections.map(|section| (section.name, section.length)).collect())
}

fn header(path: &Path) -> Result<Header, TransportError> {
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
    serde_json::from_slice(&json).map_err(|error| broken(&error.to_string()))
}

/// Checks the checksum, every length and every index before anything is used.
pub fn load(path: &Path) -> Result<Transport, TransportError> {
    certified(path, load_uncertified(path)?)
}

fn certified(path: &Path, transport: Transport) -> Result<Transport, TransportError> {
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
    if !(OLDEST..=VERSION).contains(&version) {
        return Err(format!("is of version {version}; this program reads {OLDEST} to {VERSION}"));
    }
    let end = bytes.len().checked_sub(32).ok_or("is cut off")?;
    if blake3::hash(&bytes[..end]).as_bytes()[..] != bytes[end..] {
        return Err("is damaged: its checksum does not fit".to_owned());
    }
    let body = 16 + word(12)? as usize;
    let json = bytes[..end].get(16..body).ok_or("is cut off")?;
    let header: Header = serde_json::from_slice(json).map_err(|error| error.to_string())?;
    let sections =
        sections::Sections { bytes: &bytes[..end], base: aligned(body as u64), sections: header.sections };
    let transport = sections.transport(header.solved.as_deref())?;
    Ok(Transport { certificate: header.certificate, omissions: header.omissions, ..transport })
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

    /// Everything but what is hashed comes back by comparison, the rest by its hash.
    fn assert_comes_back(transport: &Transport) -> Vec<(String, u64)> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("light");
        save(&path, transport).unwrap();
        let loaded = load_uncertified(&path).unwrap();
        assert_eq!(loaded.hash(), transport.hash());
        assert_eq!(loaded.solved, transport.solved);
        assert_eq!(loaded.omissions, transport.omissions);
        sections(&path).unwrap()
    }

    fn names(sections: &[(String, u64)]) -> Vec<&str> {
        sections.iter().map(|section| section.0.as_str()).collect()
    }

    /// As version 1 wrote it: what is empty is a section of no bytes.
    #[test]
    fn files_of_the_first_version_are_read_as_they_are() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("light");
        let transport = transport(0.02);
        save(&path, &transport).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let header_end = 16 + u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        let mut header: Header = serde_json::from_slice(&bytes[16..header_end]).unwrap();
        for name in ["probes", "samples", "probe.starts", "probe.columns", "probe.weights"] {
            header.sections.push(Section { name: name.to_owned(), offset: 0, length: 0 });
        }
        let json = serde_json::to_vec(&header).unwrap();
        let mut old = MAGIC.to_vec();
        old.extend(1_u32.to_le_bytes());
        old.extend((json.len() as u32).to_le_bytes());
        old.extend(json);
        old.resize(old.len().next_multiple_of(64), 0);
        old.extend(&bytes[header_end.next_multiple_of(64)..bytes.len() - 32]);
        let sum = blake3::hash(&old);
        old.extend(sum.as_bytes());
        std::fs::write(&path, old).unwrap();
        assert_eq!(load(&path).unwrap().hash(), transport.hash());
    }

    #[test]
    fn what_is_empty_is_absent() {
        let sections = assert_comes_back(&transport(0.02));
        let absent =
            ["sky", "probes", "probe.starts", "probe.packed", "back_blends", "samples", "probe_depths"];
        assert!(absent.iter().all(|absent| !names(&sections).contains(absent)), "{sections:?}");
        assert!(sections.iter().all(|section| section.1 > 0), "{sections:?}");
        let nothing = names(&assert_comes_back(&Transport::default())).join(" ");
        assert_eq!(nothing, "origin");
    }

    #[test]
    fn nearly_full_rows_are_weights_alone_and_come_back_to_the_last_bit() {
        let mut transport = transport(0.02);
        for full in [40, 25, 15] {
            let mut rows = crate::transport::Rows::default();
            (0..40).for_each(|i| rows.push((0..full).map(|j| (j, 0.01 + 1e-6 * (i * 40 + j) as f32))));
            (transport.patch_from_patch, transport.dense) = (rows, true);
            let sections = assert_comes_back(&transport);
            let is_dense = names(&sections).contains(&"patch.dense");
            assert_eq!(is_dense, full > 20, "{full} of 40: {sections:?}");
            transport.dense = false;
            assert!(names(&assert_comes_back(&transport)).contains(&"patch.weights"));
        }
    }

    #[test]
    fn solved_light_stands_in_place_of_rows_and_grey_takes_one_channel() {
        use crate::transport::solved::{Response, Solved, Source, Spread};
        let mut transport = transport(0.02);
        let rows = crate::transport::Rows::default;
        (transport.patch_from_patch, transport.receiver_from_patch) = (rows(), rows());
        let grey = Spread { radiosity: vec![glam::Vec3::splat(0.3); 40], ..Spread::default() };
        let blue = vec![glam::Vec3::new(0.1, 0.2, 0.7); 100];
        let blue = Spread { receivers: [Vec::new(), blue], ..Spread::default() };
        let response = |source, spread| Response { source, spread };
        let responses = vec![response(Source::Never, grey), response(Source::Sky, blue)];
        transport.solved = Some(Solved { responses });
        transport.omissions =
            vec![Omission { feature: crate::scene::Feature::Matrix, relied_on: "all of it".to_owned() }];
        let sections = assert_comes_back(&transport);
        let light: Vec<_> = sections.iter().filter(|section| section.0.starts_with("solved")).collect();
        let told =
            [("solved.0.radiosity.grey".to_owned(), 160), ("solved.1.receivers.bounced".to_owned(), 1200)];
        assert_eq!(light, told.iter().collect::<Vec<_>>());
        transport.solved = None;
        assert!(transport.validate().is_err(), "rows are missing, and nothing stands for them");
    }

    #[test]
    fn directional_rows_come_back_and_without_them_there_is_no_section() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("light");
        let has_section = || {
            let bytes = std::fs::read(&path).unwrap();
            bytes.windows(b"directional.".len()).any(|word| word == b"directional.")
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
