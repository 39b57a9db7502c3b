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

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::scene::EntityId;
pub use crate::scene::{Feature, Forced};

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
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    pub needed: bool,
    pub why: String,
    pub entities: Vec<EntityId>,
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
        for (feature, Finding { needed, why, entities }) in findings {
            let verdict = &mut needs.verdicts[feature as usize];
            let forced = forced.get(&feature).copied().filter(|&forced| (forced == Forced::In) != needed);
            let is_in = forced.map_or(needed, |forced| forced == Forced::In);
            *verdict = Verdict { is_in, forced, why, entities, ..verdict.clone() };
        }
        needs
    }

    pub fn has(&self, feature: Feature) -> bool {
        self.verdict(feature).is_in
    }

    pub fn verdict(&self, feature: Feature) -> &Verdict {
        &self.verdicts[feature as usize]
    }

    /// A line for each feature that is not there, and why.
    pub fn left_out(&self) -> impl Iterator<Item = String> + '_ {
        let out = self.verdicts.iter().filter(|verdict| !verdict.is_in);
        out.map(|verdict| format!("{}: {}", verdict.feature.name(), verdict.why))
    }
}

impl Finding {
    pub fn needed(why: impl Into<String>, entities: Vec<EntityId>) -> Self {
        Self { needed: true, why: why.into(), entities }
    }

    pub fn not_needed(why: impl Into<String>) -> Self {
        Self { needed: false, why: why.into(), entities: Vec::new() }
    }
}

// STUB
pub fn relied_on(feature: Feature, scene: &crate::scene::Scene, _: &crate::scene::assets::Assets) -> String {
    blake3::hash(format!("{feature:?}{scene:?}").as_bytes()).to_hex().to_string()
}
pub fn needs_of_scene(
    _: &crate::scene::Scene,
    _: &crate::scene::assets::Assets,
    _: &BTreeMap<Feature, Forced>,
) -> Needs {
    Needs::all()
}
pub fn needs_of_transport(
    _: &crate::scene::Scene,
    _: &crate::scene::assets::Assets,
    _: &crate::transport::Transport,
    forced: &BTreeMap<Feature, Forced>,
) -> Needs {
    let mut needs = Needs::all();
    for (&feature, &says) in forced {
        needs.verdicts[feature as usize].is_in = says == Forced::In;
    }
    needs
}
// STUB END

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_author_overrules_a_finding_and_what_agrees_is_not_forced() {
        let found = |needed| vec![(Feature::Sky, Finding { needed, why: "so".into(), entities: vec![] })];
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
