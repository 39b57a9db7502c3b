//! Reflection cubemaps: who shows them, and whether what they show changes.

use glam::{DVec3, Vec3};

use super::look::{Drawn, Look, entities, listed, told};
use super::sources::{lights, sources};
use super::{Finding, Saving};
use crate::scene::{Changes, Entity, EntityId, Feature, Material, ReflectionProbe, Refresh};
use crate::transport::reflection::ROUGH;
use crate::transport::reflection::influence::Influence;

/// Shows reflections.
pub fn is_smooth(material: &Material) -> bool {
    !material.unlit && (material.roughness < ROUGH || material.metallic_roughness_texture.is_some())
}

/// A smooth surface is in reach of a probe or of the sky.
pub fn reflections(look: &Look<'_>) -> Finding {
    let probes: Vec<_> = probes(look).collect();
    let (placed, places) = told(probes.iter().map(|(_, entity, _)| *entity));
    let saving = memory(look);
    let shows = |drawn: &Drawn<'_>| drawn.renderer.reflection.strength > 0.0;
    let smooth = look.with_material(look.drawn().filter(shows), is_smooth);
    let has_sky = look.has(Feature::Sky);
    if smooth.is_empty() {
        return Finding::not_needed("nothing is smooth").led_to(places).saves(saving);
    }
    if probes.is_empty() && !has_sky {
        let (names, ids) = entities(&smooth);
        let why = format!("there is no sky and no reflection probe; {names} would show them");
        return Finding::not_needed(why).led_to(ids).saves(saving);
    }
    let in_reach: Vec<_> = smooth
        .into_iter()
        .filter(|drawn| has_sky || probes.iter().any(|(index, _, probe)| reaches(look, *index, probe, drawn)))
        .collect();
    if in_reach.is_empty() {
        return Finding::not_needed(format!("nothing smooth is in reach of {placed}"))
            .led_to(places)
            .saves(saving);
    }
    let (names, ids) = entities(&in_reach);
    Finding::needed(format!("smooth: {names}"), ids).saves(saving)
}

/// Probes that take part.
fn probes<'l>(look: &'l Look<'_>) -> impl Iterator<Item = (usize, &'l Entity, &'l ReflectionProbe)> {
    look.visible().filter_map(|(index, entity)| Some((index, entity, entity.reflection_probe.as_ref()?)))
}

/// Whether something may read a probe. What moves, and a probe that does, may come anywhere.
fn reaches(look: &Look<'_>, index: usize, probe: &ReflectionProbe, drawn: &Drawn<'_>) -> bool {
    let reflection = &drawn.renderer.reflection;
    let id = look.scene.entities[index].id;
    if reflection.probes.as_ref().is_some_and(|listed| !listed.contains(&id)) {
        return false;
    }
    let anchor = reflection
        .anchor
        .and_then(|anchor| look.scene.entities.iter().position(|entity| entity.id == anchor));
    if look.carried[index] || anchor.is_some_and(|anchor| look.carried[anchor]) {
        return true;
    }
    let Some((centre, radius)) = sphere(look, drawn, anchor) else { return true };
    Influence::new(probe, &look.world[index], centre)
        .is_some_and(|influence| influence.touches(Vec3::ZERO, 1.001 * radius as f32))
}

/// About a static object, or the point that it takes its probes from; none of what may be anywhere.
fn sphere(look: &Look<'_>, drawn: &Drawn<'_>, anchor: Option<usize>) -> Option<(DVec3, f64)> {
    if let Some(anchor) = anchor {
        return Some((look.world[anchor].translation, 0.0));
    }
    if !drawn.entity.is_static {
        return None;
    }
    let mesh = look.assets.meshes.get(&drawn.renderer.mesh)?;
    let world = &look.world[drawn.index];
    let points = || mesh.positions.iter().map(|point| world.transform_point3(point.as_dvec3()));
    let low = points().reduce(DVec3::min)?;
    let high = points().reduce(DVec3::max)?;
    Some(((low + high) * 0.5, 0.5 * low.distance(high)))
}

