//! What the hierarchy does to the scene: delete, reparent, reorder, hide. Each makes an edit and touches nothing.

use std::collections::HashSet;

use engine::scene::{Entity, EntityId, Sky, SkyKind, Transform, Warning};
use glam::DAffine3;

use super::{Edit, Field, IndexedScene, objects};

/// The entities and all under them go; what referred to them forgets them and is told.
pub fn delete(scene: &IndexedScene, ids: &[EntityId]) -> (Edit, Vec<Warning>) {
    let top = scene.topmost(ids);
    let gone: Vec<EntityId> = top.iter().flat_map(|id| scene.subtree(*id)).collect();
    let is_gone: HashSet<EntityId> = gone.iter().copied().collect();
    let (mut edits, warnings) = forget(scene, &is_gone);
    edits.push(Edit::Remove(gone));
    (Edit::several(format!("Delete {}", objects(&top, scene)), edits), warnings)
}

/// References from what stays to what goes.
fn forget(scene: &IndexedScene, gone: &HashSet<EntityId>) -> (Vec<Edit>, Vec<Warning>) {
    let (mut fields, mut warnings) = (Vec::new(), Vec::new());
    for entity in scene.scene().entities.iter().filter(|entity| !gone.contains(&entity.id)) {
        let Some(mesh) = &entity.mesh else { continue };
        let mut reflection = mesh.reflection.clone();
        reflection.anchor = reflection.anchor.filter(|anchor| !gone.contains(anchor));
        if let Some(probes) = &mut reflection.probes {
            probes.retain(|probe| !gone.contains(probe));
        }
        if reflection != mesh.reflection {
            warnings.push(Warning::new(
                &entity.name,
                "its reflections referred to what was deleted: they forget it",
            ));
            fields.push((entity.id, Field::Reflection(Box::new(reflection))));
        }
    }
    let mut edits = if fields.is_empty() { Vec::new() } else { vec![Edit::Set(fields)] };
    if let SkyKind::Gradient { sun: Some(sun), .. } = scene.scene().sky.kind
        && gone.contains(&sun)
    {
        warnings.push(Warning::new("sky", "its sun was deleted: it has none now"));
        edits.push(Edit::Sky(Box::new(with_sun(&scene.scene().sky, None))));
    }
    (edits, warnings)
}

/// A sky that has no sun stays as it is.
pub fn with_sun(sky: &Sky, new: Option<EntityId>) -> Sky {
    let mut sky = sky.clone();
    if let SkyKind::Gradient { sun, .. } = &mut sky.kind {
        *sun = new;
    }
    sky
}

/// The entities come to stand under `parent` (`None`: under none), before its child `before` (`None`: as the last),
/// and keep their place in the world. Refused where an entity would stand under itself.
pub fn reparent(
    scene: &IndexedScene,
    ids: &[EntityId],
    parent: Option<EntityId>,
    before: Option<EntityId>,
) -> Result<(Edit, Vec<Warning>), String> {
    let top = scene.topmost(ids);
    if let Some(parent) = parent {
        let circle = top.iter().find(|id| scene.is_under(parent, **id));
        if let Some(entity) = circle.and_then(|id| scene.entity(*id)) {
            return Err(format!("`{}` cannot stand under itself", entity.name));
        }
    }
    let (mut fields, mut warnings) = (Vec::new(), Vec::new());
    for entity in top.iter().filter_map(|id| scene.entity(*id)).filter(|entity| entity.parent != parent) {
        fields.push((entity.id, Field::Parent(parent)));
        match placed_under(scene, entity, parent) {
            Ok(transform) => fields.push((entity.id, Field::Transform(Box::new(transform)))),
            Err(message) => warnings.push(Warning::new(&entity.name, message)),
        }
    }
    let verb = if fields.is_empty() { "Reorder" } else { "Reparent" };
    let name = format!("{verb} {}", objects(&top, scene));
    Ok((Edit::several(name, [Edit::Set(fields), moved_before(scene, &top, parent, before)]), warnings))
}

