// Real orthonormal spherical harmonics to order 2: irradiance out of coefficients of radiance (Ramamoorthi and
// Hanrahan 2001), order and signs as in engine/src/transport/sh.rs.
#define_import_path hohlraum::transport::sh

/// Constants: cosine lobe of the band (pi, 2 pi / 3, pi / 4) times the basis function's factor.
fn irradiance(l: array<vec3f, 9>, n: vec3f) -> vec3f {
    var h = l[0] * (3.14159265 * 0.28209479);
    h += (l[1] * n.y + l[2] * n.z + l[3] * n.x) * (2.09439510 * 0.48860251);
    h += (l[4] * (n.x * n.y) + l[5] * (n.y * n.z) + l[7] * (n.x * n.z)) * (0.78539816 * 1.09254843);
    h += l[6] * (0.78539816 * 0.31539157 * (3.0 * n.z * n.z - 1.0));
    h += l[8] * (0.78539816 * 0.54627421 * (n.x * n.x - n.y * n.y));
    return max(h, vec3f(0.0));
}

/// Y_lm of a unit direction.
fn basis(d: vec3f) -> array<f32, 9> {
    return array<f32, 9>(
        0.28209479,
        0.48860251 * d.y,
        0.48860251 * d.z,
        0.48860251 * d.x,
        1.09254843 * d.x * d.y,
        1.09254843 * d.y * d.z,
        0.31539157 * (3.0 * d.z * d.z - 1.0),
        1.09254843 * d.x * d.z,
        0.54627421 * (d.x * d.x - d.y * d.y),
    );
}
