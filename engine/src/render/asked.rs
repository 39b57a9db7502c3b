//! What the author says of features ([`crate::transport::needs`]). What is said of a feature holds whatever happens; what
//! nobody speaks of is decided frame by frame, by the scene as it is then: things come and go while it plays, and what
//! a verdict left out before would be missing. One thing no frame can see, as it is a promise: that nothing will take a
//! colour ([`super::channels`]).

use std::collections::BTreeMap;

use super::channels::Channels;
use crate::scene::{Feature, Forced};

#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Asked {
    said: BTreeMap<Feature, Forced>,
    grey: bool,
}

impl Asked {
    pub fn new(said: &BTreeMap<Feature, Forced>) -> Self {
        Self { said: said.clone(), grey: false }
    }

    /// Nothing that light comes from or meets has a colour or is free to take one.
    pub fn promising_grey(self, grey: bool) -> Self {
        Self { grey, ..self }
    }

    /// Colour may be left out where the author promises that there is none, and is there while there is some.
    pub fn channels(&self, is_coloured: impl FnOnce() -> bool) -> Channels {
        match self.said(Feature::Colour) {
            Some(Forced::In) => Channels::Three,
            Some(Forced::Out) => Channels::One,
            None if !self.grey || is_coloured() => Channels::Three,
            None => Channels::One,
        }
    }

    pub fn said(&self, feature: Feature) -> Option<Forced> {
        self.said.get(&feature).copied()
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

    #[test]
    fn one_channel_takes_a_promise_that_is_kept_or_the_authors_word() {
        let said =
            |forced: Option<Forced>| forced.map(|forced| (Feature::Colour, forced)).into_iter().collect();
        for (forced, promised, coloured, one) in [
            (None, true, false, true),
            (None, true, true, false),
            (None, false, false, false),
            (Some(Forced::In), true, false, false),
            (Some(Forced::Out), false, true, true),
        ] {
            let asked = Asked::new(&said(forced)).promising_grey(promised);
            assert_eq!(asked.channels(|| coloured) == Channels::One, one, "{forced:?} {promised} {coloured}");
        }
    }
}
