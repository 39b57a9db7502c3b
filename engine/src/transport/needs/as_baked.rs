//! The scene as a bake has it: without what is left out of it before any ray. Whoever bakes it, or asks what a bake of
//! it depends on, then needs to know nothing of features; nor of the order of the hierarchy.

use std::collections::BTreeMap;

use super::Look;
use crate::scene::assets::Assets;
use crate::scene::{Alpha, Feature, Forced, Scene, SkyKind};

/// Entities stand in the order of their ids: one that is dragged to another place among its siblings bakes to the same
/// bytes. Idempotent. What is drawn is the scene as it was authored.
pub fn as_baked(scene: &Scene, assets: &Assets, forced: &BTreeMap<Feature, Forced>) -> Scene {
    let look = Look::at_scene(scene, assets, forced);
    let [probes, sky, directional, holes] =
        [Feature::LightProbes, Feature::Sky, Feature::Directional, Feature::Holes]
            .map(|feature| look.has(feature));
    let mut baked = scene.clone();
    baked.entities.sort_by_key(|entity| entity.id);
    if !probes {
        baked.entities.iter_mut().for_each(|entity| entity.light_probes = None);
    }
    if !sky {
        baked.sky.kind = SkyKind::None;
    }
    for material in &mut baked.materials {
        material.normal_texture = material.normal_texture.take().filter(|_| directional);
        if !holes {
            material.alpha = Alpha::Opaque;
        }
    }
    baked
}

#[cfg(test)]
mod tests {
    use super::super::made::{ball, forced, gradient, material, picture, probes, scene, wall};
    use super::*;
    use crate::scene::{Material, Sky, Texture};

    fn everything() -> Scene {
        let fence = Material {
            normal_texture: Some(Texture::new(picture())),
            alpha: Alpha::Mask { cutoff: 0.5 },
            ..material(0)
        };
        Scene {
            sky: Sky { kind: gradient(), ..Sky::default() },
            materials: vec![fence],
            ..scene(vec![wall(1), ball(2), probes(3)])
        }
    }

    #[test]
    fn what_is_needed_is_baked_as_it_was_authored() {
        assert_eq!(as_baked(&everything(), &Assets::default(), &forced()), everything());
    }

    #[test]
    fn the_order_of_the_hierarchy_is_no_matter() {
        let mut turned = everything();
        turned.entities.reverse();
        assert_eq!(as_baked(&turned, &Assets::default(), &forced()), everything());
    }

    #[test]
    fn without_what_moves_no_probes_are_baked() {
        let mut still = everything();
        still.entities.remove(1);
        let baked = as_baked(&still, &Assets::default(), &forced());
        assert!(baked.entities.iter().all(|entity| entity.light_probes.is_none()));
        assert_eq!(as_baked(&baked, &Assets::default(), &forced()), baked);
        let asked = [(Feature::LightProbes, Forced::In)].into();
        assert_eq!(as_baked(&still, &Assets::default(), &asked), still);
    }

    #[test]
    fn what_is_forced_out_is_not_baked() {
        let all = [Feature::LightProbes, Feature::Sky, Feature::Directional, Feature::Holes];
        let out = all.map(|feature| (feature, Forced::Out)).into();
        let baked = as_baked(&everything(), &Assets::default(), &out);
        let Material { normal_texture, alpha, .. } = &baked.materials[0];
        assert!(normal_texture.is_none() && *alpha == Alpha::Opaque && baked.sky.kind == SkyKind::None);
        assert!(baked.entities[2].light_probes.is_none());
    }
}
