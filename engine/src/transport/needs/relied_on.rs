//! What leaving a feature out relies on, as text to be hashed: where it differs from what it was, an omission is stale.
//!
//! Most omissions rely on nothing but that nobody needs the feature. Where something is folded into numbers that were
//! made once (light that was solved, rows that are gone), all that those numbers were made of is in it: albedo and
//! emission, the sky, lights with their places. What `changes: intensity` lets change is not: those numbers are times a
//! brightness. Geometry is not either: whatever is made of rows is stale with them ([`crate::transport::key`]).

use std::fmt::Write;

use glam::Vec3;

use super::look::{Drawn, Look};
use super::sources::{changes_of, lights};
use super::{Finding, finding};
use crate::scene::assets::Assets;
use crate::scene::{Changes, Feature, Light, LightKind, Material, Scene, Sky, SkyKind, Texture};
use crate::transport::key::of_picture;

/// The same, short: what an omission carries.
pub fn grounds(feature: Feature, scene: &Scene, assets: &Assets) -> String {
    blake3::hash(relied_on(feature, scene, assets).as_bytes()).to_hex().to_string()
}

pub fn relied_on(feature: Feature, scene: &Scene, assets: &Assets) -> String {
    let forced = Default::default();
    // Whatever the order of the hierarchy.
    let mut scene = scene.clone();
    scene.entities.sort_by_key(|entity| entity.id);
    let look = Look::at_scene(&scene, assets, &forced);
    let Finding { needed, .. } = finding(feature, &look);
    let mut facts = format!("{feature:?} {needed}\n");
    match feature {
        Feature::Matrix => {
            facts += &surfaces(&look, Some(Shines::AsItDoes));
            facts += &sky(&look);
            facts += &lamps(&look, Shines::AsItDoes);
        }
        Feature::BlackPatches => facts += &surfaces(&look, Some(Shines::Somehow)),
        Feature::UnlitPatches => {
            facts += &surfaces(&look, Some(Shines::Somehow));
            facts += &format!("{}", scene.sky.kind != SkyKind::None);
            facts += &lamps(&look, Shines::Somehow);
        }
        // By the cavity gain, and by the means of patches.
        Feature::CoarseCorrection | Feature::Colour => facts += &surfaces(&look, None),
        _ => {}
    }
    facts
}

/// How exactly what shines is known.
#[derive(Clone, Copy, PartialEq)]
enum Shines {
    /// But for what may be dimmed.
    AsItDoes,
    /// Whether, and on what.
    Somehow,
}

/// Static surfaces with their materials; and what these emit.
fn surfaces(look: &Look<'_>, shines: Option<Shines>) -> String {
    let mut facts = String::new();
    let mut used = Vec::new();
    for drawn in look.still() {
        let Drawn { entity, renderer, .. } = drawn;
        let _ = writeln!(facts, "{} {:?} {}", entity.id.0, renderer.materials, renderer.casts_shadows);
        used.extend(look.materials_of(drawn));
    }
    used.sort_by_key(|material| material.id);
    used.dedup_by_key(|material| material.id);
    for material in used {
        facts += &reflects(look, material);
        facts += &shines.map_or(String::new(), |shines| gives_off(look, material, shines));
    }
    facts
}

fn reflects(look: &Look<'_>, material: &Material) -> String {
    let Material { id, albedo, metallic, alpha, opacity, unlit, .. } = material;
    let pictures =
        [&albedo.texture, &material.metallic_roughness_texture].map(|texture| picture(look, texture));
    format!("{id:?} {:?} {metallic} {alpha:?} {opacity} {unlit} {pictures:?}\n", albedo.color)
}

fn gives_off(look: &Look<'_>, material: &Material, shines: Shines) -> String {
    let emission = &material.emission;
    let radiance = emission.radiance();
    let of = match (shines, emission.changes) {
        (Shines::Somehow, _) => is_light(radiance),
        (_, Changes::Intensity) => spectrum(emission.color),
        _ => format!("{radiance:?}"),
    };
    format!("  {of} {:?} {}\n", emission.changes, picture(look, &emission.texture))
}

fn is_light(radiance: Vec3) -> String {
    format!("{}", radiance.max_element() > 0.0)
}

/// Whatever its brightness; to as many digits as a change of brightness leaves.
fn spectrum(color: Vec3) -> String {
    let [r, g, b] = (color / color.max_element().max(f32::MIN_POSITIVE)).to_array();
    format!("{r:.4} {g:.4} {b:.4}")
}

fn picture(look: &Look<'_>, texture: &Option<Texture>) -> String {
    texture.as_ref().map_or(String::new(), |texture| {
        let pixels =
            look.assets.images.get(&texture.image).map_or(String::new(), |picture| of_picture(picture));
        format!("{texture:?} {pixels}")
    })
}

fn sky(look: &Look<'_>) -> String {
    let Sky { kind, changes } = &look.scene.sky;
    let dims = *changes == Changes::Intensity;
    let of = match kind {
        SkyKind::None => String::new(),
        SkyKind::Constant { radiance } if dims => spectrum(*radiance),
        SkyKind::Constant { radiance } => format!("{radiance:?}"),
        SkyKind::Gradient { zenith, horizon, ground, .. } => {
            let all = [*zenith, *horizon, *ground];
            let brightest = all.iter().map(|part| part.max_element()).fold(f32::MIN_POSITIVE, f32::max);
            let parts = all.map(|part| if dims { relative(part, brightest) } else { format!("{part:?}") });
            format!("gradient {parts:?}")
        }
        SkyKind::Picture { image, strength, turn } => {
            let pixels = look.assets.images.get(image).map_or(String::new(), |picture| of_picture(picture));
            let strength = if dims { String::new() } else { format!("{strength}") };
            format!("{image:?} {pixels} {turn} {strength}")
        }
    };
    format!("sky {changes:?} {of}\n")
}

