// One page of sparse rows times a vector: sum over a row of weight * source[column].
#define_import_path hohlraum::transport::rows

struct Page {
    /// Of this page's first row among all rows.
    first: u32,
    /// Rows of this page.
    count: u32,
    /// 1 where columns hold weights too.
    packed: u32,
    padding: u32,
}

/// Radiosity [W/m2] by column: patches, then sky patches.
@group(2) @binding(0) var<storage, read> source: array<vec4f>;

@group(3) @binding(0) var<uniform> page: Page;
/// Into columns and weights; one more than rows.
@group(3) @binding(1) var<storage, read> starts: array<u32>;
@group(3) @binding(2) var<storage, read> columns: array<u32>;
@group(3) @binding(3) var<storage, read> weights: array<f32>;

/// weight * source[column] of an entry. Packed: the f16 of 2^15 times the weight, above the column.
fn weighted(entry: u32) -> vec3f {
    let column = columns[entry];
    if page.packed != 0u {
        return weight_of(column >> 16u) * source[column & 0xffffu].xyz;
    }
    return weights[entry] * source[column].xyz;
}

/// By its bits: not every device unpacks f16, or keeps what is too small for its exponent.
fn weight_of(half: u32) -> f32 {
    let bits = half & 0x7fffu;
    let normal = bitcast<f32>((bits << 13u) + (97u << 23u));
    let size = select(normal, f32(bits) * 0x1p-39f, bits < 0x400u);
    return select(size, -size, half > 0x7fffu);
}

/// A thread a row: best where threads are few (a processor that draws).
fn row_by_thread(row: u32) -> vec3f {
    var sum = vec3f(0.0);
    let end = starts[row + 1u];
    for (var i = starts[row]; i < end; i++) {
        sum += weighted(i);
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
            sum += weighted(i);
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