/// What a probe shows may change: something moves in its view, or what lights it may change.
pub fn recaptures(look: &Look<'_>) -> Finding {
    if !look.has(Feature::Reflections) {
        return Finding::not_needed("there are no reflection cubemaps");
    }
    let followed = probes(look).filter(|(.., probe)| probe.refresh != Refresh::Baked);
    let (names, ids) = told(followed.map(|(_, entity, _)| entity));
    let saving = captures(look, ids.len() as u64);
    let skyward = probes(look).next().is_none();
    if ids.is_empty() && !skyward {
        let (_, ids) = told(probes(look).map(|(_, entity, _)| entity));
        return Finding::not_needed("every reflection probe is baked").led_to(ids);
    }
    match changing(look, skyward) {
        Some((why, by)) if skyward => Finding::needed(format!("{why}, and cubemaps of the sky show it"), by),
        Some((why, by)) => Finding::needed(format!("{why}, seen from {names}"), by),
        None => Finding::not_needed("nothing that cubemaps show ever changes").led_to(ids),
    }
    .saves(saving)
}

/// What changes, and by whom. `skyward`: the sky alone is seen.
fn changing(look: &Look<'_>, skyward: bool) -> Option<(String, Vec<EntityId>)> {
    let sky_changes = look.scene.sky.changes != Changes::Never && look.has(Feature::Sky);
    if skyward {
        return sky_changes.then(|| ("the sky may change".to_owned(), Vec::new()));
    }
    let movers: Vec<_> = look.movers().collect();
    if !movers.is_empty() {
        let (names, ids) = entities(&movers);
        return Some((format!("{names} may move"), ids));
    }
    let carried =
        probes(look).map(|(index, entity, _)| (index, entity)).filter(|(index, _)| look.carried[*index]);
    let carried = carried.chain(
        lights(look).map(|(index, entity, _)| (index, entity)).filter(|(index, _)| look.carried[*index]),
    );
    let (names, ids) = told(carried.map(|(_, entity)| entity));
    if !ids.is_empty() {
        return Some((format!("{names} moves"), ids));
    }
    let changing = sources(look).into_iter().filter(|source| source.changes != Changes::Never);
    let (names, ids): (Vec<String>, Vec<Vec<EntityId>>) =
        changing.map(|source| (source.name, source.entities)).unzip();
    (!names.is_empty()).then(|| (format!("{} may change", listed(&names)), ids.concat()))
}

/// Nobody asks for captures that nobody reads: a probe is captured when something in view reads it.
pub fn unseen_captures(look: &Look<'_>) -> Finding {
    if !look.has(Feature::Reflections) {
        return Finding::not_needed("there are no reflection cubemaps");
    }
    let (_, ids) = told(probes(look).map(|(_, entity, _)| entity));
    let unseen = (ids.len() as u64).saturating_sub(1);
    Finding::not_needed("a probe is captured when something in view reads it")
        .led_to(ids)
        .saves(captures(look, unseen))
}

/// Six faces and their smaller levels, eight bytes a texel; the sky has one more.
fn memory(look: &Look<'_>) -> Saving {
    let size = |(.., probe): (usize, &Entity, &ReflectionProbe)| {
        u64::from(probe.resolution.clamp(16, 1024).next_power_of_two())
    };
    let sizes: Vec<u64> = probes(look).map(size).collect();
    let largest = sizes.iter().copied().max().unwrap_or(16);
    look.cost.memory(64 * largest * largest * (sizes.len() as u64 + 1), 0)
}

/// So many probes in a frame.
fn captures(look: &Look<'_>, probes: u64) -> Saving {
    let all = self::probes(look).count().max(1) as u64 + 1;
    look.cost.memory(0, memory(look).gpu_bytes / all * probes)
}

