// The light of moving objects: nine coefficients each, blended of up to four light probes. One thread a coefficient.
#import hohlraum::transport::channels::{Stored, value_of, stored, dark}

/// Shares of light probes; they sum to 1.
struct Weights {
    probes: vec4u,
    weights: vec4f,
}

@group(2) @binding(0) var<storage, read> probes_direct: array<Stored>;
@group(2) @binding(1) var<storage, read> probes_indirect: array<Stored>;
@group(2) @binding(2) var<storage, read> objects: array<Weights>;
@group(2) @binding(3) var<storage, read_write> objects_direct: array<Stored>;
@group(2) @binding(4) var<storage, read_write> objects_indirect: array<Stored>;

@compute @workgroup_size(64)
fn objects_light(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = id.y * groups.x * 64u + id.x;
    if i >= arrayLength(&objects_direct) || i / 9u >= arrayLength(&objects) {
        return;
    }
    let blend = objects[i / 9u];
    var direct = dark();
    var indirect = dark();
    for (var k = 0u; k < 4u; k++) {
        let at = blend.probes[k] * 9u + i % 9u;
        direct += blend.weights[k] * value_of(probes_direct[at]);
        indirect += blend.weights[k] * value_of(probes_indirect[at]);
    }
    objects_direct[i] = stored(direct);
    objects_indirect[i] = stored(indirect);
}
