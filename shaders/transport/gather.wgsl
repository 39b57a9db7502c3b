// What arrives where light is read: out_i = sum_j G_ij source_j, over one page of rows. Receivers:
// irradiance [W/m2]; light probes: nine SH coefficients of radiance each. Sources are in units of radiosity.
#import hohlraum::frame::frame
#import hohlraum::transport::channels::{Stored, stored, of_full}
#import hohlraum::transport::rows::{page, row_by_thread, row_by_group}

@group(2) @binding(1) var<storage, read_write> arrived: array<Stored>;

@compute @workgroup_size(64)
fn gather(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let row = id.y * groups.x * 64u + id.x;
    if row < page.count {
        arrived[page.first + row] = stored(of_full(row_by_thread(row)) * frame.light_unit);
    }
}

@compute @workgroup_size(64)
fn gather_by_group(
    @builtin(workgroup_id) id: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) thread: u32,
) {
    let row = id.y * groups.x + id.x;
    let sum = row_by_group(row, thread);
    if thread == 0u && row < page.count {
        arrived[page.first + row] = stored(of_full(sum) * frame.light_unit);
    }
}
