//! What shines, how freely it may change, and what follows: whether light is solved while the scene plays.
//!
//! Only what shines is asked how it changes. Albedo may be marked as free, too, but nothing in the player changes it, and
//! an albedo that changed in the file makes a bake's omission stale ([`super::relied_on`]).

use glam::Vec3;

use super::look::{Look, entities, listed, told};
use super::saving::{VECTOR, bytes};
use super::{Finding, Saving};
use crate::scene::{Changes, Emission, Entity, EntityId, Feature, Light, Material, SkyKind};

/// Responses up to which nobody counts their bytes, and the most of them: they are added up where one is dimmed.
const FEW_RESPONSES: u64 = 4;
const MOST_RESPONSES: u64 = 64;

/// Something that light comes from.
pub struct Source {
    /// "light `lamp`".
    pub name: String,
    pub entities: Vec<EntityId>,
    pub changes: Changes,
}

/// All that may shine onto static surfaces: lights, emitters, the sky.
pub fn sources(look: &Look<'_>) -> Vec<Source> {
    let lights = lights(look).map(|(_, entity, light)| Source {
        name: format!("light `{}`", entity.name),
        entities: vec![entity.id],
        changes: changes_of(light),
    });
    let emitters = emitters(look).into_iter().map(|(material, entities)| Source {
        name: format!("material `{}`", material.name),
        entities,
        changes: material.emission.changes,
    });
    let sky = &look.scene.sky;
    let sky = sky_shines(look).then(|| Source {
        name: "the sky".to_owned(),
        entities: Vec::new(),
        changes: sky.changes,
    });
    lights.chain(emitters).chain(sky).collect()
}

/// Lights that may shine, with their places in the scene.
pub fn lights<'l>(look: &'l Look<'_>) -> impl Iterator<Item = (usize, &'l Entity, &'l Light)> {
    let lights = look.visible().filter_map(|(index, entity)| Some((index, entity, entity.light.as_ref()?)));
    lights.filter(|(_, _, light)| may_shine(light))
}

/// Is on, or may be switched on.
pub fn may_shine(light: &Light) -> bool {
    match light.changes {
        Changes::Anything => true,
        Changes::Intensity => light.color.max_element() > 0.0,
        Changes::Never => light.power().max_element() > 0.0,
    }
}

/// What a light's clock does is a change of its brightness.
pub fn changes_of(light: &Light) -> Changes {
    match light.changes {
        Changes::Never if light.switching.is_some() => Changes::Intensity,
        changes => changes,
    }
}

/// Emits now, or will when its brightness changes. One that is dark and marked free is no emitter: all materials are.
pub fn emits(material: &Material) -> bool {
    let Emission { color, strength, changes, .. } = &material.emission;
    let strength = if *changes == Changes::Intensity { strength.max(1.0) } else { *strength };
    !material.unlit && (*color * strength).max_element() > 0.0
}

/// Materials of static surfaces that emit, with what has them. What moves does not light anything.
pub fn emitters<'a>(look: &Look<'a>) -> Vec<(&'a Material, Vec<EntityId>)> {
    let having =
        |material: &Material| entities(&look.with_material(look.still(), |other| other.id == material.id)).1;
    let emitting = look.scene.materials.iter().filter(|material| emits(material));
    emitting.map(|material| (material, having(material))).filter(|(_, having)| !having.is_empty()).collect()
}

pub fn sky_shines(look: &Look<'_>) -> bool {
    let sky = &look.scene.sky;
    let dark = match &sky.kind {
        SkyKind::None => return false,
        SkyKind::Constant { radiance } => *radiance == Vec3::ZERO,
        SkyKind::Gradient { zenith, horizon, ground, .. } => [*zenith, *horizon, *ground] == [Vec3::ZERO; 3],
        SkyKind::Picture { strength, .. } => *strength == 0.0 && sky.changes == Changes::Never,
    };
    look.has(Feature::Sky) && (sky.changes == Changes::Anything || !dark)
}

