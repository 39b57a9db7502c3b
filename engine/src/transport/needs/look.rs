//! What rules look at: the scene, what it refers to, and the bake where there is one; with what several rules ask of
//! them answered once.

use std::cell::OnceCell;
use std::collections::{BTreeMap, HashMap};

use glam::DAffine3;

use super::{Cost, Sizes, finding};
use crate::scene::assets::Assets;
use crate::scene::{
    Entity, EntityId, Feature, Forced, Material, MaterialId, MeshRenderer, Scene, world_from_local,
};
use crate::transport::Transport;
use crate::transport::materials::{self, PatchMaterials};

pub struct Look<'a> {
    pub scene: &'a Scene,
    pub assets: &'a Assets,
    pub forced: &'a BTreeMap<Feature, Forced>,
    /// With its rows: the bake is there.
    pub transport: Option<&'a Transport>,
    /// Counted, or about.
    pub sizes: Sizes,
    pub cost: Cost,
    /// Entity by entity: `world_from_local` as authored; hidden, itself or by a parent; carried about by a motion of its
    /// own or of a parent.
    pub world: Vec<DAffine3>,
    pub hidden: Vec<bool>,
    pub carried: Vec<bool>,
    material_of: HashMap<MaterialId, &'a Material>,
    patch_materials: OnceCell<PatchMaterials>,
    has: [OnceCell<bool>; Feature::ALL.len()],
}

/// Something that is drawn.
#[derive(Clone, Copy)]
pub struct Drawn<'a> {
    pub index: usize,
    pub entity: &'a Entity,
    pub renderer: &'a MeshRenderer,
}

impl<'a> Look<'a> {
    /// Before any ray.
    pub fn at_scene(scene: &'a Scene, assets: &'a Assets, forced: &'a BTreeMap<Feature, Forced>) -> Self {
        let index_of = scene.entities.iter().enumerate().map(|(index, entity)| (entity.id, index)).collect();
        let any_above = |is: fn(&Entity) -> bool| {
            (0..scene.entities.len()).map(|index| above(scene, &index_of, index).any(is)).collect()
        };
        Self {
            scene,
            assets,
            forced,
            transport: None,
            sizes: Sizes::default(),
            cost: Cost::default(),
            world: world_from_local(scene),
            hidden: any_above(|entity| entity.hidden),
            carried: any_above(|entity| entity.motion.is_some()),
            material_of: scene.materials.iter().map(|material| (material.id, material)).collect(),
            patch_materials: OnceCell::new(),
            has: Default::default(),
        }
    }

    /// After the bake. A transport whose rows are gone tells what the scene tells.
    pub fn at_transport(
        scene: &'a Scene,
        assets: &'a Assets,
        transport: &'a Transport,
        forced: &'a BTreeMap<Feature, Forced>,
    ) -> Self {
        let is_whole = transport.patch_from_patch.len() == transport.patches.len();
        let transport = Some(transport).filter(|_| is_whole);
        let sizes = transport.map_or(Sizes::default(), Sizes::of);
        Self { transport, sizes, ..Self::at_scene(scene, assets, forced) }
    }

    /// What of the scene is there, though not baked: for a plan.
    pub fn sized(self, sizes: Sizes) -> Self {
        Self { sizes, ..self }
    }

    /// What rays and entries cost on this machine, so that savings are told in time, too.
    pub fn costing(self, cost: Cost) -> Self {
        Self { cost, ..self }
    }

    /// Is a feature there, as its rule finds or as it is forced?
    pub fn has(&self, feature: Feature) -> bool {
        *self.has[feature as usize].get_or_init(|| match self.forced.get(&feature) {
            Some(forced) => *forced == Forced::In,
            None => finding(feature, self).needed,
        })
    }

    /// What is seen and not hidden.
    pub fn visible(&self) -> impl Iterator<Item = (usize, &'a Entity)> + '_ {
        self.scene.entities.iter().enumerate().filter(|(index, _)| !self.hidden[*index])
    }

    pub fn drawn(&self) -> impl Iterator<Item = Drawn<'a>> + '_ {
        let drawn = |(index, entity): (usize, &'a Entity)| {
            Some(Drawn { index, entity, renderer: entity.mesh.as_ref()? })
        };
        self.visible().filter_map(drawn)
    }

    /// What is baked.
    pub fn still(&self) -> impl Iterator<Item = Drawn<'a>> + '_ {
        self.drawn().filter(|drawn| drawn.entity.is_static)
    }

    /// What moves, or may: drawn each frame where it is, and in no bake.
    pub fn movers(&self) -> impl Iterator<Item = Drawn<'a>> + '_ {
        self.drawn().filter(|drawn| !drawn.entity.is_static)
    }

    /// Materials that something drawn names and the scene has.
    pub fn materials_of(&self, drawn: Drawn<'a>) -> impl Iterator<Item = &'a Material> + '_ {
        drawn.renderer.materials.iter().filter_map(|id| self.material_of.get(id).copied())
    }

    /// Those whose materials hold something.
    pub fn with_material(
        &self,
        drawn: impl Iterator<Item = Drawn<'a>>,
        holds: impl Fn(&Material) -> bool,
    ) -> Vec<Drawn<'a>> {
        drawn.filter(|drawn| self.materials_of(*drawn).any(&holds)).collect()
    }

    /// By patch; none before the bake.
    pub fn patch_materials(&self) -> Option<&PatchMaterials> {
        let transport = self.transport?;
        Some(self.patch_materials.get_or_init(|| materials::of_patches(transport, self.scene, self.assets)))
    }

    pub fn name(&self, entity: EntityId) -> &'a str {
        self.scene.entity(entity).map_or("", |entity| entity.name.as_str())
    }
}

/// An entity and all that it stands under.
fn above<'a>(
    scene: &'a Scene,
    index_of: &HashMap<EntityId, usize>,
    index: usize,
) -> impl Iterator<Item = &'a Entity> {
    let parent = |entity: &&'a Entity| Some(&scene.entities[*index_of.get(&entity.parent?)?]);
    // No chain is longer than there are entities: a circle ends too.
    std::iter::successors(Some(&scene.entities[index]), parent).take(scene.entities.len() + 1)
}

/// "`a`, `b` and 3 more", and what leads to them.
pub fn told<'a>(entities: impl IntoIterator<Item = &'a Entity>) -> (String, Vec<EntityId>) {
    let (names, ids): (Vec<String>, Vec<EntityId>) =
        entities.into_iter().map(|entity| (format!("`{}`", entity.name), entity.id)).unzip();
    (listed(&names), ids)
}

pub fn listed(names: &[String]) -> String {
    const NAMED: usize = 3;
    match names {
        [] => "nothing".to_owned(),
        [only] => only.clone(),
        [first @ .., last] if names.len() <= NAMED => format!("{} and {last}", first.join(", ")),
        _ => format!("{} and {} more", names[..NAMED].join(", "), names.len() - NAMED),
    }
}

pub fn entities(drawn: &[Drawn<'_>]) -> (String, Vec<EntityId>) {
    told(drawn.iter().map(|drawn| drawn.entity))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_few_names_are_told_and_the_others_counted() {
        let names: Vec<String> = (0..5).map(|k| format!("`{k}`")).collect();
        assert_eq!(listed(&names[..1]), "`0`");
        assert_eq!(listed(&names[..2]), "`0` and `1`");
        assert_eq!(listed(&names[..3]), "`0`, `1` and `2`");
        assert_eq!(listed(&names), "`0`, `1`, `2` and 2 more");
    }
}
