//! What costs and may be left out where a scene does not need it; and what the author says to that.

use serde::{Deserialize, Serialize};

/// In the order in which tables tell them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Feature {
    /// Light probes, the tetrahedra between them and their rows: what moves reads them.
    LightProbes,
    /// Cubemaps, their captures and prefilter: smooth surfaces show them.
    Reflections,
    /// Captures again of probes that see only what is static and lit as before.
    Recaptures,
    /// Captures of probes that nothing in view reads.
    UnseenCaptures,
    /// Sky patches and the sky's pass.
    Sky,
    /// A column for each sky patch; a constant sky is one.
    SkyPatches,
    /// Rows for the direction of irradiance: normal maps read them.
    Directional,
    /// Rows and columns of patches that neither reflect nor emit.
    BlackPatches,
    /// Rows of patches that no light can come to: in rooms that no source reaches.
    UnlitPatches,
    /// The matrix at run time: light is solved while the scene plays. Without it it was solved at the bake, one
    /// response a source whose intensity may change and one for all that never does.
    Matrix,
    /// Three channels of light; a grey scene has one.
    Colour,
    /// The coarse correction between products.
    CoarseCorrection,
    /// Columns beside weights; a small matrix that is nearly full has weights alone.
    Columns,
    /// The test for holes at each hit of a ray, and shadow maps that look at alpha.
    Holes,
    /// Shadow maps and what draws into them.
    ShadowMaps,
    /// Pipelines for normal maps, holes, blended and unlit surfaces, each where a material asks for it.
    MaterialVariants,
}

/// What the author says of a feature, whatever its rule finds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Forced {
    In,
    Out,
}

impl Feature {
    pub const ALL: [Self; 16] = [
        Self::LightProbes,
        Self::Reflections,
        Self::Recaptures,
        Self::UnseenCaptures,
        Self::Sky,
        Self::SkyPatches,
        Self::Directional,
        Self::BlackPatches,
        Self::UnlitPatches,
        Self::Matrix,
        Self::Colour,
        Self::CoarseCorrection,
        Self::Columns,
        Self::Holes,
        Self::ShadowMaps,
        Self::MaterialVariants,
    ];

    /// Whether it is needed is known after the bake alone.
    pub fn is_of_bake(self) -> bool {
        matches!(self, Self::BlackPatches | Self::UnlitPatches | Self::CoarseCorrection | Self::Columns)
    }

    /// For people.
    pub fn name(self) -> &'static str {
        match self {
            Self::LightProbes => "light probes",
            Self::Reflections => "reflection cubemaps",
            Self::Recaptures => "captures of what does not change",
            Self::UnseenCaptures => "captures that nothing in view reads",
            Self::Sky => "sky",
            Self::SkyPatches => "a column for each sky patch",
            Self::Directional => "directional rows",
            Self::BlackPatches => "rows and columns of black patches",
            Self::UnlitPatches => "rows of patches without light",
            Self::Matrix => "matrix at run time",
            Self::Colour => "three channels",
            Self::CoarseCorrection => "coarse correction",
            Self::Columns => "columns beside weights",
            Self::Holes => "test for holes",
            Self::ShadowMaps => "shadow maps",
            Self::MaterialVariants => "variants of materials",
        }
    }
}
