// Reflections: cubemaps blurred by roughness, blended by the boxes of their probes, seen where the reflected ray
// meets the box (engine/src/transport/reflection is the plain twin).
#define_import_path hohlraum::scene::reflection
#import hohlraum::transport::sh

struct Probe {
    /// Rows of box_from_world; the box is -1 .. 1.
    row_x: vec4f,
    row_y: vec4f,
    row_z: vec4f,
    /// Where the cubemap was taken.
    position: vec3f,
    /// Metres beyond the box over which it fades.
    fade: f32,
    /// Half the box, metres.
    half: vec3f,
    /// Radiance of one unit of the cubemap.
    unit: f32,
    /// Which cubemap; 0 is the sky's.
    cube: u32,
    /// Probes of one group share; groups take in order.
    group: u32,
    box_projection: u32,
    padding: u32,
}

/// What an object reads.
struct Use {
    /// Into `probes`, in the order in which they take.
    probes: array<vec4u, 2>,
    /// Where the whole object has the same.
    weights: array<vec4f, 2>,
    count: u32,
    /// 1: weights follow the point.
    per_point: u32,
    /// 0 .. 1
    strength: f32,
    /// The level of roughness 1.
    last_level: f32,
    /// 1 where there is a sky.
    sky: u32,
    /// 1 where irradiance is known: there is a bake.
    baked: u32,
}

@group(2) @binding(4) var<uniform> use_of: Use;
@group(2) @binding(5) var<storage, read> probes: array<Probe>;
/// Nine SH coefficients a cubemap.
@group(2) @binding(6) var<storage, read> harmonics: array<vec4f>;
@group(2) @binding(7) var cubes: texture_cube_array<f32>;
@group(2) @binding(8) var smooth_sampler: sampler;
/// x scale, y bias of F0: cosine across, roughness down.
@group(2) @binding(9) var split_sum: texture_2d<f32>;

const MOST: u32 = 8u;
const SHARP: f32 = 0.6;
const ROUGH: f32 = 0.75;
const PI: f32 = 3.14159265;

/// What stands around a point.
struct Around {
    /// From the mirrored direction, blurred by roughness [W/m2/sr].
    radiance: vec3f,
    /// What a surface with this normal would get where the cubemaps were taken [W/m2].
    irradiance: vec3f,
    /// The share of all this that probes or the sky hold; the rest is unknown.
    known: f32,
}

/// `smooth_normal` is that of the mesh.
fn around(
    position: vec3f,
    normal: vec3f,
    smooth_normal: vec3f,
    mirrored: vec3f,
    roughness: f32,
) -> Around {
    var weights = weights_at(position, smooth_normal);
    var sum = Around(vec3f(0.0), vec3f(0.0), 0.0);
    for (var k = 0u; k < use_of.count; k++) {
        if weights[k] > 0.0 {
            let probe = probes[use_of.probes[k / 4u][k % 4u]];
            var way = mirrored;
            if probe.box_projection == 1u {
                way = projected(probe, position, mirrored);
            }
            add(&sum, probe.cube, weights[k], probe.unit, way, normal, mirrored, roughness);
        }
    }
    let left = 1.0 - sum.known;
    if use_of.sky == 1u && left > 1e-4 {
        add(&sum, 0u, left, 1.0, mirrored, normal, mirrored, roughness);
    }
    return sum;
}

fn add(
    sum: ptr<function, Around>,
    cube: u32,
    weight: f32,
    unit: f32,
    way: vec3f,
    normal: vec3f,
    mirrored: vec3f,
    roughness: f32,
) {
    var l: array<vec3f, 9>;
    for (var k = 0u; k < 9u; k++) {
        l[k] = harmonics[cube * 9u + k].xyz;
    }
    let level = roughness * use_of.last_level;
    let rough = smoothstep(SHARP, ROUGH, roughness);
    var radiance = vec3f(0.0);
    if rough < 1.0 {
        radiance = textureSampleLevel(cubes, smooth_sampler, way, cube, level).rgb;
    }
    radiance = mix(radiance, sh::irradiance(l, mirrored) / PI, rough);
    (*sum).radiance += weight * unit * radiance;
    (*sum).irradiance += weight * unit * sh::irradiance(l, normal);
    (*sum).known += weight;
}