/// Light is solved while the scene plays: something that shines may change in more than its brightness, a light moves,
/// what moves casts shadows of one onto static surfaces, which patches show as surfaces do, or too many are dimmed.
pub fn matrix(look: &Look<'_>) -> Finding {
    let saving = matrix_saving(look);
    let sources = sources(look);
    if sources.is_empty() {
        return Finding::not_needed("nothing shines").saves(saving);
    }
    if look.still().next().is_none() {
        return Finding::not_needed("no surface is static").saves(saving);
    }
    let free: Vec<&Source> = sources.iter().filter(|source| source.changes == Changes::Anything).collect();
    if !free.is_empty() {
        return Finding::needed(format!("{} may change freely", names(&free)), ids(&free)).saves(saving);
    }
    let carried = lights(look).filter(|(index, ..)| look.carried[*index]);
    let (moving, moved) = told(carried.map(|(_, entity, _)| entity));
    if !moved.is_empty() {
        return Finding::needed(format!("light {moving} moves"), moved).saves(saving);
    }
    if let Some(shadowed) = moving_shadows(look) {
        return shadowed.saves(saving);
    }
    let dimmed: Vec<&Source> = sources.iter().filter(|source| source.changes == Changes::Intensity).collect();
    if let Some(why) = too_many(look, &dimmed) {
        return Finding::needed(why, ids(&dimmed)).saves(saving);
    }
    let why = if dimmed.is_empty() {
        "nothing that shines ever changes".to_owned()
    } else {
        format!("only the brightness of {} may change", names(&dimmed))
    };
    let all: Vec<&Source> = sources.iter().collect();
    Finding::not_needed(why).led_to(ids(&all)).saves(saving)
}

/// Each source that may be dimmed has a response of its own, over all that light is read at: many take more than the rows
/// in whose place they stand.
fn too_many(look: &Look<'_>, dimmed: &[&Source]) -> Option<String> {
    // And one of all that never changes.
    let responses = dimmed.len() as u64 + 1;
    if responses <= FEW_RESPONSES {
        return None;
    }
    let each = format!("{} may each be dimmed by itself", names(dimmed));
    if responses > MOST_RESPONSES {
        return Some(format!("{each}, and more than {MOST_RESPONSES} responses are too many"));
    }
    let sizes = &look.sizes;
    // Three floats an element: of patches once, elsewhere of what is emitted and of what bounced.
    let a_response = 12 * (sizes.patches + 2 * sizes.receivers + 18 * sizes.probes);
    let rows = [sizes.of_patches, sizes.of_receivers, sizes.of_probes];
    let in_rows = rows.iter().map(|rows| rows.saving(&look.cost, 1.0).file_bytes).sum::<u64>();
    (responses * a_response > in_rows).then(|| {
        let [took, instead] = [responses * a_response, in_rows].map(bytes);
        format!("{each}: {responses} responses take {took}, and the rows in whose place they stand {instead}")
    })
}

/// Of what moves, in the light of a lamp that casts.
fn moving_shadows(look: &Look<'_>) -> Option<Finding> {
    let (lights, mut lamps) =
        told(lights(look).filter(|(.., light)| light.casts_shadows).map(|(_, entity, _)| entity));
    let casters: Vec<_> = look.movers().filter(|mover| mover.renderer.casts_shadows).collect();
    let (movers, moving) = entities(&casters);
    if lamps.is_empty() || moving.is_empty() {
        return None;
    }
    lamps.extend(moving);
    Some(Finding::needed(format!("shadows of what may move, {movers}, in the light of {lights}"), lamps))
}

fn names(sources: &[&Source]) -> String {
    listed(&sources.iter().map(|source| source.name.clone()).collect::<Vec<_>>())
}

fn ids(sources: &[&Source]) -> Vec<EntityId> {
    sources.iter().flat_map(|source| source.entities.iter().copied()).collect()
}

/// Rows of patches, read by two products a frame; and what a product works on.
fn matrix_saving(look: &Look<'_>) -> Saving {
    let sizes = &look.sizes;
    let light = 4 * VECTOR * (sizes.patches + sizes.sky_patches);
    sizes.of_patches.saving(&look.cost, 2.0) + look.cost.memory(light, light)
}

#[cfg(test)]
mod tests {
    use super::super::made::{ball, constant, emitter, forced, lamp, material, moved, never, scene, wall};
    use super::super::{RowSizes, Sizes};
    use super::*;
    use crate::scene::assets::Assets;
    use crate::scene::{Scene, Sky, Switching};

