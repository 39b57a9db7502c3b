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
    /// Another one for each triangle: two sheets of glass do not let the same texels through.
    @location(2) @interpolate(flat) sheet: u32,
}

@vertex
fn still(@location(0) position: vec3f, @location(3) uv: vec4f, @location(4) color: vec4f) -> Point {
    return Point(view.clip_from_world * vec4f(position, 1.0), uv, color, sheet_of(position));
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
    return Point(view.clip_from_world * vec4f(world, 1.0), uv, color, sheet_of(position));
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
/// Interleaved gradient noise (Jimenez 2014): every neighbourhood holds all thresholds. Along the same line of texels two
/// such patterns would go together, whatever lies between them: the two sides of a pane have lines that cross, so that
/// the share that both let through is the product of theirs, and panes are shifted and mirrored at random.
fn dither(point: Point, front: bool) -> f32 {
    let shift = vec2f(f32(point.sheet & 63u), f32((point.sheet >> 6u) & 63u));
    let mirror = select(1.0, -1.0, (point.sheet & 4096u) != 0u);
    let at = (point.clip.xy + shift) * vec2f(1.0, mirror);
    let across = select(at.yx, at, front);
    return fract(52.9829189 * fract(dot(across, vec2f(0.06711056, 0.00583715))));
}

/// The mask's own where it is seen sharply. Where a texel of the map covers several of the picture, alpha is a mean, the
/// share that is solid, and so many texels are to block.
fn threshold(point: Point, front: bool) -> f32 {
    let texels = mapped(material.base_map, point.uv) * vec2f(textureDimensions(base_picture));
    let covered = max(length(dpdx(texels)), length(dpdy(texels)));
    return mix(material.cutoff, dither(point, front), saturate(log2(max(covered, 1.0))));
}
#endif

/// A hash of 32 bits (PCG, O'Neill 2014), the same on every GPU.
fn sheet_of(position: vec3f) -> u32 {
    let bits = bitcast<vec3u>(position);
    return hashed(bits.x + hashed(bits.y + hashed(bits.z)));
}

fn hashed(seed: u32) -> u32 {
    let state = seed * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}
