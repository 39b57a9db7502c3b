// Patches in colours of their own, or by their size: flat, from triangles with vertices of their own.
#import hohlraum::hash::hashed
#import hohlraum::frame::{frame, to_eye, DENSITY}

struct Point {
    @builtin(position) clip: vec4f,
    @location(0) position: vec3f,
    /// Of the patch in front and behind.
    @location(1) @interpolate(flat) patches: vec2u,
    /// 0 the smallest patch, 1 the largest.
    @location(2) @interpolate(flat) sizes: vec2f,
}

@vertex
fn corner(@location(0) position: vec3f, @location(1) patches: vec2u, @location(2) sizes: vec2f) -> Point {
    return Point(frame.clip_from_world * vec4f(position, 1.0), position, patches, sizes);
}

@fragment
fn flat_color(point: Point, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    let normal = normalize(cross(dpdx(point.position), dpdy(point.position)));
    // A little shape, so that walls of one colour part.
    let shade = 0.75 + 0.25 * abs(dot(normal, to_eye(point.position)));
    let id = select(point.patches.y, point.patches.x, front);
    let size = select(point.sizes.y, point.sizes.x, front);
    if id == 0xffffffffu {
        return vec4f(vec3f(0.05) * shade, 1.0);
    }
    if frame.view == DENSITY {
        return vec4f(ramp(size) * shade, 1.0);
    }
    return vec4f(color_of(id) * shade, 1.0);
}

/// The number's hash as a light, well spread colour.
fn color_of(id: u32) -> vec3f {
    let hash = hashed(id);
    let bytes = vec3f(f32(hash & 255u), f32((hash >> 8u) & 255u), f32((hash >> 16u) & 255u)) / 255.0;
    return 0.12 + 0.88 * bytes * bytes;
}

/// Blue, cyan, green, yellow, red.
fn ramp(t: f32) -> vec3f {
    let at = saturate(t) * 4.0;
    return saturate(vec3f(
        min(at - 2.0, 1.0),
        min(at, 4.0 - at),
        2.0 - at,
    ));
}
