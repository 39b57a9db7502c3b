//! Copied entities as text, so that they can be pasted into another scene, another project, or a message: RON with the
//! entities, the materials that they use.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use engine::scene::file::{from_text, to_text};
use engine::scene::{Entity, EntityId, Material, MaterialId, Scene, Warning};
use serde::{Deserialize, Serialize};

use crate::document::Document;
use crate::edit::{Edit, copies, tree};

/// Of the text. Newer ones are refused.
const VERSION: u32 = 1;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Copied {
    hohlraum_clipboard: u32,
    /// Which scene they come from: in that one alone do references to what was not copied lead anywhere.
    origin: String,
    materials: Vec<Material>,
    /// Each before its children.
    entities: Vec<Entity>,
}

/// The entities and all under them.
pub fn copy(document: &Document, ids: &[EntityId]) -> Result<String, String> {
    let scene = document.indexed();
    let top = scene.topmost(ids);
    let mut entities: Vec<Entity> = top.iter().flat_map(|id| copies::subtree(scene, *id)).collect();
    for entity in entities.iter_mut().filter(|entity| top.contains(&entity.id)) {
        entity.parent = None;
    }
    let used: HashSet<MaterialId> = used_materials(&entities).collect();
    let materials = scene.scene().materials.iter().filter(|material| used.contains(&material.id)).cloned();
    let (materials, origin) = (materials.collect(), origin(document));
    let copied = Copied { hohlraum_clipboard: VERSION, origin, materials, entities };
    to_text(Path::new("clipboard"), &copied).map_err(|error| error.to_string())
}

/// Is it worth a try to paste?
pub fn can_paste(text: &str) -> bool {
    text.contains("hohlraum_clipboard")
}

/// What pasting under `parent` does, and the entities to select. What the project lacks is told: files that are not there,
/// references to entities that were not copied and are not here either.
pub fn paste(
    document: &mut Document,
    text: &str,
    parent: Option<EntityId>,
) -> Result<(Edit, Vec<EntityId>, Vec<Warning>), String> {
    let mut copied = read(text)?;
    let mut edits = Vec::new();
    let materials = pasted_materials(document, &copied.materials, &mut edits);
    let new = copies::renumbered(copied.entities.iter(), &mut || document.new_entity_id());
    let is_home = copied.origin == origin(document);
    let scene = document.indexed();
    let is_here = |id: EntityId| is_home && scene.entity(id).is_some();
    let parent = parent.filter(|parent| scene.entity(*parent).is_some());
    let warnings = missing(document.project(), &is_here, &copied, &new);
    let mut names = copies::Names::beside(scene);
    let mut top = Vec::new();
    for entity in &mut copied.entities {
        entity.parent = entity.parent.filter(|parent| new.contains_key(parent));
        copies::redirect(entity, &new, &is_here);
        copies::redirect_materials(entity, &materials);
        if entity.parent.is_none() {
            entity.parent = parent;
            entity.name = names.free(parent, &entity.name);
            top.push(entity.id);
        }
    }
    let at = parent.map_or(scene.scene().entities.len(), |parent| tree::end_of_subtree(scene, parent));
    edits.push(Edit::Insert((at..).zip(copied.entities).collect()));
    Ok((Edit::several(format!("Paste {} objects", top.len()), edits), top, warnings))
}

/// Nothing that a text says is believed before it was checked as a scene is.
fn read(text: &str) -> Result<Copied, String> {
    let copied: Copied = from_text(Path::new("clipboard"), text)
        .map_err(|error| format!("what was copied is not of this program: {error}"))?;
    if copied.hohlraum_clipboard > VERSION {
        return Err("what was copied is of a newer version of this program".to_owned());
    }
    let mut alone =
        Scene { materials: copied.materials.clone(), entities: copied.entities.clone(), ..Scene::default() };
    // References may lead to what was not copied.
    let itself = copied.entities.iter().map(|entity| (entity.id, entity.id)).collect();
    alone.entities.iter_mut().for_each(|entity| copies::redirect(entity, &itself, &|_| false));
    alone.validate().map_err(|error| format!("what was copied cannot be pasted: {error}"))?;
    Ok(copied)
}

/// A scene by its place, and not told to whom the text is sent.
fn origin(document: &Document) -> String {
    let path = document.path();
    let path = std::path::absolute(&path).unwrap_or(path);
    blake3::hash(path.to_string_lossy().as_bytes()).to_hex().to_string()
}

/// A material that the scene has under the same name and with the same values is used again.
fn pasted_materials(
    document: &mut Document,
    copied: &[Material],
    edits: &mut Vec<Edit>,
) -> HashMap<MaterialId, MaterialId> {
    let mut new = HashMap::new();
    let mut inserted = Vec::new();
    let end = document.scene().materials.len();
    for material in copied {
        let same = |own: &&Material| Material { id: own.id, ..material.clone() } == **own;
        let own = document.scene().materials.iter().find(same).map(|own| own.id);
        let id = own.unwrap_or_else(|| document.new_material_id());
        if own.is_none() {
            inserted.push((end + inserted.len(), Material { id, ..material.clone() }));
        }
        new.insert(material.id, id);
    }
    if !inserted.is_empty() {
        edits.push(Edit::InsertMaterials(inserted));
    }
    new
}

fn used_materials(entities: &[Entity]) -> impl Iterator<Item = MaterialId> {
    entities.iter().filter_map(|entity| entity.mesh.as_ref()).flat_map(|mesh| mesh.materials.iter().copied())
}

fn missing(
    project: &Path,
    is_here: &dyn Fn(EntityId) -> bool,
    copied: &Copied,
    new: &HashMap<EntityId, EntityId>,
) -> Vec<Warning> {
    let mut warnings = Vec::new();
    for entity in &copied.entities {
        let reflection = entity.mesh.iter().map(|mesh| &mesh.reflection);
        let mut referred =
            reflection.flat_map(|one| one.anchor.into_iter().chain(one.probes.iter().flatten().copied()));
        if referred.any(|id| !new.contains_key(&id) && !is_here(id)) {
            warnings.push(Warning::new(
                &entity.name,
                "its reflections referred to what was not copied: they forget it",
            ));
        }
    }
    let alone =
        Scene { materials: copied.materials.clone(), entities: copied.entities.clone(), ..Scene::default() };
    let absent = crate::assets::references(&alone).into_keys().filter(|file| !project.join(file).is_file());
    warnings
        .extend(absent.map(|file| Warning::new(&file, "is not in this project: import it, or relink it")));
    warnings
}
