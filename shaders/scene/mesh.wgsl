// Vertices of static surfaces and of meshes that move.
#define_import_path hohlraum::scene::mesh

/// As baked, relative to the transport's origin.
struct Still {
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) tangent: vec4f,
    @location(3) uv: vec4f,
    @location(4) color: vec4f,
    /// Up to four receivers, for the front and for the back side.
    @location(5) receivers: vec4u,
    @location(6) weights: vec4f,
    @location(7) back_receivers: vec4u,
    @location(8) back_weights: vec4f,
}

/// In its own space; the instance says where that is.
struct Moving {
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) tangent: vec4f,
    @location(3) uv: vec4f,
    @location(4) color: vec4f,
    /// Rows of world_from_local.
    @location(9) row_x: vec4f,
    @location(10) row_y: vec4f,
    @location(11) row_z: vec4f,
    /// Which object it is, to find its light; 1 where the transform mirrors.
    @location(12) light: vec2u,
}

fn moved(position: vec3f, row_x: vec4f, row_y: vec4f, row_z: vec4f) -> vec3f {
    let p = vec4f(position, 1.0);
    return vec3f(dot(row_x, p), dot(row_y, p), dot(row_z, p));
}

/// Normals go by the cofactors of the matrix, which exist for flat scales too.
fn moved_normal(normal: vec3f, row_x: vec3f, row_y: vec3f, row_z: vec3f, mirrored: u32) -> vec3f {
    let n = vec3f(
        dot(cross(row_y, row_z), normal),
        dot(cross(row_z, row_x), normal),
        dot(cross(row_x, row_y), normal),
    );
    return normalize(select(n, -n, mirrored == 1u));
}

fn moved_tangent(tangent: vec3f, row_x: vec3f, row_y: vec3f, row_z: vec3f) -> vec3f {
    return vec3f(dot(row_x, tangent), dot(row_y, tangent), dot(row_z, tangent));
}
