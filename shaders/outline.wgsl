// A line around what is selected: pixels near the mask, but not in it. Its edge is as soft as a pixel.
#import hohlraum::frame::frame

/// Pixels.
const WIDTH: i32 = 2;
/// As a display shows it, for both themes.
const COLOR: vec3f = vec3f(1.0, 0.58, 0.13);

@group(3) @binding(0) var mask: texture_2d<f32>;

@vertex
fn corner(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn outline(@builtin(position) at: vec4f) -> @location(0) vec4f {
    let here = vec2i(at.xy);
    if textureLoad(mask, here, 0).r > 0.5 {
        discard;
    }
    let size = vec2i(textureDimensions(mask));
    var nearest = f32(WIDTH) + 1.0;
    for (var y = -WIDTH; y <= WIDTH; y++) {
        for (var x = -WIDTH; x <= WIDTH; x++) {
            let there = clamp(here + vec2i(x, y), vec2i(0), size - 1);
            if textureLoad(mask, there, 0).r > 0.5 {
                nearest = min(nearest, length(vec2f(f32(x), f32(y))));
            }
        }
    }
    let alpha = saturate(f32(WIDTH) + 0.5 - nearest);
    if alpha == 0.0 {
        discard;
    }
    return vec4f(select(pow(COLOR, vec3f(2.2)), COLOR, frame.encode == 1u), alpha);
}
