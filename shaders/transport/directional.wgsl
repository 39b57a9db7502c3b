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
    let tilts = terms * aside;
    let across = terms * normal;
    let hidden = 0.5 * (1.0 - cosine);
    let linear = irradiance
        + tilts * (1.0 - angle / PI)
        + across * (1.0 - cosine - 2.0 / PI * (sine - angle * cosine));
    let least = max(irradiance * (1.0 - hidden) + tilts, irradiance * hidden);
    // A narrow cone of light is nearer to the least.
    let squared = terms[0] * terms[0] + terms[1] * terms[1] + terms[2] * terms[2];
    let vector = sqrt(max(squared - across * across + irradiance * irradiance, vec3f(0.0)));
    let everywhere = max(2.0 * irradiance + across, vec3f(1e-30));
    let share = saturate(3.0 - 3.0 * vector / everywhere);
    return least + share * max(linear - least, vec3f(0.0));
}
