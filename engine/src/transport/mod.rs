//! How light moves between the static surfaces of a scene: plain data that the baker writes, and the CPU
//! solver that is the truth for the GPU.
//!
//! Light lives on *spaces* (patches with the sky's patches behind them, receivers, probes) and moves by
//! *rows*:
//! ```text
//! B = E + rho * (P B)     patch_from_patch       radiosity leaving patches [W/m2]
//! H = G B                 receiver_from_patch    irradiance arriving at receivers [W/m2]
//! L = Q B                 probe_from_patch       SH coefficients of incoming radiance [W/m2/sr]
//! V = D B                 directional_from_patch what tilts H towards a normal map's normals [W/m2]
//! ```
//! with E_i = M_i + rho_i H_dir,i: M the emitted exitance, H_dir the irradiance from punctual lights, rho the
//! albedo. P_ij is the share of light from patch i's surface that arrives at patch j,
//! ```text
//! P_ij = 1/A_i  Int_Ai Int_Aj  V cos+ cos+ / (pi r^2)  dA_j dA_i
//! ```
//! with both cosines clamped to >= 0, no minus sign, the unknown B under the sum, and the 1/pi that makes
//! every row of a closed scene sum to 1. The diagonal stays: a cluster patch sees itself.
//!
//! Everything here is geometry; albedo, emission, lights and sky are put in at run time.

pub mod bvh;
pub mod certificate;
pub mod depths;
pub mod dering;
pub mod direct;
pub mod directional;
pub mod file;
pub mod key;
pub mod materials;
pub mod needs;
pub mod occluders;
pub mod packed;
pub mod probe_field;
pub mod reflection;
pub mod rows;
pub mod sh;
pub mod sky;
pub mod solid_angle;
pub mod solve;
pub mod solved;
pub mod stale;
pub mod steering;
pub mod surface;
pub mod tetrahedra;
pub mod tree;
mod validate;

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

use crate::scene::{EntityId, Feature};
pub use certificate::Certificate;
pub use depths::Depths;
pub use occluders::Occluders;
pub use rows::Rows;
pub use solved::Solved;
pub use surface::{Batch, Surface, Vertex};
pub use tree::Tree;

/// "No patch": a side that nothing reflects from or emits.
pub const NONE: u32 = u32::MAX;

/// The baked thing. Positions are metres relative to `origin`; all arrays are in a fixed order that does not
/// depend on threads or load order.
#[derive(Clone, Debug, Default)]
pub struct Transport {
    /// world = origin + position.
    pub origin: DVec3,
    /// Refined triangles of all static meshes: what is drawn, and what the rays met.
    pub surface: Surface,
    pub patches: Vec<Patch>,
    /// Fixed points at which direct light is sampled: those of patch i are
    /// `samples[patches[i].first_sample ..][.. patches[i].sample_count]`.
    pub samples: Vec<Sample>,
    pub receivers: Vec<Receiver>,
    pub probes: Vec<Probe>,
    /// How far probes beside walls see; empty where every probe sees its neighbours.
    pub depths: Depths,
    /// How many sky patches follow the patches in the columns of every kind of row; 0 without a sky. A sky that is
    /// the same everywhere may have one, or two that share its weights ([`sky::is_division`]).
    pub sky_patches: u32,
    /// Columns: patches, then sky patches. Sums to 1 less what is lost.
    pub patch_from_patch: Rows,
    /// Columns as above.
    pub receiver_from_patch: Rows,
    /// Nine rows a probe, (0,0), (1,-1) .. (2,2), columns as above; takes radiosity (sky: pi * radiance) to
    /// SH coefficients of incoming radiance, 1/pi included.
    pub probe_from_patch: Rows,
    /// Three rows for each of the first receivers, those that surfaces with a normal map blend: [`directional`].
    /// Columns as above. Empty where no static surface has one.
    pub directional_from_patch: Rows,
    /// Patch rows are nearly full: the file has their weights alone, row after row, and so may the GPU.
    pub dense: bool,
    /// The light itself, where it was solved at the bake: there are no rows then, and no samples.
    pub solved: Option<Solved>,
    /// What the full transport has and this one has not; empty where this is the full one. The certificate is that of
    /// the full one.
    pub omissions: Vec<Omission>,
    pub certificate: Certificate,
}

/// A feature that a player's file was made without.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Omission {
    pub feature: Feature,
    /// Hash of all in the scene that leaving it out relied on: where that changes, the light is no longer the scene's.
    pub relied_on: String,
}

