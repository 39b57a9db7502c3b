//! Every shader, embedded.

use std::sync::Arc;

use super::surface::Parts;
use crate::gpu::pipeline::Compiler;
use crate::gpu::shader::{Library, Source};
use crate::gpu::{Gpu, GpuError};

/// Files that others import; each stands behind those that it imports itself.
pub const IMPORTED: [Source; 13] = [
    Source { name: "hash", text: include_str!("../../../shaders/hash.wgsl") },
    Source { name: "frame", text: include_str!("../../../shaders/frame.wgsl") },
    Source { name: "scene/mesh", text: include_str!("../../../shaders/scene/mesh.wgsl") },
    Source { name: "scene/material", text: include_str!("../../../shaders/scene/material.wgsl") },
    Source { name: "scene/light", text: include_str!("../../../shaders/scene/light.wgsl") },
    Source { name: "transport/channels", text: include_str!("../../../shaders/transport/channels.wgsl") },
    Source { name: "transport/patch", text: include_str!("../../../shaders/transport/patch.wgsl") },
    Source { name: "transport/rays", text: include_str!("../../../shaders/transport/rays.wgsl") },
    Source {
        name: "transport/solid_angle",
        text: include_str!("../../../shaders/transport/solid_angle.wgsl"),
    },
    Source { name: "transport/rows", text: include_str!("../../../shaders/transport/rows.wgsl") },
    Source {
        name: "transport/directional",
        text: include_str!("../../../shaders/transport/directional.wgsl"),
    },
    Source { name: "transport/sh", text: include_str!("../../../shaders/transport/sh.wgsl") },
    Source { name: "scene/reflection", text: include_str!("../../../shaders/scene/reflection.wgsl") },
];

/// One file a pass.
pub const PASSES: [Source; 22] = [
    SHADOW, UNIT, DIRECT, BOUNCE, COARSE, GATHER, MEAN, DERING, OBJECTS, PREFILTER, SURFACE, PATCHES, PROBES,
    LINES, SKY, EXPOSURE, TONEMAP, OVERLAY, MIPMAP, PICKING, OUTLINE, WIREFRAME,
];

pub const SHADOW: Source = Source { name: "shadow", text: include_str!("../../../shaders/shadow.wgsl") };
pub const UNIT: Source =
    Source { name: "transport/unit", text: include_str!("../../../shaders/transport/unit.wgsl") };
pub const DIRECT: Source =
    Source { name: "transport/direct", text: include_str!("../../../shaders/transport/direct.wgsl") };
pub const BOUNCE: Source =
    Source { name: "transport/bounce", text: include_str!("../../../shaders/transport/bounce.wgsl") };
pub const COARSE: Source =
    Source { name: "transport/coarse", text: include_str!("../../../shaders/transport/coarse.wgsl") };
pub const GATHER: Source =
    Source { name: "transport/gather", text: include_str!("../../../shaders/transport/gather.wgsl") };
pub const MEAN: Source =
    Source { name: "transport/mean", text: include_str!("../../../shaders/transport/mean.wgsl") };
pub const DERING: Source =
    Source { name: "transport/dering", text: include_str!("../../../shaders/transport/dering.wgsl") };
pub const OBJECTS: Source =
    Source { name: "transport/objects", text: include_str!("../../../shaders/transport/objects.wgsl") };
pub const PREFILTER: Source =
    Source { name: "prefilter", text: include_str!("../../../shaders/prefilter.wgsl") };
pub const SURFACE: Source = Source { name: "surface", text: include_str!("../../../shaders/surface.wgsl") };
pub const PATCHES: Source = Source { name: "patches", text: include_str!("../../../shaders/patches.wgsl") };
pub const PROBES: Source = Source { name: "probes", text: include_str!("../../../shaders/probes.wgsl") };
pub const LINES: Source = Source { name: "lines", text: include_str!("../../../shaders/lines.wgsl") };
pub const SKY: Source = Source { name: "sky", text: include_str!("../../../shaders/sky.wgsl") };
pub const EXPOSURE: Source =
    Source { name: "exposure", text: include_str!("../../../shaders/exposure.wgsl") };
pub const TONEMAP: Source = Source { name: "tonemap", text: include_str!("../../../shaders/tonemap.wgsl") };
pub const OVERLAY: Source = Source { name: "overlay", text: include_str!("../../../shaders/overlay.wgsl") };
pub const MIPMAP: Source = Source { name: "mipmap", text: include_str!("../../../shaders/mipmap.wgsl") };
pub const PICKING: Source = Source { name: "picking", text: include_str!("../../../shaders/picking.wgsl") };
pub const OUTLINE: Source = Source { name: "outline", text: include_str!("../../../shaders/outline.wgsl") };
pub const WIREFRAME: Source =
    Source { name: "wireframe", text: include_str!("../../../shaders/wireframe.wgsl") };

/// What may be defined in a pass, in sets like those of some scenes: nothing, each part alone, all but each, and all of
/// them.
pub fn defines(pass: &str) -> Vec<Vec<&'static str>> {
    let all = match pass {
        "surface" => Parts::ALL.defines(),
        "shadow" => vec!["HOLES"],
        "transport/bounce" | "transport/gather" => vec!["DENSE", "GREY"],
        "transport/direct" | "transport/coarse" | "transport/unit" => vec!["GREY"],
        "transport/mean" | "transport/dering" | "transport/objects" | "probes" => vec!["GREY"],
        _ => Vec::new(),
    };
    let alone = all.iter().map(|part| vec![*part]);
    let without = |part| all.iter().copied().filter(|other| *other != part).collect::<Vec<_>>();
    let all_but = all.iter().copied().map(without);
    [Vec::new()].into_iter().chain(alone).chain(all_but).chain([all.clone()]).collect()
}

/// What makes pipelines of them.
pub fn compiler(gpu: &Arc<Gpu>) -> Result<Arc<Compiler>, GpuError> {
    Ok(Arc::new(Compiler { gpu: gpu.clone(), library: library()? }))
}

pub fn library() -> Result<Library, GpuError> {
    Library::new(&IMPORTED)
}
