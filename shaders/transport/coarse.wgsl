// The end of a product. With aggregates (room-sized groups of patches), what the bounce has not yet
// evened out between rooms is solved for directly: with d = next - B,
//     r = Restricted d        one number an aggregate, channel by channel
//     c = Inverse r              what irradiance the aggregate lacks
//     B = max(next + albedo c[aggregate], E)
// Without aggregates c is 0.
#import hohlraum::transport::channels::{Stored, value_of, stored, dark, in_full, of_full}
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
@group(2) @binding(0) var<storage, read> radiosity_before: array<Stored>;
@group(2) @binding(1) var<storage, read> next: array<Stored>;
@group(3) @binding(1) var<storage, read> restricted: array<Stored>;
@group(3) @binding(2) var<storage, read_write> parts: array<Stored>;

@compute @workgroup_size(64)
fn restrict_change(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = id.y * groups.x * 64u + id.x;
    if i >= coarse.aggregates * coarse.chunks {
        return;
    }
    let aggregate = i / coarse.chunks;
    let first = (i % coarse.chunks) * 64u;
    var sum = dark();
    for (var j = first; j < min(first + 64u, coarse.patches); j++) {
        let change = value_of(next[j]) - value_of(radiosity_before[j]);
        sum += value_of(restricted[aggregate * coarse.patches + j]) * change;
    }
    parts[i] = stored(sum);
}

// solve: one workgroup
@group(3) @binding(3) var<storage, read> inverse: array<Stored>;
@group(3) @binding(4) var<storage, read_write> correction: array<Stored>;
var<workgroup> residuals: array<vec3f, 64>;

@compute @workgroup_size(64)
fn solve(@builtin(local_invocation_index) thread: u32) {
    var sum = dark();
    if thread < coarse.aggregates {
        for (var k = 0u; k < coarse.chunks; k++) {
            sum += value_of(parts[thread * coarse.chunks + k]);
        }
    }
    residuals[thread] = in_full(sum);
    workgroupBarrier();
    if thread < coarse.aggregates {
        var change = dark();
        for (var a = 0u; a < coarse.aggregates; a++) {
            change += value_of(inverse[thread * coarse.aggregates + a]) * of_full(residuals[a]);
        }
        correction[thread] = stored(change);
    }
}

// correct: one thread a patch
@group(2) @binding(0) var<storage, read> patches: array<Patch>;
@group(2) @binding(2) var<storage, read> exitance: array<Stored>;
@group(2) @binding(3) var<storage, read> emitted: array<Stored>;
@group(2) @binding(4) var<storage, read> albedo: array<Stored>;
@group(2) @binding(5) var<storage, read_write> radiosity: array<Stored>;
/// Radiosity without what patches emit themselves.
@group(2) @binding(6) var<storage, read_write> bounced: array<Stored>;
@group(3) @binding(1) var<storage, read> correction_now: array<Stored>;

@compute @workgroup_size(64)
fn correct(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = id.y * groups.x * 64u + id.x;
    if i >= coarse.patches {
        return;
    }
    var change = dark();
    // A patch may belong to none.
    if patches[i].aggregate < coarse.aggregates {
        change = value_of(albedo[i]) * value_of(correction_now[patches[i].aggregate]);
    }
    let b = max(value_of(next[i]) + change, value_of(exitance[i]));
    radiosity[i] = stored(b);
    bounced[i] = stored(max(b - value_of(emitted[i]), dark()));
}
