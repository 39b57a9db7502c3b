//! Edits: everything that can change a scene, as data.
//!
//! Applying an edit gives its inverse, made of the values that it replaced: doing, undoing and redoing are one body,
//! and none of them copies the scene. What an edit names and the scene does not have is left out, of its inverse too.

pub mod copies;
mod field;
mod index;
mod size;
mod stale;
pub mod tree;

use std::collections::{HashMap, HashSet};

use engine::scene::{Entity, EntityId, Material, MaterialId, Scene, Sky};

pub use field::Field;
pub use index::IndexedScene;
pub use stale::Stale;

#[derive(Clone, Debug, PartialEq)]
pub enum Edit {
    /// Fields of entities take these values.
    Set(Vec<(EntityId, Field)>),
    /// Entities come to stand at these places of the scene's list, which ascend.
    Insert(Vec<(usize, Entity)>),
    /// These alone: whoever removes a parent removes its children with it.
    Remove(Vec<EntityId>),
    /// Entities move to these places of the list, which ascend; all others keep their order.
    Order(Vec<(EntityId, usize)>),
    /// Materials take these values, each that of its id.
    SetMaterials(Vec<Material>),
    /// At these places of the scene's list, which ascend.
    InsertMaterials(Vec<(usize, Material)>),
    RemoveMaterials(Vec<MaterialId>),
    Sky(Box<Sky>),
    /// All of the scene at once: what was on disk, what was recovered.
    Whole(Box<Scene>),
    /// One after the other, as one step.
    Several {
        name: String,
        edits: Vec<Edit>,
    },
}

/// What applying an edit gives.
pub struct Applied {
    /// Applied in turn, it restores what was.
    pub back: Edit,
    pub stale: Stale,
}

impl Edit {
    pub fn set(id: EntityId, field: Field) -> Self {
        Self::Set(vec![(id, field)])
    }

    pub fn several(name: impl Into<String>, edits: impl IntoIterator<Item = Edit>) -> Self {
        Self::Several { name: name.into(), edits: edits.into_iter().collect() }
    }

    pub fn apply(self, scene: &mut IndexedScene) -> Applied {
        let stale = self.stale(scene);
        match self {
            Self::Set(fields) => set(fields, scene),
            Self::Several { name, edits } => several(name, edits, scene),
            Self::Insert(entities) => Applied { back: insert(entities, scene), stale },
            Self::Remove(ids) => Applied { back: Self::Insert(remove(&ids, scene)), stale },
            Self::Order(places) => Applied { back: order(places, scene), stale },
            Self::SetMaterials(materials) => Applied { back: set_materials(materials, scene), stale },
            Self::InsertMaterials(materials) => Applied { back: insert_materials(materials, scene), stale },
            Self::RemoveMaterials(ids) => Applied { back: remove_materials(&ids, scene), stale },
            Self::Sky(sky) if *sky == scene.scene.sky => Applied { back: Self::Set(Vec::new()), stale },
            Self::Sky(mut sky) => {
                std::mem::swap(&mut scene.scene.sky, &mut sky);
                Applied { back: Self::Sky(sky), stale }
            }
            Self::Whole(new) => {
                let old = std::mem::replace(scene, IndexedScene::new(*new));
                Applied { back: Self::Whole(Box::new(old.scene)), stale }
            }
        }
    }

    /// Would it change nothing, whatever the scene is?
    pub fn is_empty(&self) -> bool {
        match self {
            Self::Set(fields) => fields.is_empty(),
            Self::Insert(entities) => entities.is_empty(),
            Self::Remove(ids) => ids.is_empty(),
            Self::Order(places) => places.is_empty(),
            Self::SetMaterials(materials) => materials.is_empty(),
            Self::InsertMaterials(materials) => materials.is_empty(),
            Self::RemoveMaterials(ids) => ids.is_empty(),
            Self::Several { edits, .. } => edits.iter().all(Self::is_empty),
            Self::Sky(_) | Self::Whole(_) => false,
        }
    }

