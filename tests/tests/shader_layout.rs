//! Every struct that Rust writes and a shader reads lies in memory as the shader takes it: size and offset of
//! every field.

use std::mem::offset_of;

use engine::render::Channels;
use engine::render::coarse::CoarseUniform;
use engine::render::exposure::{ExposureState, MeterUniform};
use engine::render::frame::FrameUniform;
use engine::render::gather::MeanUniform;
use engine::render::light_grid::GridUniform;
use engine::render::lights::GpuLight;
use engine::render::materials::{MapUniform, MaterialUniform};
use engine::render::overlay::PanelUniform;
use engine::render::rays::{Blocker, CountUniform, GpuTriangle};
use engine::render::reflections::prefilter::{PrefilterUniform, ProjectUniform};
use engine::render::reflections::uses::{self, GpuReflectionProbe, ReflectionUse};
use engine::render::rows::PageUniform;
use engine::render::shaders;
use engine::render::shadow::ShadowView;
use engine::render::sky::SkyUniform;
use engine::render::unit::RescaleUniform;
use engine::transport::probe_field::Weights;
use engine::transport::reflection;
use engine::transport::{Patch, Sample};
use naga::{Module, TypeInner};

/// Fields and sizes of a struct in a composed shader; naga_oil adds a module's name to what it imports.
fn wgsl(module: &Module, name: &str) -> (Vec<(String, u32)>, u32) {
    let found = module.types.iter().find_map(|(_, ty)| {
        let own = ty.name.as_ref()?;
        let plain = own.split("X_naga_oil_mod_X").next()?;
        match &ty.inner {
            TypeInner::Struct { members, span } if plain == name => Some((members, *span)),
            _ => None,
        }
    });
    let (members, span) = found.unwrap_or_else(|| panic!("no struct {name}"));
    let fields = members.iter().map(|member| (member.name.clone().unwrap_or_default(), member.offset));
    (fields.collect(), span)
}

/// Compares the named fields' offsets; `size` is the twin's.
fn compare(source: engine::gpu::shader::Source, name: &str, fields: &[(&str, usize)], size: usize) {
    // With all that any scene has of it.
    let defines = shaders::defines(source.name).pop().unwrap_or_default();
    let module = shaders::library().unwrap().compose_with(source, &defines).unwrap();
    let (theirs, span) = wgsl(&module, name);
    let ours: Vec<(String, u32)> =
        fields.iter().map(|(name, offset)| ((*name).to_owned(), *offset as u32)).collect();
    let without_padding = |fields: Vec<(String, u32)>| -> Vec<(String, u32)> {
        fields.into_iter().filter(|(name, _)| name != "padding").collect()
    };
    assert_eq!(without_padding(theirs), without_padding(ours), "{name}");
    assert_eq!(span as usize, size, "size of {name}");
}

/// Offsets of a Rust struct's fields.
macro_rules! fields {
    ($ty:ty: $($field:ident),* $(,)?) => { &[$((stringify!($field), offset_of!($ty, $field))),*] };
}

#[test]
fn frame() {
    let fields = fields!(FrameUniform: clip_from_world, eye, forward, time, right, exposure, up, view,
        cascade_ends, cascade_texels, eye_depth, encode, pre_exposure, curve, capture, light_unit, directional);
    compare(shaders::SURFACE, "Frame", fields, size_of::<FrameUniform>());
}

#[test]
fn light_in_one_channel_and_in_three() {
    for defines in shaders::defines(shaders::BOUNCE.name) {
        let module = shaders::library().unwrap().compose_with(shaders::BOUNCE, &defines).unwrap();
        let channels = if defines.contains(&"GREY") { Channels::One } else { Channels::Three };
        let stored = wgsl(&module, "Stored");
        assert_eq!(stored, (vec![("light".to_owned(), 0)], channels.stride() as u32), "{defines:?}");
    }
}

#[test]
fn light() {
    let fields = fields!(GpuLight: position, kind, direction, range, power, layer, cone, first_view, texel);
    compare(shaders::SURFACE, "Light", fields, size_of::<GpuLight>());
    let fields = fields!(GridUniform: low, everywhere, cells_per_metre, counts);
    compare(shaders::SURFACE, "LightGrid", fields, size_of::<GridUniform>());
}

#[test]
fn material() {
    let fields = fields!(MaterialUniform: base, emission, metallic, roughness, normal_scale, cutoff, flags,
        base_map, metal_map, normal_map, emission_map);
    compare(shaders::SURFACE, "Material", fields, size_of::<MaterialUniform>());
    compare(shaders::SURFACE, "Map", fields!(MapUniform: u, v), size_of::<MapUniform>());
}

#[test]
fn shadow() {
    // Slots of a dynamic offset are wider than what the shader reads of them.
    compare(shaders::SHADOW, "ShadowView", fields!(ShadowView: clip_from_world), 64);
    assert_eq!(size_of::<ShadowView>(), 256);
}

