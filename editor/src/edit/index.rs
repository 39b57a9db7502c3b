//! The scene, and beside it where everything in it is: an entity is found by its id without a search.

use std::collections::HashMap;

use engine::scene::{Entity, EntityId, Material, MaterialId, Scene};
use glam::DAffine3;

/// A scene that only edits change, so that the index always fits it.
#[derive(Clone, Debug, Default)]
pub struct IndexedScene {
    pub(super) scene: Scene,
    entity_at: HashMap<EntityId, usize>,
    material_at: HashMap<MaterialId, usize>,
    /// In the scene's order; `None`: those without a parent.
    children: HashMap<Option<EntityId>, Vec<EntityId>>,
}

impl IndexedScene {
    pub fn new(scene: Scene) -> Self {
        let mut indexed = Self { scene, ..Self::default() };
        indexed.index_entities(0);
        indexed.index_materials();
        indexed
    }

    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    pub fn entity(&self, id: EntityId) -> Option<&Entity> {
        Some(&self.scene.entities[self.position(id)?])
    }

    pub fn material(&self, id: MaterialId) -> Option<&Material> {
        Some(&self.scene.materials[self.material_position(id)?])
    }

    /// Where in the scene's list.
    pub fn position(&self, id: EntityId) -> Option<usize> {
        self.entity_at.get(&id).copied()
    }

    pub fn material_position(&self, id: MaterialId) -> Option<usize> {
        self.material_at.get(&id).copied()
    }

    /// In the order of the hierarchy. `None`: the roots.
    pub fn children(&self, parent: Option<EntityId>) -> &[EntityId] {
        self.children.get(&parent).map_or(&[], Vec::as_slice)
    }

    /// The entity and all that stands under it, each before its children, in the order of the hierarchy.
    pub fn subtree(&self, root: EntityId) -> Vec<EntityId> {
        let mut found = Vec::new();
        let mut stack = vec![root];
        while let Some(id) = stack.pop().filter(|_| found.len() <= self.scene.entities.len()) {
            found.push(id);
            stack.extend(self.children(Some(id)).iter().rev());
        }
        found
    }

    /// From the entity's parent up to a root.
    pub fn ancestors(&self, id: EntityId) -> impl Iterator<Item = &Entity> {
        let parent = |entity: &&Entity| self.entity(entity.parent?);
        let first = self.entity(id);
        // No chain is longer than there are entities: a circle ends too.
        std::iter::successors(first, parent).skip(1).take(self.scene.entities.len())
    }

    /// Is `id` the entity `above`, or does it stand under it?
    pub fn is_under(&self, id: EntityId, above: EntityId) -> bool {
        id == above || self.ancestors(id).any(|entity| entity.id == above)
    }

    /// Identity where there is no such entity.
    pub fn world_from_local(&self, id: EntityId) -> DAffine3 {
        let local = |entity: &Entity| entity.transform.parent_from_local();
        let own = self.entity(id).map_or(DAffine3::IDENTITY, local);
        self.ancestors(id).fold(own, |below, parent| local(parent) * below)
    }

    /// Of the entities themselves, those that stand under no other of them, in the scene's order.
    pub fn topmost(&self, ids: &[EntityId]) -> Vec<EntityId> {
        let chosen: std::collections::HashSet<EntityId> = ids.iter().copied().collect();
        let stands_alone = |id: &EntityId| !self.ancestors(*id).any(|above| chosen.contains(&above.id));
        let mut top: Vec<EntityId> =
            chosen.iter().copied().filter(|id| self.position(*id).is_some()).filter(stands_alone).collect();
        top.sort_by_key(|id| self.position(*id));
        top
    }

    /// After entities came, went or moved at `first` and behind it.
    pub(super) fn index_entities(&mut self, first: usize) {
        self.entity_at.retain(|_, at| *at < first);
        let moved = self.scene.entities.iter().enumerate().skip(first);
        self.entity_at.extend(moved.map(|(at, entity)| (entity.id, at)));
        self.index_children();
    }

    pub(super) fn index_children(&mut self) {
        self.children.clear();
        for entity in &self.scene.entities {
            self.children.entry(entity.parent).or_default().push(entity.id);
        }
    }

    pub(super) fn index_materials(&mut self) {
        let materials = self.scene.materials.iter().enumerate();
        self.material_at = materials.map(|(at, material)| (material.id, at)).collect();
    }

    /// The index says what a search says.
    pub fn validate(&self) -> Result<(), String> {
        let fresh = Self::new(self.scene.clone());
        let fits = fresh.entity_at == self.entity_at
            && fresh.material_at == self.material_at
            && fresh.children == self.children;
        if fits { Ok(()) } else { Err("the index does not fit its scene".to_owned()) }
    }
}
