// The end of a product. With aggregates (room-sized groups of patches), what the bounce has not yet
// evened out between rooms is solved for directly: with d = next - B,
//     r = Restricted d        one number an aggregate, channel by channel
//     c = Inverse r              what irradiance the aggregate lacks
//     B = max(next + albedo c[aggregate], E)
// Without aggregates c is 0.
#import hohlraum::transport::patch::Patch

struct Coarse {
    patches: u32,
    aggregates: u32,
    /// Stretches of 64 patches.
    chunks: u32,
    padding: u32,
}

@group(3) @binding(0) var<uniform> coarse: Coarse;

// restrict_change: one thread an aggregate and stretch of patches
@group(2) @binding(0) var<storage, read> radiosity_before: array<vec4f>;
@group(2) @binding(1) var<storage, read> next: array<vec4f>;
@group(3) @binding(1) var<storage, read> restricted: array<vec4f>;
@group(3) @binding(2) var<storage, read_write> parts: array<vec4f>;

@compute @workgroup_size(64)
fn restrict_change(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = id.y * groups.x * 64u + id.x;
    if i >= coarse.aggregates * coarse.chunks {
        return;
    }
    let aggregate = i / coarse.chunks;
    let first = (i % coarse.chunks) * 64u;
    var sum = vec3f(0.0);
    for (var j = first; j < min(first + 64u, coarse.patches); j++) {
        sum += restricted[aggregate * coarse.patches + j].xyz * (next[j].xyz - radiosity_before[j].xyz);
    }
    parts[i] = vec4f(sum, 0.0);
}

// solve: one workgroup
@group(3) @binding(3) var<storage, read> inverse: array<vec4f>;
@group(3) @binding(4) var<storage, read_write> correction: array<vec4f>;
var<workgroup> residuals: array<vec3f, 64>;

@compute @workgroup_size(64)
fn solve(@builtin(local_invocation_index) thread: u32) {
    var sum = vec3f(0.0);
    if thread < coarse.aggregates {
        for (var k = 0u; k < coarse.chunks; k++) {
            sum += parts[thread * coarse.chunks + k].xyz;
        }
    }
    residuals[thread] = sum;
    workgroupBarrier();
    if thread < coarse.aggregates {
        var change = vec3f(0.0);
        for (var a = 0u; a < coarse.aggregates; a++) {
            change += inverse[thread * coarse.aggregates + a].xyz * residuals[a];
        }
        correction[thread] = vec4f(change, 0.0);
    }
}

// correct: one thread a patch
@group(2) @binding(0) var<storage, read> patches: array<Patch>;
@group(2) @binding(2) var<storage, read> exitance: array<vec4f>;
@group(2) @binding(3) var<storage, read> emitted: array<vec4f>;
@group(2) @binding(4) var<storage, read> albedo: array<vec4f>;
@group(2) @binding(5) var<storage, read_write> radiosity: array<vec4f>;
/// Radiosity without what patches emit themselves.
@group(2) @binding(6) var<storage, read_write> bounced: array<vec4f>;
@group(3) @binding(1) var<storage, read> correction_now: array<vec4f>;

@compute @workgroup_size(64)
fn correct(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = id.y * groups.x * 64u + id.x;
    if i >= coarse.patches {
        return;
    }
    var change = vec3f(0.0);
    // A patch may belong to none.
    if patches[i].aggregate < coarse.aggregates {
        change = albedo[i].xyz * correction_now[patches[i].aggregate].xyz;
    }
    let b = max(next[i].xyz + change, exitance[i].xyz);
    radiosity[i] = vec4f(b, 0.0);
    bounced[i] = vec4f(max(b - emitted[i].xyz, vec3f(0.0)), 0.0);
}