/// The transform under another parent that leaves the entity where it is.
fn placed_under(
    scene: &IndexedScene,
    entity: &Entity,
    parent: Option<EntityId>,
) -> Result<Transform, &'static str> {
    const FLAT: &str = "a scale of 0 stands above it or is its own: it keeps its numbers and not its place";
    const SHEARED: &str = "it would be sheared under its new parent: it keeps its numbers and not its place";
    let world_from_parent = parent.map_or(DAffine3::IDENTITY, |parent| scene.world_from_local(parent));
    let parent_from_local = world_from_parent.inverse() * scene.world_from_local(entity.id);
    let (scale, rotation, translation) = parent_from_local.to_scale_rotation_translation();
    let transform = Transform { translation, rotation: rotation.normalize(), scale };
    if !transform.is_finite() {
        return Err(FLAT);
    }
    let size =
        parent_from_local.matrix3.to_cols_array().into_iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let difference = transform.parent_from_local().matrix3 - parent_from_local.matrix3;
    let is_same = difference.to_cols_array().into_iter().all(|x| x.abs() <= 1e-6 * size);
    if is_same { Ok(transform) } else { Err(SHEARED) }
}

/// Whole subtrees move, each in its order.
fn moved_before(
    scene: &IndexedScene,
    top: &[EntityId],
    parent: Option<EntityId>,
    before: Option<EntityId>,
) -> Edit {
    let moved: Vec<EntityId> = top.iter().flat_map(|id| scene.subtree(*id)).collect();
    let moves: HashSet<EntityId> = moved.iter().copied().collect();
    let siblings = scene.children(parent);
    let from = before.and_then(|before| siblings.iter().position(|id| *id == before));
    // The one to stand before, or the next that stays.
    let next = from.and_then(|from| siblings[from..].iter().find(|id| !moves.contains(id)));
    let target = match (next.and_then(|next| scene.position(*next)), parent) {
        (Some(next), _) => next,
        (None, Some(parent)) => end_of_subtree(scene, parent),
        (None, None) => scene.scene().entities.len(),
    };
    let stay_before =
        scene.scene().entities[..target].iter().filter(|entity| !moves.contains(&entity.id)).count();
    Edit::Order(moved.into_iter().zip(stay_before..).collect())
}

/// Behind the last of all that stand under an entity.
pub fn end_of_subtree(scene: &IndexedScene, root: EntityId) -> usize {
    scene.subtree(root).into_iter().filter_map(|id| scene.position(id)).max().map_or(0, |last| last + 1)
}

/// Where in the list something has to stand to come right after the entity among its siblings.
pub fn behind(scene: &IndexedScene, id: EntityId) -> usize {
    let parent = scene.entity(id).and_then(|entity| entity.parent);
    let siblings = scene.children(parent);
    let own = siblings.iter().position(|sibling| *sibling == id);
    let next = own.and_then(|own| siblings.get(own + 1)).and_then(|next| scene.position(*next));
    next.unwrap_or_else(|| end_of_subtree(scene, id))
}

/// Sets a value of the entities, and of all under them where that is wanted.
pub fn set_flag(scene: &IndexedScene, ids: &[EntityId], with_children: bool, field: Field) -> Edit {
    let all = || scene.topmost(ids).into_iter().flat_map(|id| scene.subtree(id)).collect();
    let ids: Vec<EntityId> = if with_children { all() } else { ids.to_vec() };
    Edit::Set(ids.into_iter().map(|id| (id, field.clone())).collect())
}

/// Hides all that is neither among the entities nor above nor below them. Parents stay, for what is hidden hides what it
/// carries.
pub fn isolate(scene: &IndexedScene, ids: &[EntityId]) -> Edit {
    let above = |id: &EntityId| scene.ancestors(*id).map(|entity| entity.id).collect::<Vec<_>>();
    let kept: HashSet<EntityId> =
        ids.iter().flat_map(|id| scene.subtree(*id).into_iter().chain(above(id))).collect();
    let others = scene.scene().entities.iter().filter(|entity| !kept.contains(&entity.id));
    Edit::Set(others.map(|entity| (entity.id, Field::Hidden(true))).collect())
}
