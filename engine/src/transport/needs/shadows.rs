//! Shadow maps are for lights that cast.

use super::look::{Look, told};
use super::sources::may_shine;
use super::{Finding, Saving};
use crate::scene::{Entity, LightKind};

/// Some light that may shine casts shadows.
pub fn shadow_maps(look: &Look<'_>) -> Finding {
    let lights: Vec<&Entity> =
        look.visible().map(|(_, entity)| entity).filter(|e| e.light.is_some()).collect();
    let casts = |entity: &&&Entity| {
        entity.light.as_ref().is_some_and(|light| light.casts_shadows && may_shine(light))
    };
    let casting: Vec<&Entity> = lights.iter().filter(casts).copied().collect();
    let saving = saving(look, &casting);
    if casting.is_empty() {
        let (_, ids) = told(lights.iter().copied());
        let why = if lights.is_empty() { "the scene has no light" } else { "no light casts shadows" };
        return Finding::not_needed(why).led_to(ids).saves(saving);
    }
    let (names, ids) = told(casting);
    Finding::needed(format!("lights that cast them: {names}"), ids).saves(saving)
}

/// About: maps of the size that a few lights of a kind get, of four bytes a texel.
fn saving(look: &Look<'_>, casting: &[&Entity]) -> Saving {
    let texels = |entity: &&Entity| match entity.light.as_ref().map(|light| light.kind) {
        Some(LightKind::Sun) => 4 * 2048 * 2048,
        Some(LightKind::Spot { .. }) => 1024 * 1024,
        Some(LightKind::Point) => 6 * 512 * 512,
        None => 0,
    };
    let bytes = 4 * casting.iter().map(texels).sum::<u64>();
    look.cost.memory(bytes, bytes)
}

#[cfg(test)]
mod tests {
    use super::super::made::{forced, lamp, scene, wall};
    use super::*;
    use crate::scene::assets::Assets;
    use crate::scene::{Changes, EntityId, Light};

    fn found(entities: Vec<Entity>) -> Finding {
        let (scene, assets, forced) = (scene(entities), Assets::default(), forced());
        shadow_maps(&Look::at_scene(&scene, &assets, &forced))
    }

    #[test]
    fn shadow_maps_are_for_lights_that_cast_and_may_shine() {
        let light = Light::default();
        let found = |light| found(vec![wall(1), lamp(2, light)]);
        let wanted = found(light.clone());
        assert!(
            wanted.needed && wanted.entities == [EntityId(2)] && wanted.saving.gpu_bytes > 0,
            "{wanted:?}"
        );
        assert!(!found(Light { casts_shadows: false, ..light.clone() }).needed);
        let off = Light { on: false, ..light };
        assert!(found(off.clone()).needed, "it may be switched on");
        assert!(!found(Light { changes: Changes::Never, ..off }).needed, "it stays off");
    }

    #[test]
    fn a_scene_without_lights_has_none() {
        assert_eq!(found(vec![wall(1)]).why, "the scene has no light");
    }
}
