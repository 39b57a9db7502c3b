// A picture's next smaller level: the mean of four texels, by the sampler (which decodes sRGB before).

@group(3) @binding(0) var level: texture_2d<f32>;
@group(3) @binding(1) var linear: sampler;

struct Point {
    @builtin(position) clip: vec4f,
    @location(0) uv: vec2f,
}

@vertex
fn corner(@builtin(vertex_index) index: u32) -> Point {
    let at = vec2f(f32(index & 1u) * 2.0, f32(index >> 1u) * 2.0);
    return Point(vec4f(at.x * 2.0 - 1.0, 1.0 - at.y * 2.0, 0.0, 1.0), at);
}

@fragment
fn smaller(point: Point) -> @location(0) vec4f {
    return textureSampleLevel(level, linear, point.uv, 0.0);
}
