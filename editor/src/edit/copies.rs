//! Copies of entities with ids of their own: what duplicate and paste have in common.

use std::borrow::Cow;
use std::collections::{HashMap, HashSet};

use engine::scene::{Entity, EntityId, MaterialId};

use super::{Edit, IndexedScene, objects, tree};

/// New ids for entities.
pub type NewId<'a> = &'a mut dyn FnMut() -> EntityId;

/// The entities and all under them once more, each copy behind its original. References inside what is copied lead
/// to the copies, all others to where they led.
pub fn duplicate(scene: &IndexedScene, ids: &[EntityId], new_id: NewId) -> Edit {
    let top = scene.topmost(ids);
    let originals: Vec<Vec<Entity>> = top.iter().map(|root| subtree(scene, *root)).collect();
    let ids_of_copies = renumbered(originals.iter().flatten(), new_id);
    let mut names = Names::beside(scene);
    let mut placed: Vec<(usize, Entity)> = Vec::new();
    let mut blocks: Vec<(usize, Vec<Entity>)> =
        top.iter().zip(originals).map(|(root, block)| (tree::behind(scene, *root), block)).collect();
    // Stable: copies that come to stand at one place keep their order.
    blocks.sort_by_key(|(at, _)| *at);
    for (at, block) in blocks {
        for (n, mut copy) in block.into_iter().enumerate() {
            redirect(&mut copy, &ids_of_copies, &|_| true);
            if n == 0 {
                copy.name = names.free(copy.parent, &copy.name);
            }
            placed.push((at + placed.len(), copy));
        }
    }
    Edit::several(format!("Duplicate {}", objects(&top, scene)), [Edit::Insert(placed)])
}

/// Clones of an entity and all under it.
pub fn subtree(scene: &IndexedScene, root: EntityId) -> Vec<Entity> {
    scene.subtree(root).into_iter().filter_map(|id| scene.entity(id).cloned()).collect()
}

pub fn renumbered<'a>(
    entities: impl Iterator<Item = &'a Entity>,
    new_id: NewId,
) -> HashMap<EntityId, EntityId> {
    entities.map(|entity| (entity.id, new_id())).collect()
}

/// The entity gets its new id, and so do its references; one that leads elsewhere stays where it is known there.
pub fn redirect(entity: &mut Entity, new: &HashMap<EntityId, EntityId>, is_known: &dyn Fn(EntityId) -> bool) {
    let redirected = |id: EntityId| new.get(&id).copied().or(is_known(id).then_some(id));
    entity.id = new.get(&entity.id).copied().unwrap_or(entity.id);
    entity.parent = entity.parent.and_then(redirected);
    if let Some(mesh) = &mut entity.mesh {
        mesh.reflection.anchor = mesh.reflection.anchor.and_then(redirected);
        if let Some(probes) = &mut mesh.reflection.probes {
            *probes = probes.iter().copied().filter_map(redirected).collect();
        }
    }
}

pub fn redirect_materials(entity: &mut Entity, new: &HashMap<MaterialId, MaterialId>) {
    for material in entity.mesh.iter_mut().flat_map(|mesh| &mut mesh.materials) {
        *material = new.get(material).copied().unwrap_or(*material);
    }
}

/// Names of siblings, so that each is told from the others.
pub struct Names<'a> {
    scene: &'a IndexedScene,
    taken: HashMap<Option<EntityId>, HashSet<Cow<'a, str>>>,
}

impl<'a> Names<'a> {
    pub fn beside(scene: &'a IndexedScene) -> Self {
        Self { scene, taken: HashMap::new() }
    }

    /// `Cube`, and where that is taken `Cube 2`, `Cube 3`; the name counts as taken from then on.
    pub fn free(&mut self, parent: Option<EntityId>, name: &str) -> String {
        let named = |id: &EntityId| Some(Cow::from(self.scene.entity(*id)?.name.as_str()));
        let siblings = || self.scene.children(parent).iter().filter_map(named).collect();
        let taken = self.taken.entry(parent).or_insert_with(siblings);
        let stem = name.trim_end_matches(|c: char| c.is_ascii_digit()).trim_end();
        let stem = if stem.is_empty() { name } else { stem };
        let numbered = (2..).map(|n: u64| format!("{stem} {n}"));
        let mut candidates = std::iter::once(name.to_owned()).chain(numbered);
        let free = candidates.find(|name| !taken.contains(name.as_str())).unwrap_or_default();
        taken.insert(Cow::from(free.clone()));
        free
    }
}
