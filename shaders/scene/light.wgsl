// Punctual lights (KHR_lights_punctual) and what their shadow maps let through.
#define_import_path hohlraum::scene::light
#import hohlraum::frame::frame

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
    /// Its first matrix in `shadow_views`; a sun's are the scene's and, where there are any, the cascades'.
    first_view: u32,
    /// Width of a shadow map's texel [m]: sun everywhere, others at distance 1.
    texel: f32,
}

/// Cells over the scene, x fastest, then y.
struct LightGrid {
    low: vec3f,
    /// So many lights, the first ones, reach all of the scene and stand in no list.
    everywhere: u32,
    cells_per_metre: vec3f,
    counts: vec3u,
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
@group(1) @binding(6) var<uniform> light_grid: LightGrid;
/// First and count of each cell's list, then the lists.
@group(1) @binding(7) var<storage, read> light_lists: array<u32>;

/// The lights of a point: those that reach all, then `count` less so many from `first` on in `light_lists`.
struct LightList {
    first: u32,
    count: u32,
}

fn lights_at(position: vec3f) -> LightList {
    let counts = light_grid.counts;
    let at = (position - light_grid.low) * light_grid.cells_per_metre;
    let cell = vec3u(clamp(at, vec3f(0.0), vec3f(counts) - 1.0));
    let index = 2u * ((cell.z * counts.y + cell.y) * counts.x + cell.x);
    return LightList(light_lists[index], light_grid.everywhere + light_lists[index + 1u]);
}

fn light_of(list: LightList, k: u32) -> Light {
    if k < light_grid.everywhere {
        return lights[k];
    }
    return lights[light_lists[list.first + k - light_grid.everywhere]];
}

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

/// Share of the light that reaches a point, by its shadow map; a sun's is that of the whole scene. `both`: its surface
/// is lit from both sides.
fn visible(light: Light, position: vec3f, normal: vec3f, towards: vec3f, both: bool) -> f32 {
    if light.layer < 0 {
        return 1.0;
    }
    return looked_up(light, 0u, width_of(light, position), position, normal, towards, both);
}

/// Of a texel of the light's own map (a sun's: of the whole scene), where the point is [m].
fn width_of(light: Light, position: vec3f) -> f32 {
    if light.kind == POINT {
        let size = abs(position - light.position);
        return light.texel * max(size.x, max(size.y, size.z));
    }
    if light.kind == SPOT {
        return light.texel * max(dot(position - light.position, light.direction), 0.0);
    }
    return light.texel;
}

/// The same for a point that this frame's eye sees: a sun's cascade, which passes over into the next, the last one
/// into the map of the whole scene.
fn visible_in_view(light: Light, position: vec3f, normal: vec3f, towards: vec3f, both: bool) -> f32 {
    if light.layer < 0 {
        return 1.0;
    }
    var map = 0u;
    var next = 0u;
    var over = 0.0;
    let depth = dot(frame.forward, position) - frame.eye_depth;
    let last = frame.cascade_ends.w;
    if light.kind == SUN && last > 0.0 && depth < last {
        var begin = 0.0;
        while map < 3u && depth >= frame.cascade_ends[map] {
            begin = frame.cascade_ends[map];
            map += 1u;
        }
        let end = frame.cascade_ends[map];
        over = saturate(1.0 - (end - depth) / (BLEND * (end - begin)));
        map += 1u;
        next = (map + 1u) % 5u;
    }
    // One map, or two where one passes over into the next.
    var share = 0.0;
    var weight = 1.0 - over;
    for (var k = 0; k < 2; k++) {
        var width = width_of(light, position);
        if map > 0u {
            width = frame.cascade_texels[map - 1u];
        }
        share += weight * looked_up(light, map, width, position, normal, towards, both);
        if over <= 0.0 {
            break;
        }
        map = next;
        weight = over;
    }
    return share;
}

/// The share of a slice at its end in which it passes over into the next.
const BLEND: f32 = 0.1;
/// Texels that the filter reaches to each side.
const REACH: f32 = 3.0;
/// Texels over whose slope fronts are drawn farther from the light than they are.
const PUSH: f32 = 4.5;
/// Texels by which the filter looks from off the surface: its back may be close behind it.
const LIFT: vec2f = vec2f(0.5, 2.5);
/// Where less of the surface than this is to be seen (it may cast no shadow), the rest counts as lit.
const LEAST: f32 = 0.2;

/// By a light's map with this number, whose texels are `width` metres wide at the point.
///
/// A filter blurs light and shadow on the plane of the surface, beyond its end too: where a wall in front of the sun
/// stands on a floor, it would read light from behind the wall, and from the wall. So of what the filter reads, only
/// that counts which shows this surface, or what stands before it.
fn looked_up(
    light: Light,
    number: u32,
    width: f32,
    position: vec3f,
    normal: vec3f,
    towards: vec3f,
    both: bool,
) -> f32 {
    let cosine = max(dot(normal, towards), 0.05);
    let slope = sqrt(1.0 - min(cosine * cosine, 1.0));
    let lift = width * (LIFT.x + LIFT.y * slope);
    let point = position + normal * lift;
    let map = select(number, face_of(point - light.position), light.kind == POINT);
    let layer = light.layer + i32(map);
    let clip_from_world = shadow_views[light.first_view + map];
    let clip = clip_from_world * vec4f(point, 1.0);
    if clip.w <= 0.0 {
        return 1.0;
    }
    let ndc = clip.xyz / clip.w;
    let at = in_map(ndc);
    // What lies farther than the surface, than what stands before it, and than the surface's own plane; a map that
    // shows only light or only shadow is asked once. One loop, as a processor that draws steps through every branch.
    var depth = ndc.z;
    var rise = vec2f(0.0);
    var free = 0.0;
    var beyond = 0.0;
    var unblocked = 0.0;
    for (var step = 0; step < 3; step++) {
        let share = farther(light.kind, at, layer, depth, rise);
        if step == 0 {
            free = share;
            unblocked = share;
            if free <= 0.001 || free >= 0.999 {
                return round(free);
            }
            let behind = (lift + width * (1.5 * REACH + PUSH) * slope) / cosine + 0.5 * width;
            let deep = clip_from_world * vec4f(point - towards * behind, 1.0);
            depth = deep.z / deep.w;
        } else if step == 1 {
            beyond = share;
            if both {
                break;
            }
            // Fronts are pushed by more than this, what stands on the surface is not.
            let foot_clip = clip_from_world * vec4f(position, 1.0);
            let foot = foot_clip.xyz / foot_clip.w;
            rise = steepness(clip_from_world, foot, foot_clip.w, normal);
            let texel = abs(rise) / map_size(light.kind);
            depth = foot.z + dot(rise, at - in_map(foot)) - 0.5 * PUSH * max(texel.x, texel.y);
        } else {
            unblocked = share;
        }
    }
    let blocked = 1.0 - free;
    return saturate(1.0 - blocked / max(blocked + unblocked - beyond, LEAST));
}

fn in_map(ndc: vec3f) -> vec2f {
    return vec2f(0.5, 0.5) + vec2f(0.5, -0.5) * ndc.xy;
}

/// Change of depth over a map's whole width and height, on the plane with this normal through the point at `ndc`.
fn steepness(clip_from_world: mat4x4f, ndc: vec3f, w: f32, normal: vec3f) -> vec2f {
    let other = select(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), abs(normal.x) > 0.7);
    let tangent = normalize(cross(normal, other));
    let along = clip_from_world * vec4f(tangent, 0.0);
    let across = clip_from_world * vec4f(cross(normal, tangent), 0.0);
    let plane = cross(along.xyz - ndc * along.w, across.xyz - ndc * across.w) / (w * w);
    let least = 1e-3 * length(plane);
    let facing = select(max(plane.z, least), min(plane.z, -least), plane.z < 0.0);
    return vec2f(-2.0, 2.0) * plane.xy / facing;
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

// Percentage closer filtering (Reeves et al. 1987) by a tent that reaches three texels to each side: six texels in a
// row have the weights 1 - s, 2 - s, 3 - s, 2 + s, 1 + s, s, in ninths, where s is how far the point is beyond the
// middle of the third. A bilinear comparison between two texels takes both, each with its weight.

/// Three taps along an axis: where, in texels, how much they count, and how far from the point their texels are.
struct Tent {
    at: vec3f,
    weight: vec3f,
    way: vec3f,
}

fn tent(at: f32) -> Tent {
    let third = floor(at - 0.5);
    let s = at - 0.5 - third;
    let weight = vec3f(3.0 - 2.0 * s, 5.0, 1.0 + 2.0 * s);
    let between = vec3f(2.0 - s, 2.0 + s, s) / weight;
    return Tent(third + vec3f(-1.5, 0.5, 2.5) + between, weight / 9.0, vec3f(-1.5, 0.5, 2.5) - s);
}

/// Share of what a light's map shows about a place that lies farther from the light than a plane with this depth
/// there and this steepness.
fn farther(kind: u32, at: vec2f, layer: i32, depth: f32, steepness: vec2f) -> f32 {
    let size = map_size(kind);
    let x = tent(at.x * size.x);
    let y = tent(at.y * size.y);
    let rise = steepness / size;
    var sum = 0.0;
    for (var k = 0u; k < 9u; k++) {
        let i = k % 3u;
        let j = k / 3u;
        let tap = vec2f(x.at[i], y.at[j]) / size;
        let nearest = saturate(depth + rise.x * x.way[i] + rise.y * y.way[j]);
        sum += x.weight[i] * y.weight[j] * compared(kind, tap, layer, nearest);
    }
    return sum;
}

fn map_size(kind: u32) -> vec2f {
    if kind == SUN {
        return vec2f(textureDimensions(sun_maps));
    }
    if kind == SPOT {
        return vec2f(textureDimensions(spot_maps));
    }
    return vec2f(textureDimensions(point_maps));
}

/// One bilinear comparison. WGSL passes no textures to functions on every target, hence one for each kind; in loops,
/// which a processor that draws leaves out where they do not run, as it does not leave out branches.
fn compared(kind: u32, tap: vec2f, layer: i32, depth: f32) -> f32 {
    var share = 0.0;
    for (var due = kind == SUN; due; due = false) {
        share = textureSampleCompareLevel(sun_maps, nearer, tap, layer, depth);
    }
    for (var due = kind == SPOT; due; due = false) {
        share = textureSampleCompareLevel(spot_maps, nearer, tap, layer, depth);
    }
    for (var due = kind == POINT; due; due = false) {
        share = textureSampleCompareLevel(point_maps, nearer, tap, layer, depth);
    }
    return share;
}