    /// The entities that it names, each once, in its order: what to select when it is undone or redone.
    pub fn entities(&self) -> Vec<EntityId> {
        let mut named: Vec<EntityId> = match self {
            Self::Set(fields) => fields.iter().map(|(id, _)| *id).collect(),
            Self::Insert(entities) => entities.iter().map(|(_, entity)| entity.id).collect(),
            Self::Remove(ids) => ids.clone(),
            Self::Order(places) => places.iter().map(|(id, _)| *id).collect(),
            Self::Several { edits, .. } => edits.iter().flat_map(Self::entities).collect(),
            _ => Vec::new(),
        };
        let mut seen = HashSet::new();
        named.retain(|id| seen.insert(*id));
        named
    }

    /// As an undo menu says it: `Rename "wall"`, `Hide 3 objects`.
    pub fn name(&self, scene: &IndexedScene) -> String {
        let of = |verb: &str| format!("{verb} {}", objects(&self.entities(), scene));
        match self {
            Self::Several { name, .. } => name.clone(),
            Self::Set(fields) => of(fields.first().map_or("Change", |(_, field)| field.verb())),
            Self::Insert(entities) => match entities.as_slice() {
                [(_, one)] => format!("Create \"{}\"", one.name),
                many => format!("Create {} objects", many.len()),
            },
            Self::Remove(_) => of("Delete"),
            Self::Order(_) => of("Reorder"),
            Self::SetMaterials(materials) => match materials.as_slice() {
                [one] => format!("Change material \"{}\"", one.name),
                many => format!("Change {} materials", many.len()),
            },
            Self::InsertMaterials(_) => "Create material".to_owned(),
            Self::RemoveMaterials(_) => "Delete material".to_owned(),
            Self::Sky(_) => "Change sky".to_owned(),
            Self::Whole(_) => "Replace scene".to_owned(),
        }
    }
}

/// `"wall"`, `3 objects`.
pub fn objects(ids: &[EntityId], scene: &IndexedScene) -> String {
    match ids {
        [one] => scene.entity(*one).map_or("object".to_owned(), |entity| format!("\"{}\"", entity.name)),
        many => format!("{} objects", many.len()),
    }
}

/// Values that are there already are left out: a click that moves nothing is no step.
fn set(fields: Vec<(EntityId, Field)>, scene: &mut IndexedScene) -> Applied {
    let mut stale = Stale::Nothing;
    let mut back = Vec::with_capacity(fields.len());
    let mut reparents = false;
    let probed = stale::has_light_probes(scene);
    for (id, field) in fields {
        let Some(at) = scene.position(id) else { continue };
        let costs = stale::of_field(&field, at, scene, probed);
        let Some(old) = field.exchange(&mut scene.scene.entities[at]) else { continue };
        reparents |= matches!(old, Field::Parent(_));
        stale = stale.max(costs);
        back.push((id, old));
    }
    if reparents {
        scene.index_children();
    }
    // A field that was set twice gets its first value back last.
    back.reverse();
    Applied { back: Edit::Set(back), stale }
}

fn several(name: String, edits: Vec<Edit>, scene: &mut IndexedScene) -> Applied {
    let applied: Vec<Applied> = edits.into_iter().map(|edit| edit.apply(scene)).collect();
    let stale = applied.iter().map(|one| one.stale).max().unwrap_or_default();
    let edits = applied.into_iter().rev().map(|one| one.back).filter(|back| !back.is_empty()).collect();
    Applied { back: Edit::Several { name, edits }, stale }
}

/// An id that is taken stays with whom it belongs to.
fn insert(mut entities: Vec<(usize, Entity)>, scene: &mut IndexedScene) -> Edit {
    let mut seen = HashSet::new();
    entities.retain(|(_, new)| scene.position(new.id).is_none() && seen.insert(new.id));
    let Some(first) = entities.first().map(|(at, _)| (*at).min(scene.scene.entities.len())) else {
        return Edit::Remove(Vec::new());
    };
    let ids = entities.iter().map(|(_, new)| new.id).collect();
    put(entities, &mut scene.scene.entities);
    scene.index_entities(first);
    Edit::Remove(ids)
}

