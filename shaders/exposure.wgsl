// Meters a picture: how bright it is, and how it is to be exposed. `count` sorts texels by log2 luminance,
// `adapt` takes the mean of what lies between the 50th and the 95th hundredth of them, makes it middle grey, and
// goes part of the way there from the last exposure. Texels without any light are not counted.
#import hohlraum::frame::frame

struct Meter {
    size: vec2u,
    step: u32,
    kept: f32,
    compensation: f32,
    least: f32,
    most: f32,
    padding: u32,
}

struct Exposure {
    stops: f32,
    exposure: f32,
    pre_exposure: f32,
    padding: u32,
}

@group(3) @binding(0) var<uniform> meter: Meter;
@group(3) @binding(1) var<storage, read_write> bins: array<atomic<u32>, 256>;
@group(3) @binding(2) var<storage, read_write> state: Exposure;
@group(3) @binding(3) var radiance: texture_2d<f32>;
@group(3) @binding(3) var radiance_samples: texture_multisampled_2d<f32>;

const A_THREAD: u32 = 16u;
/// Half floats hold luminance between 2^-24 and 2^16.
const DARKEST: f32 = -24.0;
const BINS_A_STOP: f32 = 6.4;
const MIDDLE_GREY: f32 = 0.18;
const DARK: f32 = 0.5;
const BRIGHT: f32 = 0.95;

var<workgroup> counted: array<atomic<u32>, 256>;

@compute @workgroup_size(64)
fn count(
    @builtin(workgroup_id) id: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) thread: u32,
) {
    let first = (id.y * groups.x + id.x) * 64u + thread;
    for (var k = 0u; k < A_THREAD; k++) {
        let at = texel(first, k, groups);
        if at.x >= 0 {
            add(textureLoad(radiance, at, 0).rgb);
        }
    }
    hand_over(thread);
}

/// Of a pixel's samples, the first.
@compute @workgroup_size(64)
fn count_samples(
    @builtin(workgroup_id) id: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) thread: u32,
) {
    let first = (id.y * groups.x + id.x) * 64u + thread;
    for (var k = 0u; k < A_THREAD; k++) {
        let at = texel(first, k, groups);
        if at.x >= 0 {
            add(textureLoad(radiance_samples, at, 0).rgb);
        }
    }
    hand_over(thread);
}

/// The k-th texel of a thread; negative where there is none.
fn texel(first: u32, k: u32, groups: vec3u) -> vec2i {
    let columns = (meter.size.x + meter.step - 1u) / meter.step;
    let index = first + k * groups.x * groups.y * 64u;
    let at = vec2u(index % columns, index / columns) * meter.step;
    return select(vec2i(-1), vec2i(at), at.y < meter.size.y);
}

fn add(light: vec3f) {
    let luminance = dot(light, vec3f(0.2126, 0.7152, 0.0722));
    if luminance > 0.0 {
        let bin = (log2(luminance) - DARKEST) * BINS_A_STOP;
        atomicAdd(&counted[u32(clamp(bin, 0.0, 255.0))], 1u);
    }
}

fn hand_over(thread: u32) {
    workgroupBarrier();
    for (var bin = thread; bin < 256u; bin += 64u) {
        let here = atomicLoad(&counted[bin]);
        if here > 0u {
            atomicAdd(&bins[bin], here);
        }
    }
}

@compute @workgroup_size(64)
fn adapt(@builtin(local_invocation_index) thread: u32) {
    if thread > 0u {
        return;
    }
    var all = 0u;
    for (var bin = 0u; bin < 256u; bin++) {
        all += atomicLoad(&bins[bin]);
    }
    let low = DARK * f32(all);
    let high = BRIGHT * f32(all);
    var below = 0.0;
    var sum = 0.0;
    var weight = 0.0;
    for (var bin = 0u; bin < 256u; bin++) {
        let here = f32(atomicExchange(&bins[bin], 0u));
        // How many of the bin lie between the two marks.
        let between = max(min(below + here, high) - max(below, low), 0.0);
        sum += between * (DARKEST + (f32(bin) + 0.5) / BINS_A_STOP);
        weight += between;
        below += here;
    }
    if weight > 0.0 {
        let luminance = sum / weight - log2(frame.pre_exposure);
        let wanted = clamp(log2(MIDDLE_GREY) - luminance + meter.compensation, meter.least, meter.most);
        state.stops = wanted + (state.stops - wanted) * meter.kept;
    }
    state.exposure = exp2(state.stops);
    state.pre_exposure = exp2(round(state.stops));
}
