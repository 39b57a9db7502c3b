// Depth as a light sees it, nothing culled: a back face blocks too. Holes of alpha masks are left out, or their share
// where they are too small for the map; a blended surface blocks a share of the texels that is its alpha. Shares are by
// ordered dither. HOLES is defined where there are such.
#import hohlraum::hash::hashed
#import hohlraum::scene::mesh::moved
#ifdef HOLES
#import hohlraum::scene::material::{material, base_color, base_picture, is, mapped, MASKED, BLENDED}
#endif

/// Texels a side: of two sheets whose lines do not cross, 0.36 comes through as 0.36 +- 0.002 (shifts alone: +- 0.1), and
/// a filter of 5 x 5 texels sees one sheet's share to 0.045 (0.031).
const BLOCK: u32 = 4u;

struct ShadowView {
    clip_from_world: mat4x4f,
}

@group(0) @binding(0) var<uniform> view: ShadowView;

struct Point {
    @builtin(position) clip: vec4f,
    @location(0) uv: vec4f,
    @location(1) color: vec4f,
    /// Another number for each triangle of each object: two sheets of glass do not let the same texels through.
    @location(2) @interpolate(flat) sheet: u32,
}

@vertex
fn still(@location(0) position: vec3f, @location(3) uv: vec4f, @location(4) color: vec4f) -> Point {
    return Point(view.clip_from_world * vec4f(position, 1.0), uv, color, sheet_of(position, 0u));
}

@vertex
fn moving(
    @location(0) position: vec3f,
    @location(3) uv: vec4f,
    @location(4) color: vec4f,
    @location(9) row_x: vec4f,
    @location(10) row_y: vec4f,
    @location(11) row_z: vec4f,
    @location(12) light: vec2u,
) -> Point {
    let world = moved(position, row_x, row_y, row_z);
    return Point(view.clip_from_world * vec4f(world, 1.0), uv, color, sheet_of(position, 1u + light.x));
}

#ifdef HOLES
@fragment
fn holes(point: Point, @builtin(front_facing) front: bool) {
    let alpha = base_color(point.uv, point.color).a;
    if is(MASKED) {
        if alpha < threshold(point, front) {
            discard;
        }
    } else if is(BLENDED) && alpha <= dither(point, front) {
        discard;
    }
}
#endif

#ifdef HOLES
/// Interleaved gradient noise (Jimenez 2014): every neighbourhood holds all thresholds. Two such patterns go together or
/// against each other, as their shift has it, and any two sheets are to let the product of their shares through. So each
/// block of texels has an offset of its own in every sheet: over a few blocks, all shifts. The two sides of a pane need
/// no blocks for that; their lines cross.
fn dither(point: Point, front: bool) -> f32 {
    let block = vec2u(point.clip.xy) / BLOCK;
    let offset = f32(hashed(block.x + hashed(block.y + point.sheet)) >> 8u) / 16777216.0;
    let at = select(point.clip.yx, point.clip.xy, front);
    return fract(52.9829189 * fract(dot(at, vec2f(0.06711056, 0.00583715))) + offset);
}

/// The mask's own where it is seen sharply. Where a texel of the map covers several of the picture, alpha is a mean, the
/// share that is solid, and so many texels are to block.
fn threshold(point: Point, front: bool) -> f32 {
    let texels = mapped(material.base_map, point.uv) * vec2f(textureDimensions(base_picture));
    let covered = max(length(dpdx(texels)), length(dpdy(texels)));
    return mix(material.cutoff, dither(point, front), saturate(log2(max(covered, 1.0))));
}
#endif

/// `object`: of what moves, whose positions are its mesh's.
fn sheet_of(position: vec3f, object: u32) -> u32 {
    let bits = bitcast<vec3u>(position);
    return hashed(bits.x + hashed(bits.y + hashed(bits.z + hashed(object))));
}
