// What leaves patches before any bounce: E_i = M_i + rho_i * H_i, H_i the mean over the patch's points of the
// irradiance from punctual lights [W/m2]; a light that is near gives by the patch's solid angle instead. The twin is
// engine/src/transport/direct.rs. First the points, a thread each, for they wait on shadows: by maps (`direct`), or by
// rays (`direct_by_rays`); a light that has no map is asked by rays in any case, and a ray that meets something with
// holes asks the map. Then the patches, a thread each (`leave`).
#import hohlraum::frame::frame
#import hohlraum::scene::light::{Light, lights_at, light_of, arrival, visible, SUN, SPOT, UNMAPPED}
#import hohlraum::transport::channels::{Stored, dark, value_of, stored, of_any}
#import hohlraum::transport::patch::{Patch, Sample}
#import hohlraum::transport::rays::{triangles, let_through, holes_met}
#import hohlraum::transport::solid_angle::{solid_angle, cone_in_triangle}

@group(2) @binding(0) var<storage, read> patches: array<Patch>;
@group(2) @binding(1) var<storage, read> samples: array<Sample>;
@group(2) @binding(2) var<storage, read> albedo: array<Stored>;
@group(2) @binding(3) var<storage, read> emitted: array<Stored>;
@group(2) @binding(4) var<storage, read_write> exitance: array<Stored>;
/// By sample: H in light's unit.
@group(2) @binding(5) var<storage, read_write> arrived: array<Stored>;

/// Triangles that cover less of the sphere around a spot [sr] are taken at their middle, where there are more than
/// these: others are given their exact part of the cone.
const SMALL: f32 = 0.01;
const FEW: u32 = 32u;
/// Patches of more triangles are not summed over.
const MANY: u32 = 1024u;

@compute @workgroup_size(64)
fn direct(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    arrive(id.y * groups.x * 64u + id.x, false);
}

@compute @workgroup_size(64)
fn direct_by_rays(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    arrive(id.y * groups.x * 64u + id.x, true);
}

fn arrive(s: u32, by_rays: bool) {
    if s >= arrayLength(&samples) || s >= arrayLength(&arrived) {
        return;
    }
    let at = samples[s];
    arrived[s] = stored(of_any(irradiance(at.owner, at, by_rays) / frame.light_unit));
}

@compute @workgroup_size(64)
fn leave(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = id.y * groups.x * 64u + id.x;
    if i >= arrayLength(&exitance) || i >= arrayLength(&patches) {
        return;
    }
    let first = patches[i].first_sample;
    let count = patches[i].sample_count;
    var sum = dark();
    for (var s = first; s < first + count; s++) {
        sum += value_of(arrived[s]);
    }
    exitance[i] = stored(value_of(emitted[i]) + value_of(albedo[i]) * sum / f32(max(count, 1u)));
}

fn irradiance(i: u32, at: Sample, by_rays: bool) -> vec3f {
    var sum = vec3f(0.0);
    let list = lights_at(at.position);
    for (var k = 0u; k < list.count; k++) {
        sum += irradiance_from(light_of(list, k), i, at, by_rays);
    }
    return sum;
}

/// At one point of patch `i`, so that the mean over its points is the patch's.
fn irradiance_from(light: Light, i: u32, at: Sample, by_rays: bool) -> vec3f {
    let light_here = arrival(light, at.position, 0.0);
    let cosine = dot(at.normal, light_here.towards);
    if cosine <= 0.0 {
        return vec3f(0.0);
    }
    let way = light.position - at.position;
    let squared = dot(way, way);
    var irradiance = light_here.irradiance * cosine;
    if light.kind != SUN && patches[i].triangle_count > MANY {
        // The sample stands for a disc.
        let disc = patches[i].area / (f32(max(patches[i].sample_count, 1u)) * 6.28318531);
        irradiance *= squared / (squared + disc);
        if light.kind == SPOT {
            // No more than it has.
            let cone = 6.28318531 * (1.0 - (1.0 - light.cone.y) / light.cone.x + 1.0 / (3.0 * light.cone.x));
            irradiance = min(irradiance, light.power * (cone / (disc * 6.28318531)));
        }
    }
    let nearness = nearness_of(light, i);
    if nearness > 0.0 {
        let part = near_weight(light, at) / near_weights(light, i);
        irradiance = mix(irradiance, near_irradiance(light, i) * part, nearness);
    }
    if all(irradiance <= vec3f(0.0)) {
        return vec3f(0.0);
    }
    if by_rays || light.layer == UNMAPPED {
        return irradiance * asked(light, at, light_here.towards, squared);
    }
    return irradiance * visible(light, at.position, at.normal, light_here.towards, false);
}

