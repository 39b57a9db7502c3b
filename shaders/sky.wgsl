// The sky behind everything: constant, gradient with the sun's disc, or an equirectangular picture.
#import hohlraum::frame::{frame, drawn}

struct Sky {
    zenith: vec3f,
    kind: u32,
    horizon: vec3f,
    /// Of the disc, radians; 0: none.
    sun_radius: f32,
    ground: vec3f,
    /// Of a picture, about Y, radians.
    turn: f32,
    /// To the sun, unit.
    sun: vec3f,
    /// Times the picture.
    strength: f32,
    /// Of the disc [W/m2/sr].
    sun_radiance: vec3f,
    padding: f32,
}

const CONSTANT: u32 = 1u;
const GRADIENT: u32 = 2u;
const PICTURE: u32 = 3u;

@group(3) @binding(0) var<uniform> sky: Sky;
@group(3) @binding(1) var picture: texture_2d<f32>;
@group(3) @binding(2) var picture_sampler: sampler;

struct Point {
    @builtin(position) clip: vec4f,
    @location(0) at: vec2f,
}

@vertex
fn corner(@builtin(vertex_index) index: u32) -> Point {
    let at = vec2f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0);
    // Depth is reversed: 0 is behind everything.
    return Point(vec4f(at, 0.0, 1.0), at);
}

@fragment
fn behind(point: Point) -> @location(0) vec4f {
    let direction = normalize(frame.forward + frame.right * point.at.x + frame.up * point.at.y);
    var radiance = radiance_from(direction);
    // The sun's own light makes its highlights: captures would show them twice.
    radiance += select(disc(direction), vec3f(0.0), frame.capture == 1u);
    return vec4f(drawn(radiance), 1.0);
}

fn radiance_from(d: vec3f) -> vec3f {
    let uv = vec2f((atan2(d.x, -d.z) + sky.turn) / 6.28318531 + 0.5, acos(clamp(d.y, -1.0, 1.0)) / 3.14159265);
    let texel = textureSampleLevel(picture, picture_sampler, uv, 0.0).rgb;
    if sky.kind == PICTURE {
        return texel * sky.strength;
    }
    if sky.kind == GRADIENT && d.y < 0.0 {
        return sky.ground;
    }
    return mix(sky.horizon, sky.zenith, sqrt(max(d.y, 0.0)));
}

fn disc(d: vec3f) -> vec3f {
    let apart = length(d - sky.sun);
    let soft = max(fwidth(apart), 1e-6);
    return sky.sun_radiance * saturate((sky.sun_radius - apart) / soft + 0.5);
}
