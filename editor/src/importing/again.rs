//! Importing a file again after it changed. What the file says now is compared with what it said the last time: what
//! differs is taken over, except where the user has changed it since, which stays as the user left it.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::{Path, PathBuf};

use engine::scene::file::{read, write};
use engine::scene::{Entity, EntityId, Material, MaterialId, Scene, SceneError, Warning};
use serde::{Deserialize, Serialize};

use super::Ready;
use super::ready::renumbered;
use crate::document::Document;
use crate::edit::{Edit, Field, copies, tree};
use crate::recovery::folder;

/// What an import gave, so that another can be told from it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Relative to the project.
    pub file: String,
    pub root: EntityId,
    /// As the file said it, with the file's ids.
    scene: Scene,
    /// The document's ids by the file's.
    entities: BTreeMap<EntityId, EntityId>,
    materials: BTreeMap<MaterialId, MaterialId>,
}

/// An entity by its place in a file: names from the root down, and which of those with one name.
type Place = Vec<(String, usize)>;

impl Record {
    pub fn new(
        ready: &Ready,
        root: EntityId,
        entities: &HashMap<EntityId, EntityId>,
        materials: &HashMap<MaterialId, MaterialId>,
    ) -> Self {
        let (entities, materials) = (
            entities.iter().map(|(a, b)| (*a, *b)).collect(),
            materials.iter().map(|(a, b)| (*a, *b)).collect(),
        );
        Self { file: ready.file.clone(), root, scene: ready.scene.clone(), entities, materials }
    }

    fn path(project: &Path, name: &str, root: EntityId) -> PathBuf {
        folder(project).join("imports").join(name).join(format!("{}.ron", root.0))
    }

    /// Of the scene's imports, those of a file. Damaged ones count as absent: their edits are all kept.
    pub fn all(project: &Path, name: &str, file: &str) -> Vec<Self> {
        let Ok(entries) = folder(project).join("imports").join(name).read_dir() else { return Vec::new() };
        let records = entries.flatten().filter_map(|entry| read::<Self>(&entry.path()).ok());
        let mut records: Vec<Self> = records.filter(|record| record.file == file).collect();
        records.sort_by_key(|record| record.root);
        records
    }

    pub fn save(&self, project: &Path, name: &str) -> Result<(), SceneError> {
        write(&Self::path(project, name, self.root), self)
    }
}

/// What importing the file again does to one placement of it, and what is to be known the next time.
pub fn reimport(document: &mut Document, record: &Record, ready: &Ready) -> (Edit, Record, Vec<Warning>) {
    let merge = Merge::new(document, record, ready);
    let materials = merge.materials(document);
    let entities = merge.entities(document);
    let (gone, warnings) = merge.gone(document);
    let name = format!("Import {} again", engine::scene::import::settings::stem(&ready.file));
    let edit = Edit::several(name, materials.into_iter().chain(entities).chain([gone]));
    let record = Record::new(ready, record.root, &merge.entities, &merge.materials);
    (edit, record, warnings)
}

struct Merge<'a> {
    record: &'a Record,
    ready: &'a Ready,
    /// The document's ids by those of the file as it is now.
    entities: HashMap<EntityId, EntityId>,
    materials: HashMap<MaterialId, MaterialId>,
    /// The file's old id by its new one.
    old_entity: HashMap<EntityId, EntityId>,
    old_material: HashMap<MaterialId, MaterialId>,
}

impl<'a> Merge<'a> {
    fn new(document: &mut Document, record: &'a Record, ready: &'a Ready) -> Self {
        let old_entity = matched(&places(&record.scene), &places(&ready.scene));
        let old_material = matched(&material_places(&record.scene), &material_places(&ready.scene));
        let mut id = |new: &Entity| {
            let known = old_entity.get(&new.id).and_then(|old| record.entities.get(old)).copied();
            (new.id, known.unwrap_or_else(|| document.new_entity_id()))
        };
        let entities = ready.scene.entities.iter().map(&mut id).collect();
        let mut id = |new: &Material| {
            let known = old_material.get(&new.id).and_then(|old| record.materials.get(old)).copied();
            (new.id, known.unwrap_or_else(|| document.new_material_id()))
        };
        let materials = ready.scene.materials.iter().map(&mut id).collect();
        Self { record, ready, entities, materials, old_entity, old_material }
    }

