// One page of sparse rows times a vector: sum over a row of weight * source[column].
#define_import_path hohlraum::transport::rows

struct Page {
    /// Of this page's first row among all rows.
    first: u32,
    /// Rows of this page.
    count: u32,
    padding: vec2u,
}

/// Radiosity [W/m2] by column: patches, then sky patches.
@group(2) @binding(0) var<storage, read> source: array<vec4f>;

@group(3) @binding(0) var<uniform> page: Page;
/// Into columns and weights; one more than rows.
@group(3) @binding(1) var<storage, read> starts: array<u32>;
@group(3) @binding(2) var<storage, read> columns: array<u32>;
@group(3) @binding(3) var<storage, read> weights: array<f32>;

/// A thread a row: best where threads are few (a processor that draws).
fn row_by_thread(row: u32) -> vec3f {
    var sum = vec3f(0.0);
    let end = starts[row + 1u];
    for (var i = starts[row]; i < end; i++) {
        sum += weights[i] * source[columns[i]].xyz;
    }
    return sum;
}

var<workgroup> parts: array<vec3f, 64>;

/// A workgroup a row: best where threads are many. Every thread of the group calls it; thread 0 gets the sum.
fn row_by_group(row: u32, thread: u32) -> vec3f {
    var sum = vec3f(0.0);
    if row < page.count {
        let end = starts[row + 1u];
        for (var i = starts[row] + thread; i < end; i += 64u) {
            sum += weights[i] * source[columns[i]].xyz;
        }
    }
    parts[thread] = sum;
    for (var half = 32u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if thread < half {
            parts[thread] += parts[thread + half];
        }
    }
    return parts[0];
}
