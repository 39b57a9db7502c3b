// From radiance to the display: exposure, tone curve, sRGB. The curve is linear up to 0.8 and then bends
// towards 1, paling bright colours: the shoulder of the Khronos PBR Neutral tone mapper (2024). Its toe, which
// takes off the 4 % that dielectrics reflect, is left out, as diffuse light has no such share.
#import hohlraum::frame::{frame, ALBEDO}

@group(3) @binding(0) var radiance: texture_2d<f32>;
@group(3) @binding(0) var radiance_samples: texture_multisampled_2d<f32>;

@vertex
fn corner(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn tonemap(@builtin(position) at: vec4f) -> @location(0) vec4f {
    return encoded(displayed(textureLoad(radiance, vec2i(at.xy), 0).rgb));
}

/// Each sample goes through the curve before they are averaged: edges of bright things stay smooth.
@fragment
fn tonemap_samples(@builtin(position) at: vec4f) -> @location(0) vec4f {
    var sum = vec3f(0.0);
    for (var s = 0; s < 4; s++) {
        sum += displayed(textureLoad(radiance_samples, vec2i(at.xy), s).rgb);
    }
    return encoded(sum / 4.0);
}

fn displayed(light: vec3f) -> vec3f {
    if frame.view >= ALBEDO {
        return saturate(light);
    }
    let color = max(light * frame.exposure, vec3f(0.0));
    let peak = max(color.r, max(color.g, color.b));
    let bend = 0.8;
    if peak < bend {
        return color;
    }
    let room = 1.0 - bend;
    let new_peak = 1.0 - room * room / (peak + room - bend);
    let pale = 1.0 - 1.0 / (0.15 * (peak - new_peak) + 1.0);
    return mix(color * (new_peak / peak), vec3f(new_peak), pale);
}

/// sRGB (IEC 61966-2-1), where the target does not do it.
fn encoded(color: vec3f) -> vec4f {
    let curve = 1.055 * pow(color, vec3f(1.0 / 2.4)) - 0.055;
    let by_hand = select(curve, color * 12.92, color <= vec3f(0.0031308));
    return vec4f(select(color, by_hand, frame.encode == 1u), 1.0);
}
