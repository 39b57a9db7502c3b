//! Which entities are selected, in the order in which they were.

use std::collections::HashSet;

use engine::scene::EntityId;

use crate::edit::IndexedScene;

/// The last of them is the active one: the one that inspectors show first and that others are aligned to.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Selection {
    ids: Vec<EntityId>,
    /// The same: thousands are asked about in every picture.
    chosen: HashSet<EntityId>,
    /// Where a range with Shift begins.
    anchor: Option<EntityId>,
}

/// What was held while something was clicked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Click {
    /// Alone.
    #[default]
    Replace,
    /// Ctrl: in if it was out, out if it was in.
    Toggle,
    /// Shift: all between the last click and this one.
    Range,
}

impl Selection {
    pub fn ids(&self) -> &[EntityId] {
        &self.ids
    }

    pub fn active(&self) -> Option<EntityId> {
        self.ids.last().copied()
    }

    pub fn contains(&self, id: EntityId) -> bool {
        self.chosen.contains(&id)
    }

    pub fn is_empty(&self) -> bool {
        self.ids.is_empty()
    }

    pub fn clear(&mut self) {
        *self = Self::default();
    }

    pub fn set(&mut self, ids: impl IntoIterator<Item = EntityId>) {
        self.clear();
        ids.into_iter().for_each(|id| self.add(id));
        self.anchor = self.active();
    }

    /// The entity becomes the active one.
    pub fn add(&mut self, id: EntityId) {
        self.remove(id);
        self.chosen.insert(id);
        self.ids.push(id);
    }

    pub fn remove(&mut self, id: EntityId) {
        if self.chosen.remove(&id) {
            self.ids.retain(|other| *other != id);
        }
    }

    /// A click on an entity, among those that are shown, in their order.
    pub fn click(&mut self, id: EntityId, how: Click, shown: &[EntityId]) {
        match how {
            Click::Replace => self.set([id]),
            Click::Toggle if self.contains(id) => self.remove(id),
            Click::Toggle => self.add(id),
            Click::Range => return self.extend(id, shown),
        }
        self.anchor = Some(id);
    }

    /// From the anchor to the entity; the anchor stays, so that another range begins there too.
    fn extend(&mut self, id: EntityId, shown: &[EntityId]) {
        let at = |id: EntityId| shown.iter().position(|other| *other == id);
        let (Some(to), Some(from)) = (at(id), self.anchor.and_then(at)) else { return self.set([id]) };
        let anchor = self.anchor;
        let range = &shown[from.min(to)..=from.max(to)];
        self.set(range.iter().copied());
        self.add(id);
        self.anchor = anchor;
    }

    /// What is gone is not selected any more.
    pub fn retain_existing(&mut self, scene: &IndexedScene) {
        self.chosen.retain(|id| scene.entity(*id).is_some());
        self.ids.retain(|id| self.chosen.contains(id));
        self.anchor = self.anchor.filter(|id| scene.entity(*id).is_some());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ids(numbers: &[u64]) -> Vec<EntityId> {
        numbers.iter().map(|&n| EntityId(n)).collect()
    }

    #[test]
    fn ctrl_toggles_and_shift_takes_all_between() {
        let shown = ids(&[5, 3, 8, 1, 9]);
        let mut selection = Selection::default();
        selection.click(EntityId(3), Click::Replace, &shown);
        selection.click(EntityId(1), Click::Range, &shown);
        assert_eq!(selection.ids(), ids(&[3, 8, 1]));
        selection.click(EntityId(5), Click::Range, &shown);
        assert_eq!((selection.ids(), selection.active()), (&*ids(&[3, 5]), Some(EntityId(5))));
        selection.click(EntityId(9), Click::Toggle, &shown);
        selection.click(EntityId(3), Click::Toggle, &shown);
        assert_eq!(selection.ids(), ids(&[5, 9]));
        selection.click(EntityId(8), Click::Replace, &shown);
        assert_eq!(selection.ids(), ids(&[8]));
    }

    #[test]
    fn a_range_without_a_beginning_selects_one() {
        let mut selection = Selection::default();
        selection.click(EntityId(2), Click::Range, &ids(&[1, 2]));
        assert_eq!(selection.ids(), ids(&[2]));
        selection.click(EntityId(7), Click::Range, &ids(&[1, 2]));
        assert_eq!(selection.ids(), ids(&[7]));
    }
}
