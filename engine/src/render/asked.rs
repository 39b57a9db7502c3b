//! What the author says of features ([`crate::transport::needs`]). What is said of a feature holds whatever happens; what
//! nobody speaks of is decided frame by frame, by the scene as it is then: things come and go while it plays, and what
//! a verdict left out before would be missing.

use std::collections::BTreeMap;

use crate::scene::{Feature, Forced};

#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Asked(BTreeMap<Feature, Forced>);

impl Asked {
    pub fn new(said: &BTreeMap<Feature, Forced>) -> Self {
        Self(said.clone())
    }

    pub fn said(&self, feature: Feature) -> Option<Forced> {
        self.0.get(&feature).copied()
    }

    /// Whether the feature is there, where the scene asks for it `now` or does not.
    pub fn has(&self, feature: Feature, now: bool) -> bool {
        self.said(feature).map_or(now, |forced| forced == Forced::In)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_author_says_holds_whatever_the_scene_asks_for() {
        let said = BTreeMap::from([(Feature::Sky, Forced::In), (Feature::Holes, Forced::Out)]);
        let asked = Asked::new(&said);
        for now in [false, true] {
            let has = [Feature::Sky, Feature::Holes, Feature::Reflections].map(|f| asked.has(f, now));
            assert_eq!(has, [true, false, now]);
        }
    }
}
