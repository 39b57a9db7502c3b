// Text over the picture: a panel drawn on the CPU, each of its texels as a square of pixels, in a corner of the
// display after the tone curve. Its alpha is how much of the picture it hides.

struct Panel {
    /// Texels in use, from the upper left.
    size: vec2u,
    /// Pixels a texel.
    scale: u32,
    /// 1 where the target does not encode sRGB by itself.
    encode: u32,
    /// Of the display, pixels.
    display: vec2u,
    padding: vec2u,
}

@group(3) @binding(0) var<uniform> panel: Panel;
@group(3) @binding(1) var text: texture_2d<f32>;

@vertex
fn corner(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    let share = vec2f(f32(index & 1u), f32(index >> 1u));
    let at = share * vec2f(panel.size * panel.scale) / vec2f(panel.display);
    return vec4f(at.x * 2.0 - 1.0, 1.0 - at.y * 2.0, 0.0, 1.0);
}

@fragment
fn overlay(@builtin(position) at: vec4f) -> @location(0) vec4f {
    let texel = min(vec2u(at.xy) / panel.scale, panel.size - 1u);
    let shown = textureLoad(text, texel, 0);
    // The panel is stored as a display shows it.
    let linear = pow(shown.rgb, vec3f(2.2));
    return vec4f(select(linear, shown.rgb, panel.encode == 1u), shown.a);
}
