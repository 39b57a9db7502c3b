//! Reflections: what a surface that is not quite rough shows of its surroundings, taken from cubemaps.
//!
//! ```text
//! L_out = L(R, roughness) * (F0 * scale + edge * bias)         split sum (Karis 2013)
//! L     = sum_k w_k L_k(R_k, roughness) + (1 - sum_k w_k) L_sky(R, roughness)
//! ```
//! R is the mirrored view direction; R_k leads from where probe k was captured to where the ray meets the probe's
//! box; L_k is the cubemap blurred with the lobe of the roughness ([`ggx`]); w_k says how much a point reads of
//! probe k ([`influence`]). This is the plain truth that the GPU's passes are tested against.

pub mod cube;
pub mod ggx;
pub mod influence;

pub use cube::Cube;
pub use influence::{Influence, weights};

/// Perceptual roughness up to which cubemaps are read, and from which on spherical harmonics stand in for them.
pub const SHARP: f32 = 0.6;
pub const ROUGH: f32 = 0.75;

/// In captures, a surface mirrors at most this share: light between mirrors that face each other ends.
pub const MOST_IN_CAPTURES: f32 = 0.9;
