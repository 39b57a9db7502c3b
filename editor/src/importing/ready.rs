//! What an import gives: a scene of its own, which becomes part of the document's by one edit.

use std::collections::HashMap;
use std::sync::Arc;

use engine::scene::assets::Assets;
use engine::scene::import::settings::stem;
use engine::scene::{Entity, EntityId, Material, MaterialId, Scene, Transform, Warning};
use glam::DVec3;

use super::Record;
use crate::document::Document;
use crate::edit::{Edit, copies, tree};

pub struct Ready {
    /// Relative to the project.
    pub file: String,
    /// With ids of its own.
    pub scene: Scene,
    /// All that the scene refers to, loaded.
    pub assets: Arc<Assets>,
    pub warnings: Vec<Warning>,
    /// Where the file stands in the scene already, if that was asked for.
    pub records: Vec<Record>,
}

impl Ready {
    /// What placing it does: everything under one root, whose origin comes to stand at `place`. Also the root, and what
    /// importing it again has to know, to be saved when the edit was taken.
    pub fn place(&self, document: &mut Document, place: DVec3) -> (Edit, EntityId, Record) {
        self.place_under(document, place, None)
    }

    /// Likewise under an entity, whose own origin is `place` 0.
    pub fn place_under(
        &self,
        document: &mut Document,
        place: DVec3,
        parent: Option<EntityId>,
    ) -> (Edit, EntityId, Record) {
        let parent = parent.filter(|parent| document.entity(*parent).is_some());
        let ids = copies::renumbered(self.scene.entities.iter(), &mut || document.new_entity_id());
        let materials = self.material_ids(document);
        let mut entities: Vec<Entity> = self.scene.entities.clone();
        for entity in &mut entities {
            copies::redirect(entity, &ids, &|_| false);
            copies::redirect_materials(entity, &materials);
        }
        let root = self.root(document, &mut entities, place, parent);
        let record = Record::new(self, root, &ids, &materials);
        let first = match parent {
            Some(parent) => tree::end_of_subtree(document.indexed(), parent),
            None => document.scene().entities.len(),
        };
        let new = self.scene.materials.iter().map(|material| renumbered(material, &materials));
        let edits = [
            Edit::InsertMaterials((document.scene().materials.len()..).zip(new).collect()),
            Edit::Insert((first..).zip(entities).collect()),
        ];
        (Edit::several(format!("Import {}", stem(&self.file)), edits), root, record)
    }

    fn material_ids(&self, document: &mut Document) -> HashMap<MaterialId, MaterialId> {
        self.scene.materials.iter().map(|material| (material.id, document.new_material_id())).collect()
    }

    /// The only root there is, or a new one above all roots.
    fn root(
        &self,
        document: &mut Document,
        entities: &mut Vec<Entity>,
        place: DVec3,
        parent: Option<EntityId>,
    ) -> EntityId {
        let roots: Vec<usize> = (0..entities.len()).filter(|&at| entities[at].parent.is_none()).collect();
        let at = if let [only] = roots[..] {
            entities[only].transform.translation += place;
            only
        } else {
            let id = document.new_entity_id();
            roots.iter().for_each(|&at| entities[at].parent = Some(id));
            let transform = Transform::at(place);
            entities.insert(0, Entity { id, name: stem(&self.file), transform, ..Entity::default() });
            0
        };
        entities[at].parent = parent;
        entities[at].name = copies::Names::beside(document.indexed()).free(parent, &entities[at].name);
        entities[at].id
    }
}

pub fn renumbered(material: &Material, ids: &HashMap<MaterialId, MaterialId>) -> Material {
    Material { id: ids.get(&material.id).copied().unwrap_or(material.id), ..material.clone() }
}
