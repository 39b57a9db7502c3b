// One bounce: next_i = E_i + rho_i * sum_j P_ij B_j, over one page of rows. `measure` takes the largest
// residual |next - B|, the largest B and the largest E: non-negative floats order as their bits do.
#import hohlraum::transport::rows::{page, source, row_by_thread, row_by_group}

@group(2) @binding(1) var<storage, read> exitance: array<vec4f>;
@group(2) @binding(2) var<storage, read> albedo: array<vec4f>;
@group(2) @binding(3) var<storage, read_write> next: array<vec4f>;
@group(2) @binding(4) var<storage, read_write> tally: array<atomic<u32>>;

@compute @workgroup_size(64)
fn bounce(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let row = id.y * groups.x * 64u + id.x;
    if row < page.count {
        reflect_row(page.first + row, row_by_thread(row));
    }
}

@compute @workgroup_size(64)
fn bounce_by_group(
    @builtin(workgroup_id) id: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) thread: u32,
) {
    let row = id.y * groups.x + id.x;
    let sum = row_by_group(row, thread);
    if thread == 0u && row < page.count {
        reflect_row(page.first + row, sum);
    }
}

@compute @workgroup_size(64)
fn measure(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = id.y * groups.x * 64u + id.x;
    if i < page.count {
        let row = page.first + i;
        let residual = abs(next[row].xyz - source[row].xyz);
        atomicMax(&tally[0], bitcast<u32>(max(residual.x, max(residual.y, residual.z))));
        atomicMax(&tally[1], bitcast<u32>(max(next[row].x, max(next[row].y, next[row].z))));
        let own = exitance[row];
        atomicMax(&tally[2], bitcast<u32>(max(own.x, max(own.y, own.z))));
    }
}

fn reflect_row(row: u32, irradiance: vec3f) {
    next[row] = vec4f(exitance[row].xyz + albedo[row].xyz * irradiance, 0.0);
}
