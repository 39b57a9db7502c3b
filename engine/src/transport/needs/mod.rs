//! What a scene needs, and what is left out because it does not need it.
//!
//! ```text
//! needs_of_scene      before any ray: what the scene alone tells            -> what is baked
//! needs_of_transport  after the bake: what rows and components tell, too    -> what is in the player's file, on the
//!                                                                              GPU, in the frame
//! ```
//! Each [`Feature`] is something that costs and that some scenes do without. A rule looks at the scene (and at the bake)
//! and finds who needs the feature, or why nobody does; that is a [`Verdict`]. Everything else asks
//! [`Needs::has`] and nothing more. The author may overrule each verdict by the project's settings ([`Forced`]): in,
//! and it is there though nobody needs it; out, and whoever needs it does without.

mod as_baked;
mod colour;
pub mod look;
#[cfg(test)]
mod made;
mod patches;
mod probes;
mod reflections;
mod relied_on;
mod saving;
mod shadows;
mod sky;
mod solver;
mod sources;
mod surfaces;
mod told;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::Transport;
use crate::scene::assets::Assets;
use crate::scene::{EntityId, Scene};
pub use crate::scene::{Feature, Forced};
pub use as_baked::as_baked;
pub use look::Look;
pub use reflections::is_smooth;
pub use relied_on::{grounds, relied_on};
pub use saving::{Cost, PROBE_RAYS, RowSizes, Sizes, bytes};
pub use solver::SMALL;

/// What the scene alone tells, before any ray. What only a bake tells is taken as needed, and savings are known where
/// [`Sizes`] are ([`Look::sized`]).
pub fn needs_of_scene(scene: &Scene, assets: &Assets, forced: &BTreeMap<Feature, Forced>) -> Needs {
    Look::at_scene(scene, assets, forced).needs()
}

/// What the bake tells, too; savings are counted in it.
pub fn needs_of_transport(
    scene: &Scene,
    assets: &Assets,
    transport: &Transport,
    forced: &BTreeMap<Feature, Forced>,
) -> Needs {
    Look::at_transport(scene, assets, transport, forced).needs()
}

/// What a player tells: what its scene needs now, with what things take on this machine. What a light file left out
/// cannot be counted in it: that is told as it was when it was baked.
pub fn needs_in_play(
    scene: &Scene,
    assets: &Assets,
    transport: &Transport,
    forced: &BTreeMap<Feature, Forced>,
) -> Needs {
    let cost = Cost::measured().of_bake(transport);
    let mut needs = Look::at_transport(scene, assets, transport, forced).costing(cost).needs();
    let baked = transport.certificate.needs.iter().flat_map(|needs| &needs.verdicts);
    for (now, then) in needs.verdicts.iter_mut().zip(baked) {
        if !now.is_in && !then.is_in && now.saving.gpu_bytes < then.saving.gpu_bytes {
            now.saving = then.saving;
        }
        // What only a bake tells, of one whose rows are left out.
        if now.is_in && !then.is_in && then.feature.is_of_bake() && now.forced.is_none() {
            *now = then.clone();
        }
    }
    needs
}

/// By patch: black, and in a room that no source reaches. What has no row and no column where [`Feature::BlackPatches`]
/// and [`Feature::UnlitPatches`] are left out.
pub fn dark_patches(scene: &Scene, assets: &Assets, transport: &Transport) -> [Vec<bool>; 2] {
    let forced = BTreeMap::new();
    let look = Look::at_transport(scene, assets, transport, &forced);
    [patches::black(&look), patches::unlit(&look)].map(Option::unwrap_or_default)
}

impl Look<'_> {
    pub fn needs(&self) -> Needs {
        let findings = Feature::ALL.into_iter().map(|feature| (feature, finding(feature, self))).collect();
        Needs::of(findings, self.forced)
    }
}