    /// A material that the user changed stays; one that is new or was deleted comes.
    fn materials(&self, document: &Document) -> Vec<Edit> {
        let (mut changed, mut new) = (Vec::new(), Vec::new());
        let end = document.scene().materials.len();
        for material in &self.ready.scene.materials {
            let mapped = renumbered(material, &self.materials);
            let Some(own) = document.material(mapped.id) else {
                new.push((end + new.len(), mapped));
                continue;
            };
            let before = self.old_material.get(&material.id).and_then(|old| self.record.scene.material(*old));
            let is_untouched = before.is_some_and(|old| Material { id: own.id, ..old.clone() } == *own);
            if is_untouched && mapped != *own {
                changed.push(mapped);
            }
        }
        vec![Edit::InsertMaterials(new), Edit::SetMaterials(changed)]
    }

    fn entities(&self, document: &Document) -> Vec<Edit> {
        let (mut fields, mut new) = (Vec::new(), Vec::new());
        for entity in &self.ready.scene.entities {
            let mapped = self.mapped(entity, &self.entities, &self.materials);
            let old = self.old_entity.get(&entity.id).and_then(|old| self.record.scene.entity(*old));
            match (document.entity(mapped.id), old) {
                (Some(own), Some(old)) => {
                    let ids = self.record.entities.iter().map(|(a, b)| (*a, *b)).collect();
                    let materials = self.record.materials.iter().map(|(a, b)| (*a, *b)).collect();
                    fields.extend(self.merged(own, &self.mapped(old, &ids, &materials), mapped));
                }
                // Deleted by the user: it stays so.
                (None, Some(_)) => {}
                (_, None) => new.push(mapped),
            }
        }
        vec![self.inserted(document, new), Edit::Set(fields)]
    }

    /// In the document's ids.
    fn mapped(
        &self,
        entity: &Entity,
        ids: &HashMap<EntityId, EntityId>,
        materials: &HashMap<MaterialId, MaterialId>,
    ) -> Entity {
        let mut mapped = entity.clone();
        copies::redirect(&mut mapped, ids, &|_| false);
        copies::redirect_materials(&mut mapped, materials);
        mapped
    }

    /// What the file changed and the user did not.
    fn merged(&self, own: &Entity, old: &Entity, new: Entity) -> Vec<(EntityId, Field)> {
        fn taken<T: PartialEq>(own: &T, old: &T, new: &T) -> bool {
            old != new && own == old
        }
        let mut fields = Vec::new();
        if taken(&own.transform, &old.transform, &new.transform) && own.id != self.record.root {
            fields.push(Field::Transform(Box::new(new.transform)));
        }
        if taken(&own.light, &old.light, &new.light) {
            fields.push(Field::Light(new.light.map(Box::new)));
        }
        if taken(&own.camera, &old.camera, &new.camera) {
            fields.push(Field::Camera(new.camera.map(Box::new)));
        }
        if taken(&own.motion, &old.motion, &new.motion) {
            fields.push(Field::Static(new.is_static));
            fields.push(Field::Motion(new.motion.map(Box::new)));
        }
        if let (Some(mesh), Some(before), Some(now)) = (&own.mesh, &old.mesh, &new.mesh) {
            let mut merged = mesh.clone();
            if taken(&mesh.mesh, &before.mesh, &now.mesh) {
                merged.mesh = now.mesh.clone();
            }
            if taken(&mesh.materials, &before.materials, &now.materials) {
                merged.materials.clone_from(&now.materials);
            }
            fields.push(Field::Mesh(Some(Box::new(merged))));
        } else if taken(&own.mesh, &old.mesh, &new.mesh) {
            fields.push(Field::Mesh(new.mesh.map(Box::new)));
        }
        fields.into_iter().map(|field| (own.id, field)).collect()
    }

