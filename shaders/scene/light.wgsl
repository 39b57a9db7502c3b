// Punctual lights (KHR_lights_punctual) and what their shadow maps let through.
#define_import_path hohlraum::scene::light

struct Light {
    position: vec3f,
    kind: u32,
    /// Along which it shines, unit.
    direction: vec3f,
    /// Windowed to nothing at this distance [m]; 0: it reaches all.
    range: f32,
    /// Sun: irradiance [W/m2]; point and spot: intensity [W/sr].
    power: vec3f,
    /// Its first shadow map among those of its kind; -1: it casts no shadow.
    layer: i32,
    /// share = saturate(cone.x * cos + cone.y)^2
    cone: vec2f,
    /// Its first matrix in `shadow_views`.
    first_view: u32,
    /// Width of a shadow map's texel [m]: sun everywhere, others at distance 1.
    texel: f32,
}

const SUN: u32 = 0u;
const POINT: u32 = 1u;
const SPOT: u32 = 2u;
/// In place of a layer: it casts shadows, but there is no map for it.
const UNMAPPED: i32 = -2;

@group(1) @binding(0) var<storage, read> lights: array<Light>;
@group(1) @binding(1) var<storage, read> shadow_views: array<mat4x4f>;
@group(1) @binding(2) var sun_maps: texture_depth_2d_array;
@group(1) @binding(3) var spot_maps: texture_depth_2d_array;
@group(1) @binding(4) var point_maps: texture_depth_2d_array;
@group(1) @binding(5) var nearer: sampler_comparison;

struct Arrival {
    /// To the light, unit.
    towards: vec3f,
    /// Irradiance on a surface that faces the light [W/m2], without shadows.
    irradiance: vec3f,
}

/// What arrives at a point; distances count as at least `least` metres, so that a light closer to a patch
/// than the patch is wide keeps its energy finite.
fn arrival(light: Light, position: vec3f, least: f32) -> Arrival {
    if light.kind == SUN {
        return Arrival(-light.direction, light.power);
    }
    let way = light.position - position;
    let distance = max(length(way), 1e-6);
    let towards = way / distance;
    var share = 1.0 / max(distance * distance, least * least);
    if light.range > 0.0 {
        let part = distance / light.range;
        share *= saturate(1.0 - part * part * part * part);
    }
    let cone = saturate(light.cone.x * dot(-towards, light.direction) + light.cone.y);
    return Arrival(towards, light.power * (share * cone * cone));
}

/// Share of the light that reaches a point, by its shadow map. The filter looks from a point off the surface by as
/// much as the filter is wide, and a little towards the light: a surface does not shade itself.
///
/// It looks once more from so far off that this moves it on the map by more than the filter is wide, and from
/// behind: where two walls meet, the first look reads beyond the outline of the wall that blocks, into the open,
/// and would light a thin line. The lesser of both counts.
fn visible(light: Light, position: vec3f, normal: vec3f, towards: vec3f) -> f32 {
    if light.layer < 0 {
        return 1.0;
    }
    var width = light.texel;
    if light.kind == POINT {
        let size = abs(position - light.position);
        width *= max(size.x, max(size.y, size.z));
    } else if light.kind == SPOT {
        width *= max(dot(position - light.position, light.direction), 0.0);
    }
    let cosine = dot(normal, towards);
    let slope = sqrt(saturate(1.0 - cosine * cosine));
    let near = position + normal * (width * (0.5 + 2.2 * slope)) + towards * (0.5 * width);
    let share = looked_up(light, near, 1);
    if share <= 0.0 {
        return 0.0;
    }
    let off = width * 2.5 / max(slope, 0.25);
    let far = position + normal * off - towards * (0.75 * off * cosine);
    return min(share, looked_up(light, far, 0));
}

/// Mean of (2 radius + 1)^2 comparisons about a point.
fn looked_up(light: Light, point: vec3f, radius: i32) -> f32 {
    let face = select(0u, face_of(point - light.position), light.kind == POINT);
    let clip = shadow_views[light.first_view + face] * vec4f(point, 1.0);
    if clip.w <= 0.0 {
        return 1.0;
    }
    let ndc = clip.xyz / clip.w;
    let at = vec2f(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y);
    let depth = saturate(ndc.z);
    let layer = light.layer + i32(face);
    if light.kind == SUN {
        return filtered_sun(at, layer, depth, radius);
    }
    if light.kind == SPOT {
        return filtered_spot(at, layer, depth, radius);
    }
    return filtered_point(at, layer, depth, radius);
}

/// Faces +x -x +y -y +z -z.
fn face_of(way: vec3f) -> u32 {
    let size = abs(way);
    if size.x >= size.y && size.x >= size.z {
        return select(1u, 0u, way.x > 0.0);
    }
    if size.y >= size.z {
        return select(3u, 2u, way.y > 0.0);
    }
    return select(5u, 4u, way.z > 0.0);
}

// Percentage closer filtering over bilinear comparisons (Reeves et al. 1987). WGSL passes no textures to
// functions on every target, hence one function a kind.

fn filtered_sun(at: vec2f, layer: i32, depth: f32, radius: i32) -> f32 {
    let texel = 1.0 / vec2f(textureDimensions(sun_maps));
    var sum = 0.0;
    for (var y = -radius; y <= radius; y++) {
        for (var x = -radius; x <= radius; x++) {
            let tap = at + vec2f(f32(x), f32(y)) * texel;
            sum += textureSampleCompareLevel(sun_maps, nearer, tap, layer, depth);
        }
    }
    let taps = f32(2 * radius + 1);
    return sum / (taps * taps);
}

fn filtered_spot(at: vec2f, layer: i32, depth: f32, radius: i32) -> f32 {
    let texel = 1.0 / vec2f(textureDimensions(spot_maps));
    var sum = 0.0;
    for (var y = -radius; y <= radius; y++) {
        for (var x = -radius; x <= radius; x++) {
            let tap = at + vec2f(f32(x), f32(y)) * texel;
            sum += textureSampleCompareLevel(spot_maps, nearer, tap, layer, depth);
        }
    }
    let taps = f32(2 * radius + 1);
    return sum / (taps * taps);
}

fn filtered_point(at: vec2f, layer: i32, depth: f32, radius: i32) -> f32 {
    let texel = 1.0 / vec2f(textureDimensions(point_maps));
    var sum = 0.0;
    for (var y = -radius; y <= radius; y++) {
        for (var x = -radius; x <= radius; x++) {
            let tap = at + vec2f(f32(x), f32(y)) * texel;
            sum += textureSampleCompareLevel(point_maps, nearer, tap, layer, depth);
        }
    }
    let taps = f32(2 * radius + 1);
    return sum / (taps * taps);
}
