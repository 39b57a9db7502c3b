// Light probes as small white spheres in the light that each of them knows; those inside solids in plain red.
#import hohlraum::frame::{frame, drawn}
#import hohlraum::transport::channels::{Stored, value_of, in_full}
#import hohlraum::transport::sh

@group(2) @binding(0) var<storage, read> probes_direct: array<Stored>;
@group(2) @binding(1) var<storage, read> probes_indirect: array<Stored>;

struct Point {
    @builtin(position) clip: vec4f,
    @location(0) radiance: vec3f,
}

/// A corner of a sphere one metre across, its place and radius, and which probe it is; 1 where it is valid.
@vertex
fn sphere(
    @location(0) corner: vec3f,
    @location(1) place: vec4f,
    @location(2) probe: vec2u,
) -> Point {
    let normal = normalize(corner);
    var light: array<vec3f, 9>;
    for (var k = 0u; k < 9u; k++) {
        let at = probe.x * 9u + k;
        light[k] = in_full(value_of(probes_direct[at]) + value_of(probes_indirect[at]));
    }
    let lit = sh::irradiance(light, normal) / 3.14159265;
    var point = Point(frame.clip_from_world * vec4f(place.xyz + normal * place.w, 1.0), lit);
    if probe.y == 0u {
        point.radiance = vec3f(1.0, 0.02, 0.02) / frame.exposure;
        point.clip.z = point.clip.w; // in front of the solid that it is in
    }
    return point;
}

@fragment
fn glow(point: Point) -> @location(0) vec4f {
    return vec4f(drawn(point.radiance), 1.0);
}
