// Cubemaps from captures: smaller levels, levels blurred by roughness, spherical harmonics.
#import hohlraum::transport::sh

struct Prefilter {
    /// Along the face's middle, to its right and to its top.
    forward: vec3f,
    /// Of directions to blur with.
    count: u32,
    right: vec3f,
    up: vec3f,
    /// About +z, unit; w: the level to read.
    samples: array<vec4f, 64>,
}

@group(3) @binding(0) var<uniform> prefilter: Prefilter;
@group(3) @binding(1) var cube: texture_cube<f32>;
@group(3) @binding(2) var cube_sampler: sampler;

struct Point {
    @builtin(position) clip: vec4f,
    @location(0) at: vec2f,
}

@vertex
fn corner(@builtin(vertex_index) index: u32) -> Point {
    let at = vec2f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0);
    return Point(vec4f(at, 0.0, 1.0), at);
}

fn direction(at: vec2f) -> vec3f {
    return prefilter.forward + prefilter.right * at.x + prefilter.up * at.y;
}

/// The next smaller level: what is bound is the level above alone, and between four texels the sampler gives their
/// mean.
@fragment
fn halve(point: Point) -> @location(0) vec4f {
    return textureSampleLevel(cube, cube_sampler, direction(point.at), 0.0);
}

/// The lobe about the mirrored direction, with the view along it: what is lost is the lobe's stretch at grazing
/// angles.
@fragment
fn blur(point: Point) -> @location(0) vec4f {
    let normal = normalize(direction(point.at));
    let up = select(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), abs(normal.y) < 0.9);
    let tangent = normalize(cross(up, normal));
    let bitangent = cross(normal, tangent);
    var sum = vec3f(0.0);
    var weights = 0.0;
    for (var k = 0u; k < prefilter.count; k++) {
        let sample = prefilter.samples[k];
        let way = tangent * sample.x + bitangent * sample.y + normal * sample.z;
        sum += textureSampleLevel(cube, cube_sampler, way, sample.w).rgb * sample.z;
        weights += sample.z;
    }
    return vec4f(sum / weights, 1.0);
}

// ---- spherical harmonics: one workgroup a cubemap

struct Project {
    /// Texels across a face of the level that is bound.
    size: u32,
    /// Into `harmonics`, of its first coefficient.
    first: u32,
    padding: vec2u,
}

@group(3) @binding(0) var<uniform> project_to: Project;
@group(3) @binding(3) var<storage, read_write> harmonics: array<vec4f>;

const GROUP: u32 = 64u;
var<workgroup> parts: array<vec4f, 576>;

@compute @workgroup_size(64)
fn project(@builtin(local_invocation_index) thread: u32) {
    var sums: array<vec4f, 9>;
    let face_texels = project_to.size * project_to.size;
    for (var i = thread; i < 6u * face_texels; i += GROUP) {
        let at = i % face_texels;
        let s = (f32(at % project_to.size) + 0.5) / f32(project_to.size) * 2.0 - 1.0;
        let t = (f32(at / project_to.size) + 0.5) / f32(project_to.size) * 2.0 - 1.0;
        let way = texel_direction(i / face_texels, s, t);
        let solid_angle = pow(dot(way, way), -1.5);
        let radiance = textureSampleLevel(cube, cube_sampler, way, 0.0).rgb;
        let basis = sh::basis(normalize(way));
        for (var k = 0u; k < 9u; k++) {
            sums[k] += vec4f(radiance * (basis[k] * solid_angle), solid_angle);
        }
    }
    for (var k = 0u; k < 9u; k++) {
        parts[thread * 9u + k] = sums[k];
    }
    workgroupBarrier();
    if thread < 9u {
        var sum = vec4f(0.0);
        for (var k = 0u; k < GROUP; k++) {
            sum += parts[k * 9u + thread];
        }
        harmonics[project_to.first + thread] = vec4f(sum.xyz * (12.5663706 / sum.w), 0.0);
    }
}

/// As in engine/src/transport/reflection/cube.rs.
fn texel_direction(face: u32, s: f32, t: f32) -> vec3f {
    switch face {
        case 0u: { return vec3f(1.0, -t, -s); }
        case 1u: { return vec3f(-1.0, -t, s); }
        case 2u: { return vec3f(s, 1.0, t); }
        case 3u: { return vec3f(s, -1.0, -t); }
        case 4u: { return vec3f(s, -t, 1.0); }
        default: { return vec3f(-s, -t, -1.0); }
    }
}
