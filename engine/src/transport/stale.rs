//! A bake that does not fit its scene any more: what of it is stale, and how the rest of it is still used.

use std::collections::{HashMap, HashSet};
use std::fmt;

use super::key::{Input, What};
use super::{NONE, Transport};
use crate::scene::EntityId;

/// What differs between what was baked and what is there. Empty: the bake fits.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stale {
    pub changed: Vec<Input>,
    /// Was not there when the scene was baked.
    pub new: Vec<Input>,
    /// Was there then.
    pub gone: Vec<Input>,
}

impl Stale {
    /// Between the inputs of a bake and those of the scene as it is now ([`super::key::inputs`]). Light probes that
    /// nothing reads any more are no difference: a bake that has more than its scene needs fits it.
    pub fn between(baked: &[Input], now: &[Input]) -> Self {
        fn by_place(inputs: &[Input]) -> HashMap<(What, EntityId), &Input> {
            inputs.iter().map(|input| ((input.what, input.entity), input)).collect()
        }
        let (was, is) = (by_place(baked), by_place(now));
        let place = |input: &Input| (input.what, input.entity);
        let reads_probes = now.iter().any(|input| input.what == What::Probes);
        let is_missed =
            |input: &&Input| !is.contains_key(&place(input)) && (input.what != What::Probes || reads_probes);
        let changed = |input: &&Input| was.get(&place(input)).is_some_and(|was| was.key != input.key);
        Self {
            changed: now.iter().filter(changed).cloned().collect(),
            new: now.iter().filter(|input| !was.contains_key(&place(input))).cloned().collect(),
            gone: baked.iter().filter(is_missed).cloned().collect(),
        }
    }

    pub fn is_empty(&self) -> bool {
        self.changed.is_empty() && self.new.is_empty() && self.gone.is_empty()
    }
}

/// "changed `box`, the sky; new `lamp`; gone `wall` and 3 more".
impl fmt::Display for Stale {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const NAMED: usize = 5;
        let kinds = [("changed", &self.changed), ("new", &self.new), ("gone", &self.gone)];
        let mut left = NAMED;
        let mut told = Vec::new();
        for (kind, inputs) in kinds {
            let names: Vec<String> = inputs.iter().take(left).map(name).collect();
            left -= names.len();
            if !names.is_empty() {
                told.push(format!("{kind} {}", names.join(", ")));
            }
        }
        let more = (self.changed.len() + self.new.len() + self.gone.len()).saturating_sub(NAMED);
        f.write_str(&told.join("; "))?;
        if more > 0 { write!(f, " and {more} more") } else { Ok(()) }
    }
}

fn name(input: &Input) -> String {
    match input.what {
        What::Method | What::Sky => input.name.clone(),
        What::Surface => format!("`{}`", input.name),
        What::Probes => format!("the light probes of `{}`", input.name),
    }
}

impl Transport {
    /// Takes out of the picture what is stale, and leaves the rest of the light as it is. Surfaces of entities
    /// that changed or are gone are no longer drawn. Patches of what changed go on to reflect and emit from where
    /// they were, which is the best that is known; those of what is gone are black.
    pub fn leave_out(&mut self, stale: &Stale) {
        let surfaces = |inputs: &[Input]| -> HashSet<EntityId> {
            inputs.iter().filter(|input| input.what == What::Surface).map(|input| input.entity).collect()
        };
        let (changed, gone) = (surfaces(&stale.changed), surfaces(&stale.gone));
        for batch in &mut self.surface.batches {
            let entity = batch.entity();
            if gone.contains(&entity) {
                batch.material = NONE;
            }
            if gone.contains(&entity) || changed.contains(&entity) {
                batch.entity = [NONE; 2];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transport::Batch;

    fn input(what: What, entity: u64, key: &str) -> Input {
        Input { what, entity: EntityId(entity), name: format!("e{entity}"), key: key.to_owned() }
    }

    #[test]
    fn each_difference_is_named_and_the_first_five_by_name() {
        let surface = |entity, key| input(What::Surface, entity, key);
        let was = [surface(1, "a"), surface(2, "a"), surface(3, "a"), input(What::Probes, 3, "p")];
        let is = [surface(1, "a"), surface(2, "b"), surface(4, "a"), input(What::Probes, 3, "q")];
        let stale = Stale::between(&was, &is);
        assert_eq!(stale.to_string(), "changed `e2`, the light probes of `e3`; new `e4`; gone `e3`");
        assert!(Stale::between(&was, &was).is_empty());
        let many: Vec<Input> = (0..8).map(|entity| surface(entity, "a")).collect();
        let told = Stale::between(&[], &many).to_string();
        assert_eq!(told, "new `e0`, `e1`, `e2`, `e3`, `e4` and 3 more");
    }

    #[test]
    fn probes_that_nothing_reads_any_more_are_no_difference_and_new_ones_are() {
        let wall = input(What::Surface, 1, "a");
        let with = [wall.clone(), input(What::Probes, 2, "p"), input(What::Probes, 3, "p")];
        assert!(Stale::between(&with, std::slice::from_ref(&wall)).is_empty());
        assert_eq!(Stale::between(&with, &with[..2]).to_string(), "gone the light probes of `e3`");
        let told = Stale::between(&[wall], &with).to_string();
        assert_eq!(told, "new the light probes of `e2`, the light probes of `e3`");
    }

    #[test]
    fn what_changed_is_not_drawn_and_what_is_gone_is_black() {
        let batch = |entity| Batch { entity: [entity, 0], material: 7, ..Batch::default() };
        let mut transport = Transport::default();
        transport.surface.batches = vec![batch(1), batch(2), batch(3)];
        let surface = |entity, key| input(What::Surface, entity, key);
        let was = [surface(1, "a"), surface(2, "a"), surface(3, "a")];
        transport.leave_out(&Stale::between(&was, &[surface(1, "a"), surface(2, "b")]));
        let [kept, changed, gone] = transport.surface.batches[..] else { panic!() };
        assert_eq!((kept, changed.material, gone.material), (batch(1), 7, NONE));
        assert!(!kept.is_stale() && changed.is_stale() && gone.is_stale());
    }
}
