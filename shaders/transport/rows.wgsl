// One page of rows times a vector: sum over a row of weight * source[column]. Rows are sparse; where DENSE is defined,
// they have the weights of all columns instead.
#define_import_path hohlraum::transport::rows
#import hohlraum::transport::channels::{Stored, value_of, dark, in_full}

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
@group(2) @binding(0) var<storage, read> source: array<Stored>;

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
#else
fn entries_of(row: u32) -> Entries {
    return Entries(starts[row], starts[row + 1u]);
}
#endif

/// By its bits: not every device unpacks f16, or keeps what is too small for its exponent.
fn weight_of(half: u32) -> f32 {
    let bits = half & 0x7fffu;
    let normal = bitcast<f32>((bits << 13u) + (97u << 23u));
    let size = select(normal, f32(bits) * 0x1p-39f, bits < 0x400u);
    return select(size, -size, half > 0x7fffu);
}

/// Of every `step`th entry of a row: weight * source[column]. Packed: the f16 of 2^15 times the weight, above the column,
/// or above that of the column before.
fn part_of_row(row: u32, start: u32, step: u32) -> vec3f {
    let row_entries = entries_of(row);
    var sum = dark();
    for (var i = row_entries.first + start; i < row_entries.end; i += step) {
#ifdef DENSE
        let at = i - row_entries.first;
        if page.packed == 0u {
            sum += weights[i] * value_of(source[at]);
            continue;
        }
        let both = columns[i];
        var two = weight_of(both & 0xffffu) * value_of(source[2u * at]);
        if 2u * at + 1u < page.width {
            two += weight_of(both >> 16u) * value_of(source[2u * at + 1u]);
        }
        sum += two;
#else
        let column = columns[i];
        if page.packed == 0u {
            sum += weights[i] * value_of(source[column]);
            continue;
        }
        sum += weight_of(column >> 16u) * value_of(source[column & 0xffffu]);
#endif
    }
    return in_full(sum);
}

/// A thread a row: best where threads are few (a processor that draws).
fn row_by_thread(row: u32) -> vec3f {
    return part_of_row(row, 0u, 1u);
}

var<workgroup> parts: array<vec3f, 64>;

/// A workgroup a row: best where threads are many. Every thread of the group calls it; thread 0 gets the sum.
fn row_by_group(row: u32, thread: u32) -> vec3f {
    var sum = vec3f(0.0);
    if row < page.count {
        sum = part_of_row(row, thread, 64u);
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
