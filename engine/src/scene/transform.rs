//! Where an entity stands in its parent, in f64 so that a scene far from the origin keeps its shape.

use std::collections::HashMap;

use glam::{DAffine3, DMat3, DQuat, DVec3};
use serde::{Deserialize, Serialize};

use super::{EntityId, Scene};

/// `parent_from_local` = translate * rotate * scale. A negative scale mirrors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Transform {
    #[serde(default)]
    pub translation: DVec3,
    #[serde(default)]
    pub rotation: DQuat,
    #[serde(default = "one")]
    pub scale: DVec3,
}

fn one() -> DVec3 {
    DVec3::ONE
}

impl Default for Transform {
    fn default() -> Self {
        Self { translation: DVec3::ZERO, rotation: DQuat::IDENTITY, scale: DVec3::ONE }
    }
}

impl Transform {
    pub fn at(translation: DVec3) -> Self {
        Self { translation, ..Self::default() }
    }

    pub fn parent_from_local(&self) -> DAffine3 {
        DAffine3::from_scale_rotation_translation(self.scale, self.rotation, self.translation)
    }

    pub fn is_finite(&self) -> bool {
        self.translation.is_finite() && self.rotation.is_finite() && self.scale.is_finite()
    }
}

/// `world_from_local` of every entity, in the scene's order. Parents that do not exist or that stand
/// in a circle count as none ([`Scene::validate`] refuses both).
pub fn world_from_local(scene: &Scene) -> Vec<DAffine3> {
    world_from_local_of(scene, |index| scene.entities[index].transform.parent_from_local())
}

/// The same, with `parent_from_local` of each entity (by its index) given by the caller: motion, a drag.
pub fn world_from_local_of(scene: &Scene, parent_from_local: impl Fn(usize) -> DAffine3) -> Vec<DAffine3> {
    let index_of: HashMap<EntityId, usize> =
        scene.entities.iter().enumerate().map(|(index, entity)| (entity.id, index)).collect();
    let mut world: Vec<Option<DAffine3>> = vec![None; scene.entities.len()];
    let mut chain = Vec::new();
    let mut on_chain = vec![false; scene.entities.len()];
    for start in 0..scene.entities.len() {
        // Up to the first ancestor that is known, then down again.
        let mut at = Some(start);
        while let Some(index) = at {
            if world[index].is_some() || on_chain[index] {
                break;
            }
            chain.push(index);
            on_chain[index] = true;
            at = scene.entities[index].parent.and_then(|parent| index_of.get(&parent).copied());
        }
        while let Some(index) = chain.pop() {
            let parent = scene.entities[index].parent.and_then(|parent| index_of.get(&parent).copied());
            let world_from_parent = parent.and_then(|parent| world[parent]).unwrap_or(DAffine3::IDENTITY);
            world[index] = Some(world_from_parent * parent_from_local(index));
        }
    }
    world.into_iter().map(|world| world.unwrap_or(DAffine3::IDENTITY)).collect()
}

/// The matrix that takes normals along: the cofactors, which exist for singular scales too and carry
/// the sign of a mirror.
pub fn normal_matrix(world_from_local: &DAffine3) -> DMat3 {
    let m = world_from_local.matrix3;
    let cofactors =
        DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
    if m.determinant() < 0.0 { cofactors * -1.0 } else { cofactors }
}
