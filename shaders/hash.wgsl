#define_import_path hohlraum::hash

/// 32 bits (PCG, O'Neill 2014), the same on every GPU.
fn hashed(seed: u32) -> u32 {
    let state = seed * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}
