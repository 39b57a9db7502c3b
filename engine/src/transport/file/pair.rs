//! A bake on disk: what the player loads, and beside it the full transport where the first leaves something out.
//!
//! ```text
//! light.hohlraum         what the scene needs while it plays; the full transport where nothing is left out
//! transport.hohlraum     only beside a light file that leaves something out: the full transport
//! ```
//! Both carry the hash of the full transport, so that two of different bakes are told apart. Each is replaced in one
//! piece, the full one first: whenever a bake is cut off, the light file is whole, and what stands beside it is either
//! its own or is seen not to be. The certificate in the light file is the newer one: colours and lights change it and
//! leave the full transport as it is.

use std::path::{Path, PathBuf};

use super::{TransportError, header, load_uncertified, save};
use crate::scene::file::baked_dir;
use crate::transport::{Omission, Transport};

pub const FULL: &str = "transport.hohlraum";

/// Where a scene's light file is: what the player loads.
pub fn path(project: &Path, scene: &str) -> PathBuf {
    baked_dir(project, scene).join("light.hohlraum")
}

/// Where the full transport is, if the light file leaves something out.
pub fn full_path(project: &Path, scene: &str) -> PathBuf {
    baked_dir(project, scene).join(FULL)
}

/// The full transport of a scene; its certificate holds.
pub fn load_full(project: &Path, scene: &str) -> Result<Transport, TransportError> {
    let transport = load_full_uncertified(project, scene)?;
    super::certified(&path(project, scene), transport)
}

/// The same whatever its certificate says.
pub fn load_full_uncertified(project: &Path, scene: &str) -> Result<Transport, TransportError> {
    let (light, beside) = (path(project, scene), full_path(project, scene));
    if !light.is_file() && beside.is_file() {
        return load_uncertified(&beside); // the bake was cut off between the two
    }
    let light_file = load_uncertified(&light)?;
    if light_file.omissions.is_empty() {
        return Ok(light_file);
    }
    if !beside.is_file() {
        return Err(TransportError::Parted { path: light, left_out: names(&light_file.omissions) });
    }
    let full = load_uncertified(&beside)?;
    let certificate = if belong(&light_file, &full) { light_file.certificate } else { full.certificate };
    Ok(Transport { certificate, ..full })
}

/// Do the files of a bake, as far as their heads tell, belong together? A full transport beside one that leaves nothing
/// out is a left-over.
pub fn is_whole(project: &Path, scene: &str) -> bool {
    let (light, beside) = (path(project, scene), full_path(project, scene));
    let Ok(light) = header(&light) else { return false };
    match light.omissions.is_empty() {
        true => !beside.exists(),
        false => header(&beside)
            .is_ok_and(|full| full.certificate.transport_hash == light.certificate.transport_hash),
    }
}

/// Are a player's transport and a full one of the same bake?
pub fn belong(light: &Transport, full: &Transport) -> bool {
    light.certificate.transport_hash == full.certificate.transport_hash
}

pub fn names(omissions: &[Omission]) -> String {
    let names: Vec<&str> = omissions.iter().map(|omission| omission.feature.name()).collect();
    names.join(", ")
}

/// Writes what the player loads: `shipped`, with `full` beside it, or `full` alone. `keep`: a full transport that is
/// there already and has the same hash stays.
pub fn save_pair(
    project: &Path,
    scene: &str,
    full: &Transport,
    shipped: Option<&Transport>,
    keep: bool,
) -> Result<(), TransportError> {
    let (light, beside) = (path(project, scene), full_path(project, scene));
    let Some(shipped) = shipped else {
        save(&light, full)?;
        return remove(&beside);
    };
    let hash = |path: &Path| header(path).ok().map(|header| header.certificate.transport_hash);
    if !keep || hash(&beside).as_ref() != Some(&full.certificate.transport_hash) {
        save(&beside, full)?;
    }
    save(&light, shipped).map(|_| ())
}

fn remove(path: &Path) -> Result<(), TransportError> {
    match std::fs::remove_file(path) {
        Err(source) if source.kind() != std::io::ErrorKind::NotFound => {
            Err(TransportError::Io { path: path.to_owned(), source })
        }
        _ => Ok(()),
    }
}
