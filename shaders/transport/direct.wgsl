// What leaves patches before any bounce: E_i = M_i + rho_i * H_i, H_i the mean over the patch's points of the
// irradiance from punctual lights [W/m2]. One thread a patch.
#import hohlraum::scene::light::{lights_at, light_of, arrival, visible}
#import hohlraum::transport::patch::{Patch, Sample}

@group(2) @binding(0) var<storage, read> patches: array<Patch>;
@group(2) @binding(1) var<storage, read> samples: array<Sample>;
@group(2) @binding(2) var<storage, read> albedo: array<vec4f>;
@group(2) @binding(3) var<storage, read> emitted: array<vec4f>;
@group(2) @binding(4) var<storage, read_write> exitance: array<vec4f>;

@compute @workgroup_size(64)
fn direct(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = id.y * groups.x * 64u + id.x;
    if i >= arrayLength(&exitance) || i >= arrayLength(&patches) {
        return;
    }
    let first = patches[i].first_sample;
    let count = patches[i].sample_count;
    let least = sqrt(patches[i].area) * 0.25;
    var sum = vec3f(0.0);
    for (var s = first; s < first + count; s++) {
        sum += irradiance(samples[s], least);
    }
    let mean = sum / f32(max(count, 1u));
    exitance[i] = vec4f(emitted[i].xyz + albedo[i].xyz * mean, 0.0);
}

fn irradiance(at: Sample, least: f32) -> vec3f {
    var sum = vec3f(0.0);
    let list = lights_at(at.position);
    for (var k = 0u; k < list.count; k++) {
        let light = light_of(list, k);
        let light_here = arrival(light, at.position, least);
        let cosine = dot(at.normal, light_here.towards);
        if cosine > 0.0 && any(light_here.irradiance > vec3f(0.0)) {
            let share = visible(light, at.position, at.normal, light_here.towards, false);
            sum += light_here.irradiance * (cosine * share);
        }
    }
    return sum;
}
