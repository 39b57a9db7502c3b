// From radiance to the display: exposure, tone curve, sRGB.
//
// The neutral curve is linear up to 0.8 and then bends towards 1, paling bright colours: the shoulder of the
// Khronos PBR Neutral tone mapper (2024). Its toe, which takes off the 4 % that dielectrics reflect, is left out,
// as diffuse light has no such share.
//
// AgX is Troy Sobotka's (2022): colours are drawn towards grey, log2 of light from 12.47 stops below 1 to 4.03
// above it goes through a sigmoid, and most of the grey is taken out again. Matrices, range and the polynomial of
// the sigmoid are those of Benjamin Wrensch's "Minimal AgX implementation" (2023).
#import hohlraum::frame::{frame, AS_IT_IS, AGX}

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
    if frame.curve == AS_IT_IS {
        return saturate(light);
    }
    // What half floats could not hold is as bright as they go.
    let held = clamp(light, vec3f(0.0), vec3f(65504.0));
    let color = held * (frame.exposure / frame.pre_exposure);
    if frame.curve == AGX {
        return agx(color);
    }
    return neutral(color);
}

fn neutral(color: vec3f) -> vec3f {
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

const AGX_FROM_RGB = mat3x3f(
    vec3f(0.842479062, 0.0423282423, 0.0423756549),
    vec3f(0.0784336, 0.878468636, 0.0784336),
    vec3f(0.0792237451, 0.0791661275, 0.879142973),
);
const RGB_FROM_AGX = mat3x3f(
    vec3f(1.196879, -0.0528968518, -0.0529716355),
    vec3f(-0.0980208811, 1.15190313, -0.0980434501),
    vec3f(-0.0990297441, -0.0989611768, 1.15107367),
);
const LEAST_STOPS: f32 = -12.47393;
const MOST_STOPS: f32 = 4.026069;

fn agx(color: vec3f) -> vec3f {
    let stops = log2(max(AGX_FROM_RGB * color, vec3f(1e-10)));
    let x = saturate((stops - LEAST_STOPS) / (MOST_STOPS - LEAST_STOPS));
    let even = ((15.5 * x * x + 31.96) * x * x + 0.4298) * x * x - 0.00232;
    let odd = ((-40.14 * x * x - 6.868) * x * x + 0.1191) * x;
    // What comes out is encoded for a display of gamma 2.2.
    return pow(saturate(RGB_FROM_AGX * (even + odd)), vec3f(2.2));
}

/// sRGB (IEC 61966-2-1), where the target does not do it.
fn encoded(color: vec3f) -> vec4f {
    let curve = 1.055 * pow(color, vec3f(1.0 / 2.4)) - 0.055;
    let by_hand = select(curve, color * 12.92, color <= vec3f(0.0031308));
    return vec4f(select(color, by_hand, frame.encode == 1u), 1.0);
}
