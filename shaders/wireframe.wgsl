// Edges of meshes over their surfaces.
#import hohlraum::frame::{frame, drawn}
#import hohlraum::scene::mesh::moved

/// As displayed, and opacity.
const COLOR: vec4f = vec4f(0.02, 0.05, 0.12, 0.6);
/// Share of the distance by which edges lie before their own surface.
const NEARER: f32 = 6e-4;

@vertex
fn edge(
    @location(0) position: vec3f,
    @location(9) row_x: vec4f,
    @location(10) row_y: vec4f,
    @location(11) row_z: vec4f,
) -> @builtin(position) vec4f {
    var clip = frame.clip_from_world * vec4f(moved(position, row_x, row_y, row_z), 1.0);
    // Depth is reversed: 1 / distance with perspective, else a share of the whole depth.
    clip.z += select(2e-6, clip.z * NEARER, frame.eye.w > 0.0);
    return clip;
}

@fragment
fn edge_color() -> @location(0) vec4f {
    return vec4f(drawn(COLOR.rgb / frame.exposure), COLOR.a);
}
