// The view and the time: group 0 of every pass that draws for a camera.
#define_import_path hohlraum::frame

struct Frame {
    clip_from_world: mat4x4f,
    /// Where the eye is, and 1; with parallel rays: against the rays, and 0.
    eye: vec4f,
    /// To the middle of the picture; `right` and `up` lead from there to its edges, for sky rays.
    forward: vec3f,
    time: f32,
    right: vec3f,
    /// Display = exposure * radiance.
    exposure: f32,
    up: vec3f,
    view: u32,
    /// Depths at which the sun's cascades end [m]; all 0: there are none.
    cascade_ends: vec4f,
    /// Widths of their texels [m].
    cascade_texels: vec4f,
    /// depth = dot(forward, position) - eye_depth
    eye_depth: f32,
    /// 1 where the target does not encode sRGB by itself.
    encode: u32,
    /// Radiance is drawn times this power of two.
    pre_exposure: f32,
    /// The tone curve.
    curve: u32,
    /// 1 for a reflection probe's camera.
    capture: u32,
    /// W/m2 of one stored unit of radiosity, a power of two.
    light_unit: f32,
    /// Where directional terms begin among the receivers.
    directional: u32,
}

@group(0) @binding(0) var<uniform> frame: Frame;

const COMPOSITE: u32 = 0u;
const DIRECT: u32 = 1u;
const INDIRECT: u32 = 2u;
const REFLECTION: u32 = 3u;
const ALBEDO: u32 = 4u;
const NORMAL: u32 = 5u;
const PATCHES: u32 = 6u;
const DENSITY: u32 = 7u;
const HEADLIGHT: u32 = 8u;
const PROBES: u32 = 9u;
const TETRAHEDRA: u32 = 10u;

/// Views that show no light are neither exposed nor bent.
const AS_IT_IS: u32 = 0u;
const NEUTRAL: u32 = 1u;
const AGX: u32 = 2u;

/// What half floats hold.
const BRIGHTEST: f32 = 65000.0;

/// Radiance as it is drawn.
fn drawn(radiance: vec3f) -> vec3f {
    return min(radiance * frame.pre_exposure, vec3f(BRIGHTEST));
}

/// From a point to the eye, unit.
fn to_eye(position: vec3f) -> vec3f {
    return normalize(frame.eye.xyz - position * frame.eye.w);
}
