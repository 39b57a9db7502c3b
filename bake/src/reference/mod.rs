//! The references that everything fast is measured against: slow, plain, and as unlike it as can be.
//!
//! ```text
//! E(x) = Int L(x, w) cos dw          L(x, w) = L_e(y, -w) + Int f(y, w', -w) L(y, w') cos' dw',   y seen from x along w
//! ```
//! * [`PathTracer`] follows light backwards along paths of any length: E at points, spherical harmonics at points in
//!   space, radiance along rays. It has the bake's triangles and nothing else of it: no patch, no receiver, no row;
//!   materials are looked up where a ray lands. Its answers are right on average, and it says how far off they may be.
//! * [`MatrixReference`] is the radiosity model itself, solved as well as one can: the patches of a bake, a dense f64
//!   matrix from many rays, balanced to rounding and solved to rounding. What it differs by from the path tracer is
//!   what patches cost; what a bake differs by from it is what its rays cost.
//!
//! Every answer is the mean of replicates that share no random number, and its standard error is theirs.

mod closing;
mod finish;
mod ggx;
mod matrix;
mod path;
mod place;
mod replicates;
mod sequence;
mod solve;
mod sources;
mod world;

use glam::DVec3;

pub use matrix::MatrixReference;
pub use path::PathTracer;

/// How surfaces reflect.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Surfaces {
    /// Lambert's law alone, albedo * (1 - metallic), on flat triangles: what radiosity solves.
    #[default]
    Diffuse,
    /// As the player shades: GGX on interpolated and mapped normals, and Lambert for what is not mirrored.
    Shiny,
}

/// Irradiance at a point [W/m2].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measured {
    /// Seen unblocked from emitters, sky and punctual lights.
    pub direct: DVec3,
    /// All that was reflected at least once.
    pub indirect: DVec3,
    /// Of the sum of both, one sigma.
    pub standard_error: DVec3,
}

impl Measured {
    pub fn total(&self) -> DVec3 {
        self.direct + self.indirect
    }
}

/// Nine coefficients of incoming radiance at a point, in the order of [`engine::transport::sh`] [W/m2/sr]. Punctual
/// lights are not seen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeasuredProbe {
    pub coefficients: [DVec3; 9],
    /// One sigma.
    pub standard_error: [DVec3; 9],
}

/// Radiance along a ray [W/m2/sr].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeasuredRadiance {
    pub radiance: DVec3,
    /// One sigma.
    pub standard_error: DVec3,
}