/// Each feature's rule.
pub fn finding(feature: Feature, look: &Look<'_>) -> Finding {
    match feature {
        Feature::LightProbes => probes::light_probes(look),
        Feature::Reflections => reflections::reflections(look),
        Feature::Recaptures => reflections::recaptures(look),
        Feature::UnseenCaptures => reflections::unseen_captures(look),
        Feature::Sky => sky::sky(look),
        Feature::SkyPatches => sky::sky_patches(look),
        Feature::Directional => surfaces::directional(look),
        Feature::BlackPatches => patches::black_patches(look),
        Feature::UnlitPatches => patches::unlit_patches(look),
        Feature::Matrix => sources::matrix(look),
        Feature::Colour => colour::colour(look),
        Feature::CoarseCorrection => solver::coarse_correction(look),
        Feature::Columns => solver::columns(look),
        Feature::Holes => surfaces::holes(look),
        Feature::ShadowMaps => shadows::shadow_maps(look),
        Feature::MaterialVariants => surfaces::material_variants(look),
    }
}

/// What is needed, feature by feature, in the order of [`Feature::ALL`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Needs {
    pub verdicts: Vec<Verdict>,
}

/// What became of one feature.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    pub feature: Feature,
    /// It is there: somebody needs it, or it is forced in.
    pub is_in: bool,
    /// What the author says, where that is something else than the rule.
    pub forced: Option<Forced>,
    /// Who needs it; or why nobody does. A sentence without its end.
    pub why: String,
    /// Those who need it, or to whom it is due that nobody does: where a click on the row leads.
    pub entities: Vec<EntityId>,
    /// What leaving it out saves, or would save: the price of forcing it in.
    pub saving: Saving,
}

/// Estimates before the bake, counts after it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Saving {
    /// In the player's file.
    pub file_bytes: u64,
    /// On the GPU.
    pub gpu_bytes: u64,
    /// A frame in which light changes.
    pub milliseconds: f64,
    /// Of the bake.
    pub seconds: f64,
}

/// What a rule found, before the author overrules it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Finding {
    pub needed: bool,
    pub why: String,
    pub entities: Vec<EntityId>,
    pub saving: Saving,
}

impl Needs {
    /// Everything is there: what the editor loads, and what a scene without a look at it gets.
    pub fn all() -> Self {
        let verdict = |feature| Verdict {
            feature,
            is_in: true,
            forced: None,
            why: "nobody has looked".to_owned(),
            entities: Vec::new(),
            saving: Saving::default(),
        };
        Self { verdicts: Feature::ALL.into_iter().map(verdict).collect() }
    }

    /// Verdicts of findings, overruled where the author says so. What is not found is in.
    pub fn of(findings: Vec<(Feature, Finding)>, forced: &BTreeMap<Feature, Forced>) -> Self {
        let mut needs = Self::all();
        for (feature, Finding { needed, why, entities, saving }) in findings {
            let forced = forced.get(&feature).copied().filter(|&forced| (forced == Forced::In) != needed);
            let is_in = forced.map_or(needed, |forced| forced == Forced::In);
            needs.verdicts[feature as usize] = Verdict { feature, is_in, forced, why, entities, saving };
        }
        needs
    }

    pub fn has(&self, feature: Feature) -> bool {
        self.verdict(feature).is_in
    }

    pub fn verdict(&self, feature: Feature) -> &Verdict {
        &self.verdicts[feature as usize]
    }
}

impl Finding {
    pub fn needed(why: impl Into<String>, entities: Vec<EntityId>) -> Self {
        Self { needed: true, why: why.into(), entities, ..Self::default() }
    }

    pub fn not_needed(why: impl Into<String>) -> Self {
        Self { needed: false, why: why.into(), ..Self::default() }
    }

    /// Those to whom it is due that nobody needs it.
    pub fn led_to(self, entities: Vec<EntityId>) -> Self {
        Self { entities, ..self }
    }

    pub fn saves(self, saving: Saving) -> Self {
        Self { saving, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_author_overrules_a_finding_and_what_agrees_is_not_forced() {
        let found = |needed| vec![(Feature::Sky, Finding { needed, why: "so".into(), ..Finding::default() })];
        for needed in [false, true] {
            for (forced, is_in) in [(None, needed), (Some(Forced::In), true), (Some(Forced::Out), false)] {
                let says = forced.map(|forced| (Feature::Sky, forced)).into_iter().collect();
                let verdict = Needs::of(found(needed), &says).verdict(Feature::Sky).clone();
                assert_eq!((verdict.is_in, verdict.forced.is_some()), (is_in, is_in != needed));
            }
        }
    }

    #[test]
    fn features_stand_in_the_order_of_their_list() {
        assert!(Feature::ALL.into_iter().enumerate().all(|(i, feature)| feature as usize == i));
    }
}