fn relative(color: Vec3, brightest: f32) -> String {
    let [r, g, b] = (color / brightest).to_array();
    format!("{r:.4} {g:.4} {b:.4}")
}

/// Lights that may shine, where they stand.
fn lamps(look: &Look<'_>, shines: Shines) -> String {
    let mut facts = String::new();
    for (index, entity, light) in lights(look) {
        let power = match (shines, changes_of(light)) {
            (Shines::Somehow, _) => String::new(),
            (_, Changes::Intensity) => spectrum(light.color),
            _ => format!("{:?}", light.power()),
        };
        let Light { range, casts_shadows, changes, .. } = light;
        let changes = (shines == Shines::AsItDoes).then_some((changes, light.switching.is_some()));
        let place = look.world[index].to_cols_array().map(f64::to_bits);
        let cone = match light.kind {
            LightKind::Spot { inner, outer } => [inner, outer],
            _ => [0.0; 2],
        };
        let kind = std::mem::discriminant(&light.kind);
        let carried = look.carried[index];
        let _ = writeln!(
            facts,
            "light {} {kind:?} {cone:?} {range:?} {casts_shadows} {changes:?} {power} {place:x?} {carried}",
            entity.id.0
        );
    }
    facts
}

#[cfg(test)]
mod tests {
    use super::super::made::{emitter, lamp, material, never, scene, wall};
    use super::*;
    use crate::scene::{Entity, Transform};

    fn facts(feature: Feature, scene: &Scene) -> String {
        relied_on(feature, scene, &Assets::default())
    }

    fn room(light: Light) -> Scene {
        Scene { materials: vec![material(0)], ..scene(vec![wall(1), lamp(2, light)]) }
    }

    #[test]
    fn solved_light_relies_on_albedo_emission_sky_and_lights_with_their_places() {
        let still = room(never());
        let edits: [fn(&mut Scene); 6] = [
            |scene| scene.materials[0].albedo.color.x = 0.5,
            |scene| scene.materials[0].emission.color.x = 0.5,
            |scene| scene.sky.kind = SkyKind::Constant { radiance: Vec3::ONE },
            |scene| scene.entities[1].transform.translation.x += 1.0,
            |scene| scene.entities[1].light.iter_mut().for_each(|light| light.intensity = 3.0),
            |scene| scene.entities[0].mesh.iter_mut().for_each(|mesh| mesh.casts_shadows = false),
        ];
        for (which, edit) in edits.into_iter().enumerate() {
            let mut edited = still.clone();
            edit(&mut edited);
            assert_ne!(facts(Feature::Matrix, &still), facts(Feature::Matrix, &edited), "edit {which}");
        }
    }

    #[test]
    fn the_order_of_the_hierarchy_is_not_relied_on() {
        let still = room(never());
        let mut turned = still.clone();
        turned.entities.reverse();
        for feature in Feature::ALL {
            assert_eq!(facts(feature, &still), facts(feature, &turned), "{feature:?}");
        }
    }

    #[test]
    fn brightness_that_may_change_is_not_relied_on_and_colour_is() {
        let dimmed = room(Light { changes: Changes::Intensity, color: Vec3::new(1.0, 0.7, 0.3), ..never() });
        let with = |edit: fn(&mut Light)| {
            let mut scene = dimmed.clone();
            scene.entities[1].light.iter_mut().for_each(edit);
            facts(Feature::Matrix, &scene)
        };
        let before = facts(Feature::Matrix, &dimmed);
        assert_eq!(before, with(|light| light.intensity *= 0.37));
        assert_eq!(before, with(|light| light.color *= 0.37));
        assert_eq!(before, with(|light| light.on = false));
        assert_ne!(before, with(|light| light.color.y = 0.1));
        let mut glowing = room(never());
        glowing.materials[0] = emitter(0, Changes::Intensity);
        let before = facts(Feature::Matrix, &glowing);
        glowing.materials[0].emission.strength = 7.0;
        assert_eq!(before, facts(Feature::Matrix, &glowing));
        glowing.materials[0].emission.color.z = 0.0;
        assert_ne!(before, facts(Feature::Matrix, &glowing));
    }

    #[test]
    fn unlit_rooms_rely_on_where_lights_are_and_not_on_how_bright() {
        let still = room(never());
        let mut bright = still.clone();
        bright.entities[1].light.iter_mut().for_each(|light| light.intensity = 9.0);
        assert_eq!(facts(Feature::UnlitPatches, &still), facts(Feature::UnlitPatches, &bright));
        let mut moved = still.clone();
        moved.entities[1].transform = Transform { translation: glam::DVec3::X, ..Transform::default() };
        assert_ne!(facts(Feature::UnlitPatches, &still), facts(Feature::UnlitPatches, &moved));
    }

    #[test]
    fn what_nobody_needs_relies_on_that_alone() {
        let still = room(never());
        let mut more = still.clone();
        more.entities.push(Entity { id: crate::scene::EntityId(7), ..wall(7) });
        more.materials[0].albedo.color.x = 0.1;
        for feature in [Feature::LightProbes, Feature::Sky, Feature::Directional, Feature::Holes] {
            assert_eq!(facts(feature, &still), facts(feature, &more), "{feature:?}");
        }
        more.entities.push(super::super::made::ball(8));
        more.entities.push(super::super::made::probes(9));
        assert_ne!(facts(Feature::LightProbes, &still), facts(Feature::LightProbes, &more));
    }
}