fn remove(ids: &[EntityId], scene: &mut IndexedScene) -> Vec<(usize, Entity)> {
    let gone: HashSet<usize> = ids.iter().filter_map(|id| scene.position(*id)).collect();
    let Some(&first) = gone.iter().min() else { return Vec::new() };
    let taken = take(&gone, &mut scene.scene.entities);
    scene.index_entities(first);
    taken
}

fn order(mut places: Vec<(EntityId, usize)>, scene: &mut IndexedScene) -> Edit {
    let mut seen = HashSet::new();
    places.retain(|(id, _)| scene.position(*id).is_some() && seen.insert(*id));
    let moved: HashSet<usize> = places.iter().filter_map(|(id, _)| scene.position(*id)).collect();
    let taken = take(&moved, &mut scene.scene.entities);
    let back: Vec<(EntityId, usize)> = taken.iter().map(|(at, entity)| (entity.id, *at)).collect();
    let mut by_id: HashMap<EntityId, Entity> =
        taken.into_iter().map(|(_, entity)| (entity.id, entity)).collect();
    let placed = places.iter().filter_map(|(id, at)| Some((*at, by_id.remove(id)?))).collect();
    put(placed, &mut scene.scene.entities);
    scene.index_entities(0);
    let stayed = back.iter().all(|(id, at)| scene.position(*id) == Some(*at));
    Edit::Order(if stayed { Vec::new() } else { back })
}

/// In place, with their positions, which ascend.
fn take<T>(positions: &HashSet<usize>, list: &mut Vec<T>) -> Vec<(usize, T)> {
    let mut at = 0;
    let taken = list.extract_if(.., |_| {
        at += 1;
        positions.contains(&(at - 1))
    });
    let taken: Vec<T> = taken.collect();
    let mut positions: Vec<usize> = positions.iter().copied().collect();
    positions.sort_unstable();
    positions.into_iter().zip(taken).collect()
}

/// In place, run by run, at positions that ascend; beyond the end means at the end.
fn put<T>(items: Vec<(usize, T)>, list: &mut Vec<T>) {
    let mut items = items.into_iter().peekable();
    while let Some((at, item)) = items.next() {
        let at = at.min(list.len());
        let mut run = vec![item];
        while let Some((_, item)) = items.next_if(|(next, _)| *next <= at + run.len()) {
            run.push(item);
        }
        list.splice(at..at, run);
    }
}

fn set_materials(materials: Vec<Material>, scene: &mut IndexedScene) -> Edit {
    let mut back = Vec::with_capacity(materials.len());
    for material in materials {
        let Some(at) = scene.material_position(material.id) else { continue };
        let place = &mut scene.scene.materials[at];
        if *place != material {
            back.push(std::mem::replace(place, material));
        }
    }
    back.reverse();
    Edit::SetMaterials(back)
}

fn insert_materials(mut materials: Vec<(usize, Material)>, scene: &mut IndexedScene) -> Edit {
    let mut seen = HashSet::new();
    materials.retain(|(_, new)| scene.material_position(new.id).is_none() && seen.insert(new.id));
    let ids = materials.iter().map(|(_, new)| new.id).collect();
    put(materials, &mut scene.scene.materials);
    scene.index_materials();
    Edit::RemoveMaterials(ids)
}

fn remove_materials(ids: &[MaterialId], scene: &mut IndexedScene) -> Edit {
    let gone: HashSet<usize> = ids.iter().filter_map(|id| scene.material_position(*id)).collect();
    let taken = take(&gone, &mut scene.scene.materials);
    scene.index_materials();
    Edit::InsertMaterials(taken)
}
