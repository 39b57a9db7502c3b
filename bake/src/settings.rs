//! From what the command line and the project say to how a scene is baked.

use engine::scene::file::{Project, Quality};
use engine::transport::key::BakeWith;

use crate::{BakeError, Settings};

/// Patches that a quality aims at; the patch length follows from the scene's area. Together with the rays below they are
/// measured points near the front of error against bake time (`hohlraum-bake report`): errors of patches fall with their
/// length, those of rays are averaged away by the receivers, so that rays are worth less than patches. The front alone
/// would have half as many rays; walls then look blotched where a small bright patch of sun lights a room.
fn patches(quality: Quality) -> f64 {
    match quality {
        Quality::Draft => 1000.0,
        Quality::Standard => 4000.0,
        Quality::Fine => 8000.0,
    }
}

fn rays(quality: Quality) -> u32 {
    match quality {
        Quality::Draft => 512,
        Quality::Standard => 1024,
        Quality::Fine => 2048,
    }
}

/// No patch is longer than this [m], unless the scene is so large that it would have more than [`LARGE`] times
/// the patches that its quality aims at: a box of half a kilometre is a box drawn in other units.
const LONGEST: f64 = 2.0;
const LARGE: f64 = 8.0;
/// Patches beyond which a length is refused rather than baked for days.
const MOST_PATCHES: f64 = 2e6;

/// `area`: of all static surfaces, m2. Also says whether the base length is new and belongs into the project.
pub fn settle(
    project: &Project,
    scene: &str,
    settings: &Settings,
    area: f64,
) -> Result<(BakeWith, bool), BakeError> {
    let quality = settings.quality.unwrap_or(project.bake.quality);
    let rays = settings.rays.or(project.bake.rays).unwrap_or(rays(quality));
    let explicit = settings.patch_length.or(project.bake.patch_length);
    let fixed = project.bake.base_length.get(&base_length_key(scene, quality)).copied();
    let length_for = |patches: f64| (area / patches).sqrt();
    let aimed = patches(quality);
    let natural = length_for(aimed).min(LONGEST).max(length_for(LARGE * aimed)).max(1e-6);
    let length = explicit.or(fixed).unwrap_or(natural);
    if !(length > 0.0 && length.is_finite()) || rays == 0 {
        return Err(BakeError::Other(format!(
            "rays are {rays}, the patch length {length}: both must be above 0"
        )));
    }
    if area / (length * length) > MOST_PATCHES {
        let most = (area / MOST_PATCHES).sqrt();
        return Err(BakeError::Other(format!(
            "a patch length of {length} m makes {:.0} patches of {area:.0} m2; use at least {most:.3} m",
            area / (length * length)
        )));
    }
    let new = explicit.is_none() && fixed.is_none() && area > 0.0;
    // Sobol points are even in powers of two.
    Ok((BakeWith { quality, rays: rays.min(1 << 20).next_power_of_two(), length }, new))
}

pub fn base_length_key(scene: &str, quality: Quality) -> String {
    format!("{scene}/{quality}")
}
