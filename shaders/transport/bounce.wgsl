// One bounce: next_i = E_i + rho_i * sum_j P_ij B_j, over one page of rows. `measure` takes the largest
// residual |next - B|, the largest B and the largest E: non-negative floats order as their bits do.
#import hohlraum::transport::channels::{Stored, value_of, stored, largest, of_full}
#import hohlraum::transport::rows::{page, source, row_by_thread, row_by_group}

@group(2) @binding(1) var<storage, read> exitance: array<Stored>;
@group(2) @binding(2) var<storage, read> albedo: array<Stored>;
@group(2) @binding(3) var<storage, read_write> next: array<Stored>;
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
        let after = value_of(next[row]);
        let residual = abs(after - value_of(source[row]));
        atomicMax(&tally[0], bitcast<u32>(largest(residual)));
        atomicMax(&tally[1], bitcast<u32>(largest(after)));
        atomicMax(&tally[2], bitcast<u32>(largest(value_of(exitance[row]))));
    }
}

fn reflect_row(row: u32, irradiance: vec3f) {
    next[row] = stored(value_of(exitance[row]) + value_of(albedo[row]) * of_full(irradiance));
}
