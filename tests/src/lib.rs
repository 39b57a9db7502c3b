//! What tests of whole crates share.

pub mod source;

pub mod made;
pub mod project;

use std::path::{Path, PathBuf};

/// The folder of assets that the project does not hold itself: `$HOHLRAUM_SHARED`, else `../shared` beside
/// the workspace. Where there is none, says so and gives `None`: the test then has nothing to do.
pub fn shared() -> Option<PathBuf> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared");
    let folder = std::env::var_os("HOHLRAUM_SHARED").map_or_else(beside, PathBuf::from);
    if folder.is_dir() {
        println!("with ../shared"); // .ci/run counts both
        return Some(folder);
    }
    println!("not run: no ../shared");
    None
}

pub mod bumps;
pub mod closed_forms;
pub mod enclosure;
pub mod lit;
pub mod picture;
pub mod repeats;
pub mod room;
pub mod runtime;
pub mod solution;
pub mod solved;
pub mod surfaces;
pub mod systems;
pub mod table;
pub mod ten;
