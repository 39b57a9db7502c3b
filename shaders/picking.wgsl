// What is seen where, for the hand: surfaces drawn in the number of their entity, or as a mask of those that are marked.
#import hohlraum::frame::frame
#import hohlraum::scene::mesh::moved

struct Object {
    /// Of the entity, from 1.
    number: u32,
}

@group(3) @binding(0) var<uniform> object: Object;

@vertex
fn still(@location(0) position: vec3f) -> @builtin(position) vec4f {
    return frame.clip_from_world * vec4f(position, 1.0);
}

@vertex
fn moving(
    @location(0) position: vec3f,
    @location(9) row_x: vec4f,
    @location(10) row_y: vec4f,
    @location(11) row_z: vec4f,
) -> @builtin(position) vec4f {
    return frame.clip_from_world * vec4f(moved(position, row_x, row_y, row_z), 1.0);
}

@fragment
fn number() -> @location(0) vec4u {
    return vec4u(object.number, 0u, 0u, 0u);
}

@fragment
fn mask() -> @location(0) vec4f {
    return vec4f(1.0);
}
