//! What a bake says of itself: every statement with its number and its limit.

use serde::{Deserialize, Serialize};

use super::directional;
use super::key::Input;
use super::needs::Needs;

/// Written into the bake and printed. Times, threads and texts lie outside the transport hash.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Certificate {
    pub transport_hash: String,
    /// What it was baked from ([`super::key::transport_key`]).
    pub key: String,
    /// The same part by part; empty in files of before there were such keys.
    pub inputs: Vec<Input>,
    pub quality: String,
    pub rays_per_row: u32,
    /// Metres.
    pub base_length: f64,
    pub patches: usize,
    pub receivers: usize,
    pub probes: usize,
    pub sky_patches: usize,
    pub triangles: usize,
    /// Entries of patch, receiver and probe rows.
    pub entries: [usize; 3],
    /// Receivers with directional terms, and the entries of their rows.
    #[serde(skip_serializing_if = "is_zero")]
    pub directional_receivers: usize,
    #[serde(skip_serializing_if = "is_zero")]
    pub directional_entries: usize,
    /// Traced for what is now in the file, and of those in this run.
    pub rays: u64,
    pub rays_traced: u64,
    /// Of this run.
    pub seconds: f64,
    pub threads: usize,
    /// Of the full transport, as it would be stored.
    pub bytes: u64,
    /// What the player's file was made for: what is needed, and all that leaving out the rest relies on.
    pub shipped_for: String,
    /// max over patches of |sum - target| of the stored rows; target: 1 less sky and lost.
    pub row_sum_defect: f64,
    /// max over patches of the sum beyond its target; never above 0.
    pub row_sum_excess: f64,
    /// The same before balancing: the noise that was there.
    pub row_sum_defect_raw: f64,
    /// max |A_i P_ij - A_j P_ji| / max A_i P_ij of the stored rows.
    pub asymmetry: f64,
    pub least_entry: f64,
    /// max over receivers of the sum of their rows beyond 1; never above 0.
    pub receiver_sum_excess: f64,
    /// max over probes of the constant coefficient beyond that of the whole sphere, relative.
    pub probe_sum_excess: f64,
    /// max over directional rows of the sum of their sizes beyond [`directional::MOST`]; never above 0.
    pub directional_sum_excess: f64,
    /// The share of all light, under the scene's own emitters and a white sky, that appears or vanishes.
    pub energy_defect: f64,
    /// Area mean of the share of light that is lost on back faces.
    pub lost: f64,
    /// Area mean of the share of light that leaves the scene: to the sky, or to nothing.
    pub escaped: f64,
    /// Cavity gain w: max of (I - RP)^-1 1 over patches and channels, and the entity where it is.
    pub cavity_gain: f64,
    pub cavity_gain_entity: String,
    /// The project lifts the limit on the gain of closed rooms.
    pub unlimited_gain: bool,
    /// Predicted noise of the irradiance at patches, relative: median and 95th percentile.
    pub noise: [f64; 2],
    /// Triangles dropped for having no area or repeated indices.
    pub dropped_triangles: usize,
    /// What was found to be needed, with bytes counted in this bake; none in files of before anybody looked.
    pub needs: Option<Needs>,
    pub left_out: Vec<String>,
    pub warnings: Vec<String>,
}

fn is_zero(count: &usize) -> bool {
    *count == 0
}

/// One line of [`Certificate::statements`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Statement {
    pub what: &'static str,
    pub value: f64,
    pub limit: f64,
    pub holds: bool,
}

impl Certificate {
    /// What `check` checks, and what a bake must hold to be loaded. A NaN never holds.
    pub fn statements(&self) -> Vec<Statement> {
        let at_most = |what, value: f64, limit: f64| Statement { what, value, limit, holds: value <= limit };
        let mut statements = vec![
            at_most("row sums miss their targets by", self.row_sum_defect, 2e-7),
            at_most("row sums exceed their targets by", self.row_sum_excess, 0.0),
            at_most("receivers' row sums exceed 1 by", self.receiver_sum_excess, 0.0),
            at_most("probes see more than everything by", self.probe_sum_excess, 1e-6),
            at_most("reciprocity is missed by", self.asymmetry, 1e-4),
            at_most("least entry, negated", -self.least_entry, 0.0),
            at_most("share of light that appears or vanishes", self.energy_defect, 1e-4),
            at_most("cavity gain", self.cavity_gain, if self.unlimited_gain { f64::MAX } else { 1.1e4 }),
        ];
        if self.directional_receivers > 0 {
            // As much as storing adds: each term becomes either of its neighbours of 11 bits, a step of 2^-10 apart.
            let what = "directional terms exceed all light by";
            statements.push(at_most(what, self.directional_sum_excess, directional::MOST / 1024.0));
        }
        statements
    }

    pub fn holds(&self) -> bool {
        self.statements().iter().all(|statement| statement.holds)
    }

    /// What does not hold, in a line; none where all does.
    pub fn broken(&self) -> Option<String> {
        let broken: Vec<String> = self
            .statements()
            .iter()
            .filter(|statement| !statement.holds)
            .map(|statement| {
                format!("{} {:.1e} (limit {:.1e})", statement.what, statement.value, statement.limit)
            })
            .collect();
        (!broken.is_empty()).then(|| broken.join(", "))
    }
}
