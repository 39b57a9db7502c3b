// One page of rows times a vector: sum over a row of weight * source[column]. Rows are sparse; where DENSE is defined,
// they have the weights of all columns instead.
#define_import_path hohlraum::transport::rows

struct Page {
    /// Of this page's first row among all rows.
    first: u32,
    /// Rows of this page.
    count: u32,
    /// 1 where weights are halves: above their columns, or two by two.
    packed: u32,
    /// Columns of the matrix.
    width: u32,
}

/// Radiosity [W/m2] by column: patches, then sky patches.
@group(2) @binding(0) var<storage, read> source: array<vec4f>;

@group(3) @binding(0) var<uniform> page: Page;
/// Into columns and weights; one more than rows.
@group(3) @binding(1) var<storage, read> starts: array<u32>;
@group(3) @binding(2) var<storage, read> columns: array<u32>;
@group(3) @binding(3) var<storage, read> weights: array<f32>;

/// Entries of a row, in `columns` and `weights`.
struct Entries {
    first: u32,
    end: u32,
}

#ifdef DENSE
fn entries_of(row: u32) -> Entries {
    let stride = select(page.width, (page.width + 1u) / 2u, page.packed != 0u);
    return Entries(row * stride, row * stride + stride);
}

/// weight * source[column] of an entry of a row that begins at `first`, or of two that share four bytes.
fn weighted(entry: u32, first: u32) -> vec3f {
    let at = entry - first;
    if page.packed == 0u {
        return weights[entry] * source[at].xyz;
    }
    let both = columns[entry];
    var sum = weight_of(both & 0xffffu) * source[2u * at].xyz;
    if 2u * at + 1u < page.width {
        sum += weight_of(both >> 16u) * source[2u * at + 1u].xyz;
    }
    return sum;
}
#else
fn entries_of(row: u32) -> Entries {
    return Entries(starts[row], starts[row + 1u]);
}

/// weight * source[column] of an entry. Packed: the f16 of 2^15 times the weight, above the column.
fn weighted(entry: u32, first: u32) -> vec3f {
    let column = columns[entry];
    if page.packed != 0u {
        return weight_of(column >> 16u) * source[column & 0xffffu].xyz;
    }
    return weights[entry] * source[column].xyz;
}
#endif

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
    let row_entries = entries_of(row);
    for (var i = row_entries.first; i < row_entries.end; i++) {
        sum += weighted(i, row_entries.first);
    }
    return sum;
}

var<workgroup> parts: array<vec3f, 64>;

/// A workgroup a row: best where threads are many. Every thread of the group calls it; thread 0 gets the sum.
fn row_by_group(row: u32, thread: u32) -> vec3f {
    var sum = vec3f(0.0);
    if row < page.count {
        let row_entries = entries_of(row);
        for (var i = row_entries.first + thread; i < row_entries.end; i += 64u) {
            sum += weighted(i, row_entries.first);
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