#[test]
fn reflections() {
    let fields = fields!(GpuReflectionProbe: rows, position, fade, half, unit, cube, group, box_projection);
    // Three rows there, one array here.
    let rows = [("row_x", 0), ("row_y", 16), ("row_z", 32)];
    let fields: Vec<_> = rows.into_iter().chain(fields[1..].iter().copied()).collect();
    compare(shaders::SURFACE, "Probe", &fields, size_of::<GpuReflectionProbe>());
    let fields = fields!(ReflectionUse: probes, weights, count, per_point, strength, last_level, sky, baked);
    compare(shaders::SURFACE, "Use", fields, uses::READ_BYTES as usize);
    assert_eq!(size_of::<ReflectionUse>(), 256);
    let fields = fields!(PrefilterUniform: forward, count, right, up, samples);
    compare(shaders::PREFILTER, "Prefilter", fields, size_of::<PrefilterUniform>());
    compare(shaders::PREFILTER, "Project", fields!(ProjectUniform: size, first), size_of::<ProjectUniform>());
}

#[test]
fn sky() {
    let fields =
        fields!(SkyUniform: zenith, kind, horizon, sun_radius, ground, turn, sun, strength, sun_radiance);
    compare(shaders::SKY, "Sky", fields, size_of::<SkyUniform>());
}

#[test]
fn patches_and_samples() {
    let fields = fields!(Patch: centre, area, normal, batch, first_triangle, triangle_count, first_sample,
        sample_count, back, component, aggregate);
    compare(shaders::DIRECT, "Patch", fields, size_of::<Patch>());
    // `patch` is a reserved word of WGSL.
    let fields = &[
        ("position", offset_of!(Sample, position)),
        ("owner", offset_of!(Sample, patch)),
        ("normal", offset_of!(Sample, normal)),
    ];
    compare(shaders::DIRECT, "Sample", fields, size_of::<Sample>());
}

#[test]
fn exposure_and_overlay() {
    let fields = fields!(MeterUniform: size, step, kept, compensation, least, most);
    compare(shaders::EXPOSURE, "Meter", fields, size_of::<MeterUniform>());
    let fields = fields!(ExposureState: stops, exposure, pre_exposure);
    compare(shaders::EXPOSURE, "Exposure", fields, size_of::<ExposureState>());
    let fields = fields!(PanelUniform: size, scale, encode, display);
    compare(shaders::OVERLAY, "Panel", fields, size_of::<PanelUniform>());
}

#[test]
fn weights_of_probes() {
    compare(shaders::OBJECTS, "Weights", fields!(Weights: probes, weights), size_of::<Weights>());
}

#[test]
fn rows() {
    compare(
        shaders::BOUNCE,
        "Page",
        fields!(PageUniform: first, count, packed, width),
        size_of::<PageUniform>(),
    );
    let fields = fields!(CoarseUniform: patches, aggregates, chunks);
    compare(shaders::COARSE, "Coarse", fields, size_of::<CoarseUniform>());
    compare(shaders::UNIT, "Rescale", fields!(RescaleUniform: columns, factor), size_of::<RescaleUniform>());
    let fields = fields!(MeanUniform: receivers, share, probe);
    compare(shaders::MEAN, "Mean", fields, size_of::<MeanUniform>());
}

#[test]
fn rays() {
    let fields = fields!(Blocker: row_x, row_y, row_z, centre, radius, nodes, triangles, parts, scale);
    compare(shaders::DIRECT, "Blocker", fields, size_of::<Blocker>());
    let fields = fields!(GpuTriangle: a, part, b, ordered, c);
    compare(shaders::DIRECT, "Triangle", fields, size_of::<GpuTriangle>());
    compare(shaders::DIRECT, "Count", fields!(CountUniform: blockers, offset), size_of::<CountUniform>());
    // The tree's nodes are uploaded as they are.
    let module = shaders::library().unwrap().compose(shaders::DIRECT).unwrap();
    assert_eq!(wgsl(&module, "Node").1, 80);
}

/// What both sides reckon with has one value.
#[test]
fn constants_of_reflections() {
    let shader = |name: &str| {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders").join(name);
        std::fs::read_to_string(path).unwrap()
    };
    let (reads, surface) = (shader("scene/reflection.wgsl"), shader("surface.wgsl"));
    for (text, name, value) in [
        (&reads, "SHARP", reflection::SHARP),
        (&reads, "ROUGH", reflection::ROUGH),
        (&surface, "MOST_IN_CAPTURES", reflection::MOST_IN_CAPTURES),
    ] {
        assert!(text.contains(&format!("const {name}: f32 = {value:?};")), "{name} is {value}");
    }
    assert!(reads.contains(&format!("const MOST: u32 = {}u;", uses::MOST)));
}
