// Radiosity is stored in a unit of 2^k W/m2. When k changes, what is stored is multiplied by a power of two: not a digit
// is lost. One thread a column.
#import hohlraum::transport::channels::Stored

struct Rescale {
    columns: u32,
    /// Old unit / new unit.
    factor: f32,
    padding: vec2u,
}

@group(2) @binding(0) var<storage, read_write> radiosity: array<Stored>;
@group(3) @binding(0) var<uniform> change: Rescale;

@compute @workgroup_size(64)
fn rescale(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = id.y * groups.x * 64u + id.x;
    if i < change.columns {
        radiosity[i].light *= change.factor;
    }
}
