// Light for moving objects where no probe is: the mean irradiance of all valid receivers, written behind the
// probes as one more probe that gives this irradiance from everywhere. One workgroup.
#import hohlraum::transport::channels::{Stored, value_of, stored, in_full, of_full}

struct Mean {
    receivers: u32,
    /// 1 / valid receivers.
    share: f32,
    /// The first coefficient of the probe to write.
    probe: u32,
    padding: u32,
}

@group(2) @binding(0) var<storage, read> arrived: array<Stored>;
@group(2) @binding(1) var<storage, read_write> probes: array<Stored>;
@group(3) @binding(0) var<uniform> whole: Mean;

var<workgroup> parts: array<vec3f, 64>;

@compute @workgroup_size(64)
fn mean(@builtin(local_invocation_index) thread: u32) {
    var sum = vec3f(0.0);
    for (var i = thread; i < whole.receivers; i += 64u) {
        sum += in_full(value_of(arrived[i]));
    }
    parts[thread] = sum;
    workgroupBarrier();
    if thread == 0u {
        var total = vec3f(0.0);
        for (var i = 0u; i < 64u; i++) {
            total += parts[i];
        }
        // H = pi * L00 * Y00 for light that is the same from everywhere; the other eight stay 0.
        probes[whole.probe] = stored(of_full(total) * whole.share / (3.14159265 * 0.28209479));
    }
}