/// A piece of surface that holds one radiosity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Patch {
    pub centre: Vec3,
    /// m2, of its valid surface.
    pub area: f32,
    /// Unit; the area's mean for a cluster.
    pub normal: Vec3,
    /// Which of `surface.batches` it belongs to: entity and material.
    pub batch: u32,
    /// Its triangles, one run of `surface.triangles`.
    pub first_triangle: u32,
    pub triangle_count: u32,
    pub first_sample: u32,
    pub sample_count: u32,
    /// 1 for the back side of a double-sided surface: the same triangles, seen from behind.
    pub back: u32,
    /// Patches of one component can exchange light; others never do.
    pub component: u32,
    /// The aggregate (room-sized group of patches) of the coarse correction.
    pub aggregate: u32,
    /// What its row sums to: 1 less what is lost. The stored weights never exceed it.
    pub target: f32,
}

/// A point on a patch, with the normal of its side.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Sample {
    pub position: Vec3,
    pub patch: u32,
    pub normal: Vec3,
    pub padding: u32,
}

/// A point at which irradiance is known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Receiver {
    pub position: Vec3,
    /// 1 where the point can be lit; 0 inside a solid, where only back faces are seen.
    pub valid: f32,
    pub normal: Vec3,
    pub padding: u32,
}

/// A light probe.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Probe {
    pub position: Vec3,
    /// 1, or 0 for a probe inside a solid: most of what it sees are back faces.
    pub valid: f32,
    /// The group's entity (low and high half of its id), and its place in the group.
    pub entity: [u32; 2],
    pub index: u32,
    pub padding: u32,
}

impl Probe {
    pub fn entity(&self) -> EntityId {
        EntityId(u64::from(self.entity[0]) | u64::from(self.entity[1]) << 32)
    }
}

impl Transport {
    /// Columns of every kind of row: patches, then sky patches.
    pub fn columns(&self) -> usize {
        self.patches.len() + self.sky_patches as usize
    }

    /// H = G B: irradiance at receivers from radiosity in all columns, sky patches last (pi * radiance) [W/m2].
    pub fn irradiance_of_receivers(&self, values: &[DVec3]) -> Vec<DVec3> {
        solve::gather(&self.receiver_from_patch, values)
    }

    /// Array lengths, ranges and indices agree; numbers are finite; rows sum to at most 1. Says what does
    /// not. Whatever passes can be solved and drawn without a further look.
    pub fn validate(&self) -> Result<(), String> {
        self.surface.validate()?;
        let (patches, samples, triangles) =
            (self.patches.len(), self.samples.len(), self.surface.triangles.len());
        for (i, patch) in self.patches.iter().enumerate() {
            let in_range = |first: u32, count: u32, n: usize| u64::from(first) + u64::from(count) <= n as u64;
            if !(in_range(patch.first_triangle, patch.triangle_count, triangles)
                && in_range(patch.first_sample, patch.sample_count, samples)
                && (patch.batch as usize) < self.surface.batches.len())
            {
                return Err(format!("patch {i} names triangles, samples or a batch that do not exist"));
            }
            if !(patch.area > 0.0
                && patch.area.is_finite()
                && patch.centre.is_finite()
                && patch.normal.is_finite())
            {
                return Err(format!("patch {i} has no proper area, centre or normal"));
            }
        }
        if self.surface.patches.iter().flatten().any(|&patch| patch != NONE && patch as usize >= patches) {
            return Err("a triangle names a patch that does not exist".to_owned());
        }
        let blends = &self.surface.blends;
        if blends.iter().any(|blend| {
            blend.receivers.iter().zip(blend.weights).any(|(&receiver, weight)| {
                !weight.is_finite() || (weight != 0.0 && receiver as usize >= self.receivers.len())
            })
        }) {
            return Err("a vertex blends receivers that do not exist".to_owned());
        }
        if self.samples.iter().any(|sample| sample.patch as usize >= patches || !sample.position.is_finite())
        {
            return Err("a sample names a patch that does not exist".to_owned());
        }
        self.depths.validate(self.probes.len())?;
        validate::numbers(self)?;
        // Light that is solved needs no rows.
        let has = |count: usize| if self.solved.is_some() { 0 } else { count };
        let rows = [
            ("patch", &self.patch_from_patch, has(patches), true),
            ("receiver", &self.receiver_from_patch, has(self.receivers.len()), true),
            ("probe", &self.probe_from_patch, has(self.probes.len() * 9), false),
            (
                "directional",
                &self.directional_from_patch,
                has(self.directional_receivers() * directional::AXES),
                false,
            ),
        ];
        for (what, rows, count, shares) in rows {
            rows.validate(count, self.columns(), shares).map_err(|error| format!("{what} rows: {error}"))?;
        }
        self.solved.as_ref().map_or(Ok(()), |solved| solved.validate(self))
    }

    /// The transport hash: BLAKE3 of the arrays alone.
    pub fn hash(&self) -> blake3::Hash {
        let mut hasher = blake3::Hasher::new();
        for (name, bytes) in file::arrays(self) {
            hasher.update(name.as_bytes());
            hasher.update(&(bytes.len() as u64).to_le_bytes());
            hasher.update(&bytes);
        }
        hasher.finalize()
    }
}