/// A surface is looked up from in front of it, so that it reads no probe through the wall behind it; inside the box
/// it reads the probe wherever it faces.
fn weights_at(position: vec3f, normal: vec3f) -> array<f32, MOST> {
    var weights: array<f32, MOST>;
    for (var k = 0u; k < use_of.count; k++) {
        weights[k] = use_of.weights[k / 4u][k % 4u];
    }
    if use_of.per_point == 0u {
        return weights;
    }
    for (var k = 0u; k < use_of.count; k++) {
        let probe = probes[use_of.probes[k / 4u][k % 4u]];
        let inside = smoothstep(0.0, 0.25 * probe.fade, depth(probe, position));
        weights[k] = max(raw(probe, position + normal * probe.fade), inside);
    }
    var left = 1.0;
    var first = 0u;
    while first < use_of.count {
        let group = probes[use_of.probes[first / 4u][first % 4u]].group;
        var end = first;
        var sum = 0.0;
        while end < use_of.count && probes[use_of.probes[end / 4u][end % 4u]].group == group {
            sum += weights[end];
            end++;
        }
        for (var k = first; k < end; k++) {
            weights[k] *= left / max(sum, 1.0);
        }
        left *= 1.0 - min(sum, 1.0);
        first = end;
    }
    return weights;
}

fn in_box(probe: Probe, position: vec3f) -> vec3f {
    let p = vec4f(position, 1.0);
    return vec3f(dot(probe.row_x, p), dot(probe.row_y, p), dot(probe.row_z, p));
}

/// How far a point is inside the box, metres.
fn depth(probe: Probe, position: vec3f) -> f32 {
    let inside = (1.0 - abs(in_box(probe, position))) * probe.half;
    return min(inside.x, min(inside.y, inside.z));
}

fn raw(probe: Probe, position: vec3f) -> f32 {
    let t = saturate(1.0 + depth(probe, position) / probe.fade);
    return t * t * (3.0 - 2.0 * t);
}

/// Where a ray meets the box, seen from where the cubemap was taken. A point outside counts as the nearest of the
/// box.
fn projected(probe: Probe, position: vec3f, direction: vec3f) -> vec3f {
    let start = clamp(in_box(probe, position), vec3f(-1.0), vec3f(1.0));
    let way = vec3f(
        dot(probe.row_x.xyz, direction),
        dot(probe.row_y.xyz, direction),
        dot(probe.row_z.xyz, direction),
    );
    let safe = select(way, vec3f(1e-12), abs(way) < vec3f(1e-12));
    let to_faces = (sign(safe) - start) / safe;
    let distance = min(to_faces.x, min(to_faces.y, to_faces.z));
    // How far the point was moved, in world space: the rows are the inverse of orthogonal axes, so that an axis is
    // its row over the row's squared length.
    let moved = start - in_box(probe, position);
    let inside = position
        + probe.row_x.xyz * (moved.x / dot(probe.row_x.xyz, probe.row_x.xyz))
        + probe.row_y.xyz * (moved.y / dot(probe.row_y.xyz, probe.row_y.xyz))
        + probe.row_z.xyz * (moved.z / dot(probe.row_z.xyz, probe.row_z.xyz));
    return inside + direction * distance - probe.position;
}

/// The share of what stands around that leaves towards the viewer. What bounces between the facets is given back
/// (Fdez-Aguera 2019): a white metal under uniform light shows exactly that light.
fn reflectance(f0: vec3f, edge: f32, cosine: f32, roughness: f32) -> vec3f {
    let terms = textureSampleLevel(split_sum, smooth_sampler, vec2f(cosine, roughness), 0.0).xy;
    let once = f0 * terms.x + edge * terms.y;
    return once * (1.0 + f0 * (1.0 / max(terms.x + terms.y, 1e-3) - 1.0));
}