fn asked(light: Light, at: Sample, towards: vec3f, squared: f32) -> f32 {
    if light.layer < 0 && light.layer != UNMAPPED {
        return 1.0; // it casts no shadow
    }
    let share = let_through(at.position, at.normal, towards, select(sqrt(squared), 1e30, light.kind == SUN));
    if share <= 0.0 || !holes_met {
        return share;
    }
    if light.layer < 0 {
        return 0.0; // no map that knows the holes
    }
    return visible(light, at.position, at.normal, towards, false);
}

/// 1 for a light nearer to a patch than 2.5 times its size, 0 beyond 3.5 times, and in between.
fn nearness_of(light: Light, i: u32) -> f32 {
    if light.kind == SUN || patches[i].triangle_count > MANY {
        return 0.0;
    }
    return saturate(3.5 - distance(light.position, patches[i].centre) / sqrt(patches[i].area));
}

/// How much a sample says of what is seen of a near patch: its part of the patch's solid angle.
fn near_weight(light: Light, at: Sample) -> f32 {
    let way = light.position - at.position;
    let squared = dot(way, way);
    return max(dot(at.normal, way), 0.0) / max(squared * sqrt(squared), 1e-18);
}

/// Their mean over the patch's samples.
fn near_weights(light: Light, i: u32) -> f32 {
    let first = patches[i].first_sample;
    var sum = 0.0;
    for (var s = first; s < first + patches[i].sample_count; s++) {
        sum += near_weight(light, samples[s]);
    }
    return max(sum, 1e-30) / f32(max(patches[i].sample_count, 1u));
}

/// H = I Omega / A, without shadows.
fn near_irradiance(light: Light, i: u32) -> vec3f {
    let first = patches[i].first_triangle;
    var flux = 0.0;
    for (var t = first; t < first + patches[i].triangle_count; t++) {
        let a = triangles[t].a - light.position;
        var b = triangles[t].c - light.position;
        var c = triangles[t].b - light.position;
        if patches[i].back == 1u {
            b = triangles[t].b - light.position;
            c = triangles[t].c - light.position;
        }
        let omega = solid_angle(a, b, c);
        if omega <= 0.0 {
            continue;
        }
        let middle = length(a + b + c) / 3.0;
        flux += triangle_flux(light, patches[i].triangle_count, a, b, c, omega) * windowed(light, middle);
    }
    return min(light.power * (flux / patches[i].area), vec3f(1e34));
}

fn triangle_flux(light: Light, count: u32, a: vec3f, b: vec3f, c: vec3f, omega: f32) -> f32 {
    if light.kind == SPOT && (count <= FEW || omega > SMALL) {
        return cone_in_triangle(a, b, c, light.direction, light.cone);
    }
    let middle = a + b + c;
    let cosine = dot(light.direction, middle / max(length(middle), 1e-30));
    let cone = saturate(light.cone.x * cosine + light.cone.y);
    return omega * cone * cone;
}

fn windowed(light: Light, distance: f32) -> f32 {
    if light.range <= 0.0 {
        return 1.0;
    }
    let part = distance / light.range;
    return saturate(1.0 - part * part * part * part);
}
