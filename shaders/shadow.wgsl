// Depth as a light sees it, nothing culled: a back face blocks too. Holes of alpha masks are left out, or their share
// where they are too small for the map; a blended surface blocks a share of the texels that is its alpha. Shares are by
// ordered dither. HOLES is defined where there are such.
#import hohlraum::scene::mesh::moved
#ifdef HOLES
#import hohlraum::scene::material::{material, base_color, base_picture, is, mapped, MASKED, BLENDED}
#endif

struct ShadowView {
    clip_from_world: mat4x4f,
}

@group(0) @binding(0) var<uniform> view: ShadowView;

struct Point {
    @builtin(position) clip: vec4f,
    @location(0) uv: vec4f,
    @location(1) color: vec4f,
    /// Whole texels, another shift for each triangle: two sheets of glass do not let the same texels through.
    @location(2) @interpolate(flat) shift: vec2f,
}

@vertex
fn still(@location(0) position: vec3f, @location(3) uv: vec4f, @location(4) color: vec4f) -> Point {
    return Point(view.clip_from_world * vec4f(position, 1.0), uv, color, shift_of(position));
}

@vertex
fn moving(
    @location(0) position: vec3f,
    @location(3) uv: vec4f,
    @location(4) color: vec4f,
    @location(9) row_x: vec4f,
    @location(10) row_y: vec4f,
    @location(11) row_z: vec4f,
) -> Point {
    let world = moved(position, row_x, row_y, row_z);
    return Point(view.clip_from_world * vec4f(world, 1.0), uv, color, shift_of(position));
}

#ifdef HOLES
@fragment
fn holes(point: Point) {
    let alpha = base_color(point.uv, point.color).a;
    if is(MASKED) {
        if alpha < threshold(point) {
            discard;
        }
    } else if is(BLENDED) && alpha <= dither(point.clip.xy + point.shift) {
        discard;
    }
}
#endif

#ifdef HOLES
/// The mask's own where it is seen sharply. Where a texel of the map covers several of the picture, alpha is a mean, the
/// share that is solid, and so many texels are to block.
fn threshold(point: Point) -> f32 {
    let texels = mapped(material.base_map, point.uv) * vec2f(textureDimensions(base_picture));
    let covered = max(length(dpdx(texels)), length(dpdy(texels)));
    return mix(material.cutoff, dither(point.clip.xy + point.shift), saturate(log2(max(covered, 1.0))));
}
#endif

/// Interleaved gradient noise (Jimenez 2014): every neighbourhood holds all thresholds.
fn dither(at: vec2f) -> f32 {
    return fract(52.9829189 * fract(dot(at, vec2f(0.06711056, 0.00583715))));
}

fn shift_of(position: vec3f) -> vec2f {
    let a = fract(sin(dot(position, vec3f(12.9898, 78.233, 37.719))) * 43758.547);
    let b = fract(sin(dot(position, vec3f(39.3468, 11.135, 83.155))) * 24634.634);
    return floor(vec2f(a, b) * 64.0);
}
