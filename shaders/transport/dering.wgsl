// Windows the coefficients of light probes so that their irradiance is nowhere negative: what
// engine/src/transport/dering.rs says, one thread a probe.
#import hohlraum::transport::channels::{Stored, value_of, stored, in_full, of_full}

@group(2) @binding(0) var<storage, read_write> probes: array<Stored>;

const PI: f32 = 3.14159265;
const STEPS: u32 = 24u;
const MARGIN: f32 = 1e-6;

@compute @workgroup_size(64)
fn dering(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let first = (id.y * groups.x * 64u + id.x) * 9u;
    if first + 9u > arrayLength(&probes) {
        return;
    }
    var l: array<vec3f, 9>;
    for (var k = 0u; k < 9u; k++) {
        l[k] = in_full(value_of(probes[first + k]));
    }
    let red = window(channel(l, 0u));
#ifdef GREY
    let green = red;
    let blue = red;
#else
    let green = window(channel(l, 1u));
    let blue = window(channel(l, 2u));
#endif
    let one = vec3f(red.x, green.x, blue.x);
    let two = vec3f(red.y, green.y, blue.y);
    for (var k = 1u; k < 9u; k++) {
        probes[first + k] = stored(of_full(l[k] * select(two, one, k < 4u)));
    }
}

fn channel(l: array<vec3f, 9>, which: u32) -> array<f32, 9> {
    var one: array<f32, 9>;
    for (var k = 0u; k < 9u; k++) {
        one[k] = l[k][which];
    }
    return one;
}

/// E(n) = 1 + b.n + Sum q_i n_i^2 in the axes of its matrix, as shares of the mean.
struct Form {
    b: vec3f,
    q: vec3f,
}

/// What is left of bands 1 and 2.
fn window(l: array<f32, 9>) -> vec2f {
    if l[0] <= 0.0 {
        return vec2f(0.0);
    }
    let form = form_of(l);
    if least(form, vec2f(1.0)) >= MARGIN {
        return vec2f(1.0);
    }
    var low = 0.0;
    var high = 1.0;
    for (var step = 0u; step < STEPS; step++) {
        let middle = 0.5 * (low + high);
        if least(form, kept(middle)) >= MARGIN {
            low = middle;
        } else {
            high = middle;
        }
    }
    return kept(low);
}

/// By w = 1 / (1 + lambda).
fn kept(w: f32) -> vec2f {
    return vec2f(w / (w + 4.0 * (1.0 - w)), w / (w + 36.0 * (1.0 - w)));
}

fn least(form: Form, shares: vec2f) -> f32 {
    let lowest = min(form.q.x, min(form.q.y, form.q.z));
    let above = shares.y * (form.q - lowest);
    let half_pull = 0.5 * shares.x * form.b;
    let pull = half_pull * half_pull;
    var low = 0.0;
    var high = sqrt(pull.x + pull.y + pull.z);
    if high <= 0.0 {
        return 1.0 + shares.y * lowest;
    }
    for (var step = 0u; step < STEPS; step++) {
        let middle = 0.5 * (low + high);
        let gap = above + middle;
        if dot(pull / (gap * gap), vec3f(1.0)) > 1.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    return 1.0 + shares.y * lowest - high - dot(pull / (above + high), vec3f(1.0));
}

fn form_of(l: array<f32, 9>) -> Form {
    let mean = PI * 0.28209479 * l[0];
    let band_1 = 2.09439510 * 0.48860251 / mean;
    let mixed = 0.78539816 * 0.54627421 / mean;
    let axial = 0.78539816 * 0.31539157 * l[6] / mean;
    var b = vec3f(l[3], l[1], l[2]) * band_1;
    var q = vec3f(l[8] * mixed - axial, -l[8] * mixed - axial, 2.0 * axial);
    // xy, xz, yz
    var off = vec3f(l[4], l[7], l[5]) * mixed;
    for (var sweep = 0u; sweep < 5u; sweep++) {
        var turn = rotation(q.x, q.y, off.x);
        q = vec3f(q.x - turn.z, q.y + turn.z, q.z);
        off = vec3f(0.0, turn.x * off.y - turn.y * off.z, turn.y * off.y + turn.x * off.z);
        b = vec3f(turn.x * b.x - turn.y * b.y, turn.y * b.x + turn.x * b.y, b.z);
        turn = rotation(q.x, q.z, off.y);
        q = vec3f(q.x - turn.z, q.y, q.z + turn.z);
        off = vec3f(turn.x * off.x - turn.y * off.z, 0.0, turn.y * off.x + turn.x * off.z);
        b = vec3f(turn.x * b.x - turn.y * b.z, b.y, turn.y * b.x + turn.x * b.z);
        turn = rotation(q.y, q.z, off.z);
        q = vec3f(q.x, q.y - turn.z, q.z + turn.z);
        off = vec3f(turn.x * off.x - turn.y * off.y, turn.y * off.x + turn.x * off.y, 0.0);
        b = vec3f(b.x, turn.x * b.y - turn.y * b.z, turn.y * b.y + turn.x * b.z);
    }
    return Form(b, q);
}

/// Cosine and sine of Jacobi's rotation, and what the diagonal takes on.
fn rotation(p: f32, q: f32, off: f32) -> vec3f {
    if abs(off) < 1e-9 {
        return vec3f(1.0, 0.0, 0.0);
    }
    let ratio = (q - p) / (2.0 * off);
    let t = select(1.0, -1.0, ratio < 0.0) / (abs(ratio) + sqrt(ratio * ratio + 1.0));
    let c = 1.0 / sqrt(t * t + 1.0);
    return vec3f(c, t * c, t * off);
}