    /// What the file has and had not, under its parent there, or under the root.
    fn inserted(&self, document: &Document, mut new: Vec<Entity>) -> Edit {
        let coming: HashSet<EntityId> = new.iter().map(|entity| entity.id).collect();
        let root = document.entity(self.record.root).map(|root| root.id);
        for entity in &mut new {
            let stands = |parent: &EntityId| coming.contains(parent) || document.entity(*parent).is_some();
            entity.parent = entity.parent.filter(stands).or(root);
        }
        let at = root
            .map_or(document.scene().entities.len(), |root| tree::end_of_subtree(document.indexed(), root));
        Edit::Insert((at..).zip(new).collect())
    }

    /// What the file had and has not any more goes, unless the user hung something of their own below it.
    fn gone(&self, document: &Document) -> (Edit, Vec<Warning>) {
        let still: HashSet<EntityId> = self.old_entity.values().copied().collect();
        let gone = self.record.entities.iter().filter(|(old, _)| !still.contains(old)).map(|(_, own)| *own);
        let gone: HashSet<EntityId> = gone.filter(|own| *own != self.record.root).collect();
        let scene = document.indexed();
        let is_free = |id: &EntityId| scene.subtree(*id).iter().all(|below| gone.contains(below));
        let (free, kept): (Vec<EntityId>, Vec<EntityId>) =
            gone.iter().copied().filter(|id| scene.entity(*id).is_some()).partition(is_free);
        let told = |id: &EntityId| {
            let name = scene.entity(*id).map_or("", |entity| &entity.name);
            Warning::new(name, "is not in the file any more; it stays for what stands under it")
        };
        let mut warnings: Vec<Warning> = kept.iter().map(told).collect();
        if free.is_empty() {
            return (Edit::Set(Vec::new()), warnings);
        }
        let (edit, forgotten) = tree::delete(scene, &free);
        warnings.extend(forgotten);
        (edit, warnings)
    }
}

/// The old id by the new one, of those that stand at one place.
fn matched<P: Eq + std::hash::Hash, I: Copy + Eq + std::hash::Hash>(
    old: &HashMap<P, I>,
    new: &HashMap<P, I>,
) -> HashMap<I, I> {
    new.iter().filter_map(|(place, id)| Some((*id, *old.get(place)?))).collect()
}

fn places(scene: &Scene) -> HashMap<Place, EntityId> {
    let mut taken: HashMap<(Option<EntityId>, &str), usize> = HashMap::new();
    let mut own: HashMap<EntityId, (String, usize, Option<EntityId>)> = HashMap::new();
    for entity in &scene.entities {
        let nth = taken.entry((entity.parent, &entity.name)).or_default();
        own.insert(entity.id, (entity.name.clone(), *nth, entity.parent));
        *nth += 1;
    }
    let place = |id: EntityId| {
        let above = std::iter::successors(own.get(&id), |(_, _, parent)| own.get(parent.as_ref()?));
        above.take(own.len()).map(|(name, nth, _)| (name.clone(), *nth)).collect()
    };
    scene.entities.iter().map(|entity| (place(entity.id), entity.id)).collect()
}

fn material_places(scene: &Scene) -> HashMap<(String, usize), MaterialId> {
    let mut taken: HashMap<&str, usize> = HashMap::new();
    let mut places = HashMap::new();
    for material in &scene.materials {
        let nth = taken.entry(&material.name).or_default();
        places.insert((material.name.clone(), *nth), material.id);
        *nth += 1;
    }
    places
}
