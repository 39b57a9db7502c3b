// What a light sends into a triangle, exactly: equations and proof in engine/src/transport/solid_angle.rs, the twin.
#define_import_path hohlraum::transport::solid_angle

const TAU: f32 = 6.28318531;
/// Circles over the full part of a cone, and over the part that fades.
const FULL: u32 = 32u;
const FADING: u32 = 24u;

/// Signed solid angle of a triangle seen from the origin (Van Oosterom and Strackee 1983); negative when its corners
/// run counter-clockwise as seen from there.
fn solid_angle(a: vec3f, b: vec3f, c: vec3f) -> f32 {
    let la = length(a);
    let lb = length(b);
    let lc = length(c);
    let numerator = dot(a, cross(b - a, c - a));
    let denominator = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
    return 2.0 * angle(numerator, denominator);
}

/// Int over a triangle's directions of saturate(cone.x * cos + cone.y)^2, cos to the unit `axis`, seen from the
/// origin [sr]. The corners run clockwise as seen from there; the cone is narrower than a half space.
fn cone_in_triangle(a: vec3f, b: vec3f, c: vec3f, axis: vec3f, cone: vec2f) -> f32 {
    // Beside the axis by what nobody sees: no edge and no corner lies on it, as they do in scenes on a grid.
    let side = select(1.0, -1.0, axis.z < 0.0);
    let p = -1.0 / (side + axis.z);
    let q = axis.x * axis.y * p;
    let beside = vec3f(1.0 + side * axis.x * axis.x * p, side * q, -side * axis.x);
    let beyond = vec3f(q, side + axis.y * axis.y * p, -axis.y);
    let z = normalize(axis + beside * 1.1e-5 + beyond * 0.7e-5);
    let x = normalize(beside - z * dot(z, beside));
    let frame = mat3x3f(x, cross(z, x), z);
    let edges = array<Edge, 3>(edge_of(a * frame, b * frame), edge_of(b * frame, c * frame), edge_of(c * frame, a * frame));
    let inside = edges[0].turn > 0.0 && edges[1].turn > 0.0 && edges[2].turn > 0.0;
    let full = select(0.0, TAU, inside);
    let outer = clamp(-cone.y / cone.x, 0.0, 1.0);
    let inner = clamp((1.0 - cone.y) / cone.x, outer, 1.0);
    var flux = 0.0;
    for (var k = 0u; k < FULL; k++) {
        let mu = inner + (1.0 - inner) * (f32(k) + 0.5) / f32(FULL);
        let swept = swept_within(edges[0], mu) + swept_within(edges[1], mu) + swept_within(edges[2], mu);
        flux += (full - swept) * (1.0 - inner) / f32(FULL);
    }
    for (var k = 0u; k < FADING; k++) {
        let low = f32(k) / f32(FADING);
        let high = f32(k + 1u) / f32(FADING);
        let squares = (high * high * high - low * low * low) / 3.0;
        let mu = outer + (inner - outer) * 0.5 * (low + high);
        let swept = swept_within(edges[0], mu) + swept_within(edges[1], mu) + swept_within(edges[2], mu);
        flux += (full - swept) * squares * (inner - outer);
    }
    return max(flux, 0.0);
}

/// A side of a triangle on the sphere, in a frame whose z is the cone's axis: start * cos t + beside * sin t.
struct Edge {
    start: vec3f,
    beside: vec3f,
    /// Radians from its start to its end.
    extent: f32,
    /// Which way the azimuth goes along it: 1 or -1.
    turn: f32,
}

fn edge_of(a: vec3f, b: vec3f) -> Edge {
    let start = a / max(length(a), 1e-30);
    let normal = cross(start, b);
    let beside = cross(normal, start);
    let extent = angle(length(normal), dot(start, b));
    return Edge(start, beside / max(length(beside), 1e-30), extent, select(-1.0, 1.0, normal.z >= 0.0));
}

/// Of the azimuth, where the edge is nearer to the axis than acos(mu).
fn swept_within(edge: Edge, mu: f32) -> f32 {
    let highest = length(vec2f(edge.start.z, edge.beside.z));
    if mu >= highest {
        return 0.0;
    }
    let half = angle(sqrt(max(highest * highest - mu * mu, 0.0)), mu);
    let up = angle(edge.beside.z, edge.start.z);
    let middle = up - TAU * floor((up - 0.5 * edge.extent) / TAU + 0.5);
    let first = max(middle - half, 0.0);
    let last = min(middle + half, edge.extent);
    if first >= last {
        return 0.0;
    }
    let p = (edge.start * cos(first) + edge.beside * sin(first)).xy;
    let q = (edge.start * cos(last) + edge.beside * sin(last)).xy;
    return edge.turn * angle(abs(p.x * q.y - p.y * q.x), dot(p, q));
}

/// The angle whose sine and cosine are to each other as these: exact to 3e-7, which `atan2` need not be. (Cephes'
/// polynomial, Moshier 1989.)
fn angle(sine: f32, cosine: f32) -> f32 {
    let high = max(abs(sine), abs(cosine));
    if high == 0.0 {
        return 0.0;
    }
    var t = min(abs(sine), abs(cosine)) / high;
    var turned = 0.0;
    if t > 0.41421356 {
        t = (t - 1.0) / (t + 1.0);
        turned = 0.78539816;
    }
    let s = t * t;
    var phi = turned + t + t * s * (((8.05374449538e-2 * s - 1.38776856032e-1) * s + 1.99777106478e-1) * s - 3.33329491539e-1);
    if abs(sine) > abs(cosine) {
        phi = 1.57079633 - phi;
    }
    if cosine < 0.0 {
        phi = 3.14159265 - phi;
    }
    return select(phi, -phi, sine < 0.0);
}
