// Directional terms: irradiance for a normal that a map tilts (engine/src/transport/directional.rs has the formula and
// where it comes from).
#define_import_path hohlraum::transport::directional

const PI: f32 = 3.14159265;

/// From irradiance for `normal` and its terms along x, y and z: irradiance for `mapped` [W/m2].
fn tilted(irradiance: vec3f, terms: mat3x3f, normal: vec3f, mapped: vec3f) -> vec3f {
    let cosine = clamp(dot(normal, mapped), -1.0, 1.0);
    let aside = mapped - normal * cosine;
    let sine = length(aside);
    let angle = atan2(sine, cosine);
    let along = terms * aside;
    let across = terms * normal;
    let hidden = 0.5 * (1.0 - cosine);
    let linear = along * (1.0 - angle / PI)
        + across * (1.0 - cosine - 2.0 / PI * (sine - angle * cosine));
    let least = max(irradiance * (1.0 - hidden) + along, irradiance * hidden);
    return max(irradiance + linear, least);
}
