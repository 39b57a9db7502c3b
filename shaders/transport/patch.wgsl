// Patches and the points at which they sample direct light.
#define_import_path hohlraum::transport::patch

struct Patch {
    centre: vec3f,
    area: f32,
    normal: vec3f,
    batch: u32,
    first_triangle: u32,
    triangle_count: u32,
    first_sample: u32,
    sample_count: u32,
    back: u32,
    component: u32,
    aggregate: u32,
    padding: u32,
}

struct Sample {
    position: vec3f,
    owner: u32,
    normal: vec3f,
    padding: u32,
}