#[cfg(test)]
mod tests {
    use super::super::made::{
        assets, ball, cube_probe, forced, gradient, lamp, material, moved, never, scene, wall, with,
    };
    use super::*;
    use crate::scene::{Light, Reflection, Scene, Sky, Transform};

    fn found(rule: fn(&Look<'_>) -> Finding, scene: &Scene) -> Finding {
        let (assets, forced) = (assets(scene), forced());
        rule(&Look::at_scene(scene, &assets, &forced))
    }

    fn mirror() -> Material {
        Material { roughness: 0.1, ..material(1) }
    }

    /// A mirror in the middle of a probe's box, in the light of a lamp that never changes.
    fn hall() -> Scene {
        Scene {
            materials: vec![material(0), mirror()],
            ..scene(vec![with(wall(1), 1), cube_probe(2), lamp(3, never())])
        }
    }

    #[test]
    fn cubemaps_are_for_smooth_surfaces_in_reach_of_a_probe_or_of_the_sky() {
        let seen = found(reflections, &hall());
        assert!(seen.needed && seen.entities == [EntityId(1)], "{seen:?}");
        let mut rough = hall();
        rough.entities[0] = wall(1);
        assert_eq!(found(reflections, &rough).why, "nothing is smooth");
        let mut far = hall();
        far.entities[0].transform = Transform { translation: DVec3::X * 50.0, ..Transform::default() };
        let out = found(reflections, &far);
        assert!(!out.needed && out.why == "nothing smooth is in reach of `e2`", "{out:?}");
        far.sky = Sky { kind: gradient(), changes: Changes::Never };
        assert!(found(reflections, &far).needed, "the sky is everywhere");
    }

    #[test]
    fn without_probes_and_sky_there_is_nothing_to_show() {
        let mut alone = hall();
        alone.entities.remove(1);
        let out = found(reflections, &alone);
        assert!(!out.needed && out.entities == [EntityId(1)], "{out:?}");
        let mut hidden = hall();
        hidden.entities[1].hidden = true;
        assert!(!found(reflections, &hidden).needed);
    }

    #[test]
    fn what_moves_may_come_into_reach_and_who_names_other_probes_does_not() {
        let mut far = hall();
        far.entities[0] = with(ball(1), 1);
        far.entities[0].transform.translation = DVec3::X * 50.0;
        assert!(found(reflections, &far).needed);
        let mut listed = hall();
        listed.entities[0].mesh.iter_mut().for_each(|renderer| {
            renderer.reflection = Reflection { probes: Some(vec![EntityId(9)]), ..Reflection::default() };
        });
        assert!(!found(reflections, &listed).needed);
    }

    #[test]
    fn what_never_changes_is_captured_once() {
        let still = found(recaptures, &hall());
        assert!(!still.needed && still.entities == [EntityId(2)], "{still:?}");
        let mut lit = hall();
        lit.entities[2] = lamp(3, Light { changes: Changes::Intensity, ..never() });
        assert!(found(recaptures, &lit).needed);
        let mut busy = hall();
        busy.entities.push(ball(4));
        let busy = found(recaptures, &busy);
        assert!(busy.needed && busy.why == "`e4` may move, seen from `e2`", "{busy:?}");
        let mut carried = hall();
        carried.entities[1] = moved(cube_probe(2));
        assert!(found(recaptures, &carried).needed);
    }

    #[test]
    fn baked_probes_follow_nothing() {
        let mut baked = hall();
        baked.entities.push(ball(4));
        baked.entities[1].reflection_probe.iter_mut().for_each(|probe| probe.refresh = Refresh::Baked);
        assert!(!found(recaptures, &baked).needed);
    }

    #[test]
    fn probes_that_nobody_reads_are_not_captured() {
        let unseen = found(unseen_captures, &hall());
        assert!(!unseen.needed && unseen.entities == [EntityId(2)]);
        let mut rough = hall();
        rough.entities[0] = wall(1);
        for rule in [recaptures, unseen_captures] {
            assert_eq!(found(rule, &rough).why, "there are no reflection cubemaps");
        }
    }
}