    fn found(rule: fn(&Look<'_>) -> Finding, scene: &Scene) -> Finding {
        let (assets, forced) = (Assets::default(), forced());
        rule(&Look::at_scene(scene, &assets, &forced))
    }

    /// A wall and a lamp that never changes.
    fn room() -> Scene {
        scene(vec![wall(1), lamp(2, never())])
    }

    #[test]
    fn where_nothing_that_shines_ever_changes_there_is_nothing_to_solve() {
        let still = found(matrix, &room());
        assert!(!still.needed && still.why == "nothing that shines ever changes", "{still:?}");
        let dark = found(matrix, &scene(vec![wall(1)]));
        assert!(!dark.needed && dark.why == "nothing shines");
    }

    #[test]
    fn one_free_source_needs_the_matrix_and_is_named() {
        let free = Light { changes: Changes::Anything, ..never() };
        let by_light = found(matrix, &scene(vec![wall(1), lamp(2, free)]));
        assert!(by_light.needed && by_light.why == "light `e2` may change freely", "{by_light:?}");
        let mut by_emitter = room();
        by_emitter.materials = vec![emitter(0, Changes::Anything)];
        assert!(found(matrix, &by_emitter).why.starts_with("material `m0`"));
        let mut by_sky = room();
        by_sky.sky = Sky { kind: constant(), changes: Changes::Anything };
        assert_eq!(found(matrix, &by_sky).why, "the sky may change freely");
    }

    #[test]
    fn what_changes_in_brightness_alone_and_what_the_clock_switches_is_no_reason() {
        let dimmed = Light { changes: Changes::Intensity, ..never() };
        let by_clock =
            Light { switching: Some(Switching { period: 1.0, on_share: 0.5, offset: 0.0 }), ..never() };
        for light in [dimmed, by_clock] {
            let found = found(matrix, &scene(vec![wall(1), lamp(2, light)]));
            assert!(
                !found.needed && found.why == "only the brightness of light `e2` may change",
                "{found:?}"
            );
        }
    }

    #[test]
    fn many_that_are_dimmed_need_the_matrix_and_a_few_whose_responses_take_more_than_its_rows() {
        let dimmed = Light { changes: Changes::Intensity, ..never() };
        let lamps = |count: u64| (0..count).map(|k| lamp(k + 2, dimmed.clone()));
        let under = |count| scene([wall(1)].into_iter().chain(lamps(count)).collect());
        assert!(!found(matrix, &under(63)).needed);
        let many = found(matrix, &under(64));
        assert!(many.needed && many.entities.len() == 64, "{many:?}");
        assert!(
            many.why.ends_with(
                "and 61 more may each be dimmed by itself, and more than 64 responses are too many"
            )
        );
        // Rows of 40.8 kB, and as much in 34 responses.
        let (assets, forced) = (Assets::default(), forced());
        let of_patches = RowSizes { rows: 100, entries: 10_000, bytes: 4 };
        let full = Sizes { patches: 100, of_patches, ..Sizes::default() };
        let baked =
            |count, sizes| matrix(&Look::at_scene(&under(count), &assets, &forced).sized(sizes)).needed;
        assert_eq!([33, 34].map(|count| baked(count, full)), [false, true]);
        let empty = Sizes { patches: 100, ..Sizes::default() };
        assert_eq!([3, 4].map(|count| baked(count, empty)), [false, true], "few are not counted");
    }

    #[test]
    fn a_free_albedo_and_a_dark_free_emission_are_no_reason() {
        let mut scene = room();
        scene.materials = vec![material(0)];
        assert_eq!(scene.materials[0].albedo.changes, Changes::Anything);
        assert_eq!(scene.materials[0].emission.changes, Changes::Anything);
        assert!(!found(matrix, &scene).needed);
    }

    #[test]
    fn a_light_that_is_carried_about_needs_the_matrix() {
        let moving = found(matrix, &scene(vec![wall(1), moved(lamp(2, never()))]));
        assert!(moving.needed && moving.why == "light `e2` moves");
        let cart = moved(Entity { id: EntityId(3), ..Entity::default() });
        let carried = Entity { parent: Some(EntityId(3)), ..lamp(2, never()) };
        assert!(found(matrix, &scene(vec![wall(1), cart, carried])).needed);
    }

    #[test]
    fn shadows_of_what_moves_need_the_matrix() {
        let with_ball = |light| scene(vec![wall(1), lamp(2, light), ball(3)]);
        let shadowed = found(matrix, &with_ball(never()));
        assert!(shadowed.needed && shadowed.entities == [EntityId(2), EntityId(3)], "{shadowed:?}");
        assert!(!found(matrix, &with_ball(Light { casts_shadows: false, ..never() })).needed);
        let mut ghost = with_ball(never());
        ghost.entities[2].mesh.iter_mut().for_each(|renderer| renderer.casts_shadows = false);
        assert!(!found(matrix, &ghost).needed);
    }

    #[test]
    fn what_is_hidden_shines_on_nothing() {
        let free = Entity { hidden: true, ..lamp(2, Light::default()) };
        assert_eq!(found(matrix, &scene(vec![wall(1), free])).why, "nothing shines");
    }
}
