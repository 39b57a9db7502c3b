//! What each omission must show in bytes, pipelines, dispatches and captures.

use engine::scene::Feature;

use crate::played::Played;

/// Is what the feature costs not there? `full`: the same scene with everything forced in.
pub fn is_gone(feature: Feature, played: &Played, full: &Played) -> bool {
    let none = |kind: &str| played.bytes[kind] == 0;
    let rows = |played: &Played| played.section("patch.") + played.section("receiver.");
    match feature {
        Feature::LightProbes => {
            played.section("probe") == 0
                && none("rows of probes")
                && none("light of probes")
                && !played.compiled("dering")
        }
        Feature::Reflections => none("cubemaps") && !played.compiled("blur"),
        Feature::Recaptures | Feature::UnseenCaptures => played.captures == 0,
        Feature::Sky => played.sky_patches == 0 && !played.compiled("sky"),
        // One for what is above the horizon, one for below.
        Feature::SkyPatches => played.sky_patches <= 2,
        Feature::Directional => played.section("directional") == 0,
        Feature::BlackPatches | Feature::UnlitPatches => rows(played) < rows(full),
        Feature::Matrix => {
            rows(played) == 0
                && none("rows")
                && played.moving.transport_dispatches == 0
                && played.steady.transport_dispatches == 0
        }
        Feature::Colour => {
            let in_one = |name: &String| !name.starts_with("solved.") || name.ends_with(".grey");
            // One float of four.
            played.sections.keys().all(in_one)
                && played.compiled("grey")
                && 4 * played.bytes["light"] <= full.bytes["light"]
        }
        Feature::CoarseCorrection => none("coarse correction"),
        Feature::Columns => played.section("patch.columns") == 0,
        Feature::Holes => !played.compiled("holes"),
        Feature::ShadowMaps => none("shadow maps"),
        // A software driver takes the part for masks along with cubemaps: it fails over what discards nothing.
        Feature::MaterialVariants => played.pipelines.iter().all(|name| {
            let is_variant = ["normal map", "blend", "unlit"].iter().any(|variant| name.contains(variant));
            !is_variant && (!name.contains("mask") || name.contains("cubemaps"))
        }),
    }
}

/// Bytes in kB of 1000.
pub const HEAD: &str = "| scene | file: surface, rows, solved [kB] | GPU: rows, patches, light, shadow maps, cubemaps [kB] \
| pipelines | dispatches moving, still | passes moving, still |\n|---|---|---|---|---|---|";

pub fn row(name: &str, played: &Played) -> String {
    let kilo = |bytes: u64| bytes.div_ceil(1000);
    let rows = ["patch.", "receiver.", "probe.", "directional."].map(|start| played.section(start));
    let (rows, solved) = (rows.into_iter().sum(), played.section("solved"));
    let surface = played.sections.values().sum::<u64>() - rows - solved;
    let bytes = |kinds: &[&str]| kilo(kinds.iter().map(|kind| played.bytes[kind]).sum());
    let passes = |drawn: &engine::render::Drawn| drawn.passes.render + drawn.passes.compute;
    format!(
        "| {name} | {}, {}, {} | {}, {}, {}, {}, {} | {} | {}, {} | {}, {} |",
        kilo(surface),
        kilo(rows),
        kilo(solved),
        bytes(&["rows", "rows of probes", "coarse correction"]),
        bytes(&["patches"]),
        bytes(&["light", "light of probes"]),
        bytes(&["shadow maps"]),
        bytes(&["cubemaps"]),
        played.pipelines.len(),
        played.moving.transport_dispatches,
        played.steady.transport_dispatches,
        passes(&played.moving),
        passes(&played.steady),
    )
}
