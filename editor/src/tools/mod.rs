//! From the mouse to the camera, and from the mouse to edits.

pub mod drop;
pub mod navigate;
pub mod transform;

use std::collections::HashSet;

use engine::scene::EntityId;

use crate::edit::{Edit, Field, IndexedScene};

/// Hides all that carries something, but what is chosen and what stands under it. Lights and cameras stay: they are what
/// it is seen by.
pub fn isolate(scene: &IndexedScene, ids: &[EntityId]) -> Edit {
    let kept: HashSet<EntityId> = ids.iter().flat_map(|id| scene.subtree(*id)).collect();
    let others = scene.scene().entities.iter().filter(|entity| entity.mesh.is_some() && !kept.contains(&entity.id));
    // What hides a parent hides what is kept under it.
    let holds = |id: EntityId| kept.iter().any(|kept| scene.is_under(*kept, id));
    let hidden = others.filter(|entity| !entity.hidden && !holds(entity.id));
    Edit::Set(hidden.map(|entity| (entity.id, Field::Hidden(true))).collect())
}
