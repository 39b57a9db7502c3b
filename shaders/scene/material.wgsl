// Metallic-roughness materials (glTF 2.0): the pass's own group of whatever draws surfaces.
#define_import_path hohlraum::scene::material

/// Where in a picture a texture coordinate falls: u = dot(map.u.xyz, (uv, 1)), v likewise.
struct Map {
    /// w: which texture coordinates.
    u: vec4f,
    /// w: 1 where there is a picture.
    v: vec4f,
}

struct Material {
    /// Colour and opacity.
    base: vec4f,
    /// Radiance [W/m2/sr].
    emission: vec3f,
    metallic: f32,
    roughness: f32,
    normal_scale: f32,
    cutoff: f32,
    flags: u32,
    base_map: Map,
    metal_map: Map,
    normal_map: Map,
    emission_map: Map,
}

const MASKED: u32 = 1u;
const BLENDED: u32 = 2u;
/// By itself: nothing else lights it.
const SHINING: u32 = 4u;
const DOUBLE_SIDED: u32 = 8u;

@group(3) @binding(0) var<uniform> material: Material;
@group(3) @binding(1) var base_picture: texture_2d<f32>;
@group(3) @binding(2) var metal_picture: texture_2d<f32>;
@group(3) @binding(3) var normal_picture: texture_2d<f32>;
@group(3) @binding(4) var emission_picture: texture_2d<f32>;
@group(3) @binding(5) var base_sampler: sampler;
@group(3) @binding(6) var metal_sampler: sampler;
@group(3) @binding(7) var normal_sampler: sampler;
@group(3) @binding(8) var emission_sampler: sampler;

fn is(flag: u32) -> bool {
    return (material.flags & flag) != 0u;
}

fn mapped(map: Map, uv: vec4f) -> vec2f {
    let at = vec3f(select(uv.xy, uv.zw, map.u.w > 0.5), 1.0);
    return vec2f(dot(map.u.xyz, at), dot(map.v.xyz, at));
}

/// Colour and alpha.
fn base_color(uv: vec4f, color: vec4f) -> vec4f {
    return material.base * color
        * textureSample(base_picture, base_sampler, mapped(material.base_map, uv));
}

/// x metallic, y roughness.
fn metal(uv: vec4f) -> vec2f {
    let texel = textureSample(metal_picture, metal_sampler, mapped(material.metal_map, uv));
    return vec2f(material.metallic * texel.b, material.roughness * texel.g);
}

fn emission_at(uv: vec4f) -> vec3f {
    return material.emission
        * textureSample(emission_picture, emission_sampler, mapped(material.emission_map, uv)).rgb;
}

/// The normal map's normal in the frame of tangent, bitangent and normal.
fn bump(uv: vec4f) -> vec3f {
    let texel = textureSample(normal_picture, normal_sampler, mapped(material.normal_map, uv)).xyz;
    let n = (texel * 2.0 - 1.0) * vec3f(material.normal_scale, material.normal_scale, 1.0);
    return normalize(select(vec3f(0.0, 0.0, 1.0), n, dot(n, n) > 1e-8));
}
