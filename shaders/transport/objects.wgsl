// The light of moving objects: nine coefficients each, blended of up to four light probes. One thread a coefficient.

/// Shares of light probes; they sum to 1.
struct Weights {
    probes: vec4u,
    weights: vec4f,
}

@group(2) @binding(0) var<storage, read> probes_direct: array<vec4f>;
@group(2) @binding(1) var<storage, read> probes_indirect: array<vec4f>;
@group(2) @binding(2) var<storage, read> objects: array<Weights>;
@group(2) @binding(3) var<storage, read_write> objects_direct: array<vec4f>;
@group(2) @binding(4) var<storage, read_write> objects_indirect: array<vec4f>;

@compute @workgroup_size(64)
fn objects_light(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = id.y * groups.x * 64u + id.x;
    if i >= arrayLength(&objects_direct) || i / 9u >= arrayLength(&objects) {
        return;
    }
    let blend = objects[i / 9u];
    var direct = vec3f(0.0);
    var indirect = vec3f(0.0);
    for (var k = 0u; k < 4u; k++) {
        let at = blend.probes[k] * 9u + i % 9u;
        direct += blend.weights[k] * probes_direct[at].xyz;
        indirect += blend.weights[k] * probes_indirect[at].xyz;
    }
    objects_direct[i] = vec4f(direct, 0.0);
    objects_indirect[i] = vec4f(indirect, 0.0);
}
